#include "cosiva/physical/plant/ranging.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

namespace cosiva::physical {
namespace {

using ::testing::Each;
using ::testing::Lt;

constexpr zone::VehicleShape shape{0.20, 0.12};
constexpr double half_beam_rad = 0.07;

BodyPose at(double x, double y, double heading = 0.0) { return BodyPose::at({x, y, heading}); }

Scan scan_of(const BodyPose& body, std::initializer_list<BodyPose> others, std::initializer_list<Disc> discs = {}) {
  RangeFan fan{shape};
  fan.aim(body);
  for (const auto& other : others) fan.see(other);
  for (const auto& disc : discs) fan.see(disc);
  return fan.ranges();
}

/// The slow reference: the nearest of many points of the rectangle's border that lie in the sector.
double sampled(const BodyPose& body, const BodyPose& other, std::size_t beam) {
  const double centre = 0.01 * (DobsBoard::first_bearing_crad + static_cast<double>(beam) * DobsBoard::beam_width_crad);
  double nearest = 1e9;
  const auto sense = [&](Point2 p_B) {
    Point2 p = body.to_body(other.to_map(p_B));
    p.x_m -= 0.1;
    if (std::fabs(det_atan2(p.y_m, p.x_m) - centre) <= half_beam_rad) nearest = std::min(nearest, norm(p.x_m, p.y_m));
  };
  constexpr int n = 2000;
  for (int i = 0; i <= n; ++i) {
    const double u = static_cast<double>(i) / n - 0.5;
    sense({0.1, 0.12 * u});
    sense({-0.1, 0.12 * u});
    sense({0.2 * u, 0.06});
    sense({0.2 * u, -0.06});
  }
  return nearest;
}

TEST(RangeFan, detects_the_back_of_the_leader_from_its_own_front) {
  const Scan scan = scan_of(at(0, 0), {at(0.7, 0)});
  EXPECT_NEAR(scan[6], 0.5, 1e-12);  // 0.7 between centres, less two half lengths
  EXPECT_LT(scan[0], 0.0);
  EXPECT_LT(scan[12], 0.0);
}

TEST(RangeFan, does_not_detect_the_vehicle_behind) {
  EXPECT_THAT(scan_of(at(0, 0), {at(-0.3, 0), at(-0.25, 0.1, 2.0)}), Each(Lt(0.0)));
}

TEST(RangeFan, does_not_detect_beyond_its_reach) {
  EXPECT_NEAR(scan_of(at(0, 0), {at(2.19, 0)})[6], 1.99, 1e-12);
  EXPECT_THAT(scan_of(at(0, 0), {at(2.21, 0)}), Each(Lt(0.0)));
}

TEST(RangeFan, measures_the_nearest_point_of_a_sector_not_the_one_on_its_centre_line) {
  // A corner that reaches 1° into beam 7 from the left, off the beam's centre line.
  const double bearing = 0.14 + half_beam_rad - 0.017;
  const auto [sin, cos] = sincos(bearing);
  const BodyPose other = at(0.1 + 0.5 * cos + 0.1, 0.5 * sin + 0.06);
  EXPECT_NEAR(scan_of(at(0, 0), {other})[7], 0.5, 1e-9);
}

TEST(RangeFan, is_left_handed_where_the_vehicle_is) {
  const Scan left = scan_of(at(1, 2, 0.7), {BodyPose::at(Pose2{1, 2, 0.7} * Pose2{0.5, 0.3, 0.2})});
  const auto bearing_rad = det_atan2(0.3, 0.4);
  const auto beam = static_cast<std::size_t>(std::lround((bearing_rad + 0.84) / 0.14));
  EXPECT_GT(left[beam], 0.0);
  EXPECT_LT(left[12 - beam], 0.0);
}

TEST(RangeFan, agrees_with_sampling_for_any_pose) {
  EXPECT_TRUE(rc::check("exact sector minimum", [] {
    const auto draw = [](int low, int high) { return *rc::gen::inRange(low, high) * 0.001; };
    const BodyPose body = at(draw(-1000, 1000), draw(-1000, 1000), draw(-3141, 3141));
    const BodyPose other = BodyPose::at(body.X_MB * Pose2{draw(250, 1800), draw(-1500, 1500), draw(-3141, 3141)});
    const Scan scan = scan_of(body, {other});
    for (std::size_t beam = 0; beam < scan.size(); ++beam) {
      const double ground_truth = sampled(body, other, beam);
      if (scan[beam] >= 0.0) {
        // Sampling is a tenth of a millimetre coarse, and may miss a corner that only just reaches in.
        RC_ASSERT(scan[beam] <= ground_truth + 1e-9);
        if (ground_truth < 1e8) RC_ASSERT(scan[beam] >= ground_truth - 2e-3);
      } else {
        RC_ASSERT(ground_truth > 2.0 - 1e-9);
      }
    }
  }));
}

TEST(RangeFan, detects_a_disc_ahead) {
  // From 0.5 m a disc of 0.05 m spans asin(0.1) = ±0.1 rad: beam 6 ends at 0.07 rad, beam 7 at 0.21 rad.
  const Scan scan = scan_of(at(0, 0), {}, {{{0.6, 0.0}, 0.05}});
  EXPECT_NEAR(scan[6], 0.45, 1e-12);
  EXPECT_GT(scan[5], 0.45);
  EXPECT_LT(scan[5], 0.5);
  EXPECT_LT(scan[4], 0.0);
}

TEST(RangeFan, detects_the_side_of_a_disc_that_reaches_into_a_sector) {
  // Centre at 0.5 m; a disc of 0.15 m spans asin(0.3) = 0.305 rad to each side.
  const Scan scan = scan_of(at(0, 0), {}, {{{0.6, 0.0}, 0.15}});
  EXPECT_NEAR(scan[6], 0.35, 1e-12);
  const double border = half_beam_rad;
  const double along = 0.5 * det_cos(border);
  const double off = 0.5 * det_sin(border);
  EXPECT_NEAR(scan[7], along - std::sqrt(0.15 * 0.15 - off * off), 1e-12);
  EXPECT_DOUBLE_EQ(scan[7], scan[5]);
  EXPECT_GT(scan[8], scan[7]);  // sector from 0.21 rad
  EXPECT_LT(scan[9], 0.0);      // sector from 0.35 rad
}

TEST(RangeFan, inside_a_body_reads_zero) {
  EXPECT_THAT(scan_of(at(0, 0), {at(0.15, 0)}), Each(0.0));
  EXPECT_THAT(scan_of(at(0, 0), {}, {{{0.1, 0.0}, 0.05}}), Each(0.0));
}

TEST(RangeFan, takes_the_nearest_of_several) {
  EXPECT_NEAR(scan_of(at(0, 0), {at(1.5, 0), at(0.7, 0), at(1.0, 0)})[6], 0.5, 1e-12);
}

TEST(MeasuredScan, has_the_configured_noise_and_dropouts) {
  Scan exact;
  exact.fill(-1.0);
  exact[6] = 0.5;
  Random random{5, "ranges"};
  constexpr int scans = 10'000;
  int unresponsive = 0;
  double sum = 0.0;
  double sum_sq = 0.0;
  for (int i = 0; i < scans; ++i) {
    const Scan scan = RangeFan::measured(exact, 0.005, 0.01, random);
    ASSERT_LT(scan[5], 0.0);
    if (scan[6] < 0.0) {
      ++unresponsive;
      continue;
    }
    sum += scan[6] - 0.5;
    sum_sq += (scan[6] - 0.5) * (scan[6] - 0.5);
  }
  EXPECT_NEAR(unresponsive, 100, 40);  // σ = √(10000 · 0.01 · 0.99) = 10
  EXPECT_NEAR(sum / scans, 0.0, 4.0 * 0.005 / 100.0);
  EXPECT_NEAR(std::sqrt(sum_sq / scans), 0.005, 4.0 * 0.005 / 141.0);
}

}  // namespace
}  // namespace cosiva::physical
