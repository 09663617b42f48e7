#include "cosiva/virtual/simulator/augmented.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <rapidcheck/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

TEST(Walk, of_one_point_stays_there) {
  const Walk walk({{1.0, 2.0}}, 0.5, Repeat::loop);
  EXPECT_FALSE(walk.walks());
  const auto at = walk.at(10s);
  EXPECT_EQ(at.at, (Point2{1.0, 2.0}));
  EXPECT_EQ(at.vx_mps, 0.0);
}

TEST(Walk, once_follows_its_legs_at_its_speed_and_stops_at_the_end) {
  const Walk walk({{0.0, 0.0}, {1.0, 0.0}, {1.0, 2.0}}, 0.5, Repeat::once);
  const auto first = walk.at(1s);
  EXPECT_NEAR(first.at.x_m, 0.5, 1e-12);
  EXPECT_NEAR(first.vx_mps, 0.5, 1e-12);
  const auto second = walk.at(4s);
  EXPECT_NEAR(second.at.x_m, 1.0, 1e-12);
  EXPECT_NEAR(second.at.y_m, 1.0, 1e-12);
  EXPECT_NEAR(second.heading_rad, 0.5 * pi, 1e-12);
  const auto end = walk.at(60s);
  EXPECT_EQ(end.at, (Point2{1.0, 2.0}));
  EXPECT_EQ(end.vy_mps, 0.0);
  EXPECT_NEAR(end.heading_rad, 0.5 * pi, 1e-12) << "it faces its last direction of motion";
}

TEST(Walk, back_and_forth_returns_on_the_same_path) {
  const Walk walk({{0.0, 0.0}, {2.0, 0.0}}, 1.0, Repeat::back_and_forth);
  EXPECT_NEAR(walk.at(3s).at.x_m, 1.0, 1e-12);
  EXPECT_NEAR(walk.at(3s).vx_mps, -1.0, 1e-12);
  EXPECT_NEAR(walk.at(5s).at.x_m, 1.0, 1e-12);
  EXPECT_NEAR(walk.at(5s).vx_mps, 1.0, 1e-12);
}

TEST(Walk, loop_closes_its_path_from_the_last_point_to_the_first) {
  const Walk walk({{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}, 1.0, Repeat::loop);
  const auto closing = walk.at(3500ms);
  EXPECT_NEAR(closing.at.x_m, 0.0, 1e-12);
  EXPECT_NEAR(closing.at.y_m, 0.5, 1e-12);
  EXPECT_NEAR(closing.vy_mps, -1.0, 1e-12);
  EXPECT_NEAR(walk.at(4500ms).at.x_m, 0.5, 1e-12);
}

TEST(Walk, accepts_repeated_points_and_a_path_without_length) {
  const Walk twice({{0.0, 0.0}, {0.0, 0.0}, {1.0, 0.0}, {1.0, 0.0}}, 1.0, Repeat::once);
  EXPECT_NEAR(twice.at(500ms).at.x_m, 0.5, 1e-12);
  EXPECT_NEAR(twice.at(9s).at.x_m, 1.0, 1e-12);
  const Walk nowhere({{1.0, 0.0}, {1.0, 0.0}}, 1.0, Repeat::back_and_forth);
  EXPECT_EQ(nowhere.at(9s).at, (Point2{1.0, 0.0}));
}

RC_GTEST_PROP(Walk, never_jumps_and_stays_within_its_bounds, (std::vector<std::pair<int, int>> corners, int repeat)) {
  std::vector<Point2> path{{0.0, 0.0}};
  for (const auto& [x, y] : corners) {
    if (path.size() == Walk::points_max) break;
    path.push_back({(x % 100) * 0.1, (y % 100) * 0.1});
  }
  const double speed = 0.7;
  const Walk walk(path, speed, static_cast<Repeat>((repeat % 3 + 3) % 3));
  Walk::Motion before = walk.at(0s);
  for (int i = 1; i <= 300; ++i) {
    const Walk::Motion now = walk.at(i * 100ms);
    RC_ASSERT(distance(before.at, now.at) <= speed * 0.1 + 1e-9);
    RC_ASSERT(std::abs(now.at.x_m) <= 10.0 && std::abs(now.at.y_m) <= 10.0);
    before = now;
  }
}

TEST(Augmented, stores_objects_by_name_and_assigns_no_handle_twice) {
  Augmented world;
  const SimTime now = virtual_epoch;
  world.add({"P1", VirtualObjectKind::person, 0, 0.06, Walk({{0.0, 0.0}}, 0.0, Repeat::once), now, now});
  EXPECT_EQ(world.find("P1")->handle, 0x8000);
  EXPECT_TRUE(world.remove("P1"));
  EXPECT_FALSE(world.remove("P1"));
  world.add({"O1", VirtualObjectKind::obstacle, 0, 0.06, Walk({{0.0, 0.0}}, 0.0, Repeat::once), now, now});
  EXPECT_EQ(world.find("O1")->handle, 0x8001) << "not the one that has just been released";
  EXPECT_FALSE(world.move("P1", Walk{}, now));
  EXPECT_TRUE(world.move("O1", Walk({{3.0, 0.0}}, 0.0, Repeat::once), now + 5s));
  EXPECT_EQ(world.find("O1")->at(now + 6s).at.x_m, 3.0);
  EXPECT_EQ(world.find("O1")->since, now);
}

TEST(Augmented, assigns_handles_cyclically_and_skips_those_in_use) {
  Augmented world;
  world.add({"P1", VirtualObjectKind::person, 0, 0.06, Walk{}, virtual_epoch, virtual_epoch});
  for (int i = 0; i < Augmented::handles + 3; ++i) {
    world.add({"O1", VirtualObjectKind::obstacle, 0, 0.06, Walk{}, virtual_epoch, virtual_epoch});
    ASSERT_NE(world.find("O1")->handle, 0x8000);
    ASSERT_LT(world.find("O1")->handle, 0xC000);
    world.remove("O1");
  }
}

TEST(Augmented, terms_are_parsed_back_from_their_text) {
  for (const Repeat repeat : {Repeat::once, Repeat::back_and_forth, Repeat::loop})
    EXPECT_EQ(parse_repeat(to_string(repeat)), repeat);
  for (const VirtualObjectKind kind : {VirtualObjectKind::person, VirtualObjectKind::obstacle})
    EXPECT_EQ(parse_virtual_object_kind(to_string(kind)), kind);
  EXPECT_FALSE(parse_repeat("twice").has_value());
  EXPECT_FALSE(parse_virtual_object_kind("aiv").has_value());
}

}  // namespace
}  // namespace cosiva::virtual_side
