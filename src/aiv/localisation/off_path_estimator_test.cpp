// The estimate off the path: at bends where the vehicle turns on the spot, and where it joins a path.
#include "cosiva/aiv/localisation/off_path_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "cosiva/aiv/localisation/test_estimator.h"
#include "cosiva/aiv/testing/test_graphs.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::square;
using Estimator = test::GraphEstimator;

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
  EXPECT_TRUE(estimator.off_path_estimator().manoeuvring());
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
  EXPECT_NEAR(estimator.off_path_estimator().off_by_m(), 0.2, 1e-9);
  EXPECT_EQ(estimator.section(), "trunk");
  EXPECT_NEAR(estimator.track_position().s_m, 0.5, 1e-9);
  estimator.set_off_path({0.5, 0.31, 2.0});
  EXPECT_TRUE(estimator.pose_known());
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
  EXPECT_NEAR(estimator.off_path_estimator().off_by_m(), 0.04, 1e-9);
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
  PositionEstimator after{diamond(), test::ideal};
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
  PositionEstimator after{diamond(), test::ideal};
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

TEST(EstimateOffPath, joins_a_path_within_30_centimetres_and_the_rounding_of_a_report) {
  for (const double off_m : {0.304, 0.306}) {
    Estimator estimator{diamond()};
    estimator.set_off_path({0.5, off_m, 0.0});
    EXPECT_EQ(estimator.near_path(), off_m < 0.305) << off_m;
    EXPECT_NEAR(estimator.off_path_estimator().off_by_m(), off_m, 1e-9);
  }
}

TEST(EstimateOffPath, has_found_a_path_when_its_wheels_have_moved_a_centimetre) {
  for (const double distance_m : {0.0096, 0.0104, -0.0096, -0.0104}) {
    Estimator estimator{diamond()};
    estimator.set_off_path({0.5, 0.05, 0.0});
    const double moved_m = estimator.drive(distance_m);
    EXPECT_EQ(estimator.off_path(), std::fabs(distance_m) < 0.01) << distance_m;
    EXPECT_NEAR(moved_m, std::fabs(distance_m) < 0.01 ? 0.0 : distance_m, 1e-9) << distance_m;
  }
  // Away from all paths the pose moves on straight ahead.
  Estimator away{diamond()};
  away.set_off_path({0.5, 1.0, 0.5 * pi});
  EXPECT_EQ(away.drive(0.1), 0.0);
  EXPECT_NEAR(away.pose().x_m, 0.5, 1e-9);
  EXPECT_NEAR(away.pose().y_m, 1.1, 1e-9);
}

/// The pose after two reports of manoeuvres of a body that is off the path at (0.5, 0.25), facing the path.
Pose2 after_manoeuvres(wire::Manoeuvre first, wire::Manoeuvre second, std::int64_t driven_um = 0) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.25, -pi / 2.0});
  estimator.odometry.manoeuvre = first;
  estimator.on_odometry(estimator.odometry);
  estimator.odometry.manoeuvre = second;
  estimator.odometry.distance_um += driven_um;
  estimator.on_odometry(estimator.odometry);
  return estimator.pose();
}

TEST(EstimateOffPath, takes_a_manoeuvre_that_comes_back_by_over_3_millimetres_for_another) {
  EXPECT_NEAR(after_manoeuvres({100, 0, 0}, {98, 0, 0}).y_m, 0.25 - 0.098, 1e-9);
  EXPECT_NEAR(after_manoeuvres({100, 0, 0}, {96, 0, 0}).y_m, 0.25 - 0.1 - 0.096, 1e-9);
  EXPECT_NEAR(after_manoeuvres({60, 80, 0}, {57, 80, 0}).y_m, 0.25 - 0.057, 1e-9) << "98.2 of 100 mm";
}

TEST(EstimateOffPath, takes_a_turn_on_the_spot_that_comes_back_by_over_a_fiftieth_of_a_radian_for_another) {
  const auto turned_rad = [](wire::Manoeuvre first, wire::Manoeuvre second) {
    return wrap_angle(after_manoeuvres(first, second).heading_rad + pi / 2.0);
  };
  EXPECT_NEAR(turned_rad({0, 0, 600}, {0, 0, 581}), 0.581, 1e-9);
  EXPECT_NEAR(turned_rad({0, 0, 600}, {0, 0, 579}), 0.6 + 0.579, 1e-9);
  EXPECT_NEAR(turned_rad({0, 0, -600}, {0, 0, -581}), -0.581, 1e-9);
  EXPECT_NEAR(turned_rad({0, 0, -600}, {0, 0, -579}), -0.6 - 0.579, 1e-9);
  // On its last leg it turns back to its goal's heading.
  EXPECT_NEAR(turned_rad({100, 0, 600}, {100, 0, 100}), 0.1, 1e-9);
  EXPECT_NEAR(turned_rad({0, 0, 600}, {1, 0, 100}), 0.1, 1e-9);
}

TEST(EstimateOffPath, takes_a_manoeuvre_after_more_than_two_millimetres_of_driving_for_another) {
  const auto turned_rad = [](std::int64_t driven_um) {
    return wrap_angle(after_manoeuvres({0, 0, 600}, {0, 0, 700}, driven_um).heading_rad + pi / 2.0);
  };
  EXPECT_NEAR(turned_rad(1'900), 0.7, 1e-9);
  EXPECT_NEAR(turned_rad(-1'900), 0.7, 1e-9);
  EXPECT_NEAR(turned_rad(2'100), 1.3, 1e-9);
  EXPECT_NEAR(turned_rad(-2'100), 1.3, 1e-9);
}

TEST(EstimateOffPath, is_on_a_path_where_its_manoeuvre_ended_within_6_centimetres_and_0_3_rad) {
  const auto lands = [](wire::Manoeuvre last) {
    Estimator estimator{diamond()};
    estimator.set_off_path({0.5, 0.1, 0.0});
    estimator.odometry.manoeuvre = last;
    estimator.on_odometry(estimator.odometry);
    const EstimateStep end = estimator.end();
    EXPECT_EQ(end.kind, estimator.off_path() ? FixKind::relocated : FixKind::none);
    EXPECT_NEAR(end.step_m, estimator.off_path() ? 0.0 : 1e-3 * last.x_mm, 1e-9);
    return !estimator.off_path();
  };
  EXPECT_TRUE(lands({50, -41, 0}));
  EXPECT_FALSE(lands({50, -39, 0}));
  EXPECT_TRUE(lands({50, -159, 0}));
  EXPECT_FALSE(lands({50, -161, 0}));
  EXPECT_TRUE(lands({50, -100, 299}));
  EXPECT_FALSE(lands({50, -100, 301}));
  EXPECT_FALSE(lands({50, -100, -301}));
}

TEST(EstimateOffPath, is_relocated_where_its_manoeuvre_ended_on_another_section) {
  Estimator estimator{diamond()};
  estimator.set_off_path({1.9, 0.1, 0.0});
  EXPECT_EQ(estimator.section(), "trunk");
  // 0.2 m beyond the fork the left branch has turned by 0.2 rad, and is 2 cm to the left.
  estimator.odometry.manoeuvre = wire::Manoeuvre{299, -80, 200};
  estimator.on_odometry(estimator.odometry);
  EXPECT_EQ(estimator.end().kind, FixKind::relocated);
  EXPECT_FALSE(estimator.off_path());
  EXPECT_EQ(estimator.section(), "l_up");
  EXPECT_NEAR(estimator.track_position().s_m, 0.2, 0.002);
}

TEST(EstimateOffPath, resumes_a_persisted_manoeuvre_at_its_pose_and_none_that_is_reported_already) {
  Estimator estimator{diamond()};
  estimator.set_off_path({0.5, 0.2, 0.0});
  estimator.resume_manoeuvre({0.1, 0.0, 0.0}, std::nullopt);
  EXPECT_LT(distance(estimator.pose(), {0.5, 0.2, 0.0}), 1e-9);
  estimator.odometry.manoeuvre = wire::Manoeuvre{150, 0, 0};
  estimator.on_odometry(estimator.odometry);
  EXPECT_LT(distance(estimator.pose(), {0.55, 0.2, 0.0}), 1e-9);
  estimator.resume_manoeuvre({0.3, 0.0, 0.0}, std::nullopt);
  EXPECT_LT(distance(estimator.pose(), {0.55, 0.2, 0.0}), 1e-9);
  Estimator lost{diamond()};
  lost.resume_manoeuvre({0.1, 0.0, 0.0}, std::nullopt);
  EXPECT_FALSE(lost.pose_known());
  EXPECT_FALSE(lost.off_path_estimator().manoeuvring());
}

}  // namespace
}  // namespace cosiva::aiv
