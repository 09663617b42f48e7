// The estimate on graphs: along a course, at forks and merges, and at fiducials.
#include "cosiva/aiv/localisation/on_path_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "cosiva/aiv/localisation/test_estimator.h"
#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::lacet4;
using test::there_and_back;
using Estimator = test::GraphEstimator;

TEST(EstimateOnAGraph, follows_its_course_over_a_fork) {
  Estimator estimator{diamond()};
  estimator.stopped_at("trunk", 1.9).along({"trunk", "r_up", "r_over"}).drive(0.3);
  EXPECT_EQ(estimator.section(), "r_up");
  EXPECT_NEAR(estimator.track_position().s_m, 0.2, 1e-9);
}

TEST(EstimateOnAGraph, waits_at_an_undecided_fork) {
  Estimator estimator{diamond()};
  EXPECT_NEAR(estimator.stopped_at("trunk", 1.9).drive(0.3), 0.1, 1e-9);
  EXPECT_EQ(estimator.track_position(), at(diamond(), "trunk", 2.0));
  estimator.along({"trunk", "r_up"}).drive(0.1);
  EXPECT_EQ(estimator.section(), "r_up");
}

TEST(EstimateOnAGraph, continues_over_joints_without_branches) {
  Estimator estimator{diamond()};
  estimator.stopped_at("r_up", 0.5).drive(1.0);
  EXPECT_EQ(estimator.section(), "r_over");
}

TEST(EstimateOnAGraph, goes_back_over_a_merge_along_the_traversed_branch) {
  for (const char* side : {"l", "r"}) {
    const std::string down = std::string(side) + "_down";
    Estimator estimator{diamond()};
    estimator.stopped_at(down, pi / 4.0 - 0.05).along({down, "tail"}).drive(0.1);
    EXPECT_EQ(estimator.section(), "tail");
    estimator.drive(-0.1);
    EXPECT_EQ(estimator.section(), down);
    EXPECT_NEAR(estimator.track_position().s_m, pi / 4.0 - 0.05, 1e-6);
  }
}

TEST(EstimateOnAGraph, is_corrected_by_a_tag_on_its_route_and_jumps_to_one_on_another) {
  zone::TrafficZone zone = diamond();
  zone.tags = {
      {1, at(zone, "r_down", pi / 4.0 - 0.03)}, {2, at(zone, "l_down", pi / 4.0 - 0.20)}, {3, at(zone, "r_up", 0.1)}};
  Estimator estimator{zone};
  estimator.stopped_at("r_down", 0.2).along({"r_down", "tail"}).drive(pi / 4.0 - 0.2 + 0.02);
  EXPECT_EQ(estimator.section(), "tail");
  const auto back = estimator.on_tag(1, 0.0, 0.0);
  EXPECT_EQ(back.kind, FixKind::corrected);
  EXPECT_NEAR(back.correction_m, -0.05, 5e-6);  // the odometer counts micrometres
  EXPECT_EQ(estimator.section(), "r_down");
  estimator.drive(0.1);
  EXPECT_EQ(estimator.on_tag(2, 0.0, 0.0).kind, FixKind::relocated) << "that section was not traversed";
  EXPECT_EQ(estimator.section(), "l_down");

  estimator.stopped_at("trunk", 1.95).along({"trunk", "r_up"});
  const auto ahead = estimator.on_tag(3, 0.0, 0.0);
  EXPECT_EQ(ahead.kind, FixKind::corrected);
  EXPECT_NEAR(ahead.correction_m, 0.15, 1e-9);
  EXPECT_EQ(estimator.section(), "r_up");
}

TEST(EstimateOnAGraph, is_corrected_by_a_beacon_next_to_its_own_branch) {
  zone::TrafficZone zone = diamond();
  const Point2 beacon = position(zone.circuit.pose_at(at(zone, "r_up", 0.30)));
  zone.beacons = zone::BeaconGrid{1.0, beacon, 1, 1};
  Estimator estimator{zone};
  estimator.stopped_at("r_up", 0.25).along({"trunk", "r_up", "r_over"});
  estimator.stopped_at("r_up", 0.25);
  const auto fix = estimator.on_tag(zone.beacons->first_number, 0.0, 0.0);
  EXPECT_EQ(fix.kind, FixKind::corrected);
  EXPECT_NEAR(fix.correction_m, 0.05, 1e-6);
}

TEST(EstimateOnAGraph, on_the_return_along_a_lane_is_rectified_by_the_tags_of_the_outward_lane) {
  zone::TrafficZone zone = there_and_back();
  zone.tags = {{1, at(zone, "there", 0.7)}};
  Estimator estimator{zone};
  estimator.stopped_at("there", 1.0).along({"there", "back", "there"});
  estimator.turn(pi);
  estimator.end();
  estimator.drive(0.28);
  const auto fix = estimator.on_tag(1, 0.0, 0.0);
  EXPECT_EQ(fix.kind, FixKind::corrected);
  EXPECT_NEAR(fix.correction_m, 0.02, 1e-5) << "not back round the bend to the first passing of the tag";
  EXPECT_EQ(estimator.track_position().section, at(zone, "back", 0.0).section);
}

TEST(EstimateOnAGraph, after_a_long_distance_without_a_fix_searches_further_for_the_joint_where_it_waits) {
  for (const double driven_m : {0.2, 40.0}) {
    Estimator estimator{diamond()};
    estimator.stopped_at("trunk", 1.0);
    for (double there_m = 0.0; there_m < driven_m; there_m += 0.2) {
      estimator.drive(0.1);
      estimator.drive(-0.1);
    }
    estimator.drive(0.83);
    EXPECT_NEAR(estimator.on_stuck(), driven_m > 1.0 ? 0.17 : 0.0, 1e-4);
  }
}

TEST(Pose, is_snapped_to_the_circuit_only_near_it_and_along_it) {
  const auto on = position_on_circuit(lacet4().circuit, {-0.5, -0.10, 0.1}, 0.25);
  ASSERT_TRUE(on);
  EXPECT_EQ(on->section, 0U);
  EXPECT_NEAR(on->s_m, 0.25, 1e-9);
  EXPECT_EQ(position_on_circuit(lacet4().circuit, {-0.5, -0.10, 2.0}, 0.25), std::nullopt);
  EXPECT_EQ(position_on_circuit(lacet4().circuit, {3.0, 3.0, 0.0}, 0.25), std::nullopt);
}

}  // namespace
}  // namespace cosiva::aiv
