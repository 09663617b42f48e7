#include "cosiva/aiv/perception/path_look_ahead.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

/// The points of the path, one every `sample_m`, in the frame of the body: computed from poses of the circuit.
std::vector<Point2> expected_samples(const zone::Circuit& circuit, zone::TrackPosition here, double sample_m,
                                     std::size_t count) {
  std::vector<Point2> samples;
  const Pose2 X_BM = inverse(circuit.pose_at(here));
  for (std::size_t i = 0; i < count; ++i)
    samples.push_back(X_BM * position(circuit.pose_at(circuit.advance(here, static_cast<double>(i) * sample_m))));
  return samples;
}

TEST(PathLookAhead, has_the_nearest_of_all_its_samples_for_any_point) {
  // A straight, a bend of 0.5 m to the left and one of 1 m to the right.
  const zone::Circuit circuit = test::lay({{0.5}, {0.8, 2.0}, {2.0, -1.0}}, false);
  const zone::TrackPosition here{0, 0.2};
  PathLookAhead look_ahead{circuit, 0.03, 1.3};
  look_ahead.sample(here);
  EXPECT_NEAR(look_ahead.length_m(), 43 * 0.03, 1e-12);  // the last sample within 1.30 m
  const auto samples = expected_samples(circuit, here, 0.03, 44);
  for (double x_m = -0.3; x_m < 1.5; x_m += 0.13) {
    for (double y_m = -0.6; y_m < 1.2; y_m += 0.11) {
      const auto found = look_ahead.off_path({x_m, y_m});
      double nearest2_m2 = std::numeric_limits<double>::infinity();
      for (const Point2& sample : samples)
        nearest2_m2 = std::fmin(nearest2_m2, std::pow(distance(sample, Point2{x_m, y_m}), 2));
      EXPECT_NEAR(found.distance2_m2, nearest2_m2, 1e-9) << x_m << " " << y_m;
      EXPECT_NEAR(std::pow(distance(samples[found.sample], Point2{x_m, y_m}), 2), nearest2_m2, 1e-9);
    }
  }
}

TEST(PathLookAhead, has_the_same_nearest_sample_where_only_a_short_distance_is_of_interest) {
  const zone::Circuit circuit = test::lay({{0.5}, {0.8, 2.0}, {2.0, -1.0}}, false);
  PathLookAhead look_ahead{circuit, 0.03, 1.3};
  look_ahead.sample(zone::TrackPosition{0, 0.2});
  constexpr double within_m = 0.12;
  int near = 0;
  int beyond = 0;
  for (double x_m = -0.3; x_m < 1.5; x_m += 0.017) {
    for (double y_m = -0.6; y_m < 1.2; y_m += 0.019) {
      const auto nearest = look_ahead.off_path({x_m, y_m});
      const auto found = look_ahead.off_path({x_m, y_m}, within_m);
      if (nearest.distance2_m2 <= within_m * within_m) {
        ++near;
        EXPECT_EQ(found.distance2_m2, nearest.distance2_m2) << x_m << " " << y_m;
        EXPECT_EQ(found.sample, nearest.sample) << x_m << " " << y_m;
      } else {
        ++beyond;
        EXPECT_GT(found.distance2_m2, within_m * within_m) << x_m << " " << y_m;
      }
    }
  }
  EXPECT_GT(near, 500);
  EXPECT_GT(beyond, 500);
}

TEST(PathLookAhead, measures_along_the_path_between_its_samples) {
  const zone::Circuit circuit = test::lay({{0.5}, {2.0, 0.8}}, false);
  const zone::TrackPosition here{0, 0.2};
  PathLookAhead look_ahead{circuit, 0.03, 1.3};
  look_ahead.sample(here);
  const Pose2 X_BM = inverse(circuit.pose_at(here));
  for (double along_m = 0.0; along_m < 1.28; along_m += 0.013) {
    const Point2 on_path = X_BM * position(circuit.pose_at(circuit.advance(here, along_m)));
    EXPECT_NEAR(look_ahead.along_path_m(on_path, look_ahead.off_path(on_path).sample), along_m, 1e-3) << along_m;
  }
  // Behind the body, and next to it.
  EXPECT_NEAR(look_ahead.along_path_m({-0.1, 0.05}, 0), -0.1, 1e-12);
  EXPECT_NEAR(look_ahead.along_path_m({0.07, 0.05}, 2), 0.07, 1e-12);
}

TEST(PathLookAhead, of_a_body_off_the_path_leads_straight_to_it_first) {
  const zone::Circuit circuit = test::lay({{5.0}}, false);
  Outlook outlook{0, 1.0};
  outlook.X_MB = Pose2{0.7, 0.4, 0.5 * pi};  // 0.5 m from the position where it joins
  PathLookAhead look_ahead{circuit, 0.03, 1.3};
  look_ahead.sample(outlook);
  EXPECT_NEAR(look_ahead.length_m(), 1.29, 1e-12);
  const Pose2 X_BM = inverse(*outlook.X_MB);
  struct Case {
    Point2 p_M;
    double along_m;
  };
  for (const Case& one : {Case{{0.7, 0.4}, 0.0},
                          {{0.7 + 0.3 * 0.48, 0.4 - 0.4 * 0.48}, 0.24},
                          {{0.7 + 0.3 * 0.9, 0.4 - 0.4 * 0.9}, 0.45},
                          {{1.1, 0.0}, 0.6},
                          {{1.7, 0.0}, 1.2}}) {
    const Point2 p_B = X_BM * one.p_M;
    const auto near = look_ahead.off_path(p_B);
    EXPECT_LE(near.distance2_m2, 0.015 * 0.015 + 1e-12) << one.along_m;
    EXPECT_NEAR(look_ahead.along_path_m(p_B, near.sample), one.along_m, 1e-9) << one.along_m;
  }
  // A body that turns on the spot where the path continues has its pose and no distance to the path.
  outlook.X_MB = Pose2{1.0, 0.0, 1.0};
  look_ahead.sample(outlook);
  EXPECT_NEAR(look_ahead.off_path(inverse(*outlook.X_MB) * Point2{1.6, 0.0}).distance2_m2, 0.0, 1e-12);
}

TEST(PathLookAhead, ends_at_a_dead_end) {
  const zone::Circuit circuit = test::lay({{0.5}, {0.5}}, false);
  PathLookAhead look_ahead{circuit, 0.1, 2.0};
  EXPECT_EQ(look_ahead.length_m(), 0.0);
  look_ahead.sample(Outlook{0, 0.25});
  EXPECT_NEAR(look_ahead.length_m(), 0.7, 1e-12);
}

TEST(PathLookAheadDeathTest, has_a_step_shorter_than_its_reach) {
  const zone::Circuit circuit = test::lay({{0.5}}, false);
  EXPECT_DEATH(static_cast<void>(PathLookAhead{circuit, 0.0, 1.0}), "sample_m > 0.0");
  EXPECT_DEATH(static_cast<void>(PathLookAhead{circuit, 0.1, 0.1}), "reach_m > sample_m");
}

TEST(PathLookAhead, has_a_sample_exactly_at_its_reach_and_at_the_end_of_a_section) {
  // Steps of 0.25 m from 0.25 m on: the fourth is at the end of the first section, the fifth at the reach.
  const zone::Circuit circuit = test::lay({{1.0}, {1.0}}, false);
  PathLookAhead samples{circuit, 0.25, 1.0};
  samples.sample(Outlook{0, 0.25});
  EXPECT_EQ(samples.length_m(), 1.0);
  EXPECT_EQ(samples.off_path({0.75, 0.0}).sample, 3U);
  EXPECT_EQ(samples.off_path({0.75, 0.0}).distance2_m2, 0.0);
  EXPECT_EQ(samples.off_path({1.0, 0.0}).sample, 4U);
}

TEST(PathLookAhead, gives_points_within_the_requested_distance_exactly_and_others_as_beyond_it) {
  const zone::Circuit circuit = test::lay({{0.5}, {0.8, 2.0}, {2.0, -1.0}}, false);
  PathLookAhead look_ahead{circuit, 0.03, 1.3};
  look_ahead.sample(zone::TrackPosition{0, 0.2});
  std::size_t within = 0;
  for (const double within_m : {0.05, 0.1, 0.25}) {
    for (double x_m = -0.4; x_m < 1.6; x_m += 0.017) {
      for (double y_m = -0.7; y_m < 1.3; y_m += 0.019) {
        const auto exact = look_ahead.off_path({x_m, y_m});
        const auto found = look_ahead.off_path({x_m, y_m}, within_m);
        if (exact.distance2_m2 > within_m * within_m) {
          EXPECT_GT(found.distance2_m2, within_m * within_m) << x_m << " " << y_m;
        } else {
          ++within;
          EXPECT_EQ(found.distance2_m2, exact.distance2_m2) << x_m << " " << y_m;
          EXPECT_EQ(found.sample, exact.sample);
        }
      }
    }
  }
  EXPECT_GT(within, 1000U);
}

}  // namespace
}  // namespace cosiva::aiv
