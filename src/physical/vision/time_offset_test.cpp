#include "cosiva/physical/vision/time_offset.h"

#include <gmock/gmock.h>

#include <cmath>

#include "cosiva/base/random.h"

namespace cosiva::vision {
namespace {

/// A vehicle that drives round a circle of 1 m at varying speed.
Pose2 there(double t_s) {
  const double distance_m = 0.35 * t_s - 0.15 * det_cos(1.3 * t_s);
  const auto [s, c] = sincos(distance_m);
  return {c, s, wrap_angle(distance_m + 0.5 * pi)};
}

std::vector<Timed> detected(double late_s, Pose2 lever, double noise_m) {
  std::vector<Timed> all;
  Random random{1, "seen"};
  for (int i = 0; i < 400; ++i) {
    const double t_s = 1.0 + 0.05 * i;
    Pose2 pose = there(t_s - late_s) * lever;
    pose.x_m += random.gaussian(0.0, noise_m);
    pose.y_m += random.gaussian(0.0, noise_m);
    all.push_back({t_s, pose});
  }
  return all;
}

std::vector<Timed> reference() {
  std::vector<Timed> all;
  for (int i = 0; i < 2400; ++i) all.push_back({0.01 * i, there(0.01 * i)});
  return all;
}

TEST(TimeOffset, is_found_whatever_else_is_shifted) {
  for (const double late_s : {-0.080, 0.0, 0.010, 0.120}) {
    const auto found = time_offset(detected(late_s, {0.05, -0.01, 0.0}, 0.001), reference());
    ASSERT_TRUE(found) << to_string(found.error());
    EXPECT_NEAR(found->offset_s, late_s, 0.002);
    EXPECT_NEAR(found->lever.x_m, 0.05, 0.001);
    EXPECT_NEAR(found->lever.y_m, -0.01, 0.001);
    EXPECT_NEAR(found->after_rms_m, 0.001 * std::sqrt(2.0), 0.0003);
    EXPECT_LT(found->standard_error_s, 0.003);
    EXPECT_LT(std::fabs(found->offset_s - late_s), 4.0 * found->standard_error_s + 1e-4);
  }
}

TEST(TimeOffset, that_cannot_be_distinguished_from_a_lever_is_refused) {
  std::vector<Timed> steady;
  for (int i = 0; i < 100; ++i) steady.push_back({0.1 * i, {0.05 * i, 0.0, 0.0}});
  const auto found = time_offset(steady, steady);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, testing::HasSubstr("speed never changes"));
}

TEST(TimeOffset, of_series_that_do_not_overlap_is_refused) {
  const auto found = time_offset(detected(0.0, {}, 0.0), {{0.0, {}}, {0.1, {}}});
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, testing::HasSubstr("only 0 stamps"));
}

}  // namespace
}  // namespace cosiva::vision
