// The estimate on graphs: along a course, at forks and merges, and off the path.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/testing/test_graphs.h"

namespace cosiva::aiv {
namespace {

using FixKind = PositionEstimator::FixKind;
using test::at;
using test::diamond;
using test::square;
using test::there_and_back;

constexpr EstimatorModel ideal{.antenna_range_m = 0.0, .reading_latency_s = 0.0};

/// Reports of PILS, and the resulting estimate.
struct Estimator : PositionEstimator {
  const zone::TrafficZone& zone;
  wire::Odometry odometry;

  explicit Estimator(const zone::TrafficZone& z) : PositionEstimator{z, ideal}, zone{z} { on_odometry(odometry); }
  Estimator& stopped_at(std::string_view section, double s_m) {
    position_at(at(zone, section, s_m));
    return *this;
  }
  Estimator& along(const std::vector<std::string>& names) {
    std::vector<zone::SectionId> sections;
    for (const auto& name : names) sections.push_back(zone.circuit.find(name).value());
    follow(zone::Course{std::move(sections)});
    return *this;
  }
  double drive(double distance_m) {
    double moved_m = 0.0;
    for (int i = 0; i < 100; ++i) {
      odometry.distance_um += std::llround(1e4 * distance_m);
      moved_m += on_odometry(odometry).step_m;
    }
    return moved_m;
  }
  Rolled turn(double turned_rad) {
    odometry.manoeuvre = wire::Manoeuvre{0, 0, static_cast<std::int16_t>(std::lround(1e3 * turned_rad))};
    return on_odometry(odometry);
  }
  Rolled end() {
    odometry.manoeuvre.reset();
    return on_odometry(odometry);
  }
  using PositionEstimator::on_odometry;
  std::string section() const { return zone.circuit.part(track_position().section).name; }
};

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

// --- bends ----------------------------------------------------------------------------------------------------------

TEST(EstimateAtABend, does_not_pass_the_bend_before_the_turn) {
  Estimator estimator{square()};
  estimator.stopped_at("south", 0.95).along({"south", "east"}).drive(0.1);
  EXPECT_EQ(estimator.track_position(), at(square(), "south", 1.0));
  EXPECT_EQ(estimator.pose().heading_rad, 0.0);
}

TEST(EstimateAtABend, turns_with_the_vehicle_and_is_certain_at_the_end) {
  Estimator estimator{square()};
  estimator.stopped_at("south", 0.9).along({"south", "east", "north"});
  EXPECT_NEAR(estimator.turn(0.0).step_m, 0.1, 1e-9) << "a vehicle that turns is at the joint";
  estimator.turn(0.7);
  EXPECT_NEAR(estimator.pose().heading_rad, 0.7, 1e-9);
  EXPECT_NEAR(estimator.pose().x_m, 1.0, 1e-9);
  estimator.turn(1.57);
  const auto end = estimator.end();
  EXPECT_EQ(end.step_m, 0.0);
  EXPECT_EQ(end.kind, FixKind::none);
  EXPECT_EQ(estimator.track_position(), at(square(), "east", 0.0));
  EXPECT_FALSE(estimator.off_path());
  estimator.drive(-0.05);
  EXPECT_EQ(estimator.track_position(), at(square(), "east", 0.0)) << "nor back round the bend";
}

TEST(EstimateAtABend, distinguishes_two_turns_between_which_every_frame_was_lost) {
  zone::TrafficZone zone = square();
  Estimator estimator{zone};
  estimator.stopped_at("south", 1.0).along({"south", "east", "north", "west"});
  estimator.turn(0.5);
  estimator.turn(1.57);
  estimator.odometry.distance_um += 480'000;  // then the next turn begins, a little short of the joint by the odometer
  estimator.turn(0.01);
  estimator.odometry.distance_um += 480'000;
  estimator.turn(0.02);
  EXPECT_EQ(estimator.section(), "east");
  EXPECT_TRUE(estimator.manoeuvring());
}

TEST(EstimateAtABend, finds_that_it_turned_into_another_branch_than_commanded) {
  Estimator estimator{square()};
  estimator.stopped_at("west", 1.0).along({"west", "south"});
  estimator.turn(0.5);
  estimator.turn(pi / 3.0);
  EXPECT_EQ(estimator.end().kind, FixKind::relocated);
  EXPECT_EQ(estimator.section(), "bow");
}

TEST(EstimateAtABend, ignores_a_turn_while_its_position_is_unknown) {
  Estimator estimator{square()};
  estimator.turn(0.5);
  EXPECT_FALSE(estimator.pose_known());
  estimator.end();
  EXPECT_FALSE(estimator.pose_known());
  estimator.turn(0.4);
  estimator.stopped_at("south", 1.0);
  EXPECT_NEAR(estimator.pose().heading_rad, 0.4, 1e-9) << "the position is given during the turn";
  estimator.turn(pi / 2.0);
  estimator.end();
  EXPECT_EQ(estimator.section(), "east");
}

TEST(EstimateAtABend, resumes_a_persisted_turn) {
  for (const bool ended_meanwhile : {false, true}) {
    Estimator estimator{square()};
    estimator.stopped_at("south", 1.0);
    estimator.resume_manoeuvre({0.0, 0.0, 1.4}, square().circuit.find("east"));
    EXPECT_NEAR(estimator.pose().heading_rad, 1.4, 1e-9);
    if (!ended_meanwhile) estimator.turn(1.5);
    estimator.end();
    EXPECT_EQ(estimator.track_position(), at(square(), "east", 0.0));
  }
}

// --- off the path ---------------------------------------------------------------------------------------------------

TEST(EstimateOffPath, has_the_given_pose_and_the_position_where_it_joins) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.2, 2.0});
  EXPECT_TRUE(estimator.near_path());
  EXPECT_EQ(estimator.pose(), (Pose2{0.5, 0.2, 2.0}));
  EXPECT_NEAR(estimator.off_by_m(), 0.2, 1e-9);
  EXPECT_EQ(estimator.section(), "trunk");
  EXPECT_NEAR(estimator.track_position().s_m, 0.5, 1e-9);
  estimator.set_off_path({0.5, 0.31, 2.0});
  EXPECT_TRUE(estimator.away());
  EXPECT_FALSE(estimator.known());
}

TEST(EstimateOffPath, is_on_the_path_where_the_manoeuvre_ended) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.2, -pi / 2.0});
  estimator.odometry.manoeuvre = wire::Manoeuvre{200, 0, 0};
  estimator.on_odometry(estimator.odometry);
  EXPECT_NEAR(estimator.pose().y_m, 0.0, 1e-9);
  EXPECT_TRUE(estimator.near_path()) << "across the path is not on it";
  estimator.odometry.manoeuvre = wire::Manoeuvre{200, 0, 1571};
  estimator.on_odometry(estimator.odometry);
  estimator.end();
  EXPECT_FALSE(estimator.off_path());
  EXPECT_NEAR(estimator.pose().x_m, 0.5, 1e-3);
  estimator.drive(0.2);
  EXPECT_NEAR(estimator.pose().x_m, 0.7, 1e-3);
}

TEST(EstimateOffPath, stays_off_path_when_a_manoeuvre_ended_near_it_and_no_line_is_detected) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.1, 0.0});
  estimator.odometry.manoeuvre = wire::Manoeuvre{50, -60, 0};
  estimator.on_odometry(estimator.odometry);
  estimator.odometry.line_lost = true;
  EXPECT_EQ(estimator.end().kind, FixKind::relocated);
  EXPECT_TRUE(estimator.near_path()) << "4 cm off, the vehicle would wait for its line for ever";
  EXPECT_NEAR(estimator.off_by_m(), 0.04, 1e-9);
}

TEST(EstimateOffPath, ignores_tags_until_it_is_on_the_path) {
  zone::TrafficZone zone = diamond();
  zone.tags = {{1, at(zone, "tail", 1.0)}};
  Estimator estimator{zone};
  estimator.set_off_path({0.5, 0.2, 0.0});
  EXPECT_EQ(estimator.on_tag(1, 0.0, 0.0).kind, FixKind::none);
  EXPECT_TRUE(estimator.near_path());
}

TEST(EstimateOffPath, follows_the_path_when_its_wheels_move) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.05, 0.0});
  estimator.drive(0.1);
  EXPECT_FALSE(estimator.off_path());
  EXPECT_NEAR(estimator.track_position().s_m, 0.6, 1e-6);
}

TEST(EstimateOffPath, begins_another_manoeuvre_where_the_last_one_ended_without_a_report_of_its_end) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.25, -pi / 2.0});
  const auto commanded = [&](wire::Manoeuvre manoeuvre) {
    estimator.odometry.manoeuvre = manoeuvre;
    estimator.on_odometry(estimator.odometry);
    return estimator.pose();
  };
  // Straight on, and a new manoeuvre from there.
  EXPECT_LT(distance(commanded({100, 0, 0}), {0.5, 0.15, 0.0}), 1e-9);
  EXPECT_LT(distance(commanded({0, 0, 10}), {0.5, 0.15, 0.0}), 1e-9);
  // A turn on the spot, and another turn from there.
  EXPECT_NEAR(commanded({0, 0, 600}).heading_rad, -pi / 2.0 + 0.6, 1e-9);
  EXPECT_NEAR(commanded({0, 0, 5}).heading_rad, -pi / 2.0 + 0.605, 1e-9);
  // Vibration of the wheels is no new manoeuvre.
  EXPECT_NEAR(commanded({0, 0, 0}).heading_rad, -pi / 2.0 + 0.6, 1e-9);
}

TEST(EstimateOffPath, is_off_path_where_a_manoeuvre_to_a_path_of_the_old_zone_ended) {
  Estimator before{square()};
  before.set_off_path({0.5, 0.05, 0.2});
  before.odometry.manoeuvre = wire::Manoeuvre{30, 0, 0};
  before.on_odometry(before.odometry);
  PositionEstimator after{diamond(), ideal};
  after.take_over(before);
  const Pose2 is_stopped = after.pose();
  wire::Odometry odometry = before.odometry;  // along the old path and near a new one; no manoeuvre on the new floor
  odometry.manoeuvre.reset();
  after.on_odometry(odometry);
  EXPECT_TRUE(after.near_path());
  EXPECT_EQ(after.pose(), is_stopped);
}

TEST(EstimateOffPath, keeps_pose_and_odometer_from_one_zone_to_the_next) {
  Estimator before{square()};
  before.stopped_at("south", 1.0).along({"south", "east"});
  before.turn(0.6);
  PositionEstimator after{diamond(), ideal};
  after.take_over(before);
  EXPECT_NEAR(after.pose().heading_rad, 0.6, 1e-9);
  EXPECT_TRUE(after.near_path());
  wire::Odometry odometry = before.odometry;  // the manoeuvre is abandoned with the old floor
  odometry.manoeuvre.reset();
  odometry.line_lost = true;
  after.on_odometry(odometry);
  EXPECT_TRUE(after.near_path());
  EXPECT_NEAR(after.pose().heading_rad, 0.6, 1e-9);
  EXPECT_EQ(after.travelled_m(), before.travelled_m());
}

}  // namespace
}  // namespace cosiva::aiv
