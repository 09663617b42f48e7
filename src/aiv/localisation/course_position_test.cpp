// A position along a course on its own, without an estimator.
#include "cosiva/aiv/localisation/course_position.h"

#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::diamond;
using Sections = std::vector<zone::SectionId>;

// Sections of the diamond; those of a branch are π/4, π/2 and π/4 long, trunk and tail 2 m.
constexpr zone::SectionId trunk = 0;
constexpr zone::SectionId l_up = 1;
constexpr zone::SectionId l_down = 3;
constexpr zone::SectionId r_up = 4;
constexpr zone::SectionId r_over = 5;
constexpr zone::SectionId r_down = 6;
constexpr zone::SectionId tail = 7;
constexpr double eighth_m = pi / 4.0;

Sections copied(std::span<const zone::SectionId> sections) { return {sections.begin(), sections.end()}; }

/// A point of the diamond's floor under a section.
Point2 on_floor(zone::SectionId section, double s_m) {
  return cosiva::position(diamond().circuit.pose_at({section, s_m}));
}

/// Three sections of 1 m in a row.
zone::Circuit row() { return test::lay({{1.0}, {1.0}, {1.0}}, false); }

TEST(CoursePosition, keeps_its_course_where_it_jumps_along_it_and_drops_it_elsewhere) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 1.0});
  path.follow(zone::Course{{trunk, r_up, r_over}});
  path.jump_to({r_up, 0.125});
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{r_up, 0.125}));
  EXPECT_EQ(copied(path.course().traversed()), (Sections{trunk}));
  EXPECT_EQ(copied(path.course().remaining()), (Sections{r_over}));
  path.jump_to({l_up, 0.125});
  EXPECT_TRUE(path.course().empty());
  path.follow(zone::Course{{l_up}});
  EXPECT_FALSE(path.course().empty());
  path.jump_without_course({l_up, 0.25});
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{l_up, 0.25}));
  EXPECT_TRUE(path.course().empty());
}

TEST(CoursePosition, has_no_course_after_one_that_begins_elsewhere) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 1.0});
  path.follow(zone::Course{{trunk, r_up}});
  path.follow(zone::Course{{r_up, r_over}});
  EXPECT_TRUE(path.course().empty());
}

TEST(CoursePosition, keeps_the_sections_that_it_has_driven_rather_than_those_of_an_order) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 1.875});
  path.follow(zone::Course{{trunk, r_up, r_over}});
  EXPECT_EQ(path.shift(0.25), 0.25);
  path.follow(zone::Course{{l_down, r_up, r_over, r_down}, 1});
  EXPECT_EQ(copied(path.course().traversed()), (Sections{trunk}));
  EXPECT_EQ(path.course().here(), r_up);
  EXPECT_EQ(copied(path.course().remaining()), (Sections{r_over, r_down}));
}

TEST(CoursePosition, takes_the_sections_before_it_from_an_order_while_it_has_driven_none) {
  CoursePosition path{diamond().circuit};
  path.jump_to({r_up, 0.125});
  path.follow(zone::Course{{r_up, r_over}});
  EXPECT_TRUE(path.course().traversed().empty());
  path.follow(zone::Course{{trunk, r_up}, 1});
  EXPECT_EQ(copied(path.course().traversed()), (Sections{trunk}));
  EXPECT_TRUE(path.course().remaining().empty());
}

TEST(CoursePosition, takes_over_the_last_sixteen_sections_of_a_course) {
  Sections sections(4, l_up);
  sections.insert(sections.end(), 16, trunk);
  sections.push_back(r_up);
  sections.push_back(r_over);
  CoursePosition path{diamond().circuit};
  path.jump_to({r_up, 0.0});
  path.follow(zone::Course{sections, 20});
  EXPECT_EQ(copied(path.course().traversed()), Sections(16, trunk));
  EXPECT_EQ(path.course().here(), r_up);
  EXPECT_EQ(copied(path.course().remaining()), (Sections{r_over}));
}

TEST(CoursePosition, keeps_sixteen_of_the_sections_that_it_has_driven_whenever_these_are_64) {
  const zone::Circuit stadium = test::lay({{2.0}, {0.5 * pi, 2.0}, {2.0}, {0.5 * pi, 2.0}}, true);
  const auto cross_joints = [](CoursePosition& path, int count) {
    for (int i = 0; i < count; ++i) {
      const zone::SectionId before = path.track_position().section;
      while (path.track_position().section == before) path.shift(0.25);
    }
  };
  CoursePosition path{stadium};
  path.jump_to({0, 0.5});
  path.follow(zone::Course{Sections{0}});
  cross_joints(path, 63);
  EXPECT_EQ(path.course().traversed().size(), 63U);
  cross_joints(path, 1);
  EXPECT_EQ(path.course().traversed().size(), 16U);
  EXPECT_EQ(path.course().here(), path.track_position().section);
  CoursePosition without_course{stadium};
  without_course.jump_to({0, 0.5});
  cross_joints(without_course, 3);
  EXPECT_EQ(without_course.track_position().section, 3U);
  EXPECT_TRUE(without_course.course().empty());
}

TEST(CoursePosition, stays_on_the_section_whose_end_or_begin_it_reaches) {
  const zone::Circuit circuit = row();
  CoursePosition path{circuit};
  path.jump_to({0, 0.75});
  EXPECT_EQ(path.shift(0.25), 0.25);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{0, 1.0}));
  path.jump_to({1, 0.25});
  EXPECT_EQ(path.shift(-0.25), -0.25);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{1, 0.0}));
}

TEST(CoursePosition, passes_several_joints_in_one_move_and_ends_where_the_circuit_does) {
  const zone::Circuit circuit = row();
  CoursePosition path{circuit};
  path.jump_to({0, 0.5});
  EXPECT_EQ(path.shift(2.0), 2.0);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{2, 0.5}));
  EXPECT_EQ(path.shift(-2.0), -2.0);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{0, 0.5}));
  EXPECT_EQ(path.shift(5.0), 2.5);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{2, 1.0}));
  EXPECT_EQ(path.shift(-5.0), -3.0);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{0, 0.0}));
}

TEST(CoursePosition, steps_back_along_its_course_and_adds_none_where_it_had_none) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 1.875});
  path.follow(zone::Course{{trunk, r_up, r_over}});
  EXPECT_EQ(path.shift(0.25), 0.25);
  EXPECT_EQ(path.shift(-0.1875), -0.1875);
  EXPECT_EQ(path.track_position().section, trunk);
  EXPECT_NEAR(path.track_position().s_m, 1.9375, 1e-12);
  EXPECT_TRUE(path.course().traversed().empty());
  EXPECT_EQ(copied(path.course().remaining()), (Sections{r_up, r_over}));

  CoursePosition without_course{diamond().circuit};
  without_course.jump_to({r_over, 0.125});
  EXPECT_EQ(without_course.shift(-0.25), -0.25);
  EXPECT_EQ(without_course.track_position().section, r_up);
  EXPECT_TRUE(without_course.course().empty());
  without_course.jump_to({tail, 0.125});
  without_course.shift(-0.25);
  EXPECT_EQ(without_course.track_position().section, l_down) << "of two that merge there the first";
}

TEST(CoursePosition, enters_a_branch_and_drops_a_course_that_leads_elsewhere) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 2.0});
  path.follow(zone::Course{{trunk, r_up, r_over}});
  path.enter_branch(l_up);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{l_up, 0.0}));
  EXPECT_EQ(copied(path.course().traversed()), (Sections{trunk}));
  EXPECT_TRUE(path.course().remaining().empty());

  path.jump_to({trunk, 2.0});
  path.follow(zone::Course{{trunk, r_up, r_over}});
  path.enter_branch(r_up);
  EXPECT_EQ(path.track_position(), (zone::TrackPosition{r_up, 0.0}));
  EXPECT_EQ(copied(path.course().remaining()), (Sections{r_over}));

  path.jump_without_course({trunk, 2.0});
  path.enter_branch(l_up);
  EXPECT_EQ(copied(path.course().sections()), (Sections{trunk, l_up}));
  EXPECT_EQ(path.course().here(), l_up);
}

TEST(CoursePosition, that_expects_a_section_has_a_course_to_it_and_no_further) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 1.0});
  path.expect_next(r_up);
  EXPECT_TRUE(path.course().traversed().empty());
  EXPECT_EQ(path.course().here(), trunk);
  EXPECT_EQ(copied(path.course().remaining()), (Sections{r_up}));
}

TEST(CoursePosition, measures_the_shorter_distance_round_a_loop_and_of_equal_ones_that_forwards) {
  // A square of 1 m.
  const zone::TrafficZone loop = test::graph("loop",
                                             {{"a", {0.0, 0.0, 0.0}, 1.0, 0.0, {1}, true},
                                              {"b", {1.0, 0.0, 0.5 * pi}, 1.0, 0.0, {2}, true},
                                              {"c", {1.0, 1.0, pi}, 1.0, 0.0, {3}, true},
                                              {"d", {0.0, 1.0, -0.5 * pi}, 1.0, 0.0, {0}, true}},
                                             {});
  CoursePosition path{loop.circuit};
  path.jump_to({0, 0.5});
  EXPECT_EQ(path.offset_to({2, 0.5}, 3.0), 2.0) << "as far back";
  EXPECT_EQ(path.offset_to({1, 0.75}, 3.0), 1.25);
  EXPECT_EQ(path.offset_to({3, 0.25}, 3.0), -1.25);
  EXPECT_EQ(path.offset_to({0, 0.25}, 1.0), -0.25);
  EXPECT_EQ(path.offset_to({0, 0.75}, 1.0), 0.25);
  EXPECT_EQ(path.offset_to({2, 0.5}, 2.0), 2.0);
  EXPECT_FALSE(path.offset_to({2, 0.5}, 1.9));
}

TEST(CoursePosition, measures_back_along_the_branch_that_it_has_driven) {
  CoursePosition path{diamond().circuit};
  path.jump_to({tail, 0.1});
  path.follow(zone::Course{{r_up, r_over, r_down, tail}, 3});
  const auto back_m = [&](zone::TrackPosition to, double limit_m) { return path.offset_to(to, limit_m).value_or(9.0); };
  EXPECT_NEAR(back_m({r_over, 2.0 * eighth_m - 0.05}, 3.0), -(0.1 + eighth_m + 0.05), 1e-12);
  EXPECT_NEAR(back_m({r_down, eighth_m - 0.05}, 3.0), -0.15, 1e-12);
  EXPECT_NEAR(back_m({tail, 0.05}, 0.06), -0.05, 1e-12);
  // The other branch counts only where the traversed sections are not known as far back as the limit.
  EXPECT_EQ(back_m({l_down, 0.5}, 0.6), 9.0);
  EXPECT_NEAR(back_m({l_down, 0.5}, 5.0), -(eighth_m - 0.5 + 0.1), 1e-12);
}

TEST(CoursePosition, finds_the_foot_of_a_fiducial_within_its_reach_and_near_its_path) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 0.5});
  const Point2 fiducial{1.0, 0.0625};
  const auto foot = path.foot_of(fiducial, 1.0, 0.08);
  ASSERT_TRUE(foot);
  const auto [offset_m, off_m] = *foot;
  EXPECT_NEAR(offset_m, 0.5, 1e-12);
  EXPECT_NEAR(off_m, 0.0625, 1e-12);
  EXPECT_TRUE(path.foot_of(fiducial, 0.51, 0.08));
  EXPECT_FALSE(path.foot_of(fiducial, 0.49, 0.08));
  EXPECT_TRUE(path.foot_of(fiducial, 1.0, 0.0626));
  EXPECT_FALSE(path.foot_of(fiducial, 1.0, 0.0625));
  const auto behind = path.foot_of({0.25, 0.0}, 1.0, 0.08);
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->offset_m, -0.25, 1e-12);
}

TEST(CoursePosition, finds_no_foot_on_a_branch_that_it_does_not_take) {
  CoursePosition path{diamond().circuit};
  path.jump_to({trunk, 1.5});
  path.follow(zone::Course{{trunk, l_up}});
  EXPECT_FALSE(path.foot_of(on_floor(r_up, 0.5), 1.5, 0.08));
  path.follow(zone::Course{{trunk, r_up}});
  const auto foot = path.foot_of(on_floor(r_up, 0.5), 1.5, 0.08);
  ASSERT_TRUE(foot);
  EXPECT_NEAR(foot->offset_m, 1.0, 1e-9);
}

TEST(CoursePosition, finds_feet_on_all_branches_that_merge_behind_it_unless_it_has_driven_one) {
  CoursePosition path{diamond().circuit};
  path.jump_to({tail, 0.1});
  // 0.4 m before the merge the branches are 0.16 m apart.
  for (const zone::SectionId branch : {l_down, r_down}) {
    const auto foot = path.foot_of(on_floor(branch, eighth_m - 0.4), 0.6, 0.08);
    ASSERT_TRUE(foot) << branch;
    EXPECT_NEAR(foot->offset_m, -0.5, 1e-9) << branch;
  }
  path.follow(zone::Course{{r_down, tail}, 1});
  EXPECT_FALSE(path.foot_of(on_floor(l_down, eighth_m - 0.4), 0.6, 0.08));
  EXPECT_TRUE(path.foot_of(on_floor(r_down, eighth_m - 0.4), 0.6, 0.08));
}

}  // namespace
}  // namespace cosiva::aiv
