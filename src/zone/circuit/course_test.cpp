#include "cosiva/zone/circuit/course.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cosiva/base/random.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Course, that_is_empty_is_nowhere_and_arrives_nowhere) {
  Course course;
  EXPECT_TRUE(course.empty());
  EXPECT_EQ(course.here(), no_section);
  EXPECT_THAT(course.remaining(), IsEmpty());
  EXPECT_THAT(course.traversed(), IsEmpty());
  EXPECT_FALSE(course.arrive(3));
  course.forget_traversed(0);
  EXPECT_TRUE(course.empty());
}

TEST(Course, begins_on_its_first_section_and_goes_on) {
  Course course{{4, 7, 2}};
  EXPECT_EQ(course.here(), 4U);
  EXPECT_THAT(course.remaining(), ElementsAre(7, 2));
  EXPECT_TRUE(course.arrive(7));
  EXPECT_THAT(course.traversed(), ElementsAre(4));
  EXPECT_THAT(course.remaining(), ElementsAre(2));
}

TEST(Course, takes_a_section_that_comes_again_for_the_next_time_it_comes) {
  // A figure of eight: 0 is the centre, left 1, right 2.
  Course course{{0, 1, 0, 2, 0, 1}};
  EXPECT_TRUE(course.arrive(1));
  EXPECT_THAT(course.traversed(), ElementsAre(0));
  EXPECT_TRUE(course.arrive(0));
  EXPECT_THAT(course.traversed(), ElementsAre(0, 1));
  EXPECT_TRUE(course.arrive(0));  // already reached
  EXPECT_THAT(course.traversed(), ElementsAre(0, 1));
  EXPECT_TRUE(course.arrive(2));
  EXPECT_TRUE(course.arrive(1));
  EXPECT_THAT(course.traversed(), ElementsAre(0, 1, 0, 2, 0));
}

TEST(Course, goes_back_to_the_nearest_where_no_section_of_that_name_follows) {
  Course course{{5, 6, 5, 7, 8}};
  ASSERT_TRUE(course.arrive(8));
  EXPECT_TRUE(course.arrive(5));
  EXPECT_THAT(course.traversed(), ElementsAre(5, 6));
}

TEST(Course, searches_no_further_ahead_than_its_limit) {
  Course course{{1, 2, 3, 4}};
  EXPECT_FALSE(course.arrive(4, 2));
  EXPECT_EQ(course.here(), 1U);
  EXPECT_TRUE(course.arrive(3, 2));
}

TEST(Course, that_knows_no_such_section_stays_as_it_is) {
  Course course{{1, 2}};
  EXPECT_FALSE(course.arrive(9));
  EXPECT_EQ(course.here(), 1U);
}

TEST(Course, drops_the_sections_behind_and_nothing_else) {
  Course course{{1, 2, 3, 4}};
  ASSERT_TRUE(course.arrive(3));
  course.forget_traversed(1);
  EXPECT_THAT(course.traversed(), ElementsAre(2));
  EXPECT_EQ(course.here(), 3U);
  EXPECT_THAT(course.remaining(), ElementsAre(4));
  course.forget_traversed(5);
  EXPECT_THAT(course.traversed(), ElementsAre(2));
}

TEST(Course, searches_no_further_back_than_its_limit) {
  Course course{{1, 2, 3, 4}, 3};
  EXPECT_EQ(course.here(), 4U);
  EXPECT_FALSE(course.arrive(1, 64, 2));
  EXPECT_EQ(course.here(), 4U);
  EXPECT_TRUE(course.arrive(2, 64, 2));
  EXPECT_EQ(course.here(), 2U);
  EXPECT_TRUE(course.arrive(1, 64, 1));
  EXPECT_EQ(course.here(), 1U);
  EXPECT_TRUE(course.arrive(1, 0, 0)) << "the section where it is";
}

TEST(Course, steps_to_and_fro_and_is_cut_after_the_next_sections) {
  Course course{{1, 2, 3, 4, 5}};
  course.step();
  EXPECT_EQ(course.here(), 2U);
  course.cut(4);
  EXPECT_THAT(course.sections(), ElementsAre(1, 2, 3, 4, 5)) << "no more than four follow";
  course.cut(3);
  EXPECT_THAT(course.sections(), ElementsAre(1, 2, 3, 4, 5));
  course.cut(2);
  EXPECT_THAT(course.sections(), ElementsAre(1, 2, 3, 4));
  course.step_back();
  EXPECT_EQ(course.here(), 1U);
  course.cut(0);
  EXPECT_THAT(course.sections(), ElementsAre(1));
  const SectionId more[] = {7, 8};
  course.extend(more);
  EXPECT_THAT(course.remaining(), ElementsAre(7, 8));
  course.clear();
  EXPECT_TRUE(course.empty());
}

TEST(Course, forgets_nothing_while_no_more_is_behind_than_it_keeps) {
  Course course{{1, 2, 3, 4}, 2};
  course.forget_traversed(2);
  EXPECT_THAT(course.traversed(), ElementsAre(1, 2));
  course.forget_traversed(0);
  EXPECT_THAT(course.sections(), ElementsAre(3, 4));
  EXPECT_EQ(course.here(), 3U);
}

TEST(Course, follows_a_random_walk_through_a_random_graph_in_step) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "course_test"};
    // No section follows itself, so that each arrival is a step.
    const std::size_t size = 2 + random.below(5);
    std::vector<SectionId> walk{static_cast<SectionId>(random.below(size))};
    for (int i = 0; i < 40; ++i) {
      const auto step = static_cast<SectionId>(1 + random.below(size - 1));
      walk.push_back(static_cast<SectionId>((walk.back() + step) % size));
    }
    Course course{{walk[0]}};
    std::size_t given = 1;
    for (std::size_t i = 1; i < walk.size(); ++i) {
      // The next few sections are known, never so many that none is unknown.
      while (given <= i || (given < walk.size() && random.chance(0.5))) {
        const SectionId more[] = {walk[given++]};
        course.extend(more);
      }
      RC_ASSERT(course.arrive(walk[i]));
      RC_ASSERT(course.here() == walk[i]);
      RC_ASSERT(course.traversed().back() == walk[i - 1]);
      RC_ASSERT(course.remaining().size() == given - 1 - i);
      if (random.chance(0.3)) {
        course.forget_traversed(1);
        RC_ASSERT(course.traversed().size() == 1U);
        RC_ASSERT(course.here() == walk[i]);
      }
    }
  }));
}

}  // namespace
}  // namespace cosiva::zone
