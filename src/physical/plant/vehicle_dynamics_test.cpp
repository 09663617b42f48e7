#include "cosiva/physical/plant/vehicle_dynamics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "cosiva/physical/plant/odometer.h"
#include "cosiva/physical/plant/test_zones.h"
#include "cosiva/physical/plant/tracked_vehicle.h"

namespace cosiva::physical {
namespace {

using zone::Circuit;
using zone::Section;

constexpr double dt_s = 0.01;

zone::Rtm read(zone::ZoneConfiguration configuration) {
  auto rtm = zone::Rtm::initialise(std::move(configuration));
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return std::move(*rtm);
}

TrackedVehicle on(const Circuit& circuit, zone::TrackPosition start = {0, 0.0}, double line_sd_m = 0.0) {
  return {circuit, start, line_sd_m, Random{1, "line"}};
}

void drive(TrackedVehicle& vehicle, const DriveCommand& command, double seconds) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / dt_s)); ++i) vehicle.step(&command, dt_s);
}
double drift_to_rest(TrackedVehicle& vehicle) {
  double distance_m = 0.0;
  for (int i = 0; i < 1000 && (i == 0 || vehicle.speed_mps() != 0.0); ++i) {
    vehicle.step(nullptr, dt_s);
    distance_m += vehicle.step_distance_m();
  }
  return distance_m;
}

Circuit fork() {
  const auto trunk = *Section::make({0, 0, 0}, 1.0);
  const auto left = *Section::make({1, 0, 0}, 1.0, 1.0);
  const auto right = *Section::make({1, 0, 0}, 1.0, -1.0);
  return *Circuit::make("fork", {{"trunk", trunk, {}, {1, 2}}, {"left", left, {}, {}}, {"right", right, {}, {}}});
}

TEST(LineVehicle, reaches_the_commanded_speed_with_its_acceleration_and_lag) {
  const auto rtm = read(straight(10.0));
  TrackedVehicle vehicle = on(rtm.zone().circuit);
  const DriveCommand command{0.5, 0.5, 1.0, 0};
  drive(vehicle, command, 1.0);
  // A first-order lag τ behind a ramp a·t lags by a·τ = 25 mm/s.
  EXPECT_NEAR(vehicle.speed_mps(), 0.475, 0.006);
  drive(vehicle, command, 0.5);
  EXPECT_NEAR(vehicle.speed_mps(), 0.5, 1e-4);
  // v²/2a + v·(t − v/a) − v·τ, to one tick's distance.
  EXPECT_NEAR(vehicle.track_position().s_m, 0.25 + 0.25 - 0.025, 0.006);
}

TEST(LineVehicle, stops_within_what_its_braking_and_lag_need) {
  const auto rtm = read(straight(10.0));
  TrackedVehicle vehicle = on(rtm.zone().circuit);
  drive(vehicle, {0.6, 1.0, 1.0, 0}, 2.0);
  const double distance_m = drift_to_rest(vehicle);
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
  EXPECT_NEAR(distance_m, 0.6 * 0.6 / 2.0 + 0.6 * 0.05, 0.006);  // one tick's distance either side
}

TEST(LineVehicle, takes_its_own_braking_where_the_command_leaves_it_open) {
  const auto rtm = read(straight(10.0));
  TrackedVehicle vehicle = on(rtm.zone().circuit);
  drive(vehicle, {0.6, 0.0, 0.0, 0}, 1.2);
  EXPECT_NEAR(vehicle.speed_mps(), 0.6, 1e-3);
  drive(vehicle, {0.0, 0.0, 0.0, 0}, 1.2);
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
}

TEST(LineVehicle, backs_up_over_a_joint_and_returns) {
  const auto rtm = read(lacet4());
  const Circuit& circuit = rtm.zone().circuit;
  const zone::SectionId loop = circuit.find("loop_se").value();
  TrackedVehicle vehicle = on(circuit, {loop, 0.2});
  drive(vehicle, {-0.3, 1.0, 1.0, 0}, 2.0);
  EXPECT_EQ(circuit.part(vehicle.track_position().section).name, "east");
  EXPECT_LT(std::fabs(vehicle.lateral_error_m()), 0.002);
  EXPECT_LT(vehicle.speed_mps(), 0.0);
  drive(vehicle, {0.3, 1.0, 1.0, 0}, 4.0);
  EXPECT_EQ(circuit.part(vehicle.track_position().section).name, "loop_se");
  EXPECT_LT(std::fabs(vehicle.lateral_error_m()), 0.002);
}

TEST(LineVehicle, turns_round_through_standstill) {
  const auto rtm = read(straight(10.0));
  TrackedVehicle vehicle = on(rtm.zone().circuit, {0, 5.0});
  drive(vehicle, {0.5, 1.0, 1.0, 0}, 1.0);
  const DriveCommand back{-0.5, 1.0, 1.0, 0};
  double fastest_change = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double before = vehicle.speed_mps();
    vehicle.step(&back, dt_s);
    fastest_change = std::max(fastest_change, std::fabs(vehicle.speed_mps() - before) / dt_s);
  }
  EXPECT_NEAR(vehicle.speed_mps(), -0.5, 1e-3);
  EXPECT_LE(fastest_change, 1.0 + 1e-9);
}

TEST(LineVehicle, stays_on_the_path_over_a_lap_at_full_speed) {
  const auto rtm = read(lacet4());
  const Circuit& circuit = rtm.zone().circuit;
  TrackedVehicle vehicle = on(circuit, {0, 0.3}, 0.0005);
  const DriveCommand fast{0.6, 0.8, 1.0, 0};
  double worst_m = 0.0;
  double travelled_m = 0.0;
  while (travelled_m < circuit.total_length_m()) {
    vehicle.step(&fast, dt_s);
    travelled_m += vehicle.step_distance_m();
    worst_m = std::max(worst_m, std::fabs(vehicle.lateral_error_m()));
    ASSERT_FALSE(vehicle.line_lost());
    // The pose is the state of the dynamics: the path's nearest point is lateral_error away from the body.
    const auto nearest = circuit.section(vehicle.track_position().section).nearest(position(vehicle.body().X_MB));
    ASSERT_NEAR(nearest.left_m, vehicle.lateral_error_m(), 1e-6);
  }
  EXPECT_LT(worst_m, 0.002);
  EXPECT_GT(worst_m, 1e-5);  // and the vehicle is no train on rails
  EXPECT_NEAR(vehicle.track_position().s_m, 0.3, 0.02);
}

TEST(LineVehicle, stays_on_the_path_backwards_too) {
  const auto rtm = read(lacet4());
  TrackedVehicle vehicle = on(rtm.zone().circuit, {0, 0.3}, 0.0005);
  const DriveCommand back{-0.4, 0.8, 1.0, 0};
  for (int i = 0; i < 5000; ++i) {
    vehicle.step(&back, dt_s);
    ASSERT_LT(std::fabs(vehicle.lateral_error_m()), 0.003) << i;
  }
}

TEST(LineVehicle, takes_the_commanded_branch) {
  const Circuit circuit = fork();
  for (const auto& [branch, name] : {std::pair{0U, "left"}, {1U, "right"}, {7U, "right"}}) {
    TrackedVehicle vehicle = on(circuit);
    drive(vehicle, {0.5, 1.0, 1.0, branch}, 3.0);
    EXPECT_EQ(circuit.part(vehicle.track_position().section).name, name);
  }
}

TEST(LineVehicle, stops_at_a_dead_end_in_either_direction) {
  const Circuit circuit = fork();
  TrackedVehicle vehicle = on(circuit);
  drive(vehicle, {0.5, 1.0, 1.0, 0}, 10.0);
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
  EXPECT_DOUBLE_EQ(vehicle.track_position().s_m, 1.0);
  drive(vehicle, {-0.5, 1.0, 1.0, 0}, 10.0);
  EXPECT_EQ(vehicle.track_position(), (zone::TrackPosition{0, 0.0}));
  EXPECT_EQ(vehicle.speed_mps(), 0.0);
}

TEST(LineVehicle, keeps_to_the_path_at_any_speed_and_curvature_a_vehicle_can_drive) {
  EXPECT_TRUE(rc::check("lateral error stays within the sensors' width", [] {
    const double speed = *rc::gen::inRange(5, 80) * 0.01;
    const double radius_m = *rc::gen::inRange(30, 300) * 0.01;
    const double side = *rc::gen::element(-1.0, 1.0);
    const auto line = *Section::make({0, 0, 0}, 1.0);
    const auto bend = *Section::make(line.end(), radius_m * pi, side / radius_m);
    const auto after = *Section::make(bend.end(), 3.0);
    const auto circuit =
        *Circuit::make("bend", {{"in", line, {}, {1}}, {"bend", bend, {}, {2}}, {"out", after, {}, {}}});
    TrackedVehicle vehicle = on(circuit);
    const DriveCommand command{speed, 1.0, 1.0, 0};
    double worst_m = 0.0;
    for (int i = 0; i < 3000; ++i) {
      vehicle.step(&command, dt_s);
      worst_m = std::max(worst_m, std::fabs(vehicle.lateral_error_m()));
    }
    RC_ASSERT(worst_m < 0.012);
  }));
}

TEST(Odometer, counts_the_exact_distance_without_errors) {
  Odometer odometer{0.0, 0.0, 0.0, Random{1, "o"}};
  for (int i = 0; i < 1000; ++i) odometer.add(0.005, 0.3);
  EXPECT_NEAR(odometer.distance_m(), 5.0, 1e-9);
  for (int i = 0; i < 1000; ++i) odometer.add(-0.005, 0.3);
  EXPECT_NEAR(odometer.distance_m(), 0.0, 1e-9);
}

TEST(Odometer, counts_more_than_the_distance_when_the_wheels_spin_and_less_when_they_slide) {
  Odometer spinning{0.0, 0.0, 0.002, Random{1, "o"}};
  spinning.add(1.0, 2.0);
  EXPECT_DOUBLE_EQ(spinning.distance_m(), 1.004);
  Odometer sliding{0.0, 0.0, 0.002, Random{1, "o"}};
  sliding.add(1.0, -2.0);
  EXPECT_DOUBLE_EQ(sliding.distance_m(), 0.996);
}

TEST(Odometer, has_an_error_that_grows_with_the_root_of_the_distance) {
  // 400 wheels over 4 m each: σ = 3 mm · √4 = 6 mm. The sample deviation of 400 has a relative σ of 1/√800 = 3.5 %.
  double sum_sq = 0.0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Odometer odometer{0.0, 0.003, 0.0, Random{seed, "o"}};
    for (int i = 0; i < 800; ++i) odometer.add(0.005, 0.0);
    sum_sq += (odometer.distance_m() - 4.0) * (odometer.distance_m() - 4.0);
  }
  EXPECT_NEAR(std::sqrt(sum_sq / 400.0), 0.006, 4.0 * 0.035 * 0.006);
}

}  // namespace
}  // namespace cosiva::physical
