#include "cosiva/aiv/perception/body_gap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

constexpr double no_body = std::numeric_limits<double>::infinity();

/// The vehicle is 0.20 m x 0.12 m, at x = 1 m on a straight of 5 m along x; the corridor is 0.16 m wide.
struct Straight {
  zone::TrafficZone zone = [] {
    zone::TrafficZone made = test::lacet4();
    made.circuit = test::lay({{5.0}}, false);
    return made;
  }();
  BodyGap gap{zone, {}};

  double gap_m(const wire::Body& body, double carried_s = 0.0, double s_m = 1.0) {
    gap.update(Outlook{0, s_m});
    return gap.gap_m(body, carried_s);
  }
};
wire::Body body_at(double x_m, double y_m, double radius_m, double length_m = 0.0, double heading_rad = 0.0) {
  return {"B", "box", x_m, y_m, heading_rad, length_m, radius_m, 0.0, 0.0};
}

TEST(BodyGap, of_a_disc_ends_at_the_chord_that_the_corridor_cuts_off) {
  Straight straight;
  EXPECT_NEAR(straight.gap_m(body_at(1.6, 0.0, 0.05)), 0.6 - 0.05 - 0.1, 1e-9);
  EXPECT_NEAR(straight.gap_m(body_at(1.6, 0.079, 0.05)), 0.6 - 0.05 - 0.1, 1e-9);
  EXPECT_NEAR(straight.gap_m(body_at(1.6, -0.11, 0.05)), 0.6 - 0.04 - 0.1, 1e-9);
  EXPECT_NEAR(straight.gap_m(body_at(1.6, 0.12, 0.05)), 0.6 - 0.03 - 0.1, 1e-9);
  EXPECT_EQ(straight.gap_m(body_at(1.6, 0.131, 0.05)), no_body);
  // Between samples of the path, 3 cm apart, nothing changes.
  for (double x_m = 1.3; x_m < 2.2; x_m += 0.007)
    EXPECT_NEAR(straight.gap_m(body_at(x_m, 0.11, 0.05)), x_m - 1.0 - 0.04 - 0.1, 1e-9) << x_m;
}

TEST(BodyGap, of_a_long_body_is_that_of_its_nearest_part) {
  Straight straight;
  // Along the path, 0.4 m long between the centres of its ends.
  EXPECT_NEAR(straight.gap_m(body_at(2.0, 0.0, 0.05, 0.4)), 1.0 - 0.2 - 0.05 - 0.1, 1e-9);
  // Across it: one of the discs, at most 5 cm apart, lies in the corridor.
  EXPECT_NEAR(straight.gap_m(body_at(1.6, 0.2, 0.05, 0.4, 0.5 * pi)), 0.6 - 0.05 - 0.1, 1e-9);
  EXPECT_EQ(straight.gap_m(body_at(1.6, 0.34, 0.05, 0.4, 0.5 * pi)), no_body);
  // Aslant: its far end reaches into the corridor.
  const double slant_rad = std::atan2(0.3, 0.4);
  EXPECT_NEAR(straight.gap_m(body_at(1.8, 0.15, 0.05, 0.5, slant_rad)), 0.8 - 0.2 - 0.05 - 0.1, 1e-9);
}

TEST(BodyGap, carries_a_body_on_at_its_speed) {
  Straight straight;
  wire::Body moving = body_at(1.6, 0.3, 0.05);
  moving.vx_mps = 0.4;
  moving.vy_mps = -0.6;
  EXPECT_EQ(straight.gap_m(moving), no_body);
  EXPECT_NEAR(straight.gap_m(moving, 0.5), 0.8 - 0.05 - 0.1, 1e-9);
}

TEST(BodyGap, is_only_to_bodies_before_it_and_within_reach) {
  Straight straight;
  EXPECT_EQ(straight.gap_m(body_at(1.04, 0.0, 0.05)), 0.0) << "a contact";
  EXPECT_EQ(straight.gap_m(body_at(0.99, 0.0, 0.05)), no_body) << "behind the body origin";
  EXPECT_EQ(straight.gap_m(body_at(1.0, 0.0, 0.05, 0.2)), no_body) << "its centre is not ahead";
  EXPECT_EQ(straight.gap_m(body_at(1.01, 0.0, 0.05, 0.2)), 0.0);
  EXPECT_NEAR(straight.gap_m(body_at(2.3, 0.0, 0.05)), 1.3 - 0.15, 1e-9);
  EXPECT_EQ(straight.gap_m(body_at(2.31, 0.0, 0.05)), no_body) << "its disc begins beyond the last sample";
  EXPECT_NEAR(straight.gap_m(body_at(2.45, 0.0, 0.05, 0.4)), 1.45 - 0.2 - 0.15, 1e-9);
  // The circuit ends at 5 m: the last sample lies at 4.99 m.
  EXPECT_NEAR(straight.gap_m(body_at(5.0, 0.0, 0.05), 0.0, 4.0), 1.0 - 0.15, 1e-9);
  EXPECT_EQ(straight.gap_m(body_at(5.02, 0.0, 0.05), 0.0, 4.0), no_body);
}

TEST(BodyGap, off_the_path_is_measured_along_the_line_to_it) {
  Straight straight;
  Outlook outlook{0, 1.5};
  outlook.X_MB = Pose2{1.5, 0.5, -0.5 * pi};  // half a metre off the path, and facing it
  straight.gap.update(outlook);
  EXPECT_NEAR(straight.gap.gap_m(body_at(1.5, 0.2, 0.05), 0.0), 0.3 - 0.15, 1e-9);
  EXPECT_EQ(straight.gap.gap_m(body_at(1.2, 0.2, 0.05), 0.0), no_body);
}

TEST(BodyGapDeathTest, has_a_corridor_no_narrower_than_the_body) {
  Straight straight;
  const BodyGap as_wide{straight.zone, {.margin_m = 0.0}};
  EXPECT_DEATH(static_cast<void>(BodyGap{straight.zone, {.margin_m = -0.01}}), "margin_m >= 0.0");
}

}  // namespace
}  // namespace cosiva::aiv
