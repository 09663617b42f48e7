#include "cosiva/virtual/vehicle/virtual_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

namespace cosiva::virtual_side {
namespace {

using ::testing::IsEmpty;
using zone::Circuit;
using zone::Section;

constexpr double dt_s = 0.02;
constexpr wire::Drive creep_north{50, 500, 800, 1};
constexpr wire::Drive seek{300, 500, 800, 0, true};
constexpr wire::Drive still{0, 500, 800, 0};

std::shared_ptr<const zone::TrafficZone> zone_of(Circuit circuit, std::vector<zone::Tag> tags = {}) {
  zone::TrafficZone zone{"z", std::move(circuit), {}, {}, std::move(tags), {}, {}, {}, {}, {}};
  return std::make_shared<const zone::TrafficZone>(std::move(zone));
}
/// A node at (1, 0): straight on to the east, or a turn on the spot to the north.
std::shared_ptr<const zone::TrafficZone> node() {
  return zone_of(*Circuit::make("node", {{"in", *Section::make({0, 0, 0}, 1.0), {}, {1, 2}, true},
                                         {"ahead", *Section::make({1, 0, 0}, 1.0), {}, {}},
                                         {"north", *Section::make({1, 0, 0.5 * pi}, 1.0), {}, {}}}));
}
std::shared_ptr<const zone::TrafficZone> line(const Pose2& pose, std::vector<zone::Tag> tags = {}) {
  return zone_of(*Circuit::make("line", {{"line", *Section::make(pose, 4.0), {}, {}}}), std::move(tags));
}

std::vector<Antenna::Reading> drive(VirtualBody& body, const wire::Drive& command, double seconds) {
  std::vector<Antenna::Reading> readings;
  for (int i = 0; i < static_cast<int>(std::lround(seconds / dt_s)); ++i) body.move(&command, dt_s, readings);
  return readings;
}

TEST(VirtualBody, follows_its_branch_and_stops_where_no_branch_was_commanded) {
  for (const auto& [branch, section] : {std::pair{0, 1U}, {9, 2U}}) {
    VirtualBody body{node(), {0, 0.9}};
    drive(body, {50, 500, 800, static_cast<std::uint8_t>(branch)}, 6.0);
    EXPECT_EQ(body.track_position().section, section);
  }
  VirtualBody body{node(), {0, 0.5}};
  drive(body, {400, 500, 800, wire::no_branch}, 5.0);
  EXPECT_EQ(body.track_position(), (zone::TrackPosition{0, 1.0}));
  EXPECT_EQ(body.speed_mps(), 0.0);
  EXPECT_NEAR(body.distance_m(), 0.5, 1e-12);
  EXPECT_EQ(body.manoeuvre(), nullptr);
}

TEST(VirtualBody, turns_on_the_spot_where_the_path_bends_and_counts_no_distance) {
  VirtualBody body{node(), {0, 0.95}};
  std::vector<Antenna::Reading> readings;
  double turned_rad = 0.0;
  int moves = 0;
  for (; moves < 1000 && body.track_position().section != 2; ++moves) {
    body.move(&creep_north, dt_s, readings);
    if (body.manoeuvre() == nullptr) continue;
    turned_rad = body.manoeuvre()->heading_rad;
    EXPECT_LT(distance(position(body.X_MB()), {1, 0}), 1e-12);
    EXPECT_EQ(body.speed_mps(), 0.0);
    EXPECT_FALSE(body.line_lost());
  }
  EXPECT_GT(turned_rad, 1.4);
  EXPECT_NEAR(body.distance_m(), 0.05, 1e-12);
  EXPECT_DOUBLE_EQ(body.X_MB().heading_rad, 0.5 * pi);
  // 0.05 m at 0.05 m/s after a ramp of 0.1 s, and a quarter turn as PILS turns: 1.05 + 0.5 s.
  EXPECT_NEAR(moves * dt_s, 1.05 + 1.55, 0.1);
}

TEST(VirtualBody, pauses_its_turn_while_there_is_no_command) {
  VirtualBody body{node(), {0, 0.99}};
  drive(body, creep_north, 1.0);
  ASSERT_NE(body.manoeuvre(), nullptr);
  drive(body, still, 1.0);
  const Pose2 waits = body.X_MB();
  std::vector<Antenna::Reading> readings;
  for (int i = 0; i < 50; ++i) body.move(nullptr, dt_s, readings);
  EXPECT_EQ(body.X_MB(), waits);
  drive(body, creep_north, 3.0);
  EXPECT_EQ(body.track_position().section, 2U);
}

TEST(VirtualBody, backs_up_to_where_its_section_begins_or_bends_and_no_further) {
  VirtualBody body{node(), {2, 0.2}};
  drive(body, {-200, 500, 800, 0}, 4.0);
  EXPECT_EQ(body.track_position(), (zone::TrackPosition{2, 0.0}));
  EXPECT_NEAR(body.distance_m(), -0.2, 1e-12);
  VirtualBody smooth{node(), {1, 0.2}};
  drive(smooth, {-200, 500, 800, 0}, 2.0);
  EXPECT_EQ(smooth.track_position().section, 0U);
}

TEST(VirtualBody, is_on_another_floor_after_standstill_with_its_pose_unchanged) {
  VirtualBody body{line({0, 0, 0}), {0, 0.5}};
  drive(body, {300, 500, 800, 0}, 2.0);
  body.change_floor(line({0, 0.1, 0}));
  drive(body, {300, 500, 800, 0}, 1.0);
  EXPECT_EQ(body.X_MB().y_m, 0.0);
  EXPECT_FALSE(body.line_lost());
  drive(body, still, 2.0);
  const Pose2 is_stopped = body.X_MB();
  EXPECT_EQ(is_stopped.y_m, 0.0);
  EXPECT_TRUE(body.line_lost());
  EXPECT_NEAR(body.track_position().s_m, is_stopped.x_m, 1e-9) << "the nearest track position";
  drive(body, {300, 500, 800, 0}, 1.0);
  EXPECT_EQ(body.X_MB(), is_stopped) << "no command to seek was given";
}

TEST(VirtualBody, seeks_its_path_and_reads_the_tags_of_the_new_floor) {
  VirtualBody body{line({0, 0, 0}, {{1, {0, 1.0}}}), {0, 0.5}};
  body.change_floor(line({0, 0.2, 0}, {{2, {0, 1.0}}}));
  drive(body, seek, 0.5);
  ASSERT_NE(body.manoeuvre(), nullptr);
  EXPECT_TRUE(body.line_lost());
  const auto readings = drive(body, seek, 10.0);
  EXPECT_EQ(body.manoeuvre(), nullptr);
  EXPECT_FALSE(body.line_lost());
  EXPECT_EQ(body.X_MB().y_m, 0.2);
  ASSERT_GT(body.X_MB().x_m, 1.1);
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(readings[0].number, 2U);
  EXPECT_NEAR(body.distance_m(), body.X_MB().x_m - 0.5, 1e-9);
}

TEST(VirtualBody, seeks_any_path_within_reach_and_ends_on_it) {
  EXPECT_TRUE(rc::check("it ends on the path, heading along it", [] {
    const Pose2 off{*rc::gen::inRange(-100, 101) * 1e-3, *rc::gen::inRange(-300, 301) * 1e-3,
                    *rc::gen::inRange(-3141, 3142) * 1e-3};
    VirtualBody body{line({0, 0, 0}), {0, 2.0}};
    const auto next = line(Pose2{2, 0, 0} * off * Pose2{-2, 0, 0});
    body.change_floor(next);
    std::vector<Antenna::Reading> readings;
    Pose2 last;
    for (int i = 0; i < 600 && (i < 2 || body.manoeuvre() != nullptr); ++i) {
      body.move(&seek, dt_s, readings);
      if (body.manoeuvre() != nullptr) last = *body.manoeuvre();
    }
    const auto near = next->circuit.locate(position(body.X_MB()));
    RC_ASSERT(near.distance_m < 1e-9);
    RC_ASSERT(std::fabs(wrap_angle(body.X_MB().heading_rad - off.heading_rad)) < 1e-9);
    RC_ASSERT(distance(Pose2{2, 0, 0} * last, body.X_MB()) < 0.01);  // one move of the straight leg at most
  }));
}

// A driver always states where it estimates the path to be. Without a commanded clearance the body must not sweep
// about.
TEST(VirtualBody, with_a_goal_at_its_own_pose_does_not_turn_across_the_path) {
  VirtualBody body{line({0, 0, 0}), {0, 0.5}};
  body.change_floor(line({0, 0.004, 0.02}));
  constexpr wire::Drive to_goal{300, 500, 800, 0, true, wire::Manoeuvre{0, 4, 20}};
  std::vector<Antenna::Reading> readings;
  double off_rad = 0.0;
  for (int i = 0; i < 100; ++i) {
    body.move(&to_goal, dt_s, readings);
    off_rad = std::max(off_rad, std::fabs(body.X_MB().heading_rad));
  }
  EXPECT_NEAR(off_rad, 0.02, 1e-9);
  EXPECT_GT(body.X_MB().x_m, 0.6) << "and it drives on";
}

TEST(VirtualBody, with_a_goal_drives_onto_the_path_at_the_goal) {
  VirtualBody body{line({0, 0, 0}), {0, 0.5}};
  body.change_floor(line({0, 0.2, 0}));
  constexpr wire::Drive to_goal{300, 500, 800, 0, true, wire::Manoeuvre{300, 200, 0}};
  drive(body, to_goal, 0.1);
  ASSERT_NE(body.manoeuvre(), nullptr);
  std::vector<Antenna::Reading> readings;
  while (body.manoeuvre() != nullptr) body.move(&to_goal, dt_s, readings);
  EXPECT_LT(distance(body.X_MB(), {0.8, 0.2, 0}), 1e-9);
}

TEST(VirtualBody, finds_no_path_out_of_reach_and_stays) {
  VirtualBody body{line({0, 0, 0}), {0, 0.5}};
  body.change_floor(line({0, 0.4, 0}));
  EXPECT_THAT(drive(body, seek, 3.0), IsEmpty());
  EXPECT_EQ(body.X_MB(), (Pose2{0.5, 0, 0}));
  EXPECT_TRUE(body.line_lost());
  EXPECT_EQ(body.manoeuvre(), nullptr);
}

TEST(VirtualBody, continues_where_the_floors_have_the_section_in_common) {
  VirtualBody body{line({0, 0, 0}), {0, 0.5}};
  body.change_floor(line({-1, 0, 0}));
  drive(body, {300, 500, 800, 0}, 2.0);
  EXPECT_FALSE(body.line_lost());
  EXPECT_GT(body.X_MB().x_m, 0.9);
  EXPECT_NEAR(body.track_position().s_m, body.X_MB().x_m + 1.0, 1e-9);
}

TEST(VirtualBody, adopts_edited_tags_at_once_and_stays_on_its_path) {
  VirtualBody body{line({0, 0, 0}, {{1, {0, 1.0}}}), {0, 0.5}};
  drive(body, {300, 500, 800, 0}, 0.5);
  body.change_floor(line({0, 0, 0}, {{1, {0, 1.5}}}));
  EXPECT_FALSE(body.line_lost());
  EXPECT_THAT(drive(body, {300, 500, 800, 0}, 2.0), IsEmpty());
  EXPECT_GT(body.track_position().s_m, 1.1);
  EXPECT_EQ(drive(body, {300, 500, 800, 0}, 2.0).size(), 1U);
}

}  // namespace
}  // namespace cosiva::virtual_side
