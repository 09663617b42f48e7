#include "cosiva/aiv/motion/speed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

namespace cosiva::aiv {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
const Situation free_path{.speed_mps = 0.3,
                          .obstacle_ahead_m = nothing,
                          .end_of_base_m = 1.0,
                          .crossing_ahead_m = nothing,
                          .charge = 1.0,
                          .imposed = std::nullopt};

TEST(StoppableSpeed, is_the_inverse_of_the_stopping_distance) {
  EXPECT_TRUE(rc::check([] {
    const double v = 1e-3 * *rc::gen::inRange(0, 5000);
    const double b = 1e-2 * *rc::gen::inRange(1, 500);
    const double t = 1e-3 * *rc::gen::inRange(0, 2000);
    const double d = v * t + v * v / (2.0 * b);
    RC_ASSERT(std::fabs(stoppable_speed(d, b, t) - v) <= 1e-12 * (1.0 + v));
  }));
}

TEST(StoppableSpeed, is_zero_without_distance_and_unbounded_for_an_unlimited_distance) {
  EXPECT_EQ(stoppable_speed(0.0, 1.0, 0.1), 0.0);
  EXPECT_EQ(stoppable_speed(-1.0, 1.0, 0.1), 0.0);
  EXPECT_EQ(stoppable_speed(nothing, 1.0, 0.1), nothing);
}

TEST(Profiles, are_parsed_from_their_exact_terms_only) {
  for (const Profile profile : {Profile::stop, Profile::slow, Profile::medium, Profile::fast})
    EXPECT_EQ(parse_profile(to_string(profile)), profile);
  EXPECT_EQ(parse_profile("Slow"), std::nullopt);
  EXPECT_EQ(parse_profile(""), std::nullopt);
}

TEST(Profiles, stop_brakes_like_medium) {
  const zone::SpeedProfiles profiles{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}, {0.7, 0.8, 0.9}};
  EXPECT_EQ(kinematics(profiles, Profile::stop).speed_mps, 0.0);
  EXPECT_EQ(kinematics(profiles, Profile::stop).braking_mps2, 0.6);
  EXPECT_EQ(kinematics(profiles, Profile::fast).speed_mps, 0.7);
}

TEST(Status, is_one_of_the_five_of_the_article) {
  EXPECT_EQ(to_string(status_of(0.3, std::nullopt)), "Normal");
  EXPECT_EQ(to_string(status_of(0.0, std::nullopt)), "stopped");
  EXPECT_EQ(to_string(status_of(0.009, Profile::fast)), "stopped");
  EXPECT_EQ(to_string(status_of(0.1, Profile::slow)), "slow speed");
  EXPECT_EQ(to_string(status_of(0.3, Profile::medium)), "medium speed");
  EXPECT_EQ(to_string(status_of(-0.5, Profile::fast)), "fast speed");
}

TEST(Profiles, have_their_own_kinematics_and_terms) {
  const zone::SpeedProfiles profiles{{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}, {0.7, 0.8, 0.9}};
  struct Row {
    Profile profile;
    const char* term;
    zone::SpeedProfile expected;
  };
  for (const Row& row : {Row{Profile::stop, "stop", {0.0, 0.5, 0.6}},
                         {Profile::slow, "slow", {0.1, 0.2, 0.3}},
                         {Profile::medium, "medium", {0.4, 0.5, 0.6}},
                         {Profile::fast, "fast", {0.7, 0.8, 0.9}}}) {
    EXPECT_EQ(to_string(row.profile), row.term);
    const zone::SpeedProfile found = kinematics(profiles, row.profile);
    EXPECT_EQ(found.speed_mps, row.expected.speed_mps);
    EXPECT_EQ(found.acceleration_mps2, row.expected.acceleration_mps2);
    EXPECT_EQ(found.braking_mps2, row.expected.braking_mps2);
  }
}

TEST(Status, is_stopped_below_a_centimetre_per_second) {
  EXPECT_EQ(status_of(0.0099, {}), Status::stopped);
  EXPECT_EQ(status_of(-0.0099, {}), Status::stopped);
  EXPECT_EQ(status_of(0.0101, {}), Status::normal);
  EXPECT_EQ(status_of(0.3, Profile::stop), Status::stopped);
}

TEST(CrispChoice, is_medium_on_a_free_path) { EXPECT_EQ(CrispSpeedPolicy{}.choose(free_path), Profile::medium); }

TEST(CrispChoice, obeys_the_operator) {
  for (const Profile imposed : {Profile::slow, Profile::medium, Profile::fast, Profile::stop}) {
    Situation situation = free_path;
    situation.imposed = imposed;
    EXPECT_EQ(CrispSpeedPolicy{}.choose(situation), imposed);
  }
}

TEST(CrispChoice, stops_without_a_base_whatever_the_operator_imposes) {
  Situation situation = free_path;
  situation.imposed = Profile::fast;
  situation.end_of_base_m = 0.0;
  EXPECT_EQ(CrispSpeedPolicy{}.choose(situation), Profile::stop);
}

TEST(CrispChoice, is_slow_near_an_obstacle_and_with_a_low_battery) {
  Situation situation = free_path;
  situation.obstacle_ahead_m = 0.2;
  EXPECT_EQ(CrispSpeedPolicy{}.choose(situation), Profile::slow);
  situation = free_path;
  situation.charge = 0.05;
  EXPECT_EQ(CrispSpeedPolicy{}.choose(situation), Profile::slow);
}

TEST(StoppableSpeedDeathTest, needs_brakes_and_no_time_travel) {
  EXPECT_DOUBLE_EQ(stoppable_speed(2.0, 1.0, 0.0), 2.0);
  EXPECT_DEATH(static_cast<void>(stoppable_speed(1.0, 0.0, 0.1)), "braking_mps2 > 0.0");
  EXPECT_DEATH(static_cast<void>(stoppable_speed(1.0, 1.0, -0.1)), "late_s >= 0.0");
}

TEST(CrispChoice, needs_a_base_and_35_centimetres) {
  Situation situation = free_path;
  situation.end_of_base_m = 0.001;
  EXPECT_EQ(CrispSpeedPolicy{}.choose(situation), Profile::medium);
  situation.end_of_base_m = -0.001;
  EXPECT_EQ(CrispSpeedPolicy{}.choose(situation), Profile::stop);
  // An obstacle 0.35 m away, a tenth of the charge.
  EXPECT_EQ(CrispSpeedPolicy{}.choose({0.3, 0.35, 1.0, nothing, 0.10, std::nullopt}), Profile::medium);
  EXPECT_EQ(CrispSpeedPolicy{}.choose({0.3, 0.349, 1.0, nothing, 0.10, std::nullopt}), Profile::slow);
  EXPECT_EQ(CrispSpeedPolicy{}.choose({0.3, 0.35, 1.0, nothing, 0.099, std::nullopt}), Profile::slow);
}

}  // namespace
}  // namespace cosiva::aiv
