#include "cosiva/zone/circuit/path_snap.h"

#include <gtest/gtest.h>

namespace cosiva::zone {
namespace {

Circuit::Part straight(std::string name, const Pose2& start, double length_m) {
  return {std::move(name), *Section::make(start, length_m), std::nullopt, {}, false};
}

/// A section east along y = 0 and one north along x = 1, which cross; and one west, 0.2 m above the first.
Circuit crossing_paths() {
  std::vector<Circuit::Part> parts;
  parts.push_back(straight("east", {0.0, 0.0, 0.0}, 2.0));
  parts.push_back(straight("north", {1.0, -1.0, 0.5 * pi}, 2.0));
  parts.push_back(straight("west", {2.0, 0.2, pi}, 0.8));
  return *Circuit::make("ways", std::move(parts));
}

TEST(PathSnap, is_the_nearest_position_of_the_section_with_the_vehicle_s_heading) {
  const Circuit circuit = crossing_paths();
  const auto east = snap_to_path(circuit, {0.99, 0.01, 0.1});
  ASSERT_TRUE(east);
  EXPECT_EQ(east->position.section, 0U);
  EXPECT_NEAR(east->position.s_m, 0.99, 1e-12);
  EXPECT_NEAR(east->left_m, 0.01, 1e-12);
  const auto north = snap_to_path(circuit, {0.99, 0.01, 1.5});
  ASSERT_TRUE(north);
  EXPECT_EQ(north->position.section, 1U);
}

TEST(PathSnap, is_the_nearest_section_whatever_its_heading_where_the_others_are_further_than_a_turn_is_worth) {
  const Circuit circuit = crossing_paths();
  // Half a turn is worth 0.157 m: 0.02 m from the section west and 0.18 m from the section east, heading east.
  const auto close = snap_to_path(circuit, {1.6, 0.19, 0.0});
  ASSERT_TRUE(close);
  EXPECT_EQ(close->position.section, 2U);
  const auto between = snap_to_path(circuit, {1.6, 0.13, 0.0});
  ASSERT_TRUE(between);
  EXPECT_EQ(between->position.section, 0U) << "0.13 m beats 0.07 + 0.157 m";
}

TEST(PathSnap, is_none_beyond_its_reach_and_includes_a_section_s_end) {
  const Circuit circuit = crossing_paths();
  EXPECT_FALSE(snap_to_path(circuit, {0.5, -0.31, 0.0}));
  EXPECT_TRUE(snap_to_path(circuit, {0.5, -0.30, 0.0}));
  const auto behind = snap_to_path(circuit, {-0.2, 0.1, 0.0});
  ASSERT_TRUE(behind);
  EXPECT_EQ(behind->position.s_m, 0.0);
  EXPECT_NEAR(behind->distance_m, norm(0.2, 0.1), 1e-12);
  EXPECT_FALSE(snap_to_path(circuit, {-0.2, 0.1, 0.0}, 0.2));
}

TEST(PathSnap, is_the_lower_section_where_two_begin_as_one) {
  std::vector<Circuit::Part> parts;
  parts.push_back(straight("a", {0.0, 0.0, 0.0}, 1.0));
  parts.push_back(straight("b", {0.0, 0.0, 0.0}, 2.0));
  const Circuit circuit = *Circuit::make("fork", std::move(parts));
  const auto found = snap_to_path(circuit, {0.5, 0.1, 0.0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->position.section, 0U);
}

TEST(PathSnap, is_the_lower_section_where_a_distance_and_a_turn_weigh_the_same) {
  std::vector<Circuit::Part> parts;
  parts.push_back(straight("along", {0.0, 0.0, 0.0}, 2.0));
  parts.push_back(straight("under", {1.0, 0.025, 0.5}, 1.0));
  const Circuit circuit = *Circuit::make("aslant", std::move(parts));
  // 0.025 m to the one, half a radian to the other.
  const auto found = snap_to_path(circuit, {1.0, 0.025, 0.0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->position.section, 0U);
  EXPECT_EQ(snap_to_path(circuit, {1.0, 0.025, 0.01})->position.section, 1U);
}

}  // namespace
}  // namespace cosiva::zone
