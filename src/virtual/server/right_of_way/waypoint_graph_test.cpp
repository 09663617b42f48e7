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

}  // namespace
}  // namespace cosiva::virtual_side
