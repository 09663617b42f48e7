#include "cosiva/aiv/decision/back_up.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cosiva::aiv {
namespace {

zone::SpeedProfile slow() {
  zone::SpeedProfile profile;
  profile.speed_mps = 0.4;
  profile.braking_mps2 = 0.5;
  return profile;
}

TEST(BackUp, is_completed_within_five_millimetres_of_its_end) {
  BackUp back_up;
  back_up.begin(0.20, 1.0);
  back_up.on_odometry(0.806, true);
  EXPECT_TRUE(back_up.active());
  back_up.on_odometry(0.8049, true);
  EXPECT_FALSE(back_up.active());
  EXPECT_TRUE(back_up.completed());
}

TEST(BackUp, ends_uncompleted_off_the_path) {
  BackUp back_up;
  back_up.begin(0.20, 1.0);
  back_up.on_odometry(0.9, false);
  EXPECT_FALSE(back_up.active());
  EXPECT_FALSE(back_up.completed());
}

TEST(BackUp, ends_uncompleted_after_fifteen_seconds_of_readings) {
  BackUp back_up;
  back_up.begin(0.20, 1.0);
  for (int k = 0; k < 750; ++k) back_up.on_odometry(1.0, true);
  EXPECT_TRUE(back_up.active());
  back_up.on_odometry(1.0, true);
  EXPECT_FALSE(back_up.active());
  EXPECT_FALSE(back_up.completed());
}

TEST(BackUp, that_begins_again_is_no_longer_completed) {
  BackUp back_up;
  back_up.begin(0.1, 1.0);
  back_up.on_odometry(0.9, true);
  ASSERT_TRUE(back_up.completed());
  back_up.begin(0.1, 0.9);
  EXPECT_FALSE(back_up.completed());
  back_up.end();
  EXPECT_FALSE(back_up.active());
}

TEST(BackUp, drives_at_a_tenth_of_a_metre_per_second_and_slows_down_to_stop_at_its_end) {
  BackUp back_up;
  back_up.begin(0.20, 1.0);
  EXPECT_EQ(back_up.speed_mps(slow(), 1.0), 0.10);
  EXPECT_DOUBLE_EQ(back_up.speed_mps(slow(), 0.804), std::sqrt(2.0 * 0.5 * 0.004));
  EXPECT_EQ(back_up.speed_mps(slow(), 0.79), 0.0);
  zone::SpeedProfile slower = slow();
  slower.speed_mps = 0.06;
  EXPECT_EQ(back_up.speed_mps(slower, 1.0), 0.06);
}

TEST(BackUpDeathTest, is_by_more_than_nothing_and_at_most_half_a_metre) {
  BackUp back_up;
  EXPECT_DEATH(back_up.begin(0.0, 1.0), "distance_m > 0.0");
  EXPECT_DEATH(back_up.begin(0.501, 1.0), "distance_m_max");
  back_up.begin(0.5, 1.0);
  EXPECT_TRUE(back_up.active());
  back_up.end();
  EXPECT_DEATH(static_cast<void>(back_up.speed_mps(slow(), 1.0)), "active");
}

TEST(BackUp, counts_its_readings_anew_when_it_begins_again) {
  BackUp back_up;
  back_up.begin(0.20, 1.0);
  for (int k = 0; k < 700; ++k) back_up.on_odometry(1.0, true);
  back_up.begin(0.20, 1.0);
  for (int k = 0; k < 750; ++k) back_up.on_odometry(1.0, true);
  EXPECT_TRUE(back_up.active());
}

TEST(BackUp, that_is_not_active_takes_no_reading_for_its_end) {
  BackUp back_up;
  back_up.begin(0.20, 1.0);
  back_up.end();
  back_up.on_odometry(0.8, true);
  EXPECT_FALSE(back_up.completed());
}

}  // namespace
}  // namespace cosiva::aiv
