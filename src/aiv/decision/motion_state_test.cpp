#include "cosiva/aiv/decision/motion_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace cosiva::aiv {
namespace {

wire::Odometry at_speed(std::int16_t speed_mmps) {
  wire::Odometry reading;
  reading.speed_mmps = speed_mmps;
  return reading;
}

wire::Odometry turned(std::int16_t turned_mrad, std::uint32_t board_ms) {
  wire::Odometry reading;
  reading.board_ms = board_ms;
  reading.manoeuvre.emplace();
  reading.manoeuvre->turned_mrad = turned_mrad;
  return reading;
}

TEST(MotionState, has_stopped_after_two_slow_readings_and_not_after_one) {
  MotionState motion;
  motion.on_odometry(at_speed(400));
  EXPECT_FALSE(motion.stopped());
  motion.on_odometry(at_speed(0));
  EXPECT_FALSE(motion.stopped());
  motion.on_odometry(at_speed(9));
  EXPECT_TRUE(motion.stopped());
  motion.on_odometry(at_speed(-11));
  EXPECT_FALSE(motion.stopped()) << "backing up is moving";
}

TEST(MotionState, has_stopped_where_the_odometer_is_lost) {
  MotionState motion;
  motion.on_odometry(at_speed(800));
  motion.on_odometry_lost();
  EXPECT_TRUE(motion.stopped());
  EXPECT_EQ(motion.speed_mps(), 0.0);
}

TEST(MotionState, turns_at_the_rate_of_its_manoeuvre) {
  MotionState motion;
  motion.on_odometry(turned(0, 1000));
  motion.on_odometry(turned(40, 1020));
  EXPECT_DOUBLE_EQ(motion.manoeuvre_turn_radps(), 2.0);
  motion.on_odometry(turned(40, 1040));
  EXPECT_EQ(motion.manoeuvre_turn_radps(), 0.0);
  motion.on_odometry(turned(80, 3000));
  EXPECT_EQ(motion.manoeuvre_turn_radps(), 0.0) << "readings a second apart give no rate";
  motion.on_odometry(at_speed(100));
  EXPECT_FALSE(motion.has_manoeuvre());
}

TEST(MotionState, has_stopped_in_a_manoeuvre_only_after_five_readings_without_progress) {
  MotionState motion;
  motion.on_odometry(turned(10, 0));
  for (int k = 1; k <= 4; ++k) {
    motion.on_odometry(turned(10, 20U * static_cast<std::uint32_t>(k)));
    EXPECT_FALSE(motion.stopped()) << k;
  }
  motion.on_odometry(turned(10, 100));
  EXPECT_TRUE(motion.stopped());
  motion.on_odometry(turned(11, 120));
  EXPECT_FALSE(motion.stopped());
}

TEST(MotionState, is_stuck_after_25_readings_without_progress_and_then_counts_anew) {
  MotionState motion;
  for (int round = 0; round < 2; ++round) {
    for (int k = 0; k < 24; ++k) EXPECT_FALSE(motion.stuck(true, 0.0)) << k;
    EXPECT_TRUE(motion.stuck(true, 0.0));
  }
}

TEST(MotionState, is_not_stuck_while_it_creeps_or_is_not_commanded_to_drive) {
  MotionState motion;
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(motion.stuck(true, 0.0006 * k));
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(motion.stuck(false, 0.06));
  motion.on_odometry(turned(10, 0));
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(motion.stuck(true, 0.06)) << "in a manoeuvre";
}

TEST(MotionState, keeps_its_state_in_another_zone) {
  MotionState before;
  before.on_odometry(at_speed(3));
  before.on_odometry(at_speed(3));
  for (int k = 0; k < 20; ++k) EXPECT_FALSE(before.stuck(true, 0.0));
  MotionState after;
  after.take_over(before);
  EXPECT_EQ(after.speed_mps(), 0.003);
  EXPECT_TRUE(after.stopped());
  for (int k = 0; k < 24; ++k) EXPECT_FALSE(after.stuck(true, 0.0)) << "the measurement of progress restarts";
}

TEST(MotionState, is_moving_at_a_centimetre_per_second) {
  MotionState motion;
  for (int k = 0; k < 3; ++k) motion.on_odometry(at_speed(10));
  EXPECT_FALSE(motion.stopped());
  for (int k = 0; k < 2; ++k) motion.on_odometry(at_speed(-9));
  EXPECT_TRUE(motion.stopped());
}

TEST(MotionState, has_a_turn_rate_by_readings_less_than_a_second_apart) {
  const auto rate_radps = [](std::uint32_t first_ms, std::uint32_t second_ms) {
    MotionState motion;
    motion.on_odometry(turned(10, first_ms));
    motion.on_odometry(turned(47, second_ms));
    return motion.manoeuvre_turn_radps();
  };
  EXPECT_DOUBLE_EQ(rate_radps(500, 501), 37.0);
  EXPECT_DOUBLE_EQ(rate_radps(500, 1499), 37.0 / 999.0);
  EXPECT_EQ(rate_radps(500, 1500), 0.0);
  EXPECT_EQ(rate_radps(500, 500), 0.0);
  EXPECT_EQ(rate_radps(500, 499), 0.0) << "the board counts from zero again";
}

TEST(MotionState, waits_where_it_has_moved_less_than_half_a_millimetre_in_either_direction) {
  for (const double moved_m : {0.0004, -0.0004, 0.0006, -0.0006}) {
    MotionState motion;
    for (int k = 0; k < 24; ++k) EXPECT_FALSE(motion.stuck(true, 3.0)) << k;
    // The first of those gave the reference, and was no wait.
    EXPECT_FALSE(motion.stuck(true, 3.0 + moved_m));
    EXPECT_EQ(motion.stuck(true, 3.0 + moved_m), std::fabs(moved_m) < 0.0005) << moved_m;
  }
}

TEST(MotionStateDeathTest, continues_another_state_only_before_it_has_moved_itself) {
  MotionState moving;
  moving.on_odometry(at_speed(400));
  EXPECT_DEATH(moving.take_over(MotionState{}), "stopped_readings");
}

}  // namespace
}  // namespace cosiva::aiv
