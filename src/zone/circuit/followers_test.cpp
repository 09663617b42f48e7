#include "cosiva/zone/circuit/followers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using testing::part;
using testing::section;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t plenty = 1'000'000;

/// Straights of 1, 2, 3, … m in a row.
Circuit row(int sections) {
  std::vector<Circuit::Part> parts;
  double x_m = 0.0;
  for (int i = 0; i < sections; ++i) {
    const double length_m = 1.0 + i;
    parts.push_back(part("s" + std::to_string(i), section({x_m, 0.0, 0.0}, length_m),
                         i + 1 < sections ? std::vector{static_cast<SectionId>(i + 1)} : std::vector<SectionId>{}));
    x_m += length_m;
  }
  return testing::circuit(std::move(parts));
}

TEST(Followers, are_the_sections_that_begin_within_the_distance_after_the_end) {
  const Circuit circuit = row(5);
  Followers followers{circuit};
  std::size_t work = plenty;
  ASSERT_TRUE(followers.find(5.0, work));
  EXPECT_EQ(followers.gap_m(0, 1), 0.0);
  EXPECT_EQ(followers.gap_m(0, 2), 2.0);
  EXPECT_EQ(followers.gap_m(0, 3), 5.0) << "exactly the distance";
  EXPECT_EQ(followers.gap_m(0, 4), infinity);
  EXPECT_EQ(followers.gap_m(1, 2), 0.0);
  EXPECT_EQ(followers.gap_m(1, 3), 3.0);
  EXPECT_EQ(followers.gap_m(1, 4), infinity);
  EXPECT_EQ(followers.gap_m(1, 0), infinity);
  EXPECT_EQ(followers.gap_m(4, 0), infinity);
  EXPECT_EQ(followers.gap_m(4, 4), infinity);
}

TEST(Followers, begin_after_the_shortest_of_several_branches) {
  // "in" leads to "end" over 3 m and over 1 m, the longer branch first.
  std::vector<Circuit::Part> parts{
      part("in", section({}, 1.0), {1, 2}), part("long", section({1.0, 0.0, 0.0}, 3.0), {3}),
      part("short", section({1.0, 0.0, 0.0}, 1.0), {3}), part("end", section({2.0, 0.0, 0.0}, 1.0))};
  auto made = Circuit::make("branches", std::move(parts), 10.0);
  ASSERT_TRUE(made);
  Followers followers{*made};
  std::size_t work = plenty;
  ASSERT_TRUE(followers.find(10.0, work));
  EXPECT_EQ(followers.gap_m(0, 3), 1.0);
}

TEST(Followers, come_back_to_the_section_itself_round_a_loop) {
  const Circuit circuit = testing::track(2.0, 0.5);
  Followers followers{circuit};
  std::size_t work = plenty;
  ASSERT_TRUE(followers.find(100.0, work));
  for (SectionId id = 0; id < 4; ++id) {
    EXPECT_NEAR(followers.gap_m(id, id), circuit.total_length_m() - circuit.section(id).length_m(), 1e-12);
    EXPECT_EQ(followers.gap_m(id, (id + 1) % 4), 0.0);
  }
}

TEST(Followers, do_not_follow_round_a_corner_of_more_than_45_degrees) {
  const auto corner = [](double turn_rad) {
    auto in = part("in", section({}, 1.0), {1});
    in.pivots = true;
    return testing::circuit({in, part("out", section({1.0, 0.0, turn_rad}, 1.0))});
  };
  for (const double side : {1.0, -1.0}) {
    const Circuit gentle = corner(side * (pi / 4.0 - 1e-9));
    const Circuit sharp = corner(side * (pi / 4.0 + 1e-9));
    EXPECT_TRUE(Followers{gentle}.follows(0, 1));
    EXPECT_FALSE(Followers{sharp}.follows(0, 1));
    Followers followers{sharp};
    std::size_t work = plenty;
    ASSERT_TRUE(followers.find(1.0, work));
    EXPECT_EQ(followers.gap_m(0, 1), infinity);
  }
}

TEST(Followers, take_each_step_s_cost_from_the_work_and_stop_when_it_is_not_enough) {
  // Each successor costs one and the number of followers found before it: s0 has s1, s2 and s3 within 5 m for 1 + 2 +
  // 3, s1 has s2 and s3 for 1 + 2, s2 has s3 and s4, whose start is 4 m away, s3 has s4, s4 none.
  const Circuit circuit = row(5);
  Followers followers{circuit};
  std::size_t work = 100;
  ASSERT_TRUE(followers.find(5.0, work));
  EXPECT_EQ(work, 100U - (1U + 2U + 3U) - (1U + 2U) - (1U + 2U) - 1U);
  work = 13;
  EXPECT_TRUE(followers.find(5.0, work));
  EXPECT_EQ(work, 0U);
  work = 12;
  EXPECT_FALSE(followers.find(5.0, work));
  work = 0;
  EXPECT_FALSE(followers.find(5.0, work));
}

TEST(Followers, follow_round_a_corner_of_exactly_45_degrees) {
  for (const double side : {1.0, -1.0}) {
    auto in = part("in", section({}, 1.0), {1});
    in.pivots = true;
    const Circuit circuit = testing::circuit({in, part("out", section({1.0, 0.0, side * pi / 4.0}, 1.0))});
    EXPECT_TRUE(Followers{circuit}.follows(0, 1));
  }
}

TEST(Followers, of_a_dead_end_are_not_those_of_the_section_listed_after_it) {
  const Circuit circuit =
      testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0)),
                        part("c", section({0.0, 5.0, 0.0}, 1.0), {3}), part("d", section({1.0, 5.0, 0.0}, 1.0))});
  Followers followers{circuit};
  std::size_t work = plenty;
  ASSERT_TRUE(followers.find(5.0, work));
  EXPECT_EQ(followers.gap_m(0, 3), infinity);
  EXPECT_EQ(followers.gap_m(1, 3), infinity);
  EXPECT_EQ(followers.gap_m(2, 3), 0.0);
}

}  // namespace
}  // namespace cosiva::zone
