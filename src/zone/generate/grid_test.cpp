#include "cosiva/zone/generate/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/check/deadlock.h"
#include "cosiva/zone/generate/floor.h"
#include "cosiva/zone/routing/route.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TrafficZone zone_of(const Result<std::string>& text) {
  EXPECT_TRUE(text) << to_string(text.error());
  auto zone = testing::read_zone(*text);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}

TrafficZone grid(const GridOptions& options) { return zone_of(generate_grid(options)); }
TrafficZone loop(const LoopOptions& options) { return zone_of(generate_loop(options)); }

std::vector<TrafficZone> make_floors() {
  std::vector<TrafficZone> all;
  std::uint64_t seed = 0;
  for (const auto& [columns, rows] :
       {std::pair{1U, 2U}, {2U, 1U}, {2U, 2U}, {1U, 5U}, {3U, 2U}, {4U, 4U}, {6U, 5U}, {3U, 7U}}) {
    for (const bool two_way : {true, false}) {
      if (!two_way && (columns == 1 || rows == 1)) continue;
      for (const std::uint32_t bays : {0U, 1U, 3U, 2 * (columns + rows)})
        all.push_back(grid({.columns = columns, .rows = rows, .bays = bays, .two_way = two_way, .seed = ++seed}));
    }
  }
  for (const VehicleShape vehicle : {VehicleShape{0.20, 0.12}, VehicleShape{0.8, 1.2}, VehicleShape{3.0, 1.2}}) {
    const double room_m = std::ceil(100.0 * node_room_m(vehicle)) / 100.0;
    for (const double pitch_m : {room_m, 2.0 * room_m, 5.3 * room_m}) {
      all.push_back(
          grid({.columns = 3, .rows = 3, .pitch_m = pitch_m, .bays = 4, .two_way = true, .vehicle = vehicle}));
      all.push_back(grid({.columns = 3, .rows = 3, .pitch_m = pitch_m, .bays = 4, .vehicle = vehicle}));
      all.push_back(loop({.nodes = 8, .pitch_m = 1.2 * pitch_m, .bays = 3, .vehicle = vehicle}));
    }
  }
  for (const std::uint32_t nodes : {3U, 4U, 7U, 12U})
    for (const std::uint32_t bays : {0U, 1U, nodes})
      all.push_back(loop({.nodes = nodes, .bays = bays, .seed = ++seed}));
  return all;
}

/// Floors of many sizes, with and without bays, for vehicles of several shapes.
const std::vector<TrafficZone>& floors() {
  static const std::vector<TrafficZone> all = make_floors();
  return all;
}

Point2 point(const TrafficZone& zone, TrackPosition at) { return position(zone.circuit.pose_at(at)); }

std::string start_node(const TrafficZone& zone, SectionId id) {
  for (const Waypoint& waypoint : zone.waypoints)
    if (waypoint.position == TrackPosition{id, 0.0}) return waypoint.id;
  ADD_FAILURE() << zone.circuit.part(id).name << " begins without a waypoint";
  return "";
}

std::vector<std::string> successors(const TrafficZone& zone, const std::string& name) {
  std::vector<std::string> names;
  for (const SectionId after : zone.circuit.next(zone.circuit.find(name).value()))
    names.push_back(zone.circuit.part(after).name);
  return names;
}

// What holds for every floor
// -------------------------------------------------------------------------------------------------

TEST(GeneratedFloor, has_no_faults_but_that_its_tracks_are_driven_both_ways) {
  for (const TrafficZone& zone : floors()) {
    for (const Problem& problem : problems(zone)) {
      if (problem.code == "zone.single_track" || problem.code == "zone.station") continue;
      ADD_FAILURE() << zone.circuit.size() << " sections: " << to_string(problem, zone);
    }
  }
}

TEST(GeneratedFloor, leads_from_every_section_to_every_other_one) {
  for (const TrafficZone& zone : floors()) {
    const Router router{zone};
    // From one to all, and from all to one.
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      EXPECT_TRUE(router.plan({0, 0.0}, {id, 0.0})) << zone.circuit.part(id).name;
      EXPECT_TRUE(router.plan({id, 0.0}, {0, 0.0})) << zone.circuit.part(id).name;
    }
  }
}

TEST(GeneratedFloor, has_at_least_two_stations_unless_it_has_one_bay_and_each_can_be_entered_and_left) {
  for (const TrafficZone& zone : floors()) {
    const Router router{zone};
    EXPECT_FALSE(zone.stations.empty());
    if (zone.stations.size() == 1) {
      EXPECT_EQ(zone.stations[0].name, "bay1");
    }
    for (const Station& station : zone.stations) {
      EXPECT_TRUE(router.plan(zone.starts.front(), station.position)) << station.name;
      EXPECT_TRUE(router.plan(station.position, zone.starts.front())) << station.name;
      EXPECT_EQ(station.position.s_m, 0.0) << "at a node, whose id it has";
    }
  }
}

TEST(GeneratedFloor, has_one_waypoint_id_at_each_point_where_sections_begin) {
  for (const TrafficZone& zone : floors()) {
    std::map<std::string, Point2> nodes;
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      const Point2 here = position(zone.circuit.section(id).start());
      const auto [known, fresh] = nodes.emplace(start_node(zone, id), here);
      EXPECT_LT(distance(known->second, here), 1e-5) << known->first;
    }
    // Different nodes are so far apart that vehicles turn at both at once.
    for (auto a = nodes.begin(); a != nodes.end(); ++a)
      for (auto b = std::next(a); b != nodes.end(); ++b)
        EXPECT_GE(distance(a->second, b->second), node_room_m(zone.vehicle) - 1e-5) << a->first << ' ' << b->first;
  }
}

TEST(GeneratedFloor, permits_every_turn_at_a_node_and_turning_back_as_the_last_choice) {
  for (const TrafficZone& zone : floors()) {
    const auto other = opposites(zone);
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      std::vector<SectionId> leaving;
      for (SectionId after = 0; after < zone.circuit.size(); ++after)
        if (distance(zone.circuit.section(id).end(), zone.circuit.section(after).start()) < 1e-3)
          leaving.push_back(after);
      const auto next = zone.circuit.next(id);
      EXPECT_THAT(next, ::testing::UnorderedElementsAreArray(leaving)) << zone.circuit.part(id).name;
      if (other[id] != no_section) {
        EXPECT_EQ(next.back(), other[id]) << zone.circuit.part(id).name;
      }
      // The straightest is the default.
      for (const SectionId after : next) {
        if (after == other[id]) continue;
        EXPECT_LE(std::fabs(zone.circuit.turn_at(id, next.front())), std::fabs(zone.circuit.turn_at(id, after)) + 1e-5);
      }
    }
  }
}

TEST(GeneratedFloor, starts_vehicles_at_different_nodes_where_none_touch_and_none_is_in_a_bay) {
  for (const TrafficZone& zone : floors()) {
    ASSERT_FALSE(zone.starts.empty());
    EXPECT_LE(zone.starts.size(), 24U);
    EXPECT_EQ(zone.start_positions(zone.starts.size()), zone.starts) << zone.circuit.size();
    for (std::size_t i = 0; i < zone.starts.size(); ++i) {
      EXPECT_THAT(start_node(zone, zone.starts[i].section), ::testing::Not(HasSubstr("bay")));
      for (std::size_t k = 0; k < i; ++k)
        EXPECT_GE(distance(point(zone, zone.starts[i]), point(zone, zone.starts[k])), node_room_m(zone.vehicle) - 1e-5);
    }
  }
}

TEST(GeneratedFloor, can_be_written_as_lif_and_read_back) {
  for (const TrafficZone& zone : floors()) {
    std::vector<Diagnostic> lost;
    const auto written = circuit_factory_for("lif").value()->written(zone, lost);
    ASSERT_TRUE(written) << to_string(written.error());
    const auto rtm = Rtm::initialise(*written);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    const TrafficZone& again = rtm->zone();
    ASSERT_EQ(again.circuit.size(), zone.circuit.size());
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      const std::string& name = zone.circuit.part(id).name;
      EXPECT_THAT(successors(again, name), ::testing::UnorderedElementsAreArray(successors(zone, name))) << name;
      EXPECT_EQ(start_node(again, again.circuit.find(name).value()), start_node(zone, id));
    }
    ASSERT_EQ(again.stations.size(), zone.stations.size());
    for (std::size_t i = 0; i < zone.stations.size(); ++i)
      EXPECT_LT(distance(point(again, again.stations[i].position), point(zone, zone.stations[i].position)), 1e-3);
    EXPECT_EQ(again.starts.size(), zone.starts.size());
    for (const Problem& problem : problems(again))
      EXPECT_NE(problem.severity, Problem::Severity::error) << to_string(problem, again);
  }
}

// Grids
// ----------------------------------------------------------------------------------------------------------------------

TEST(GeneratedGrid, has_two_coinciding_sections_for_each_track_if_two_way) {
  const TrafficZone zone = grid({.columns = 6, .rows = 5, .bays = 8, .two_way = true});
  EXPECT_EQ(zone.circuit.size(), 2U * (5 * 5 + 6 * 4 + 8));
  const auto other = opposites(zone);
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    ASSERT_NE(other[id], no_section) << zone.circuit.part(id).name;
    const Section& here = zone.circuit.section(id);
    const Section& back = zone.circuit.section(other[id]);
    for (const double ratio : {0.0, 0.3, 1.0}) {
      const Pose2 X_MB = here.pose_at(ratio * here.length_m());
      const Pose2 opposite = turned_round(back.pose_at((1.0 - ratio) * back.length_m()));
      EXPECT_LT(distance(X_MB, opposite), 1e-5);
      EXPECT_NEAR(wrap_angle(X_MB.heading_rad - opposite.heading_rad), 0.0, 1e-6);
    }
  }
}

TEST(GeneratedGrid, is_named_as_the_cells_of_a_spreadsheet_from_the_south_west) {
  const TrafficZone zone = grid({.columns = 28, .rows = 2, .pitch_m = 2.5, .two_way = true});
  const auto at = [&](const std::string& name) {
    return position(zone.circuit.section(zone.circuit.find(name).value()).start());
  };
  EXPECT_LT(distance(at("A1-B1"), {0.0, 0.0}), 1e-6);
  EXPECT_LT(distance(at("B1-B2"), {2.5, 0.0}), 1e-6);
  EXPECT_LT(distance(at("Z2-AA2"), {25 * 2.5, 2.5}), 1e-6);
  EXPECT_LT(distance(at("AB2-AB1"), {27 * 2.5, 2.5}), 1e-6);
}

TEST(GeneratedGrid, that_is_one_way_has_alternating_rows_and_columns_and_a_circuit_at_its_border) {
  const TrafficZone zone = grid({.columns = 5, .rows = 3});
  EXPECT_EQ(zone.circuit.size(), 4U * 3 + 5 * 2);
  for (const SectionId other : opposites(zone)) EXPECT_EQ(other, no_section);
  for (const char* name : {"A1-B1", "E1-E2", "E3-D3", "A3-A2", "C2-B2", "B1-B2", "C3-C2", "D2-D3"})
    EXPECT_TRUE(zone.circuit.find(name)) << name;
}

TEST(GeneratedGrid, has_bays_one_vehicle_deep_outside_its_border_driven_both_ways) {
  for (const bool two_way : {true, false}) {
    const TrafficZone zone = grid({.columns = 4, .rows = 3, .bays = 14, .two_way = two_way});
    ASSERT_THAT(zone.stations, SizeIs(14));
    std::set<std::pair<int, int>> positions;
    for (const Station& station : zone.stations) {
      const Section& out = zone.circuit.section(station.position.section);
      // Two vehicles turn on the spot at its two ends, at once: the length of a diagonal and the clearance, in whole
      // centimetres.
      EXPECT_NEAR(out.length_m(), 1.55, 1e-6) << station.name;
      const Point2 end = position(out.start());
      EXPECT_TRUE(end.x_m < -1.0 || end.x_m > 10.0 || end.y_m < -1.0 || end.y_m > 7.0) << station.name;
      positions.emplace(static_cast<int>(100.0 * end.x_m), static_cast<int>(100.0 * end.y_m));
    }
    EXPECT_THAT(positions, SizeIs(14)) << "every side of every node at the border has one";
  }
}

TEST(GeneratedGrid, spreads_its_bays_evenly_and_begins_where_the_seed_determines) {
  std::set<std::string> first;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TrafficZone zone = grid({.columns = 5, .rows = 5, .bays = 4, .two_way = true, .seed = seed});
    std::set<std::string> sides;
    for (const Station& station : zone.stations) {
      const Pose2& out = zone.circuit.section(station.position.section).start();
      sides.insert(std::to_string(std::lround(out.heading_rad / (0.5 * pi))));
    }
    EXPECT_THAT(sides, SizeIs(4)) << "a bay on each side, seed " << seed;
    first.insert(zone.circuit.part(zone.stations.front().position.section).name);
  }
  EXPECT_GT(first.size(), 8U);
}

TEST(GeneratedGrid, without_bays_has_stations_at_every_second_node_of_its_border) {
  const TrafficZone zone = grid({.columns = 4, .rows = 3, .two_way = true});
  std::vector<std::string> nodes;
  for (const Station& station : zone.stations) nodes.push_back(start_node(zone, station.position.section));
  EXPECT_THAT(nodes, ElementsAre("A1", "C1", "D2", "C3", "A3"));
  nodes.clear();
  const TrafficZone corridor = grid({.columns = 5, .rows = 1, .two_way = true});
  for (const Station& station : corridor.stations) nodes.push_back(start_node(corridor, station.position.section));
  EXPECT_THAT(nodes, ElementsAre("A1", "E1")) << "one between them would part the corridor";
}

TEST(GeneratedGrid, has_nodes_between_those_of_a_long_pitch_where_vehicles_wait_and_turn_back) {
  // Every two lengths of 1.5422 m, at least: a diagonal of 1.4422 m and the clearance.
  for (const auto& [pitch_m, parts] : {std::pair{3.0, 1U}, {6.16, 1U}, {6.17, 2U}, {10.0, 3U}}) {
    const TrafficZone zone = grid({.columns = 2, .rows = 1, .pitch_m = pitch_m, .two_way = true});
    EXPECT_EQ(zone.circuit.size(), 2 * parts) << pitch_m;
  }
  const TrafficZone zone = grid({.columns = 2, .rows = 2, .pitch_m = 10.0, .two_way = true});
  EXPECT_THAT(successors(zone, "A1-A1.B1.1"), ElementsAre("A1.B1.1-A1.B1.2", "A1.B1.1-A1"));
  EXPECT_NEAR(zone.circuit.section(zone.circuit.find("A1.B1.1-A1.B1.2").value()).length_m(), 10.0 / 3.0, 1e-5);
}

TEST(GeneratedGrid, has_as_many_starts_as_requested_and_at_most_its_nodes) {
  EXPECT_THAT(grid({.columns = 6, .rows = 5, .two_way = true}).starts, SizeIs(24));
  EXPECT_THAT(grid({.columns = 6, .rows = 5, .two_way = true, .starts = 7}).starts, SizeIs(7));
  EXPECT_THAT(grid({.columns = 6, .rows = 5, .two_way = true, .starts = 0}).starts, SizeIs(0));
  EXPECT_GE(grid({.columns = 3, .rows = 3, .two_way = true}).starts.size(), 8U);
}

TEST(GeneratedGrid, is_the_same_for_the_same_options) {
  const GridOptions options{.bays = 5, .two_way = true, .seed = 5};
  EXPECT_EQ(*generate_grid(options), *generate_grid(options));
  EXPECT_NE(*generate_grid(options), *generate_grid({.bays = 5, .two_way = true, .seed = 6}));
}

TEST(GeneratedGrid, of_impossible_options_is_refused_with_the_reason) {
  const auto message = [](const GridOptions& options) {
    const auto text = generate_grid(options);
    if (!text) {
      EXPECT_EQ(text.error().code, "generate.options");
    }
    return text ? std::string("made") : text.error().message;
  };
  for (const std::uint32_t size : {0U, 1001U}) {
    EXPECT_THAT(message({.columns = size, .two_way = true}), HasSubstr("1 to 1000 columns"));
    EXPECT_THAT(message({.rows = size, .two_way = true}), HasSubstr("1 to 1000 rows"));
  }
  EXPECT_THAT(message({.columns = 1, .rows = 1, .two_way = true}), HasSubstr("at least two nodes"));
  EXPECT_THAT(message({.columns = 5, .rows = 1}), HasSubstr("expected two-way tracks"));
  EXPECT_THAT(message({.columns = 4, .rows = 3, .bays = 15}), HasSubstr("at most 14 bays"));
  EXPECT_THAT(message({.columns = 1000, .rows = 1000, .two_way = true}), HasSubstr("3996000 sections"));
  for (const double pitch_m : {-1.0, 0.0, 1.54, 1000.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(message({.pitch_m = pitch_m}), HasSubstr("a pitch of 1.55 m to 1000 m")) << pitch_m;
  EXPECT_THAT(message({.vehicle = {6.0, 1.0}}), HasSubstr("0.05 to 5 m"));
  EXPECT_THAT(message({.name = "a\"b"}), HasSubstr("quotes"));
}

// Loops
// ----------------------------------------------------------------------------------------------------------------------

TEST(GeneratedLoop, has_nodes_on_a_circle_joined_by_arcs_driven_both_ways) {
  const TrafficZone zone = loop({.nodes = 12, .bays = 6});
  EXPECT_EQ(zone.circuit.size(), 2U * (12 + 6));
  const double radius_m = 12 * 3.0 / (2.0 * pi);
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    EXPECT_NE(opposites(zone)[id], no_section);
    const Section& section = zone.circuit.section(id);
    if (section.kind() == SectionKind::straight) continue;
    EXPECT_NEAR(section.length_m(), 3.0, 1e-5);
    EXPECT_NEAR(norm(section.start().x_m, section.start().y_m), radius_m, 1e-5);
    EXPECT_NEAR(std::fabs(section.curvature_at(0.0)), 1.0 / radius_m, 1e-6);
  }
  EXPECT_THAT(successors(zone, "L1-L2"), Contains("L2-L3"));
  EXPECT_EQ(zone.circuit.turn_at(zone.circuit.find("L1-L2").value(), zone.circuit.find("L2-L3").value()), 0.0)
      << "vehicles pass without a stop";
}

TEST(GeneratedLoop, has_bays_at_different_nodes_outside_it) {
  const TrafficZone zone = loop({.nodes = 12, .bays = 6});
  ASSERT_THAT(zone.stations, SizeIs(6));
  std::set<SectionId> nodes;
  for (const Station& station : zone.stations) {
    const Pose2& end = zone.circuit.section(station.position.section).start();
    EXPECT_NEAR(norm(end.x_m, end.y_m), 36.0 / (2.0 * pi) + 1.55, 1e-5);
    nodes.insert(zone.circuit.next(station.position.section).front());
  }
  EXPECT_THAT(nodes, SizeIs(6));
  EXPECT_THAT(zone.start_positions(8), SizeIs(8));
}

TEST(GeneratedLoop, limits_the_speed_in_a_tight_bend) {
  const TrafficZone tight = loop({.nodes = 4, .pitch_m = 2.0});
  // A radius of 8 m / 2π = 1.273 m, at 1 m/s² across.
  EXPECT_EQ(tight.circuit.part(0).speed_mps_max, 1.12);
  EXPECT_FALSE(loop({.nodes = 12}).circuit.part(0).speed_mps_max);
}

TEST(GeneratedLoop, of_impossible_options_is_refused_with_the_reason) {
  const auto message = [](const LoopOptions& options) {
    const auto text = generate_loop(options);
    return text ? std::string("made") : text.error().message;
  };
  for (const std::uint32_t nodes : {0U, 2U, 10'001U}) EXPECT_THAT(message({.nodes = nodes}), HasSubstr("3 to 10000"));
  EXPECT_THAT(message({.nodes = 5, .bays = 6}), HasSubstr("at most 5 bays"));
  EXPECT_THAT(message({.pitch_m = 1.0}), HasSubstr("a pitch of 1.55 m"));
  EXPECT_THAT(message({.nodes = 3, .pitch_m = 1.6}), HasSubstr("so small a loop"));
  EXPECT_THAT(message({.nodes = 10'000, .pitch_m = 1000.0}), HasSubstr("too many sections"));
}

}  // namespace
}  // namespace cosiva::zone
