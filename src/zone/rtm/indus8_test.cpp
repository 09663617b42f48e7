// zones/indus8.toml is the second circuit (A20): parallel aisles, tight U-turns, no crossing, on the ground of lacet4.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/zone/layout/beacon_free.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Positions spread evenly over a zone's sections.
std::vector<Point2> positions(const TrafficZone& zone, std::size_t count) {
  std::vector<Point2> found;
  const double step_m = zone.circuit.total_length_m() / static_cast<double>(count);
  TrackPosition at{0, 0.0};
  for (std::size_t i = 0; i < count; ++i) {
    found.push_back(position(zone.circuit.pose_at(at)));
    at = zone.circuit.advance(at, step_m);
  }
  return found;
}

TEST(Indus8, has_eight_parallel_aisles_joined_by_u_turns_and_a_return_section) {
  const TrafficZone zone = testing::zone_file("indus8.toml");
  ASSERT_EQ(zone.circuit.size(), 18U);
  for (int k = 1; k <= 8; ++k) {
    const Section& aisle = zone.circuit.section(zone.circuit.find("aisle_" + std::to_string(k)).value());
    EXPECT_EQ(aisle.kind(), SectionKind::straight);
    EXPECT_NEAR(aisle.start().x_m, -1.26 + 0.36 * (k - 1), 1e-12);
    EXPECT_NEAR(aisle.start().heading_rad, k % 2 == 1 ? pi / 2.0 : -pi / 2.0, 1e-12);
  }
  for (int k = 1; k <= 7; ++k) {
    const Section& turn = zone.circuit.section(zone.circuit.find("turn_" + std::to_string(k)).value());
    EXPECT_NEAR(std::fabs(turn.curvature_at(0.0)), 1.0 / 0.18, 1e-12);
    EXPECT_NEAR(turn.length_m(), pi * 0.18, 1e-12);
  }
}

TEST(Indus8, is_one_loop_of_23_66_m_that_closes_within_a_picometre) {
  const TrafficZone zone = testing::zone_file("indus8.toml");
  EXPECT_NEAR(zone.circuit.total_length_m(), 6 * 2.08 + 2 * 2.18 + 7 * pi * 0.18 + pi * 0.3 + 1.92, 1e-9);
  for (SectionId id = 0; id < 18; ++id) EXPECT_THAT(zone.circuit.next(id), ElementsAre((id + 1) % 18));
  EXPECT_NEAR(distance(zone.circuit.section(17).end(), zone.circuit.section(0).start()), 0.0, 1e-12);
  ASSERT_THAT(zone.loops, SizeIs(1));
  EXPECT_EQ(zone.loops[0].name, "round");
  EXPECT_THAT(zone.loops[0].sections, SizeIs(18));
}

TEST(Indus8, has_no_crossing_at_all) { EXPECT_THAT(testing::zone_file("indus8.toml").crossings, IsEmpty()); }

TEST(Indus8, has_tags_beacons_stations_and_a_charger) {
  const TrafficZone zone = testing::zone_file("indus8.toml");
  EXPECT_THAT(zone.tags, SizeIs(18));
  EXPECT_NEAR(longest_tag_free(zone).length_m, 2.08 - 0.60, 1e-9);
  // Every aisle and the return section lie on the matrix; the longest stretch leads round a corner.
  EXPECT_LT(longest_beacon_free(zone).length_m, 0.9);
  ASSERT_THAT(zone.stations, SizeIs(6));
  EXPECT_EQ(zone.find_station("shelf_a")->kind, StationKind::stop);
  EXPECT_EQ(zone.find_station("charger")->kind, StationKind::charger);
  for (const Station& station : zone.stations) {
    const std::size_t at = zone.waypoint_ahead(station.position);
    ASSERT_LT(at, zone.waypoints.size());
    EXPECT_EQ(zone.waypoints[at].position.section, station.position.section) << station.name;
    EXPECT_NEAR(zone.waypoints[at].position.s_m, station.position.s_m, 0.02) << station.name;
  }
}

TEST(Indus8, begins_with_four_vehicles_and_has_room_for_twelve) {
  const TrafficZone zone = testing::zone_file("indus8.toml");
  EXPECT_THAT(zone.starts, SizeIs(4));
  EXPECT_THAT(zone.start_positions(12), SizeIs(12));
}

TEST(Indus8, supports_the_same_vehicles_as_lacet4) {
  const TrafficZone zone = testing::zone_file("indus8.toml");
  const TrafficZone lacet4 = testing::lacet4();
  EXPECT_EQ(zone.vehicle.length_m, lacet4.vehicle.length_m);
  EXPECT_EQ(zone.vehicle.width_m, lacet4.vehicle.width_m);
  EXPECT_EQ(zone.profiles.fast.speed_mps, lacet4.profiles.fast.speed_mps);
}

TEST(Indus8, has_a_section_within_30_cm_of_every_position_of_lacet4) {
  const TrafficZone zone = testing::zone_file("indus8.toml");
  double worst_m = 0.0;
  for (const Point2& p : positions(testing::lacet4(), 1000))
    worst_m = std::max(worst_m, zone.circuit.locate(p).distance_m);
  EXPECT_LT(worst_m, 0.30);
}

TEST(Indus8, is_within_30_cm_of_lacet4_except_inside_its_loops_and_between_its_arms) {
  // A loop's centre is 0.60 m from its rim, so no aisle there can be nearer everywhere.
  const TrafficZone lacet4 = testing::lacet4();
  std::size_t near = 0;
  const auto all = positions(testing::zone_file("indus8.toml"), 1000);
  for (const Point2& p : all) {
    EXPECT_LE(std::fabs(p.x_m), 1.4);
    EXPECT_LE(std::fabs(p.y_m), 1.4);
    if (lacet4.circuit.locate(p).distance_m < 0.30) ++near;
  }
  EXPECT_GT(near, all.size() / 2);
  RecordProperty("share_within_30_cm_percent", static_cast<int>(near / 10));
}

}  // namespace
}  // namespace cosiva::zone
