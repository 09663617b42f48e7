#include "cosiva/aiv/localisation/estimator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;

/// No latency and no antenna field: the fix is exactly the tag's position.
constexpr EstimatorModel ideal{.antenna_range_m = 0.0, .reading_latency_s = 0.0};

struct Estimator : PositionEstimator {
  explicit Estimator(EstimatorModel model = ideal) : PositionEstimator{lacet4(), model} {}
  Estimator& stopped_at(std::string_view section, double s_m) {
    position_at(at(lacet4(), section, s_m));
    return *this;
  }
  double read(std::int64_t distance_um) {
    wire::Odometry odometry;
    odometry.distance_um = distance_um;
    return on_odometry(odometry).step_m;
  }
  void drive(double distance_m) {
    if (!counter().reading_um()) read(0);
    // The odometer counts in steps that a 50 Hz board would send.
    const auto now_um = [&] { return *counter().reading_um(); };
    const auto end_um = now_um() + static_cast<std::int64_t>(std::llround(distance_m * 1e6));
    while (now_um() < end_um) read(std::min(end_um, now_um() + 10'000));
  }
};

std::uint32_t beacon_near(Point2 p) { return lacet4().beacons->nearest(p)->number; }

TEST(Estimate, is_unknown_until_a_position_is_given) {
  Estimator estimator;
  estimator.drive(0.4);
  EXPECT_FALSE(estimator.known());
  EXPECT_NEAR(estimator.travelled_m(), 0.4, 1e-9);
  estimator.stopped_at("east", 0.2);
  EXPECT_TRUE(estimator.known());
}

TEST(Estimate, follows_the_odometer_round_the_circuit) {
  Estimator estimator;
  estimator.stopped_at("east", 1.0).drive(0.7);
  EXPECT_EQ(estimator.track_position().section, 1U);
  EXPECT_NEAR(estimator.track_position().s_m, 0.2, 1e-9);
}

TEST(Estimate, starts_at_the_first_reading_of_the_odometer) {
  Estimator estimator;
  estimator.stopped_at("east", 1.0);
  EXPECT_EQ(estimator.read(123'456'789), 0.0);
  EXPECT_NEAR(estimator.read(123'466'789), 0.01, 1e-12);
}

TEST(Estimate, does_not_jump_when_the_board_counts_from_zero_again) {
  Estimator estimator;
  estimator.stopped_at("east", 0.1).drive(0.7);
  EXPECT_EQ(estimator.read(0), 0.0);
  estimator.read(10'000);
  EXPECT_NEAR(estimator.track_position().s_m, 0.81, 1e-9);
  EXPECT_EQ(estimator.read(std::numeric_limits<std::int64_t>::min()), 0.0);
  EXPECT_EQ(estimator.read(std::numeric_limits<std::int64_t>::max()), -1e-6) << "one step round the counter";
}

TEST(Estimate, grows_less_certain_with_the_distance) {
  Estimator estimator;
  estimator.stopped_at("east", 0.0);
  const double start_m = estimator.on_path_estimator().sigma_m();
  estimator.drive(1.0);
  EXPECT_NEAR(estimator.on_path_estimator().sigma_m(), std::sqrt(start_m * start_m + 1e-4), 1e-9);
  estimator.on_tag(1, 0.0, 0.0);  // the tag is at 1.471
  EXPECT_LT(estimator.on_path_estimator().sigma_m(), start_m);
}

TEST(Tag, sets_an_unknown_position) {
  Estimator estimator;
  EXPECT_EQ(estimator.on_tag(5, 0.0, 0.0).kind, FixKind::relocated);
  EXPECT_EQ(estimator.track_position(), at(lacet4(), "loop_ne", 1.4137));
  ASSERT_TRUE(estimator.last_tag());
  EXPECT_EQ(estimator.last_tag()->number, 5U);
}

TEST(Tag, rectifies_the_estimate_and_returns_the_correction) {
  Estimator estimator;
  estimator.stopped_at("east", 1.40);
  const auto fix = estimator.on_tag(1, 0.0, 0.0);
  EXPECT_EQ(fix.kind, FixKind::corrected);
  EXPECT_NEAR(fix.correction_m, 0.071, 1e-9);
  estimator.stopped_at("loop_se", 0.05);
  EXPECT_NEAR(estimator.on_tag(1, 0.0, 0.0).correction_m, -0.079, 1e-9);
  EXPECT_NEAR(estimator.track_position().s_m, 1.471, 1e-9);
}

TEST(Tag, counts_the_distance_driven_since_it_was_read) {
  Estimator estimator{EstimatorModel{.antenna_range_m = 0.02, .reading_latency_s = 0.01}};
  estimator.stopped_at("east", 1.40);
  estimator.on_tag(1, 0.040, 0.5);
  EXPECT_NEAR(estimator.track_position().s_m, 1.471 - 0.02 + 0.5 * 0.05, 1e-9);
}

TEST(Tag, far_from_the_estimate_relocates_at_once) {
  Estimator estimator;
  estimator.stopped_at("east", 0.5);
  EXPECT_EQ(estimator.on_tag(7, 0.0, 0.0).kind, FixKind::relocated);
  EXPECT_EQ(estimator.track_position(), at(lacet4(), "west", 1.471));
}

TEST(Tag, of_unknown_number_is_ignored) {
  Estimator estimator;
  EXPECT_EQ(estimator.on_tag(999, 0.0, 0.0).kind, FixKind::none);
  EXPECT_FALSE(estimator.known());
  EXPECT_FALSE(estimator.last_tag());
}

TEST(Tag, leaves_the_distance_since_the_tag_in_the_report) {
  Estimator estimator;
  estimator.stopped_at("east", 1.47);
  estimator.on_tag(1, 0.0, 0.0);
  estimator.drive(0.3);
  ASSERT_TRUE(estimator.last_tag());
  EXPECT_NEAR(estimator.travelled_m() - estimator.last_tag()->travelled_m, 0.3, 1e-9);
}

TEST(Beacon, rectifies_along_the_adjacent_section) {
  // The beacon at (1.0, -0.25) lies 4.5 cm from the loop in the south-east.
  const auto foot = lacet4().circuit.section(1).nearest({1.0, -0.25});
  ASSERT_LT(foot.distance_m, 0.08);
  Estimator estimator;
  estimator.stopped_at("loop_se", foot.s_m - 0.1);
  const auto fix = estimator.on_tag(beacon_near({1.0, -0.25}), 0.0, 0.0);
  EXPECT_EQ(fix.kind, FixKind::corrected);
  EXPECT_NEAR(fix.correction_m, 0.1, 1e-6);
  EXPECT_FALSE(estimator.last_tag()) << "a beacon is no tag of the circuit";
}

TEST(Beacon, is_ignored_while_the_position_is_unknown) {
  Estimator estimator;
  EXPECT_EQ(estimator.on_tag(beacon_near({1.0, -0.25}), 0.0, 0.0).kind, FixKind::none);
  EXPECT_FALSE(estimator.known());
}

TEST(Beacon, that_contradicts_the_estimate_is_an_outlier_and_two_that_agree_relocate) {
  // Actually on the loop in the south-east, estimated in the north-west.
  const Point2 first{1.0, -0.25};
  const Point2 second{1.25, -0.5};
  const auto& loop = lacet4().circuit.section(1);
  ASSERT_LT(loop.nearest(second).distance_m, 0.08);
  const double distance_m = loop.nearest(second).s_m - loop.nearest(first).s_m;
  Estimator estimator;
  estimator.stopped_at("loop_nw", 1.0);
  EXPECT_EQ(estimator.on_tag(beacon_near(first), 0.0, 0.0).kind, FixKind::outlier);
  estimator.drive(distance_m);
  EXPECT_EQ(estimator.on_tag(beacon_near(second), 0.0, 0.0).kind, FixKind::relocated);
  EXPECT_EQ(estimator.track_position().section, 1U);
  EXPECT_NEAR(estimator.track_position().s_m, loop.nearest(second).s_m, 1e-6);
}

TEST(Beacon, outliers_that_do_not_agree_stay_outliers) {
  Estimator estimator;
  estimator.stopped_at("loop_nw", 1.0);
  EXPECT_EQ(estimator.on_tag(beacon_near({1.0, -0.25}), 0.0, 0.0).kind, FixKind::outlier);
  estimator.drive(0.05);
  EXPECT_EQ(estimator.on_tag(beacon_near({1.25, -1.0}), 0.0, 0.0).kind, FixKind::outlier);
  EXPECT_EQ(estimator.track_position().section, 5U);
}

TEST(EstimateDeathTest, takes_no_goal_off_the_path_where_no_path_is_near) {
  Estimator estimator;
  estimator.stopped_at("east", 0.5);
  EXPECT_DEATH(estimator.aim(at(lacet4(), "east", 0.7)), "near_path");
}

TEST(EstimateDeathTest, takes_no_beacon_without_a_position) {
  OnPathEstimator estimator{lacet4().circuit, ideal};
  EXPECT_DEATH(static_cast<void>(estimator.on_beacon({0.0, 0.0}, 0.0, 0.0)), "known_");
}

const zone::TrafficZone& lacet4_indirect() {
  static const zone::TrafficZone zone = [] {
    const auto direct = zone::testing::configuration_file("lacet4.toml");
    return zone::Rtm::initialise(zone::in_travel_direction(direct, zone::TravelDirection::indirect).value())->zone();
  }();
  return zone;
}

TEST(TravelDirectionChange, keeps_a_vehicle_on_its_path_at_its_point) {
  Estimator before;
  before.stopped_at("east", 1.0).drive(0.2);
  PositionEstimator after{lacet4_indirect(), ideal};
  after.take_over(before);
  ASSERT_TRUE(after.known());
  EXPECT_FALSE(after.off_path());
  EXPECT_EQ(after.track_position().section, before.track_position().section);
  EXPECT_NEAR(distance(after.pose(), before.pose()), 0.0, 1e-9);
  EXPECT_NEAR(std::fabs(wrap_angle(after.pose().heading_rad - before.pose().heading_rad)), pi, 1e-9);
  EXPECT_EQ(after.on_path_estimator().sigma_m(), before.on_path_estimator().sigma_m());
  EXPECT_FALSE(after.counter().reading_um()) << "the next reading has the other sign";

  Estimator again;
  static_cast<PositionEstimator&>(again).take_over(after);
  EXPECT_NEAR(again.track_position().s_m, before.track_position().s_m, 1e-12);
}

TEST(TravelDirectionChange, lets_a_vehicle_off_the_path_keep_its_pose) {
  Estimator before;
  before.set_off_path({0.05, 0.9, 0.3});
  PositionEstimator after{lacet4_indirect(), ideal};
  after.take_over(before);
  ASSERT_TRUE(after.pose_known());
  EXPECT_NEAR(distance(after.pose(), before.pose()), 0.0, 1e-9);
  EXPECT_NEAR(wrap_angle(after.pose().heading_rad - 0.3 - pi), 0.0, 1e-9);
}

}  // namespace
}  // namespace cosiva::aiv
