#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/virtual/server/right_of_way/test_straight_zone.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr zone::SectionId south = 0;
constexpr zone::SectionId east = 1;
constexpr zone::SectionId north = 2;
constexpr zone::SectionId west = 3;
constexpr double arc_m = 0.5 * pi;  ///< length of a half circle of radius 0.5 m

/// The oval with waypoints at chosen positions only.
zone::TrafficZone oval_with(const std::vector<std::pair<std::string, zone::TrackPosition>>& waypoints) {
  zone::TrafficZone zone = *zone::Rtm::initialise(oval())->shared_zone();
  zone::Waypoint waypoint = zone.waypoints.front();
  std::vector<zone::Waypoint> chosen;
  for (const auto& [id, position] : waypoints) {
    waypoint.id = id;
    waypoint.position = position;
    chosen.push_back(waypoint);
  }
  zone.waypoints = std::move(chosen);
  return zone;
}
WaypointGraph graph_of(zone::TrafficZone zone) {
  return WaypointGraph{std::make_shared<const zone::TrafficZone>(std::move(zone))};
}

/// A and B on the south side, C on the north side: 1.0 m from A to B, and two laps' ends between B, C and A.
class ThreeWaypoints : public testing::Test {
 protected:
  static constexpr WaypointIndex a = 0;
  static constexpr WaypointIndex b = 1;
  static constexpr WaypointIndex c = 2;
  WaypointGraph graph{graph_of(oval_with({{"A", {south, 0.5}}, {"B", {south, 1.5}}, {"C", {north, 1.0}}}))};
};

TEST_F(ThreeWaypoints, are_joined_by_stretches_with_lengths_sections_and_edge_names) {
  ASSERT_EQ(graph.size(), 3U);
  ASSERT_THAT(graph.stretches(a), SizeIs(1));
  EXPECT_EQ(graph.stretch(a).to, b);
  EXPECT_DOUBLE_EQ(graph.stretch(a).length_m, 1.0);
  EXPECT_THAT(graph.stretch(a).sections, IsEmpty());
  EXPECT_EQ(graph.stretch(a).edge_id, "A-B");
  EXPECT_FALSE(graph.stretch(a).crosses);
  EXPECT_EQ(graph.stretch(b).to, c);
  EXPECT_NEAR(graph.stretch(b).length_m, 0.5 + arc_m + 1.0, 1e-9);
  EXPECT_THAT(graph.stretch(b).sections, ElementsAre(east, north));
  EXPECT_EQ(graph.stretch(c).to, a);
  EXPECT_NEAR(graph.stretch(c).length_m, 1.0 + arc_m + 0.5, 1e-9);
  EXPECT_THAT(graph.stretch(c).sections, ElementsAre(west, south));
  EXPECT_NEAR(graph.point(b).x_m, 1.5, 1e-9);
  EXPECT_THAT(graph.find("B"), ElementsAre(b));
  EXPECT_THAT(graph.find("D"), IsEmpty());
}

TEST_F(ThreeWaypoints, have_a_stretch_only_along_the_sections_that_the_circuit_connects) {
  EXPECT_EQ(graph.along(b, std::vector<zone::SectionId>{east}), &graph.stretch(b));
  EXPECT_EQ(graph.along(b, std::vector<zone::SectionId>{east, north, west}), &graph.stretch(b));
  EXPECT_EQ(graph.along(b, std::vector<zone::SectionId>{west}), nullptr);
  EXPECT_EQ(graph.along(b, std::vector<zone::SectionId>{east, west}), nullptr);
}

TEST_F(ThreeWaypoints, are_found_behind_a_position) {
  const auto expect = [&](zone::TrackPosition position, WaypointIndex waypoint, double since_m,
                          const std::vector<zone::SectionId>& sections) {
    const auto behind = graph.behind(position);
    ASSERT_TRUE(behind.has_value());
    EXPECT_EQ(behind->waypoint, waypoint) << position.s_m;
    EXPECT_NEAR(behind->since_m, since_m, 1e-9) << position.s_m;
    EXPECT_EQ(behind->sections, sections) << position.s_m;
  };
  expect({south, 0.5}, a, 0.0, {});
  expect({south, 1.49}, a, 0.99, {});
  expect({south, 1.5}, b, 0.0, {});
  expect({south, 1.9}, b, 0.4, {});
  expect({east, 0.3}, b, 0.8, {east});
  expect({north, 0.2}, b, 0.5 + arc_m + 0.2, {east, north});
  expect({south, 0.499}, c, 1.0 + arc_m + 0.499, {west, south});
  expect({south, 0.5 - 1e-10}, a, 0.0, {});
}

TEST_F(ThreeWaypoints, are_found_from_a_position_along_the_remaining_sections) {
  const std::vector<zone::SectionId> remaining{east, north};
  const auto from = [&](double s_m, Sections sections) { return graph.first_ahead({south, s_m}, sections); };
  const auto at = from(0.5, remaining);
  EXPECT_EQ(at->waypoint, a);
  EXPECT_EQ(at->distance_m, 0.0);
  EXPECT_EQ(at->sections, 0U);
  const auto second = from(0.6, {});
  EXPECT_EQ(second->waypoint, b);
  EXPECT_NEAR(second->distance_m, 0.9, 1e-9);
  const auto third = from(1.6, remaining);
  EXPECT_EQ(third->waypoint, c);
  EXPECT_NEAR(third->distance_m, 0.4 + arc_m + 1.0, 1e-9);
  EXPECT_EQ(third->sections, 2U);
  EXPECT_FALSE(from(1.6, Sections{remaining}.first(1)));
}

TEST_F(ThreeWaypoints, bound_a_base_that_may_be_overshot_by_a_quarter_of_a_metre) {
  const double lap_m = 4.0 + 2.0 * arc_m;
  EXPECT_NEAR(*graph.base_left({south, 1.0}, b, 6.0), 0.5, 1e-9);
  EXPECT_EQ(graph.base_left({south, 1.0}, b, 0.4), std::nullopt) << "too far away";
  EXPECT_EQ(graph.base_left({south, 1.5}, b, 6.0), 0.0);
  EXPECT_EQ(graph.base_left({south, 1.74}, b, 6.0), 0.0);
  EXPECT_EQ(graph.base_left({south, 1.76}, b, 6.0), std::nullopt);
  EXPECT_NEAR(*graph.base_left({south, 1.76}, b, 10.0), lap_m - 0.26, 1e-9);
  EXPECT_EQ(graph.base_left({south, 1.74}, b, 10.0), 0.0) << "the vehicle has passed the end";
  EXPECT_NEAR(*graph.base_left({south, 1.74}, b, 10.0, {}, false), lap_m - 0.24, 1e-9) << "one lap is left";
  EXPECT_EQ(graph.base_left({south, 1.74}, b, 6.0, {}, false), 0.0) << "no base is that long";
  EXPECT_EQ(graph.base_left({south, 1.76}, b, 6.0, {}, false), std::nullopt);
}

TEST_F(ThreeWaypoints, determine_the_route_that_a_vehicle_reports) {
  const std::vector<std::string_view> ids{"B", "C"};
  auto through = graph.through({south, 1.0}, ids, 1);
  ASSERT_TRUE(through.has_value());
  EXPECT_THAT(through->sections, ElementsAre(south, east, north));
  EXPECT_EQ(through->end, b);
  EXPECT_EQ(through->to_end, 1U);
  through = graph.through({south, 1.0}, ids, 2);
  EXPECT_EQ(through->end, c);
  EXPECT_EQ(through->to_end, 3U);
  through = graph.through({south, 1.7}, ids, 1);
  ASSERT_TRUE(through.has_value()) << "it has passed the first node";
  EXPECT_THAT(through->sections, ElementsAre(south, east, north));
  const std::vector<std::string_view> with_unknown{"B", "elsewhere"};
  EXPECT_TRUE(graph.through({south, 1.0}, with_unknown, 1).has_value()) << "only the base has to be known";
  EXPECT_FALSE(graph.through({south, 1.0}, with_unknown, 2).has_value());
  EXPECT_FALSE(graph.through({south, 1.0}, std::vector<std::string_view>{"B", "A"}, 2).has_value())
      << "no stretch leads from B to A";
  EXPECT_FALSE(graph.through({south, 0.8}, std::vector<std::string_view>{"A"}, 1).has_value())
      << "0.3 m behind the vehicle, and nearly a lap in front of it";
  EXPECT_FALSE(graph.through({south, 1.0}, {}, 0).has_value());
}

TEST_F(ThreeWaypoints, are_replaced_only_by_a_zone_with_the_same_waypoints) {
  const zone::TrafficZone same = graph.zone();
  const auto takes = [&](const zone::TrafficZone& zone) {
    return graph.take(std::make_shared<const zone::TrafficZone>(zone));
  };
  zone::TrafficZone other = same;
  other.closed = {north};
  EXPECT_TRUE(takes(other));
  EXPECT_THAT(graph.zone().closed, ElementsAre(north));
  other = same;
  other.name = "other";
  EXPECT_FALSE(takes(other));
  other = same;
  zone::Waypoint renamed = same.waypoints[1];
  renamed.id = "D";
  other.waypoints.replace(1, renamed);
  EXPECT_FALSE(takes(other));
  other = same;
  zone::Waypoint moved = same.waypoints[1];
  moved.position.s_m += 0.001;
  other.waypoints.replace(1, moved);
  EXPECT_FALSE(takes(other));
  other = same;
  other.waypoints = std::vector<zone::Waypoint>{same.waypoints[0], same.waypoints[1]};
  EXPECT_FALSE(takes(other));
  EXPECT_THAT(graph.zone().closed, ElementsAre(north)) << "nothing has changed";
}

TEST(WaypointGraph, names_an_edge_as_its_section_where_the_format_names_edges) {
  zone::TrafficZone zone = oval_with(
      {{"A", {south, 0.0}}, {"B", {east, 0.0}}, {"C", {north, 0.0}}, {"D", {north, 2.0}}, {"E", {west, 0.7}}});
  zone.edges_are_sections = true;
  const WaypointGraph graph = graph_of(zone);
  EXPECT_EQ(graph.stretch(0).edge_id, "south");
  EXPECT_EQ(graph.stretch(1).edge_id, "east");
  EXPECT_EQ(graph.stretch(2).edge_id, "north") << "up to the end of the section";
  EXPECT_EQ(graph.stretch(3).edge_id, "D-E");
  EXPECT_EQ(graph.stretch(4).edge_id, "E-A") << "part of the section";
  zone.edges_are_sections = false;
  EXPECT_EQ(graph_of(zone).stretch(0).edge_id, "A-B");
}

/// The fork zone with a waypoint of one id at the start of either branch.
TEST(WaypointGraph, offers_all_branches_to_a_vehicle_within_five_centimetres_of_a_fork) {
  zone::TrafficZone zone = *zone::Rtm::initialise(fork())->shared_zone();
  const zone::SectionId straight = *zone.circuit.find("south");
  const zone::SectionId bypass = *zone.circuit.find("bypass1");
  const zone::SectionId other_side = *zone.circuit.find("north");
  std::vector<zone::Waypoint> waypoints = zone.waypoints;
  std::erase_if(waypoints, [&](const zone::Waypoint& waypoint) {
    return waypoint.position.s_m == 0.0 || waypoint.position.section == other_side;
  });
  zone::Waypoint at_fork = waypoints.front();
  at_fork.id = "fork";
  for (const zone::SectionId section : {straight, bypass, other_side}) {
    at_fork.position = {section, 0.0};
    waypoints.push_back(at_fork);
  }
  std::ranges::sort(waypoints, {}, [](const zone::Waypoint& waypoint) {
    return std::pair{waypoint.position.section, waypoint.position.s_m};
  });
  zone.waypoints = std::move(waypoints);
  const WaypointGraph graph = graph_of(zone);
  EXPECT_THAT(graph.starts({straight, 0.0499}),
              ElementsAre(zone::TrackPosition{straight, 0.0499}, zone::TrackPosition{bypass, 0.0}));
  EXPECT_THAT(graph.starts({bypass, 0.0}),
              ElementsAre(zone::TrackPosition{bypass, 0.0}, zone::TrackPosition{straight, 0.0}));
  EXPECT_THAT(graph.starts({straight, 0.0501}), SizeIs(1));
  EXPECT_THAT(graph.starts({other_side, 0.0}), SizeIs(1)) << "it is reached from another section";
  ASSERT_THAT(graph.find("fork"), SizeIs(3));
  const WaypointIndex first = graph.find("fork")[0];
  EXPECT_EQ(graph.waypoint(graph.sibling_on(first, bypass)).position, (zone::TrackPosition{bypass, 0.0}));
  EXPECT_EQ(graph.sibling_on(first, *zone.circuit.find("west")), no_waypoint);
}

TEST(WaypointGraph, keeps_a_body_at_a_fork_clear_of_the_other_branch_up_to_the_end_of_the_crossing) {
  const WaypointGraph graph{zone::Rtm::initialise(fork())->shared_zone()};
  const zone::SectionId straight = *graph.circuit().find("south");
  double end_m = 0.0;
  for (const zone::Crossing& crossing : graph.zone().crossings)
    for (const zone::CrossingSpan& span : crossing.spans)
      if (span.section == straight && span.from_m <= 0.01) end_m = std::max(end_m, span.to_m);
  ASSERT_GT(end_m, 0.1);
  EXPECT_DOUBLE_EQ(graph.parted_m(straight), end_m + 0.01);
  EXPECT_DOUBLE_EQ(graph.parted_m(*graph.circuit().find("north")), 0.1) << "half a body";
}

/// The first crossing of the clover's eastward straight.
class Span : public testing::Test {
 protected:
  Span() {
    for (CrossingIndex i = 0; i < graph.crossing_count(); ++i)
      for (const zone::CrossingSpan& span : graph.zone().crossings[i].spans)
        if (span.section == 0 && (first.section != 0 || span.from_m < first.from_m)) {
          first = span;
          crossing = i;
        }
  }
  [[nodiscard]] bool reaches(double s_m, double distance_m) const {
    std::vector<CrossingIndex> found;
    graph.crossings_on({first.section, s_m}, distance_m, found);
    return std::ranges::find(found, crossing) != found.end();
  }
  WaypointGraph graph{zone::Rtm::initialise(zone_file("lacet4.toml"))->shared_zone()};
  zone::CrossingSpan first{zone::no_section, 0.0, 0.0};
  CrossingIndex crossing{};
};

TEST_F(Span, is_reached_by_a_vehicle_that_drives_to_it) {
  EXPECT_FALSE(reaches(first.from_m - 0.3, 0.299));
  EXPECT_TRUE(reaches(first.from_m - 0.3, 0.301));
  EXPECT_FALSE(reaches(first.from_m - 0.3, 0.0));
  EXPECT_TRUE(reaches(first.from_m + 0.001, 0.1));
}

TEST_F(Span, contains_a_stopped_vehicle_from_two_centimetres_behind_its_start_to_one_behind_its_end) {
  EXPECT_FALSE(reaches(first.from_m + 0.019, 0.0)) << "it has stopped late at its stop line";
  EXPECT_TRUE(reaches(first.from_m + 0.021, 0.0));
  EXPECT_TRUE(reaches(first.to_m + 0.009, 0.0));
  EXPECT_FALSE(reaches(first.to_m + 0.011, 0.0));
  EXPECT_TRUE(reaches(first.to_m + 0.009, 0.1));
  EXPECT_FALSE(reaches(first.to_m + 0.011, 0.01));
}

TEST_F(Span, ends_a_centimetre_behind_its_end) {
  const zone::TrackPosition before{first.section, first.from_m - 0.2};
  const double to_exit_m = first.to_m - first.from_m + 0.2 + 0.01;
  EXPECT_NEAR(graph.distance_to_exit_m(before, crossing, 0.3), to_exit_m, 1e-9);
  EXPECT_EQ(graph.distance_to_exit_m(before, crossing, 0.199), 0.0) << "the crossing begins further away";
  std::vector<CrossingIndex> found;
  graph.crossings_on(before, 6.0, found);
  EXPECT_THAT(found, Contains(crossing));
  const auto count = found.size();
  graph.crossings_on(before, 6.0, found);
  EXPECT_EQ(found.size(), count) << "each crossing once";
}

TEST_F(ThreeWaypoints, begin_a_reported_route_within_the_longest_stretch_and_a_quarter_of_a_metre) {
  // The longest stretches are 1.5 m + arc_m = 3.07 m long.
  const std::vector<std::string_view> ids{"C"};
  const auto through = graph.through({south, 1.6}, ids, 1);
  ASSERT_TRUE(through.has_value());
  EXPECT_THAT(through->sections, ElementsAre(south, east, north));
  EXPECT_EQ(through->to_end, 3U);
  EXPECT_TRUE(graph.through({south, 1.3}, ids, 1).has_value()) << "3.27 m";
  EXPECT_FALSE(graph.through({south, 1.2}, ids, 1).has_value()) << "3.37 m";
}

TEST_F(ThreeWaypoints, bound_a_base_that_was_overshot_by_exactly_a_quarter_of_a_metre) {
  EXPECT_EQ(graph.base_left({south, 1.75}, b, 6.0), 0.0);
  EXPECT_EQ(graph.base_left({south, 1.75}, b, 6.0, {}, false), 0.0);
}

TEST(WaypointGraph, limits_the_speed_of_a_stretch_to_the_slowest_of_its_sections) {
  const WaypointGraph graph = graph_of(
      straight_zone({{2.0, {1}, 0.5}, {1.0, {2}, 0.3}, {2.0, {3}, 0.2}, {1.0, {4}, 0.1}, {1.0, {0}, std::nullopt}},
                    {{"A", {0, 0.5}}, {"B", {0, 1.5}}, {"C", {2, 1.0}}, {"D", {3, 0.0}}, {"E", {4, 0.0}}}));
  EXPECT_EQ(graph.stretch(0).speed_mps_max, 0.5);
  EXPECT_EQ(graph.stretch(1).speed_mps_max, 0.2);
  EXPECT_EQ(graph.stretch(2).speed_mps_max, 0.2) << "it ends where the next section begins";
  EXPECT_EQ(graph.stretch(3).speed_mps_max, 0.1);
  EXPECT_EQ(graph.stretch(4).speed_mps_max, 0.5) << "its first section has no limit";
}

TEST(WaypointGraph, names_an_edge_as_its_nodes_where_it_is_no_whole_section) {
  const auto first_edge = [](std::vector<zone::Waypoint> waypoints) {
    zone::TrafficZone zone = straight_zone({{2.0, {1}}, {1.0, {2}}, {1.0, {0}}}, std::move(waypoints));
    zone.edges_are_sections = true;
    return graph_of(std::move(zone)).stretch(0).edge_id;
  };
  EXPECT_EQ(first_edge({{"A", {0, 0.0}}, {"B", {1, 0.0}}, {"C", {2, 0.0}}}), "s0");
  EXPECT_EQ(first_edge({{"A", {0, 0.0}}, {"C", {2, 0.0}}, {"D", {2, 0.5}}}), "A-C") << "two sections";
  EXPECT_EQ(first_edge({{"A", {0, 0.0}}, {"B", {1, 0.3}}, {"C", {2, 0.0}}}), "A-B") << "more than one section";
  EXPECT_EQ(first_edge({{"A", {0, 0.0}}, {"B", {0, 1.0}}, {"C", {2, 0.0}}}), "A-B") << "half a section";
}

TEST(WaypointGraph, takes_only_a_zone_with_the_same_crossings) {
  const auto zone_with = [](std::vector<zone::Crossing> crossings) {
    return straight_zone({{1.0, {1}}, {1.0, {0}}}, {{"A", {0, 0.0}}, {"B", {1, 0.0}}}, std::move(crossings));
  };
  WaypointGraph graph = graph_of(zone_with({{"x", {}, {{0, 0.2, 0.3}, {1, 0.4, 0.5}}}}));
  const auto takes = [&](std::vector<zone::Crossing> crossings) {
    return graph.take(std::make_shared<const zone::TrafficZone>(zone_with(std::move(crossings))));
  };
  EXPECT_TRUE(takes({{"x", {}, {{0, 0.2, 0.3}, {1, 0.4, 0.5}}}}));
  EXPECT_FALSE(takes({{"y", {}, {{0, 0.2, 0.3}, {1, 0.4, 0.5}}}}));
  EXPECT_FALSE(takes({{"x", {}, {{1, 0.2, 0.3}, {1, 0.4, 0.5}}}}));
  EXPECT_FALSE(takes({{"x", {}, {{0, 0.1, 0.3}, {1, 0.4, 0.5}}}}));
  EXPECT_FALSE(takes({{"x", {}, {{0, 0.2, 0.3}, {1, 0.4, 0.6}}}}));
  EXPECT_FALSE(takes({{"x", {}, {{0, 0.2, 0.3}}}}));
  EXPECT_FALSE(takes({}));
}

/// The sections of the only stretch from the first waypoint, 0.5 m on section 0, to the second one, 0.5 m on section 4.
/// Section 1 leads to section 4 by itself, section 2 leads there through section 3.
std::vector<zone::SectionId> sections_of_detour(double direct_m, double first_m, double second_m, double& length_m) {
  const WaypointGraph graph =
      graph_of(straight_zone({{1.0, {1, 2}}, {direct_m, {4}}, {first_m, {3}}, {second_m, {4}}, {1.0, {0}}},
                             {{"A", {0, 0.5}}, {"B", {4, 0.5}}}));
  if (graph.stretches(0).size() != 1U) return {};
  length_m = graph.stretch(0).length_m;
  return graph.stretch(0).sections;
}

TEST(WaypointGraph, joins_two_waypoints_by_the_shortest_of_several_routes) {
  double length_m = 0.0;
  EXPECT_THAT(sections_of_detour(5.0, 1.0, 1.0, length_m), ElementsAre(2, 3, 4));
  EXPECT_DOUBLE_EQ(length_m, 0.5 + 2.0 + 0.5);
  EXPECT_THAT(sections_of_detour(1.5, 1.0, 1.0, length_m), ElementsAre(1, 4));
  EXPECT_DOUBLE_EQ(length_m, 0.5 + 1.5 + 0.5);
  EXPECT_THAT(sections_of_detour(2.0, 1.0, 1.0, length_m), ElementsAre(1, 4)) << "of equal ones, the default";
}

TEST(WaypointGraph, joins_two_waypoints_by_the_default_of_two_equal_branches) {
  const auto sections_of = [](double second_m) {
    const WaypointGraph graph = graph_of(
        straight_zone({{1.0, {1, 2}}, {2.0, {3}}, {second_m, {3}}, {1.0, {0}}}, {{"A", {0, 0.5}}, {"B", {3, 0.5}}}));
    return graph.stretch(0).sections;
  };
  EXPECT_THAT(sections_of(2.0), ElementsAre(1, 3));
  EXPECT_THAT(sections_of(3.0), ElementsAre(1, 3));
  EXPECT_THAT(sections_of(1.0), ElementsAre(2, 3));
}

TEST(WaypointGraph, lists_the_stretch_along_default_successors_first) {
  // The waypoints on the sections 2 and 3 are nearer than the one on section 4, where the default leads.
  const WaypointGraph graph =
      graph_of(straight_zone({{1.0, {1, 2, 3}}, {1.0, {4}}, {1.0, {4}}, {1.0, {4}}, {1.0, {0}}},
                             {{"A", {0, 0.5}}, {"B", {2, 0.1}}, {"C", {3, 0.2}}, {"D", {4, 0.0}}}));
  ASSERT_THAT(graph.stretches(0), SizeIs(3));
  EXPECT_THAT(graph.stretches(0)[0].sections, ElementsAre(1, 4));
  EXPECT_THAT(graph.stretches(0)[1].sections, ElementsAre(2));
  EXPECT_THAT(graph.stretches(0)[2].sections, ElementsAre(3));
  EXPECT_EQ(graph.stretches(0)[2].to, 2U);
  EXPECT_DOUBLE_EQ(graph.stretches(0)[2].length_m, 0.7);
  EXPECT_EQ(graph.along(0, std::vector<zone::SectionId>{3, 4}), &graph.stretches(0)[2]);
  EXPECT_EQ(graph.along(0, std::vector<zone::SectionId>{1}), &graph.stretches(0)[0]);
}

TEST(WaypointGraph, ends_at_a_dead_end) {
  const WaypointGraph graph = graph_of(straight_zone({{1.0, {1}}, {1.0, {}}}, {{"A", {1, 0.5}}}));
  EXPECT_THAT(graph.stretches(0), IsEmpty());
  EXPECT_EQ(graph.stretch(0).to, no_waypoint);
  EXPECT_EQ(graph.along(0, {}), nullptr);
  EXPECT_EQ(graph.chain(0).exit, no_waypoint);
  EXPECT_FALSE(graph.behind({1, 0.25}).has_value());
  EXPECT_FALSE(graph.behind({0, 0.5}).has_value());
  EXPECT_EQ(graph.behind({1, 0.75})->since_m, 0.25);
}

/// A loop of sections of 1 m with a waypoint at the start of each; the first `crossed` sections have a crossing each.
WaypointGraph crossed_loop(std::size_t count, std::size_t crossed) {
  std::vector<Straight> straights;
  std::vector<zone::Waypoint> waypoints;
  std::vector<zone::Crossing> crossings;
  for (std::size_t i = 0; i < count; ++i) {
    const auto section = static_cast<zone::SectionId>(i);
    straights.push_back({1.0, {static_cast<zone::SectionId>((i + 1) % count)}});
    waypoints.push_back({"W" + std::to_string(i), {section, 0.0}});
    if (i < crossed) crossings.push_back({"x" + std::to_string(i), {}, {{section, 0.4, 0.6}}});
  }
  return graph_of(straight_zone(straights, std::move(waypoints), std::move(crossings)));
}

TEST(Chain, reaches_over_consecutive_stretches_with_crossings) {
  const WaypointGraph graph = crossed_loop(6, 2);
  EXPECT_EQ(graph.chain(0).exit, 2U);
  EXPECT_DOUBLE_EQ(graph.chain(0).length_m, 2.0);
  EXPECT_EQ(graph.chain(1).exit, 2U);
  EXPECT_DOUBLE_EQ(graph.chain(1).length_m, 1.0);
  EXPECT_EQ(graph.chain(2).exit, no_waypoint) << "no crossing";
  EXPECT_EQ(graph.chain(2).length_m, 0.0);
}

TEST(Chain, does_not_return_to_its_beginning) {
  const WaypointGraph graph = crossed_loop(4, 4);
  EXPECT_EQ(graph.chain(1).exit, 0U);
  EXPECT_DOUBLE_EQ(graph.chain(1).length_m, 3.0);
  const WaypointGraph lap = graph_of(
      straight_zone({{1.0, {1}}, {1.0, {0}}}, {{"A", {0, 0.0}}}, {{"x", {}, {{zone::SectionId{1}, 0.4, 0.6}}}}));
  EXPECT_EQ(lap.chain(0).exit, 0U) << "there is no other waypoint";
  EXPECT_DOUBLE_EQ(lap.chain(0).length_m, 2.0);
}

TEST(Chain, is_a_single_stretch_where_sixteen_are_crossed) {
  EXPECT_EQ(crossed_loop(20, 15).chain(0).exit, 15U);
  EXPECT_DOUBLE_EQ(crossed_loop(20, 15).chain(0).length_m, 15.0);
  EXPECT_EQ(crossed_loop(20, 16).chain(0).exit, 1U);
  EXPECT_DOUBLE_EQ(crossed_loop(20, 16).chain(0).length_m, 1.0);
}

TEST(Chain, ends_at_a_goal_in_a_crossing_but_not_where_the_course_passes_the_goal) {
  const WaypointGraph graph = crossed_loop(6, 4);
  const auto exit_with = [&](const std::vector<zone::SectionId>& remaining, WaypointIndex goal) {
    return graph.chain(0, remaining, goal).exit;
  };
  EXPECT_EQ(exit_with({1}, 1), 1U);
  EXPECT_EQ(exit_with({}, 1), 1U);
  EXPECT_EQ(exit_with({1, 2}, 2), 2U);
  EXPECT_EQ(exit_with({1, 2}, 1), 4U);
  EXPECT_EQ(exit_with({1, 2}, no_waypoint), 4U);
}

TEST(Chain, follows_the_course_at_a_fork) {
  const auto crossing_on = [](zone::SectionId section) {
    return zone::Crossing{"x" + std::to_string(section), {}, {{section, 0.4, 0.6}}};
  };
  const WaypointGraph graph =
      graph_of(straight_zone({{1.0, {1}}, {1.0, {2, 3}}, {1.0, {4}}, {1.0, {4}}, {1.0, {0}}},
                             {{"A", {0, 0.0}}, {"B", {1, 0.0}}, {"C", {2, 0.0}}, {"D", {3, 0.0}}, {"E", {4, 0.0}}},
                             {crossing_on(0), crossing_on(1), crossing_on(3)}));
  EXPECT_EQ(graph.chain(0, std::vector<zone::SectionId>{1, 3}).exit, 4U);
  EXPECT_DOUBLE_EQ(graph.chain(0, std::vector<zone::SectionId>{1, 3}).length_m, 3.0);
  EXPECT_EQ(graph.chain(0, std::vector<zone::SectionId>{1, 2}).exit, 2U);
  EXPECT_EQ(graph.chain(0).exit, 2U);
}

/// Section 0 forks into the sections 1 and 2, of 1 m and 2 m, which merge into section 3.
zone::TrafficZone forked(std::vector<zone::Waypoint> waypoints, std::vector<zone::Crossing> crossings = {}) {
  return straight_zone({{1.0, {1, 2}}, {1.0, {3}}, {2.0, {3}}, {1.0, {0}}}, std::move(waypoints), std::move(crossings));
}

TEST(WaypointGraph, searches_back_through_the_branch_that_was_traversed) {
  const WaypointGraph graph = graph_of(forked({{"A", {0, 0.5}}}));
  const auto usual = graph.behind({3, 0.25});
  ASSERT_TRUE(usual.has_value());
  EXPECT_EQ(usual->since_m, 0.25 + 1.0 + 0.5);
  EXPECT_THAT(usual->sections, ElementsAre(1, 3));
  const auto traversed = graph.behind({3, 0.25}, std::vector<zone::SectionId>{0, 2});
  ASSERT_TRUE(traversed.has_value());
  EXPECT_EQ(traversed->waypoint, 0U);
  EXPECT_EQ(traversed->since_m, 0.25 + 2.0 + 0.5);
  EXPECT_THAT(traversed->sections, ElementsAre(2, 3));
}

TEST(WaypointGraph, searches_back_over_a_whole_lap) {
  const WaypointGraph graph = graph_of(straight_zone({{1.0, {1}}, {1.0, {2}}, {1.0, {0}}}, {{"A", {0, 0.75}}}));
  const auto lap = graph.behind({0, 0.25});
  ASSERT_TRUE(lap.has_value());
  EXPECT_EQ(lap->since_m, 0.25 + 2.0 + 0.25);
  EXPECT_THAT(lap->sections, ElementsAre(1, 2, 0));
}

TEST(WaypointGraph, offers_another_branch_only_where_it_begins_at_the_same_node) {
  const auto starts = [](std::vector<zone::Waypoint> waypoints, zone::TrackPosition position) {
    return graph_of(forked(std::move(waypoints))).starts(position);
  };
  EXPECT_THAT(starts({{"F", {1, 0.0}}, {"F", {2, 0.0}}, {"M", {3, 0.0}}}, {1, 0.05}),
              ElementsAre(zone::TrackPosition{1, 0.05}, zone::TrackPosition{2, 0.0}));
  EXPECT_THAT(starts({{"F", {1, 0.0}}, {"G", {2, 0.0}}, {"M", {3, 0.0}}}, {1, 0.0}), SizeIs(1));
  EXPECT_THAT(starts({{"F", {1, 0.0}}, {"F", {2, 0.5}}, {"M", {3, 0.0}}}, {1, 0.0}), SizeIs(1));
  EXPECT_THAT(starts({{"F", {1, 0.04}}, {"F", {2, 0.0}}, {"M", {3, 0.0}}}, {1, 0.03}), SizeIs(1));
  EXPECT_THAT(starts({{"F", {2, 0.0}}, {"G", {2, 0.5}}, {"M", {3, 0.0}}}, {1, 0.0}), SizeIs(1));
}

TEST(WaypointGraph, offers_all_sections_that_begin_the_circuit_at_one_node) {
  const WaypointGraph graph =
      graph_of(straight_zone({{1.0, {2}}, {1.0, {2}}, {1.0, {}}}, {{"S", {0, 0.0}}, {"S", {1, 0.0}}, {"S", {2, 0.0}}}));
  EXPECT_THAT(graph.starts({0, 0.0}), ElementsAre(zone::TrackPosition{0, 0.0}, zone::TrackPosition{1, 0.0}));
  EXPECT_THAT(graph.starts({2, 0.0}), SizeIs(1)) << "a vehicle comes there from the other two";
}

TEST(WaypointGraph, finds_a_sibling_only_at_the_start_of_a_section) {
  const WaypointGraph graph = graph_of(forked({{"F", {1, 0.0}}, {"F", {2, 0.5}}, {"F", {3, 0.0}}}));
  EXPECT_EQ(graph.sibling_on(0, 1), 0U);
  EXPECT_EQ(graph.sibling_on(0, 2), no_waypoint);
  EXPECT_EQ(graph.sibling_on(0, 3), 2U);
}

TEST(WaypointGraph, determines_the_branch_of_a_reported_route_by_the_nodes_after_the_fork) {
  const WaypointGraph graph =
      graph_of(forked({{"A", {0, 0.5}}, {"X", {1, 0.0}}, {"X", {2, 0.0}}, {"Y", {2, 1.0}}, {"Z", {3, 0.5}}}));
  auto through = graph.through({0, 0.6}, std::vector<std::string_view>{"X", "Y"}, 2);
  ASSERT_TRUE(through.has_value());
  EXPECT_THAT(through->sections, ElementsAre(0, 2));
  EXPECT_EQ(through->end, 3U);
  EXPECT_EQ(through->to_end, 2U);
  through = graph.through({0, 0.6}, std::vector<std::string_view>{"X", "Z"}, 2);
  ASSERT_TRUE(through.has_value());
  EXPECT_THAT(through->sections, ElementsAre(0, 1, 3));
  EXPECT_EQ(through->end, 4U);
  EXPECT_EQ(through->to_end, 3U);
}

/// A loop of three sections of 1 m. Crossing 0 is on section 0, crossing 1 on section 1, crossing 2 twice on section 2.
class CrossedLoop : public testing::Test {
 protected:
  [[nodiscard]] std::vector<CrossingIndex> met(zone::TrackPosition position, double distance_m) const {
    std::vector<CrossingIndex> found;
    graph.crossings_on(position, distance_m, found);
    return found;
  }
  WaypointGraph graph{graph_of(straight_zone(
      {{1.0, {1}}, {1.0, {2}}, {1.0, {0}}}, {{"A", {0, 0.0}}},
      {{"a", {}, {{0, 0.1, 0.2}}}, {"b", {}, {{1, 0.1, 0.2}}}, {"c", {}, {{2, 0.1, 0.2}, {2, 0.5, 0.6}}}}))};
};

TEST_F(CrossedLoop, has_crossings_in_driving_order_as_far_as_the_distance_reaches) {
  EXPECT_THAT(met({0, 0.5}, 0.4), IsEmpty());
  EXPECT_THAT(met({0, 0.5}, 0.55), IsEmpty());
  EXPECT_THAT(met({0, 0.5}, 0.65), ElementsAre(1));
  EXPECT_THAT(met({0, 0.5}, 1.2), ElementsAre(1));
  EXPECT_THAT(met({0, 0.5}, 2.0), ElementsAre(1, 2));
  EXPECT_THAT(met({0, 0.5}, 2.55), ElementsAre(1, 2));
  EXPECT_THAT(met({0, 0.5}, 2.65), ElementsAre(1, 2, 0));
  EXPECT_THAT(met({0, 0.5}, 3.0), ElementsAre(1, 2, 0)) << "a whole lap";
}

TEST_F(CrossedLoop, has_a_crossing_only_where_the_distance_reaches_a_micrometre_into_it) {
  // Crossing 1 begins 0.6 m ahead.
  EXPECT_THAT(met({0, 0.5}, 0.6 + 5e-7), IsEmpty());
  EXPECT_THAT(met({0, 0.5}, 0.6 + 2e-6), ElementsAre(1));
}

TEST_F(CrossedLoop, has_exits_as_far_as_the_crossings_begin_within_the_distance) {
  const zone::TrackPosition from{0, 0.5};
  EXPECT_NEAR(graph.distance_to_exit_m(from, 1, 1.0), 0.71, 1e-12);
  EXPECT_EQ(graph.distance_to_exit_m(from, 1, 0.6), 0.0) << "its start";
  EXPECT_NEAR(graph.distance_to_exit_m(from, 1, 0.601), 0.71, 1e-12);
  EXPECT_NEAR(graph.distance_to_exit_m(from, 2, 1.8), 1.71, 1e-12) << "the first of two spans";
  EXPECT_NEAR(graph.distance_to_exit_m(from, 2, 3.0), 2.11, 1e-12);
  EXPECT_NEAR(graph.distance_to_exit_m(from, 0, 3.0), 2.71, 1e-12) << "after nearly a lap";
  EXPECT_NEAR(graph.distance_to_exit_m({0, 0.15}, 0, 0.01), 0.06, 1e-12) << "in the span";
  EXPECT_EQ(graph.distance_to_exit_m({0, 0.25}, 0, 0.5), 0.0) << "behind the span";
}

TEST(WaypointGraph, finds_the_crossings_of_the_branch_that_the_course_takes) {
  const WaypointGraph graph = graph_of(forked({{"A", {0, 0.5}}}, {{"x", {}, {{zone::SectionId{2}, 0.1, 0.2}}}}));
  const std::vector<zone::SectionId> course{2};
  std::vector<CrossingIndex> found;
  graph.crossings_on({0, 0.5}, 1.0, found);
  EXPECT_THAT(found, IsEmpty());
  graph.crossings_on({0, 0.5}, 1.0, found, course);
  EXPECT_THAT(found, ElementsAre(0));
  EXPECT_EQ(graph.distance_to_exit_m({0, 0.5}, 0, 1.0), 0.0);
  EXPECT_NEAR(graph.distance_to_exit_m({0, 0.5}, 0, 1.0, course), 0.71, 1e-12);
}

TEST(WaypointGraph, counts_a_crossing_at_the_end_of_a_section_for_a_centimetre_of_the_next) {
  const WaypointGraph graph = graph_of(forked({{"A", {0, 0.5}}}, {{"x", {}, {{zone::SectionId{2}, 1.5, 2.0}}}}));
  const auto met = [&](double s_m, double distance_m) {
    std::vector<CrossingIndex> found;
    graph.crossings_on({3, s_m}, distance_m, found);
    return found.size();
  };
  EXPECT_EQ(met(0.005, 0.0), 1U);
  EXPECT_EQ(met(0.005, 0.5), 1U);
  EXPECT_EQ(met(0.015, 0.0), 0U);
}

TEST(WaypointGraph, leaves_a_crossing_exactly_a_centimetre_behind_it) {
  const double end_m = 0.5 - 0.01;
  const WaypointGraph graph = graph_of(forked({{"A", {0, 0.5}}}, {{"x", {}, {{zone::SectionId{0}, 0.1, end_m}}}}));
  std::vector<CrossingIndex> found;
  graph.crossings_on({0, 0.5}, 0.3, found);
  EXPECT_THAT(found, IsEmpty());
  graph.crossings_on({0, 0.499}, 0.3, found);
  EXPECT_THAT(found, ElementsAre(0));
}

TEST(WaypointGraph, keeps_a_body_at_a_fork_clear_only_of_crossings_that_begin_there) {
  const auto parted_m = [](double from_m) {
    return graph_of(forked({{"A", {0, 0.5}}}, {{"x", {}, {{zone::SectionId{1}, from_m, 0.3}}}})).parted_m(1);
  };
  EXPECT_DOUBLE_EQ(parted_m(0.0), 0.31);
  EXPECT_DOUBLE_EQ(parted_m(0.01), 0.31);
  EXPECT_DOUBLE_EQ(parted_m(0.011), 0.1);
}

}  // namespace
}  // namespace cosiva::virtual_side
