#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/physical/plant/odometer.h"
#include "cosiva/physical/plant/tracked_vehicle.h"
#include "cosiva/physical/plant/vehicle_dynamics.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::physical {
namespace {

using zone::Circuit;
using zone::Section;

constexpr double dt_s = 0.01;

TrackedVehicle on(const Circuit& circuit, zone::TrackPosition start = {0, 0.0}, double line_sd_m = 0.0) {
  return {circuit, start, line_sd_m, Random{1, "line"}};
}
void drive(TrackedVehicle& vehicle, const DriveCommand& command, double seconds) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / dt_s)); ++i) vehicle.step(&command, dt_s);
}

/// A node at (1, 0), reached from the west; the branches lead east (smoothly), north, or back.
Circuit node() {
  return *Circuit::make("node", {{"in", *Section::make({0, 0, 0}, 1.0), {}, {1, 2, 3}, true},
                                 {"ahead", *Section::make({1, 0, 0}, 1.0), {}, {}},
                                 {"north", *Section::make({1, 0, 0.5 * pi}, 1.0), {}, {}},
                                 {"back", *Section::make({1, 0, pi}, 1.0), {}, {}}});
}
constexpr DriveCommand creep(std::size_t branch) { return {0.05, 0.5, 0.8, branch}; }

TEST(LineVehicle, stops_at_a_sharp_bend_turns_on_the_spot_and_follows_the_next_section) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.95});
  double along_m = 0.0;
  double turned_rad = 0.0;
  for (int i = 0; i < 1000 && circuit.part(vehicle.track_position().section).name == "in"; ++i) {
    const DriveCommand command = creep(1);
    vehicle.step(&command, dt_s);
    along_m += vehicle.step_distance_m();
    if (vehicle.manoeuvre() != nullptr) {
      EXPECT_EQ(vehicle.speed_mps(), 0.0);
      EXPECT_LT(distance(vehicle.body().X_MB, {1, 0, 0}), 1e-9) << "its centre stays on the joint";
      EXPECT_FALSE(vehicle.line_lost());
    }
    turned_rad += vehicle.step_manoeuvre().turned_rad;
  }
  EXPECT_NEAR(along_m, 0.05, 0.001) << "a turn adds no distance";
  EXPECT_NEAR(turned_rad, 0.5 * pi, 1e-9);
  EXPECT_EQ(vehicle.track_position(), (zone::TrackPosition{2, 0.0}));
  EXPECT_TRUE(vehicle.following());
  drive(vehicle, creep(0), 4.0);
  EXPECT_NEAR(vehicle.body().X_MB.x_m, 1.0, 1e-9);
  EXPECT_GT(vehicle.body().X_MB.y_m, 0.15);
}

TEST(LineVehicle, takes_the_smooth_branch_of_a_node_without_stopping) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.5});
  const DriveCommand command{0.5, 1.0, 1.0, 0};
  drive(vehicle, command, 1.0);
  for (int i = 0; i < 100; ++i) {
    vehicle.step(&command, dt_s);
    ASSERT_GT(vehicle.speed_mps(), 0.4);
  }
  EXPECT_EQ(circuit.part(vehicle.track_position().section).name, "ahead");
}

TEST(LineVehicle, stops_where_no_branch_is_commanded_and_goes_on_when_one_is) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.5});
  drive(vehicle, {0.5, 1.0, 1.0, wire::no_branch}, 5.0);
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
  EXPECT_EQ(vehicle.track_position(), (zone::TrackPosition{0, 1.0}));
  EXPECT_TRUE(vehicle.following());
  drive(vehicle, creep(2), 6.0);
  EXPECT_EQ(circuit.part(vehicle.track_position().section).name, "back");
  EXPECT_LT(vehicle.body().X_MB.x_m, 1.0);
}

TEST(LineVehicle, waiting_at_a_fork_counts_no_distance_however_long_it_is_commanded_to_drive) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.95});
  double rolled_m = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const DriveCommand command = creep(wire::no_branch);
    vehicle.step(&command, dt_s);
    rolled_m += vehicle.step_distance_m();
  }
  EXPECT_EQ(vehicle.track_position(), (zone::TrackPosition{0, 1.0}));
  EXPECT_NEAR(rolled_m, 0.05, 1e-6);
}

TEST(LineVehicle, brakes_for_a_bend_no_harder_than_its_motors_can) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.1});
  const DriveCommand command{0.8, 3.0, 1.0, 1};
  double before_mps = 0.0;
  for (int i = 0; i < 300 && vehicle.manoeuvre() == nullptr; ++i) {
    vehicle.step(&command, dt_s);
    EXPECT_GT(vehicle.speed_mps() - before_mps, -1.2 * 4.0 * dt_s) << i;
    before_mps = vehicle.speed_mps();
  }
  ASSERT_NE(vehicle.manoeuvre(), nullptr);
}

TEST(LineVehicle, turns_only_while_it_is_commanded) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.99});
  for (int i = 0; i < 500 && vehicle.manoeuvre() == nullptr; ++i) drive(vehicle, creep(1), dt_s);
  drive(vehicle, creep(1), 0.5);
  drive(vehicle, {0.0, 0.5, 0.8, 1}, 0.4);
  const Pose2 waits = vehicle.body().X_MB;
  EXPECT_GT(waits.heading_rad, 0.1);
  EXPECT_LT(waits.heading_rad, 1.5);
  EXPECT_FALSE(vehicle.is_stopped()) << "it was commanded less than 0.3 s ago, as far as its wheels have come to rest";
  for (int i = 0; i < 100; ++i) vehicle.step(nullptr, dt_s);
  EXPECT_TRUE(vehicle.is_stopped());
  drive(vehicle, {-0.1, 0.5, 0.8, 1}, 0.5);
  EXPECT_LT(std::fabs(vehicle.body().X_MB.heading_rad - waits.heading_rad), 0.5);
  EXPECT_NE(vehicle.manoeuvre(), nullptr);
  // The branch was chosen when the turn began.
  for (int i = 0; i < 300 && vehicle.manoeuvre() != nullptr; ++i) drive(vehicle, creep(2), dt_s);
  EXPECT_EQ(circuit.part(vehicle.track_position().section).name, "north");
}

TEST(LineVehicle, that_coasts_onto_a_bend_waits_at_it) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.9});
  drive(vehicle, {0.5, 3.0, 1.0, 1}, 0.25);
  for (int i = 0; i < 500; ++i) vehicle.step(nullptr, dt_s);
  EXPECT_EQ(vehicle.manoeuvre(), nullptr);
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
  EXPECT_EQ(vehicle.track_position().section, 0U);
}

TEST(LineVehicle, that_coasts_over_a_fork_keeps_to_the_commanded_branch) {
  const auto trunk = *Section::make({0, 0, 0}, 1.0);
  const Circuit circuit = *Circuit::make("fork", {{"trunk", trunk, {}, {1, 2}},
                                                  {"left", *Section::make({1, 0, 0}, 1.0, 1.0), {}, {}},
                                                  {"right", *Section::make({1, 0, 0}, 1.0, -1.0), {}, {}}});
  TrackedVehicle vehicle = on(circuit, {0, 0.5});
  drive(vehicle, {0.6, 1.0, 1.0, 1}, 1.1);
  ASSERT_EQ(vehicle.track_position().section, 0U);
  for (int i = 0; i < 500; ++i) vehicle.step(nullptr, dt_s);
  EXPECT_EQ(circuit.part(vehicle.track_position().section).name, "right");
}

TEST(LineVehicle, backs_up_to_a_sharp_bend_and_no_further) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {2, 0.3});
  drive(vehicle, {-0.3, 1.0, 1.0, 0}, 5.0);
  EXPECT_EQ(vehicle.track_position(), (zone::TrackPosition{2, 0.0}));
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
}

TEST(LineVehicle, turns_onto_the_line_as_accurately_as_it_is_painted) {
  EXPECT_TRUE(rc::check("after any turn it is on the next section, with small errors", [] {
    const double turn_rad = *rc::gen::inRange(-3100, 3101) * 1e-3;
    RC_PRE(std::fabs(turn_rad) > 2e-3);
    const Circuit circuit = *Circuit::make("bend", {{"in", *Section::make({0, 0, 0}, 1.0), {}, {1}, true},
                                                    {"out", *Section::make({1, 0, turn_rad}, 2.0), {}, {}}});
    TrackedVehicle vehicle{circuit, {0, 0.5}, 0.0005, Random{*rc::gen::arbitrary<std::uint32_t>(), "line"}};
    drive(vehicle, {0.3, 0.5, 0.8, 0}, 1.0);
    for (int i = 0; i < 3000 && vehicle.track_position().section == 0; ++i) drive(vehicle, creep(0), dt_s);
    RC_ASSERT(vehicle.track_position().section == 1U);
    RC_ASSERT(distance(vehicle.body().X_MB, circuit.pose_at({1, 0.0})) < 0.003);
    RC_ASSERT(std::fabs(vehicle.heading_error_rad()) < 0.03);
    drive(vehicle, {0.3, 0.5, 0.8, 0}, 2.0);
    RC_ASSERT(std::fabs(vehicle.lateral_error_m()) < 0.003);
  }));
}

// --- another floor

/// One straight section along y = 0.
Circuit line() { return *Circuit::make("line", {{"line", *Section::make({-5, 0, 0}, 10.0), {}, {}}}); }
/// A section that begins at `pose` and is 4 m long.
Circuit other(const Pose2& pose) { return *Circuit::make("other", {{"other", *Section::make(pose, 4.0), {}, {}}}); }
constexpr DriveCommand seek{0.3, 0.5, 0.8, 0, true};

TEST(LineVehicle, put_on_another_floor_stays_in_place_and_waits_off_the_path) {
  const Circuit old = line();
  const Circuit next = other({-2, 0.2, 0.1});
  TrackedVehicle vehicle = on(old, {0, 5.0});
  const Pose2 before = vehicle.body().X_MB;
  vehicle.set_zone(next);
  EXPECT_TRUE(vehicle.line_lost());
  EXPECT_FALSE(vehicle.following());
  drive(vehicle, {0.3, 0.5, 0.8, 0}, 1.0);        // not commanded to seek
  drive(vehicle, {0.0, 0.5, 0.8, 0, true}, 1.0);  // commanded to seek, at no speed
  drive(vehicle, {-0.3, 0.5, 0.8, 0, true}, 1.0);
  for (int i = 0; i < 100; ++i) vehicle.step(nullptr, dt_s);
  EXPECT_EQ(vehicle.body().X_MB, before);
  EXPECT_EQ(vehicle.manoeuvre(), nullptr);
  EXPECT_TRUE(vehicle.is_stopped());
}

TEST(LineVehicle, seeks_the_line_within_reach_and_follows_it) {
  EXPECT_TRUE(rc::check("wherever the line lies it ends on it, heading along it", [] {
    const double off_m = *rc::gen::inRange(-340, 341) * 1e-3;
    const double turned_rad = *rc::gen::inRange(-3141, 3142) * 1e-3;
    const Circuit old = line();
    // A line at a lateral offset of `off_m` from (0, 0); the foot of the perpendicular is 2 m from its start.
    const Circuit next = other(Pose2{0, 0, turned_rad} * Pose2{-2.0, off_m, 0});
    TrackedVehicle vehicle = on(old, {0, 5.0}, 0.0005);
    const Pose2 began = vehicle.body().X_MB;
    vehicle.set_zone(next);
    Pose2 summed;
    bool manoeuvred = false;
    for (int i = 0; i < 1500 && !vehicle.following(); ++i) {
      vehicle.step(&seek, dt_s);
      RC_ASSERT(vehicle.speed_mps() == 0.0);
      RC_ASSERT(vehicle.step_distance_m() == 0.0);
      const auto [turned, traversed] = vehicle.step_manoeuvre();
      summed = summed * Pose2{traversed, 0.0, turned};
      manoeuvred = manoeuvred || vehicle.manoeuvre() != nullptr;
    }
    RC_ASSERT(manoeuvred);
    RC_ASSERT(vehicle.following());
    RC_ASSERT(distance(began * summed, vehicle.body().X_MB) < 1e-3);
    RC_ASSERT(std::fabs(vehicle.track_position().s_m - 2.0) < 1e-6);
    // A vehicle that detected the line from its initial position only turned along it: steering does the rest.
    const bool saw_it = std::fabs(off_m) <= DriveTrain{}.line_lost_m && std::fabs(turned_rad) <= aiv::on_line_rad;
    RC_ASSERT(std::fabs(vehicle.lateral_error_m()) < (saw_it ? std::fabs(off_m) + 1e-9 : 0.003));
    RC_ASSERT(!vehicle.line_lost());
    drive(vehicle, {0.3, 0.5, 0.8, 0}, 2.0);
    RC_ASSERT(vehicle.track_position().s_m > 2.3);
    RC_ASSERT(std::fabs(vehicle.lateral_error_m()) < 0.003);
  }));
}

TEST(LineVehicle, given_a_goal_drives_onto_the_line_at_that_position) {
  const Circuit old = line();
  const Circuit next = other({-2, 0.2, 0});
  const auto commanded = [&](const wire::Manoeuvre& goal) {
    TrackedVehicle vehicle = on(old, {0, 5.0});
    vehicle.set_zone(next);
    const DriveCommand command{0.3, 0.5, 0.8, 0, true, goal};
    for (int i = 0; i < 1500 && !vehicle.following(); ++i) vehicle.step(&command, dt_s);
    return vehicle;
  };
  // The line is found although its estimated position is 3 cm off: 0.3 m ahead, 0.2 m to the left.
  const LineVehicle vehicle = commanded({300, 230, 0});
  EXPECT_TRUE(vehicle.following());
  EXPECT_LT(distance(vehicle.body().X_MB, {0.3, 0.2, 0.0}), 1e-9);
  EXPECT_FALSE(vehicle.line_lost());
  EXPECT_LT(distance(commanded({-250, 200, 0}).body().X_MB, {-0.25, 0.2, 0.0}), 1e-9) << "or behind it";
  EXPECT_EQ(commanded({300, 310, 0}).manoeuvre(), nullptr) << "0.11 m from any line";
  EXPECT_TRUE(commanded({300, 310, 0}).line_lost());
}

TEST(LineVehicle, seeks_nothing_that_lies_beyond_its_reach) {
  const Circuit old = line();
  const Circuit next = other({-2, 0.36, 0});
  TrackedVehicle vehicle = on(old, {0, 5.0});
  vehicle.set_zone(next);
  drive(vehicle, seek, 3.0);
  EXPECT_EQ(vehicle.manoeuvre(), nullptr);
  EXPECT_LT(distance(vehicle.body().X_MB, {0, 0, 0}), 1e-12);
  EXPECT_TRUE(vehicle.line_lost());
}

TEST(LineVehicle, goes_on_where_the_new_floor_has_the_same_line_as_the_old_one) {
  const Circuit old = line();
  const Circuit next = other(Pose2{0, 0.003, 0.02} * Pose2{-2, 0, 0});
  TrackedVehicle vehicle = on(old, {0, 5.0});
  vehicle.set_zone(next);
  EXPECT_FALSE(vehicle.line_lost());
  drive(vehicle, {0.3, 0.5, 0.8, 0}, 2.0);
  EXPECT_EQ(vehicle.manoeuvre(), nullptr);
  EXPECT_GT(vehicle.body().X_MB.x_m, 0.4);
  EXPECT_LT(std::fabs(vehicle.lateral_error_m()), 0.001);
  EXPECT_NEAR(vehicle.body().X_MB.heading_rad, 0.02, 0.001);
}

TEST(LineVehicle, commanded_to_seek_on_the_line_makes_a_manoeuvre_that_is_reported) {
  const Circuit old = line();
  const Circuit next = other({-2, 0.0, 0.0});
  TrackedVehicle vehicle = on(old, {0, 5.0});
  vehicle.set_zone(next);
  int steps = 0;
  for (int i = 0; i < 100; ++i) {
    vehicle.step(&seek, dt_s);
    steps += vehicle.manoeuvre() != nullptr ? 1 : 0;
  }
  EXPECT_GE(steps, 9);
  EXPECT_TRUE(vehicle.following());
  EXPECT_GT(vehicle.speed_mps(), 0.2) << "the flag has no effect after that";
}

TEST(LineVehicle, commanded_to_seek_slightly_off_the_line_s_centre_does_not_turn_across_it) {
  const Circuit old = line();
  // The new line has an offset of 8 mm and an angle of 0.02 rad: the sensors detect it.
  const Circuit next = other(Pose2{0, 0.008, 0.02} * Pose2{-2, 0, 0});
  TrackedVehicle vehicle = on(old, {0, 5.0});
  vehicle.set_zone(next);
  double turned_rad = 0.0;
  for (int i = 0; i < 100; ++i) {
    vehicle.step(&seek, dt_s);
    turned_rad += std::fabs(vehicle.step_manoeuvre().turned_rad);
  }
  EXPECT_TRUE(vehicle.following());
  EXPECT_LT(turned_rad, 0.05);
}

// The on-board program always gives the line's estimated position. A seek that needs no room must not sweep over the
// floor.
TEST(LineVehicle, given_a_line_at_its_own_position_does_not_turn_across_it) {
  const Circuit old = line();
  const Circuit next = other(Pose2{0, 0.008, 0.02} * Pose2{-2, 0, 0});
  for (const wire::Manoeuvre goal : {wire::Manoeuvre{0, 0, 0}, {3, -4, 15}, {-4, 2, -30}}) {
    TrackedVehicle vehicle = on(old, {0, 5.0}, 0.002);
    vehicle.set_zone(next);
    const DriveCommand commanded{0.3, 0.5, 0.8, 0, true, goal};
    double turned_rad = 0.0;
    for (int i = 0; i < 100; ++i) {
      vehicle.step(&commanded, dt_s);
      turned_rad += std::fabs(vehicle.step_manoeuvre().turned_rad);
    }
    EXPECT_TRUE(vehicle.following());
    EXPECT_LT(turned_rad, 0.1);
  }
}

TEST(LineVehicle, given_a_line_at_an_angle_turns_to_its_heading_and_not_past_it) {
  const Circuit old = line();
  const Circuit next = other(Pose2{0, 0.005, -1.3} * Pose2{-2, 0, 0});
  TrackedVehicle vehicle = on(old, {0, 5.0});
  vehicle.set_zone(next);
  const DriveCommand commanded{0.3, 0.5, 0.8, 0, true, wire::Manoeuvre{-1, 5, -1300}};
  double least_rad = 0.0;
  for (int i = 0; i < 400 && !vehicle.following(); ++i) {
    vehicle.step(&commanded, dt_s);
    least_rad = std::min(least_rad, vehicle.body().X_MB.heading_rad);
  }
  EXPECT_TRUE(vehicle.following());
  EXPECT_NEAR(least_rad, -1.3, 1e-9);
  EXPECT_LT(std::fabs(vehicle.lateral_error_m()), 0.006);
}

TEST(LineVehicle, abandons_a_manoeuvre_without_commands_when_the_floor_is_replaced) {
  const Circuit circuit = node();
  TrackedVehicle vehicle = on(circuit, {0, 0.99});
  for (int i = 0; i < 500 && vehicle.manoeuvre() == nullptr; ++i) drive(vehicle, creep(1), dt_s);
  drive(vehicle, creep(1), 0.4);
  for (int i = 0; i < 100; ++i) vehicle.step(nullptr, dt_s);
  ASSERT_TRUE(vehicle.is_stopped());
  const Pose2 before = vehicle.body().X_MB;
  const Circuit next = other({-1, 0.1, 0});
  vehicle.set_zone(next);
  EXPECT_EQ(vehicle.manoeuvre(), nullptr);
  drive(vehicle, {0.0, 0.5, 0.8, 0}, 0.5);
  EXPECT_EQ(vehicle.body().X_MB, before);
  for (int i = 0; i < 1500 && !vehicle.following(); ++i) vehicle.step(&seek, dt_s);
  EXPECT_NEAR(vehicle.track_position().s_m, 2.0, 1e-9);
}

TEST(LineVehicle, put_on_another_floor_while_it_moves_is_an_internal_error) {
  const Circuit old = line();
  const Circuit next = other({-2, 0.2, 0});
  TrackedVehicle vehicle = on(old, {0, 1.0});
  drive(vehicle, {0.3, 0.5, 0.8, 0}, 1.0);
  EXPECT_DEATH(vehicle.set_zone(next), "is_stopped");
}

TEST(Odometer, measures_a_manoeuvre_from_its_start_and_leaves_the_distance_unchanged) {
  Odometer exact{0.0, 0.0, 0.0, Random{1, "o"}};
  exact.add(1.0, 0.0);
  exact.begin_manoeuvre();
  for (int i = 0; i < 100; ++i) exact.add_manoeuvre(0.5 * pi / 100.0, 0.0);
  for (int i = 0; i < 100; ++i) exact.add_manoeuvre(0.0, 0.002);
  EXPECT_NEAR(exact.X_SB().x_m, 0.0, 1e-12);
  EXPECT_NEAR(exact.X_SB().y_m, 0.2, 1e-12);
  EXPECT_NEAR(exact.X_SB().heading_rad, 0.5 * pi, 1e-12);
  EXPECT_EQ(exact.distance_m(), 1.0);
  exact.begin_manoeuvre();
  EXPECT_EQ(exact.X_SB(), Pose2{});
}

TEST(Odometer, errs_in_a_turn_as_much_as_its_wheels_do) {
  // In a quarter turn each wheel travels 0.05 m · π/2 = 78.5 mm: σ = 3 mm · √0.0785 = 0.84 mm, over 50 mm: 16.8 mrad.
  // The sample deviation of 400 has a relative σ of 1/√800 = 3.5 %.
  double sum_sq = 0.0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Odometer odometer{0.0, 0.003, 0.0, Random{seed, "o"}};
    odometer.begin_manoeuvre();
    for (int i = 0; i < 100; ++i) odometer.add_manoeuvre(0.5 * pi / 100.0, 0.0);
    const double error = odometer.X_SB().heading_rad - 0.5 * pi;
    sum_sq += error * error;
  }
  EXPECT_NEAR(std::sqrt(sum_sq / 400.0), 0.0168, 4.0 * 0.035 * 0.0168);
}

}  // namespace
}  // namespace cosiva::physical
