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

TEST(Pose, may_be_off_by_the_stated_distance_and_by_60_degrees) {
  const zone::Circuit& circuit = diamond().circuit;
  EXPECT_TRUE(position_on_circuit(circuit, {1.0, 0.249, 0.0}, 0.25));
  EXPECT_FALSE(position_on_circuit(circuit, {1.0, 0.251, 0.0}, 0.25));
  EXPECT_TRUE(position_on_circuit(circuit, {1.0, 0.0, 1.04}, 0.25));
  EXPECT_FALSE(position_on_circuit(circuit, {1.0, 0.0, 1.06}, 0.25));
  EXPECT_FALSE(position_on_circuit(circuit, {1.0, 0.0, -1.06}, 0.25));
}

TEST(SamePositions, are_on_other_sections_within_five_centimetres_in_that_direction) {
  const auto names = [](const zone::TrafficZone& zone, zone::TrackPosition here) {
    std::string text;
    for (const zone::TrackPosition other : same_positions(zone.circuit, here))
      text += zone.circuit.part(other.section).name + " ";
    return text;
  };
  EXPECT_EQ(names(there_and_back(), at(there_and_back(), "there", 0.5)), "there_too ");
  EXPECT_EQ(names(diamond(), at(diamond(), "trunk", 1.0)), "");
  EXPECT_EQ(names(diamond(), at(diamond(), "r_up", 0.049)).find("trunk") != std::string::npos, true);
  EXPECT_EQ(names(diamond(), at(diamond(), "r_up", 0.052)).find("trunk"), std::string::npos);
  // The branches part: 5 cm between them where each has turned by 0.16 rad.
  EXPECT_NE(names(diamond(), at(diamond(), "r_up", 0.09)).find("l_up"), std::string::npos);
  EXPECT_EQ(names(diamond(), at(diamond(), "r_up", 0.3)), "");
}

TEST(OnPathEstimate, has_the_uncertainty_of_its_last_fix_and_of_the_distance_since) {
  zone::TrafficZone zone = diamond();
  zone.tags = {{1, at(zone, "trunk", 1.0)}};
  Estimator estimator{zone};
  const auto variance = [&] { return std::pow(estimator.on_path_estimator().sigma_m(), 2); };
  estimator.stopped_at("trunk", 0.5);
  EXPECT_NEAR(variance(), 1e-4, 1e-12);
  estimator.drive(0.4);
  EXPECT_NEAR(variance(), 1e-4 + 0.4e-4, 1e-9);
  estimator.drive(-0.2);
  EXPECT_NEAR(variance(), 1e-4 + 0.6e-4, 1e-9);
  estimator.take_same_position(at(zone, "trunk", 0.7));
  EXPECT_NEAR(variance(), 1.6e-4, 1e-9);
  estimator.on_odometer_reset();
  EXPECT_NEAR(variance(), 1.6e-4 + 25e-4, 1e-9);
  // Off the path no more certain, and back on it at the position where it was placed.
  estimator.set_off_path({0.7, 0.1, 0.0});
  EXPECT_NEAR(variance(), 26.6e-4, 1e-9);
  estimator.stopped_at("trunk", 0.9);
  estimator.on_tag(1, 0.0, 0.0);
  EXPECT_NEAR(variance(), 16e-6, 1e-12);
  estimator.set_off_path({0.7, 0.1, 0.0});
  EXPECT_NEAR(variance(), 1e-4, 1e-12) << "no less than that of a position that is given";
}

TEST(OnPathEstimate, is_at_the_joint_15_centimetres_before_it_where_the_vehicle_waits) {
  for (const double before_m : {0.149, 0.151}) {
    Estimator estimator{diamond()};
    estimator.stopped_at("trunk", 2.0 - before_m);
    EXPECT_NEAR(estimator.on_stuck(), before_m < 0.15 ? before_m : 0.0, 1e-5);
    EXPECT_NEAR(estimator.track_position().s_m, before_m < 0.15 ? 2.0 : 2.0 - before_m, 1e-5);
    EXPECT_EQ(estimator.section(), "trunk");
  }
  // Over a joint that is no fork the search continues: the dead end of the tail.
  Estimator at_the_end{diamond()};
  EXPECT_NEAR(at_the_end.stopped_at("tail", 1.9).on_stuck(), 0.1, 1e-5);
  Estimator on_a_joint{diamond()};
  EXPECT_EQ(on_a_joint.stopped_at("r_up", 0.75).on_stuck(), 0.0) << "its only branch needs no wait";
  // A course that is decided does not end the wait at the fork.
  Estimator decided{diamond()};
  EXPECT_NEAR(decided.stopped_at("trunk", 1.9).along({"trunk", "r_up"}).on_stuck(), 0.1, 1e-5);
  Estimator off_path{diamond()};
  off_path.set_off_path({1.95, 0.1, 0.0});
  EXPECT_EQ(off_path.on_stuck(), 0.0);
}

TEST(OnPathEstimate, turns_at_a_bend_within_15_centimetres) {
  for (const double before_m : {0.149, 0.151}) {
    Estimator estimator{test::square()};
    estimator.stopped_at("north", 1.0 - before_m).along({"north", "west"});
    EXPECT_NEAR(estimator.turn(0.1).step_m, before_m < 0.15 ? before_m : 0.0, 1e-5);
  }
  // Without a course any bend counts.
  Estimator undecided{test::square()};
  EXPECT_NEAR(undecided.stopped_at("south", 0.9).turn(0.1).step_m, 0.1, 1e-5);
}

TEST(OnPathEstimate, takes_a_turn_for_the_branch_within_0_3_rad) {
  for (const double turned_rad : {0.5 * pi - 0.29, 0.5 * pi + 0.29, 0.5 * pi - 0.31, 0.5 * pi + 0.31}) {
    Estimator estimator{test::square()};
    estimator.stopped_at("north", 0.95).along({"north", "west"});
    for (double turned = 0.2; turned < turned_rad; turned += 0.2) estimator.turn(turned);
    estimator.turn(turned_rad);
    const EstimateStep end = estimator.end();
    if (std::fabs(turned_rad - 0.5 * pi) < 0.3) {
      EXPECT_EQ(end.kind, FixKind::none);
      EXPECT_EQ(estimator.section(), "west");
      EXPECT_NEAR(estimator.on_path_estimator().sigma_m(), 0.004, 1e-9);
    } else {
      EXPECT_EQ(end.kind, FixKind::relocated);
      EXPECT_TRUE(estimator.off_path());
    }
  }
}

TEST(OnPathEstimate, corrects_itself_by_tags_within_60_centimetres_and_jumps_beyond) {
  zone::TrafficZone zone = diamond();
  zone.tags = {{1, at(zone, "trunk", 1.0)}};
  for (const double off_m : {0.59, -0.59, 0.61, -0.61}) {
    Estimator estimator{zone};
    estimator.stopped_at("trunk", 1.0 - off_m);
    const PositionFix fix = estimator.on_tag(1, 0.0, 0.0);
    EXPECT_EQ(fix.kind, std::fabs(off_m) < 0.6 ? FixKind::corrected : FixKind::relocated) << off_m;
    EXPECT_NEAR(fix.correction_m, std::fabs(off_m) < 0.6 ? off_m : 0.0, 1e-9);
    EXPECT_NEAR(estimator.track_position().s_m, 1.0, 1e-9);
    EXPECT_NEAR(estimator.on_path_estimator().sigma_m(), std::fabs(off_m) < 0.6 ? 0.004 : 0.01, 1e-9);
  }
}

TEST(OnPathEstimate, reads_tags_and_beacons_before_and_behind_its_antenna) {
  // The field reaches 2 cm; a reading of 0.1 s ago, and 0.02 s in transit, at 0.5 m/s: 6 cm ago.
  zone::TrafficZone zone = diamond();
  zone.tags = {{1, at(zone, "trunk", 1.0)}};
  zone.beacons = zone::BeaconGrid{1.0, {1.0, 0.012}, 1, 1};
  PositionEstimator tagged{zone};
  tagged.position_at(at(zone, "trunk", 0.9));
  EXPECT_NEAR(tagged.on_tag(1, 0.1, 0.5).correction_m, 0.1 + 0.06 - 0.02, 1e-9);
  ASSERT_TRUE(tagged.last_tag());
  EXPECT_EQ(tagged.last_tag()->number, 1U);
  EXPECT_NEAR(tagged.last_tag()->travelled_m, -0.06, 1e-9);
  // A beacon 1.2 cm off the path enters the field 1.6 cm before the antenna is next to it.
  PositionEstimator beaconed{zone};
  beaconed.position_at(at(zone, "trunk", 0.9));
  EXPECT_NEAR(beaconed.on_tag(zone.beacons->first_number, 0.1, 0.5).correction_m, 0.1 + 0.06 - 0.016, 1e-9);
  EXPECT_NEAR(std::pow(beaconed.on_path_estimator().sigma_m(), 2), 16e-6 + 0.05 * 0.012 * 0.012, 1e-12);
  EXPECT_FALSE(beaconed.last_tag());
}

TEST(OnPathEstimate, is_relocated_by_two_beacons_that_agree_with_the_distance_between_them) {
  struct Case {
    double apart_m;
    double driven_m;
    bool agree;
  };
  // Up to 10 cm further apart than driven, and driven by up to 60 % and 10 cm further than that.
  for (const Case& one : {Case{0.4, 0.301, true}, {0.4, 0.299, false}, {0.4, 0.739, true}, {0.4, 0.741, false}}) {
    zone::TrafficZone zone = diamond();
    // Both on the tail, far from the estimate on the trunk.
    const Point2 first = position(zone.circuit.pose_at(at(zone, "tail", 0.5)));
    zone.beacons = zone::BeaconGrid{one.apart_m, first, 2, 1};
    Estimator estimator{zone};
    estimator.stopped_at("trunk", 0.1);
    EXPECT_EQ(estimator.on_tag(zone.beacons->first_number, 0.0, 0.0).kind, FixKind::outlier);
    estimator.drive(one.driven_m);
    EXPECT_EQ(estimator.on_tag(zone.beacons->first_number + 1, 0.0, 0.0).kind,
              one.agree ? FixKind::relocated : FixKind::outlier)
        << one.driven_m;
    EXPECT_EQ(estimator.section(), one.agree ? "tail" : "trunk");
  }
  // The same beacon twice is one contradiction, and a doubt can be forgotten.
  zone::TrafficZone zone = diamond();
  zone.beacons = zone::BeaconGrid{0.4, position(zone.circuit.pose_at(at(zone, "tail", 0.5))), 2, 1};
  Estimator estimator{zone};
  estimator.stopped_at("trunk", 0.1);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(estimator.on_tag(zone.beacons->first_number, 0.0, 0.0).kind, FixKind::outlier);
  estimator.forget_doubt();
  estimator.drive(0.4);
  EXPECT_EQ(estimator.on_tag(zone.beacons->first_number + 1, 0.0, 0.0).kind, FixKind::outlier);
}

TEST(OnPathEstimate, passes_back_over_joints_and_stops_at_ends_and_bends) {
  Estimator estimator{diamond()};
  estimator.stopped_at("r_over", 0.1);
  EXPECT_NEAR(estimator.drive(-0.3), -0.3, 1e-9);
  EXPECT_EQ(estimator.section(), "r_up");
  EXPECT_NEAR(estimator.track_position().s_m, pi / 4.0 - 0.2, 1e-9);
  estimator.stopped_at("trunk", 0.2);
  EXPECT_NEAR(estimator.drive(-0.3), -0.2, 1e-9);
  EXPECT_EQ(estimator.track_position().s_m, 0.0);
  estimator.stopped_at("tail", 1.9);
  EXPECT_NEAR(estimator.drive(0.3), 0.1, 1e-9);
  Estimator bent{test::square()};
  bent.stopped_at("west", 0.1);
  EXPECT_NEAR(bent.drive(-0.3), -0.1, 1e-9);
  EXPECT_EQ(bent.section(), "west");
  bent.stopped_at("north", 0.9);
  EXPECT_NEAR(bent.drive(0.3), 0.1, 1e-9);
  EXPECT_EQ(bent.section(), "north");
}

TEST(OnPathEstimate, keeps_its_course_over_a_joint_that_it_passes_back_over) {
  Estimator estimator{diamond()};
  estimator.stopped_at("r_over", 0.1).along({"r_over", "r_down"});
  estimator.drive(-0.2);
  EXPECT_EQ(estimator.section(), "r_up");
  const auto remaining = estimator.on_path_estimator().path().course().remaining();
  ASSERT_EQ(remaining.size(), 2U);
  EXPECT_EQ(diamond().circuit.part(remaining[0]).name, "r_over");
  EXPECT_EQ(diamond().circuit.part(remaining[1]).name, "r_down");
}

/// A straight of 1 m, 6.25 cm more in its direction, and a bend to the left.
zone::TrafficZone elbow() {
  return test::graph("elbow",
                     {{"first", {0.0, 0.0, 0.0}, 1.0, 0.0, {1}},
                      {"second", {1.0, 0.0, 0.0}, 0.0625, 0.0, {2}, true},
                      {"up", {1.0625, 0.0, 0.5 * pi}, 1.0, 0.0, {}}},
                     {});
}

TEST(OnPathEstimate, searches_beyond_a_joint_for_the_bend_where_it_turns_or_waits) {
  const zone::TrafficZone zone = elbow();
  Estimator turns{zone};
  EXPECT_NEAR(turns.stopped_at("first", 0.95).turn(0.1).step_m, 0.1125, 1e-5);
  EXPECT_EQ(turns.section(), "second");
  Estimator waits{zone};
  EXPECT_NEAR(waits.stopped_at("first", 0.95).on_stuck(), 0.1125, 1e-5);
  EXPECT_EQ(waits.section(), "second");
  EXPECT_NEAR(waits.track_position().s_m, 0.0625, 1e-5);
  Estimator too_far{zone};
  EXPECT_EQ(too_far.stopped_at("first", 0.91).on_stuck(), 0.0);
  EXPECT_EQ(too_far.turn(0.1).step_m, 0.0);
}

TEST(OnPathEstimate, that_waits_is_as_certain_as_where_it_was_placed) {
  Estimator estimator{diamond()};
  estimator.stopped_at("trunk", 1.5).drive(0.4);
  EXPECT_GT(estimator.on_path_estimator().sigma_m(), 0.011);
  EXPECT_NEAR(estimator.on_stuck(), 0.1, 1e-5);
  EXPECT_NEAR(estimator.on_path_estimator().sigma_m(), 0.01, 1e-9);
}

TEST(OnPathEstimate, takes_the_branch_nearest_to_the_turn_but_its_course_s_within_0_3_rad) {
  // From west a quarter turn leads to south, a sixth of a full turn to the bow.
  const auto section_after = [](double turned_rad, bool with_course) {
    Estimator estimator{test::square()};
    estimator.stopped_at("west", 1.0);
    if (with_course) estimator.along({"west", "south"});
    for (double turned = 0.2; turned < turned_rad; turned += 0.2) estimator.turn(turned);
    estimator.turn(turned_rad);
    EXPECT_EQ(estimator.end().kind, with_course && turned_rad < 1.27 ? FixKind::relocated : FixKind::none);
    return estimator.section();
  };
  EXPECT_EQ(section_after(1.4, false), "south");
  EXPECT_EQ(section_after(1.2, false), "bow");
  EXPECT_EQ(section_after(1.3, false), "bow");
  EXPECT_EQ(section_after(1.3, true), "south");
  EXPECT_EQ(section_after(1.2, true), "bow");
}

TEST(OnPathEstimate, takes_a_beacon_beyond_its_antenna_s_range_for_one_next_to_it) {
  zone::TrafficZone zone = diamond();
  zone.beacons = zone::BeaconGrid{1.0, {1.0, 0.03}, 1, 1};
  PositionEstimator estimator{zone};
  estimator.position_at(at(zone, "trunk", 0.9));
  EXPECT_NEAR(estimator.on_tag(zone.beacons->first_number, 0.1, 0.5).correction_m, 0.1 + 0.06, 1e-9);
  EXPECT_NEAR(std::pow(estimator.on_path_estimator().sigma_m(), 2), 16e-6 + 0.05 * 0.03 * 0.03, 1e-12);
}

TEST(OnPathEstimate, is_relocated_only_to_a_path_within_8_centimetres_of_the_second_beacon) {
  for (const double off_m : {0.079, -0.079, 0.081, -0.081}) {
    zone::TrafficZone zone = diamond();
    const Point2 on_tail = cosiva::position(zone.circuit.pose_at(at(zone, "tail", 0.5)));
    zone.beacons = zone::BeaconGrid{0.4, {on_tail.x_m, on_tail.y_m + off_m}, 2, 1};
    Estimator estimator{zone};
    estimator.stopped_at("trunk", 0.1);
    EXPECT_EQ(estimator.on_tag(zone.beacons->first_number, 0.0, 0.0).kind, FixKind::outlier);
    estimator.drive(0.4);
    EXPECT_EQ(estimator.on_tag(zone.beacons->first_number + 1, 0.0, 0.0).kind,
              std::fabs(off_m) < 0.08 ? FixKind::relocated : FixKind::outlier)
        << off_m;
  }
}

TEST(OnPathEstimate, ends_a_doubt_with_the_next_fix) {
  zone::TrafficZone zone = diamond();
  zone.tags = {{1, at(zone, "trunk", 0.3)}};
  zone.beacons = zone::BeaconGrid{0.4, cosiva::position(zone.circuit.pose_at(at(zone, "tail", 0.5))), 2, 1};
  Estimator estimator{zone};
  estimator.stopped_at("trunk", 0.1);
  EXPECT_EQ(estimator.on_tag(zone.beacons->first_number, 0.0, 0.0).kind, FixKind::outlier);
  estimator.drive(0.2);
  EXPECT_EQ(estimator.on_tag(1, 0.0, 0.0).kind, FixKind::corrected);
  estimator.drive(0.2);
  EXPECT_EQ(estimator.on_tag(zone.beacons->first_number + 1, 0.0, 0.0).kind, FixKind::outlier);
}

}  // namespace
}  // namespace cosiva::aiv
