#include "cosiva/zone/layout/beacons.h"
#include "cosiva/zone/layout/beacon_free.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using testing::part;
using testing::section;

TrafficZone zone_of(Circuit circuit) { return {"z", std::move(circuit), {}, {}, {}, {}, {}, {}, {}, {}}; }

/// 6 m eastward from the origin.
TrafficZone straight_zone() { return zone_of(testing::circuit({part("a", section({}, 6.0))})); }

BeaconGrid grid(double pitch_m, Point2 origin, double rotation_rad = 0.0) {
  BeaconGrid made{pitch_m, origin, 100, 100};
  made.rotation_rad = rotation_rad;
  return made;
}

// Positions of the beacons
// -------------------------------------------------------------------------------------------------

TEST(BeaconGrid, turned_by_90_degrees_has_its_columns_northward) {
  const BeaconGrid turned = grid(0.5, {1.0, 2.0}, pi / 2.0);
  EXPECT_NEAR(turned.at(3, 0).x_m, 1.0, 1e-12);
  EXPECT_NEAR(turned.at(3, 0).y_m, 3.5, 1e-12);
  EXPECT_NEAR(turned.at(0, 2).x_m, 0.0, 1e-12);
  EXPECT_NEAR(turned.at(0, 2).y_m, 2.0, 1e-12);
}

TEST(BeaconGrid, finds_the_nearest_of_a_turned_matrix_and_nothing_beyond_its_edge) {
  BeaconGrid turned{0.4, {0.3, -0.2}, 7, 5};
  turned.rotation_rad = 0.3;
  for (std::uint32_t j = 0; j < 5; ++j) {
    for (std::uint32_t i = 0; i < 7; ++i) {
      const Point2 beacon = turned.at(i, j);
      const auto near = turned.nearest({beacon.x_m + 0.1, beacon.y_m - 0.1});
      ASSERT_TRUE(near);
      EXPECT_EQ(near->number, turned.first_number + j * 7 + i);
      EXPECT_EQ(near->position, beacon);
      EXPECT_EQ(turned.find(near->number), beacon);
    }
  }
  // Half a pitch and a little beyond the last column, along the matrix's own axis.
  const Point2 last = turned.at(6, 2);
  EXPECT_TRUE(turned.nearest({last.x_m + 0.19 * std::cos(0.3), last.y_m + 0.19 * std::sin(0.3)}));
  EXPECT_FALSE(turned.nearest({last.x_m + 0.21 * std::cos(0.3), last.y_m + 0.21 * std::sin(0.3)}));
}

TEST(CoveringGrid, turned_covers_every_section_and_passes_through_its_point) {
  const TrafficZone zone = testing::lacet4();
  for (const double rotation_rad : {0.0, 0.2, pi / 4.0, 1.4, -2.0}) {
    const auto covering = covering_grid(zone.circuit, zone.vehicle, 0.25, {0.1, 0.05}, 100'000, rotation_rad);
    ASSERT_TRUE(covering);
    for (SectionId id = 0; id < zone.circuit.size(); ++id)
      for (double s = 0.0; s <= zone.circuit.section(id).length_m(); s += 0.05)
        EXPECT_TRUE(covering->nearest(position(zone.circuit.pose_at({id, s})))) << rotation_rad;
    EXPECT_LT(distance(covering->nearest({0.1, 0.05})->position, {0.1, 0.05}), 1e-12) << rotation_rad;
    // Not many more than necessary: 2.7 m square, and its diagonal where the matrix is turned.
    EXPECT_LE(covering->columns * covering->rows, 20U * 20U);
  }
}

TEST(CoveringGrid, has_no_row_or_column_more_than_half_a_vehicle_at_each_side_needs) {
  // 2 m eastward at y = 0.3, a vehicle 0.12 m wide: x from −0.06 to 2.06 m, y from 0.24 to 0.36 m.
  const Circuit line = testing::circuit({part("a", section({0.0, 0.3, 0.0}, 2.0))});
  const VehicleShape vehicle{0.20, 0.12};
  const auto covering = covering_grid(line, vehicle, 0.25, {0.1, 0.05}, 1000);
  ASSERT_TRUE(covering);
  EXPECT_NEAR(covering->origin.x_m, -0.15, 1e-12);
  EXPECT_EQ(covering->columns, 10U);  // to 2.10 m
  EXPECT_NEAR(covering->origin.y_m, 0.05, 1e-12);
  EXPECT_EQ(covering->rows, 3U);  // 0.05, 0.30 and 0.55 m
  EXPECT_EQ(covering->covers_through, (Point2{0.1, 0.05}));
  EXPECT_EQ(covering->pitch_m, 0.25);
  EXPECT_TRUE(covering_grid(line, vehicle, 0.25, {0.1, 0.05}, 30));
  EXPECT_FALSE(covering_grid(line, vehicle, 0.25, {0.1, 0.05}, 29));
  // Turned by 90° the columns lead north: x' = y − 0.05, y' = −(x − 0.1).
  const auto turned = covering_grid(line, vehicle, 0.25, {0.1, 0.05}, 1000, pi / 2.0);
  ASSERT_TRUE(turned);
  EXPECT_EQ(turned->columns, 3U);  // x' from 0.19 to 0.31 m: 0.00 to 0.50 m
  EXPECT_EQ(turned->rows, 10U);    // y' from −1.96 to 0.16 m: −2.00 to 0.25 m
  EXPECT_NEAR(turned->origin.x_m, 2.1, 1e-12);
  EXPECT_NEAR(turned->origin.y_m, 0.05, 1e-12);
  EXPECT_EQ(turned->rotation_rad, pi / 2.0);
}

TEST(CoveringGrid, turned_covers_curves_with_a_margin_of_a_few_millimetres_at_most) {
  // Round a circle of 1 m about the origin, turned by an eighth: 1.06 m to each side, and at most 0.25²/8 of a part
  // more.
  const Section half = section({1.0, 0.0, pi / 2.0}, pi, 1.0);
  const Circuit circle = testing::circuit({part("a", half, {1}), part("b", section(half.end(), pi, 1.0), {0})});
  const auto covering = covering_grid(circle, {0.20, 0.12}, 0.01, {0.0, 0.0}, 100'000, pi / 4.0);
  ASSERT_TRUE(covering);
  EXPECT_GE(covering->columns, 213U);
  EXPECT_LE(covering->columns, 215U);
  EXPECT_GE(covering->rows, 213U);
  EXPECT_LE(covering->rows, 215U);
}

// The longest stretch
// ---------------------------------------------------------------------------------------------------------

TEST(BeaconFree, parallel_straight_meets_one_at_every_pitch_or_never) {
  TrafficZone zone = straight_zone();
  zone.beacons = grid(0.30, {0.0, 0.0199});
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 0.30, 1e-9);
  zone.beacons = grid(0.30, {0.0, 0.0201});
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 6.0, 1e-9);
  EXPECT_NEAR(longest_beacon_free(zone, 0.03).length_m, 0.30, 1e-9);
}

TEST(BeaconFree, names_the_positions_between_which_it_lies) {
  TrafficZone zone = straight_zone();
  // The section's end has 6 − 5·1.1 = 0.5 m behind the last, its beginning none: 1.1 m lie between two.
  zone.beacons = grid(1.1, {0.0, 0.0});
  const Stretch longest = longest_beacon_free(zone);
  EXPECT_NEAR(longest.length_m, 1.1, 1e-9);
  EXPECT_NEAR(longest.to.s_m - longest.from.s_m, 1.1, 1e-9);
  EXPECT_FALSE(longest.endless);
  // Beginning and end of a section count: nothing was read before.
  zone.beacons = grid(4.0, {1.5, 0.0});
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 4.0, 1e-9);
  zone.beacons = BeaconGrid{4.0, {4.5, 0.0}, 1, 1};
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 4.5, 1e-9);
  EXPECT_EQ(longest_beacon_free(zone).from, (TrackPosition{0, 0.0}));
}

TEST(BeaconFree, oblique_straight_meets_one_at_the_lattice_points) {
  // 45° through the origin of a matrix of 0.3 m: one at every diagonal.
  TrafficZone zone = zone_of(testing::circuit({part("a", section({0.0, 0.0, pi / 4.0}, 6.0))}));
  zone.beacons = grid(0.30, {0.0, 0.0});
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 0.30 * std::sqrt(2.0), 1e-9);
  // The same matrix, turned as the section is, is parallel to it.
  zone.beacons = grid(0.30, {0.0, 0.0}, pi / 4.0);
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 0.30, 1e-9);
}

TEST(BeaconFree, runs_on_over_joints_to_the_worst_branch) {
  // A stem of 1 m with a beacon at its start; left goes on 2 m, right 3 m, neither has one.
  const Section stem = section({}, 1.0);
  const Section left = section(stem.end(), 2.0, 0.5);
  const Section right = section(stem.end(), 3.0, -0.5);
  TrafficZone zone = zone_of(testing::circuit({part("stem", stem, {1, 2}), part("left", left), part("right", right)}));
  zone.beacons = BeaconGrid{50.0, {0.0, 0.0}, 1, 1};
  const Stretch longest = longest_beacon_free(zone);
  EXPECT_NEAR(longest.length_m, 4.0, 1e-6);
  EXPECT_EQ(longest.from.section, 0U);
  EXPECT_EQ(longest.to, (TrackPosition{2, 3.0}));
}

TEST(BeaconFree, loop_without_any_is_endless) {
  TrafficZone zone = zone_of(testing::track(2.0, 0.5));
  const double round_m = 4.0 + pi;
  for (const bool far_away : {false, true}) {
    if (far_away) zone.beacons = BeaconGrid{0.3, {50.0, 50.0}, 3, 3};
    const Stretch longest = longest_beacon_free(zone);
    EXPECT_TRUE(longest.endless);
    EXPECT_NEAR(longest.length_m, round_m, 1e-9);
  }
  // One beacon on the loop: one lap from the beacon to itself.
  zone.beacons = BeaconGrid{0.3, {1.0, 0.0}, 1, 1};
  const Stretch longest = longest_beacon_free(zone);
  EXPECT_FALSE(longest.endless);
  EXPECT_NEAR(longest.length_m, round_m, 1e-9);
}

TEST(BeaconFree, counts_a_beacon_at_a_joint_once_and_in_any_case) {
  TrafficZone zone = zone_of(testing::track(2.0, 0.5));
  zone.beacons = BeaconGrid{10.0, {2.0, 0.0}, 1, 1};  // where "south" meets "east"
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 4.0 + pi, 1e-6);
}

TEST(BeaconFree, reads_on_curves_too) {
  // Round a circle of 1 m; beacons of a 1 m matrix lie on it at the four quarters alone.
  const Section half = section({1.0, 0.0, pi / 2.0}, pi, 1.0);
  const Section back = section(half.end(), pi, 1.0);
  TrafficZone zone = zone_of(testing::circuit({part("a", half, {1}), part("b", back, {0})}));
  zone.beacons = BeaconGrid{1.0, {-3.0, -3.0}, 7, 7};
  EXPECT_NEAR(longest_beacon_free(zone, 0.01).length_m, pi / 2.0, 1e-3);
}

TEST(TagFree, stretch_of_lacet4_is_a_twelfth_of_its_loop) {
  const TrafficZone zone = testing::lacet4();
  EXPECT_NEAR(longest_tag_free(zone).length_m, zone.circuit.total_length_m() / 12.0, 0.002);
  TrafficZone bare = zone;
  bare.tags.clear();
  EXPECT_TRUE(longest_tag_free(bare).endless);
}

// Better positions
// -------------------------------------------------------------------------------------------------------------

TEST(SuggestedOrigin, puts_the_beacons_under_a_parallel_straight) {
  TrafficZone zone = straight_zone();
  zone.beacons = grid(0.30, {-3.0, -3.15});  // the line runs half the distance between two rows
  const auto better = suggest_origin(zone);
  ASSERT_TRUE(better);
  EXPECT_NEAR(better->before_m, 6.0, 1e-9);
  EXPECT_NEAR(better->after_m, 0.30, 1e-6);
  zone.beacons->origin = better->origin;
  EXPECT_NEAR(longest_beacon_free(zone).length_m, better->after_m, 1e-9);
}

TEST(SuggestedOrigin, leaves_a_matrix_where_none_is_better) {
  TrafficZone zone = straight_zone();
  zone.beacons = grid(0.30, {-3.0, -3.0});
  const auto same = suggest_origin(zone);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->origin, zone.beacons->origin);
  EXPECT_EQ(same->before_m, same->after_m);
  zone.beacons.reset();
  EXPECT_FALSE(suggest_origin(zone));
}

TEST(SuggestedOrigin, of_a_real_zone_is_as_good_as_reported_when_written_to_its_file) {
  TrafficZone zone = testing::lacet4();
  for (const double rotation_rad : {0.0, 0.25}) {
    for (const double pitch_m : {0.20, 0.30, 0.45}) {
      zone.beacons = covering_grid(zone.circuit, zone.vehicle, pitch_m, {0.02, 0.11}, 100'000, rotation_rad);
      const auto better = suggest_origin(zone);
      ASSERT_TRUE(better);
      EXPECT_LE(better->after_m, better->before_m);
      const TrafficZone before = zone;
      zone.beacons = covering_grid(zone.circuit, zone.vehicle, pitch_m, better->origin, 100'000, rotation_rad);
      EXPECT_NEAR(longest_beacon_free(zone).length_m, better->after_m, 1e-6) << pitch_m << " " << rotation_rad;
      EXPECT_LT(distance(better->origin, *before.beacons->covers_through), pitch_m * 3.0);
    }
  }
}

TEST(SuggestedOrigin, holds_for_beacons_that_are_laid_a_millimetre_off) {
  TrafficZone zone = testing::lacet4();
  zone.beacons = covering_grid(zone.circuit, zone.vehicle, 0.30, {0.02, 0.11}, 100'000, 0.0);
  const auto better = suggest_origin(zone);
  ASSERT_TRUE(better);
  for (const Point2 off : {Point2{0.001, 0}, Point2{-0.001, 0}, Point2{0, 0.001}, Point2{0, -0.001}}) {
    zone.beacons = covering_grid(zone.circuit, zone.vehicle, 0.30,
                                 Point2{better->origin.x_m + off.x_m, better->origin.y_m + off.y_m}, 100'000, 0.0);
    EXPECT_LT(longest_beacon_free(zone).length_m, better->after_m + 0.002);
  }
}

// Offsets are tried along x, then along y, in steps of a pitch divided by 8 to 32, as many as the pitch has reaches.
// The line runs half a pitch, 0.15 m, from a row; the first offset along y that brings a row within nine tenths of
// the reach to it reads a beacon every 0.30 m, and no other does better.
TEST(SuggestedOrigin, is_the_first_of_its_matrix_of_offsets_that_is_best) {
  TrafficZone zone = straight_zone();
  zone.beacons = grid(0.30, {-3.0, -3.15});
  const auto expect_origin = [&](double reach_m, double y_m) {
    const auto better = suggest_origin(zone, reach_m);
    ASSERT_TRUE(better);
    EXPECT_NEAR(better->origin.x_m, -3.0, 1e-9) << reach_m;
    EXPECT_NEAR(better->origin.y_m, y_m, 1e-9) << reach_m;
    EXPECT_NEAR(better->before_m, 6.0, 1e-9) << reach_m;
    EXPECT_NEAR(better->after_m, 0.30, 1e-6) << reach_m;
  };
  expect_origin(0.02, -3.01);   // 15 steps of 0.02 m: 0.14 m leave 1 cm
  expect_origin(0.10, -3.075);  // 8 steps of 0.0375 m: 0.075 m leave 0.075 m
  expect_origin(0.007, -3.0);   // 32 steps of 0.009375 m, not 43: 0.15 m leave nothing
}

TEST(SuggestedOrigin, of_a_matrix_that_covers_the_zone_is_where_it_passes_through) {
  TrafficZone zone = straight_zone();
  zone.beacons = grid(0.30, {-3.0, -3.0});
  zone.beacons->covers_through = Point2{-1.5, 0.0};
  const auto same = suggest_origin(zone);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->origin, (Point2{-1.5, 0.0}));
  EXPECT_NEAR(same->before_m, 0.30, 1e-9);
  EXPECT_NEAR(same->after_m, 0.30, 1e-9);
}

}  // namespace
}  // namespace cosiva::zone
