#include "cosiva/zone/layout/traffic_zone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::SizeIs;

TrafficZone track_zone(std::vector<Crossing> crossings = {}) {
  TrafficZone zone{"track", testing::track(), {}, {}, {}, {}, {}, std::move(crossings), {}, {}};
  zone.waypoints = lay_waypoints(zone.circuit, zone.crossings);
  return zone;
}

std::string id_at(const TrafficZone& zone, std::size_t index) {
  return index < zone.waypoints.size() ? zone.waypoints[index].id : "none";
}

/// The id of the first waypoint from a position on.
std::string id_onward(const TrafficZone& zone, TrackPosition position) {
  return id_at(zone, zone.waypoint_ahead(position));
}

// Beacons
// ---------------------------------------------------------------------------------------------------------------

constexpr BeaconGrid grid{0.5, {-1.0, 2.0}, 4, 3, 100};

TEST(BeaconGrid, numbers_its_beacons_row_by_row) {
  EXPECT_EQ(grid.find(100), (Point2{-1.0, 2.0}));
  EXPECT_EQ(grid.find(103), (Point2{0.5, 2.0}));
  EXPECT_EQ(grid.find(104), (Point2{-1.0, 2.5}));
  EXPECT_EQ(grid.find(111), (Point2{0.5, 3.0}));
}

TEST(BeaconGrid, has_no_other_numbers) {
  for (const TagNumber number : {0U, 99U, 112U, ~0U}) EXPECT_EQ(grid.find(number), std::nullopt);
  EXPECT_EQ((BeaconGrid{0.5, {}, 0, 3, 100}.find(100)), std::nullopt);
}

TEST(BeaconGrid, finds_the_nearest_up_to_half_a_pitch_beyond_its_edge) {
  EXPECT_EQ(grid.nearest({-0.8, 2.2}).value().number, 100U);
  EXPECT_EQ(grid.nearest({-0.7, 2.3}).value().number, 105U);
  EXPECT_EQ(grid.nearest({0.74, 3.24}).value().number, 111U);
  EXPECT_EQ(grid.nearest({0.74, 3.24}).value().position, (Point2{0.5, 3.0}));
  EXPECT_FALSE(grid.nearest({0.76, 3.0}));
  EXPECT_FALSE(grid.nearest({0.0, 1.74}));
  EXPECT_FALSE(grid.nearest({std::numeric_limits<double>::quiet_NaN(), 2.0}));
  EXPECT_FALSE(grid.nearest({1e300, 2.0}));
}

TEST(BeaconGrid, holds_its_edge_half_a_pitch_beyond_the_outermost_beacons) {
  // From −1.25 to 0.75 m and from 1.75 to 3.25 m, ends included.
  EXPECT_EQ(grid.nearest({-1.25, 1.75}).value().number, 100U);
  EXPECT_EQ(grid.nearest({0.75, 1.75}).value().number, 103U);
  EXPECT_EQ(grid.nearest({-1.25, 3.25}).value().number, 108U);
  EXPECT_EQ(grid.nearest({0.75, 3.25}).value().number, 111U);
  EXPECT_EQ(grid.nearest({-0.75, 2.25}).value().number, 105U) << "at the centre of four: the last one";
  for (const Point2 beyond : {Point2{-1.26, 2.0}, {0.76, 2.0}, {0.0, 1.74}, {0.0, 3.26}})
    EXPECT_FALSE(grid.nearest(beyond)) << beyond.x_m << ' ' << beyond.y_m;
  EXPECT_FALSE((BeaconGrid{0.5, {}, 0, 3}.nearest({0.0, 0.0})));
  EXPECT_FALSE((BeaconGrid{0.5, {}, 3, 0}.nearest({0.0, 0.0})));
  EXPECT_TRUE((BeaconGrid{0.5, {}, 1, 1}.nearest({0.0, 0.0})));
}

// Tags and waypoints
// ------------------------------------------------------------------------------------------------------

TEST(TrafficZone, finds_tags_by_number) {
  TrafficZone zone = track_zone();
  zone.tags = {{7, {0, 1.0}}, {9, {1, 0.5}}};
  ASSERT_NE(zone.find_tag(9), nullptr);
  EXPECT_EQ(zone.find_tag(9)->position, (TrackPosition{1, 0.5}));
  EXPECT_EQ(zone.find_tag(8), nullptr);
}

TEST(TrafficZone, finds_waypoints_by_id_and_no_others) {
  const TrafficZone zone = track_zone();
  ASSERT_NE(zone.find_waypoint("north@0"), nullptr);
  for (const char* none : {"", "north", "north@", "north@1", "nowhere@0", "@0"})
    EXPECT_EQ(zone.find_waypoint(none), nullptr) << none;
}

TEST(TrafficZone, searches_ahead_and_behind_along_the_path) {
  const TrafficZone zone = track_zone();  // 2 m straights in seven parts of 286 mm
  EXPECT_EQ(id_onward(zone, {0, 0.3}), "south@571");
  EXPECT_EQ(id_at(zone, zone.waypoint_behind({0, 0.3})), "south@286");
  EXPECT_EQ(id_onward(zone, {0, 1.9}), "east@0");
  EXPECT_EQ(id_onward(zone, {0, 0.0}), "south@0");
  EXPECT_EQ(id_at(zone, zone.waypoint_behind({0, 0.0})), "south@0");
}

TEST(TrafficZone, is_on_a_waypoint_in_spite_of_rounding) {
  const TrafficZone zone = track_zone();
  const double s = zone.find_waypoint("south@571")->position.s_m;
  EXPECT_EQ(id_onward(zone, {0, s + 1e-12}), "south@571");
  EXPECT_EQ(id_at(zone, zone.waypoint_behind({0, s - 1e-12})), "south@571");
}

TEST(TrafficZone, next_waypoint_follows_the_loop_and_comes_back) {
  const TrafficZone zone = track_zone();
  std::size_t at = 0;
  for (std::size_t i = 0; i < zone.waypoints.size(); ++i) at = zone.next_waypoint(at);
  EXPECT_EQ(at, 0U);
  EXPECT_EQ(id_at(zone, zone.next_waypoint(zone.waypoints.size() - 1)), "south@0");
}

TEST(TrafficZone, without_waypoints_ahead_reports_none) {
  TrafficZone zone{
      "line", testing::circuit({testing::part("a", testing::section({}, 1.0))}), {}, {}, {}, {}, {}, {}, {}, {}};
  EXPECT_EQ(zone.waypoint_ahead({0, 0.5}), 0U);
  zone.waypoints = {{"a@500", {0, 0.5}}};
  EXPECT_EQ(zone.waypoint_ahead({0, 0.6}), 1U);
  EXPECT_EQ(zone.waypoint_behind({0, 0.4}), 1U);
  EXPECT_EQ(zone.next_waypoint(0), 1U);
}

/// Straights of 1 m in a row without waypoints.
TrafficZone row_zone(int sections, bool closed = false) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < sections; ++i) {
    const double radius_m = 0.5;
    parts.push_back(
        testing::part("s" + std::to_string(i), closed ? testing::section({}, 2.0 * pi * radius_m, 1.0 / radius_m)
                                                      : testing::section({1.0 * i, 0.0, 0.0}, 1.0)));
    if (i + 1 < sections)
      parts.back().next = {static_cast<SectionId>(i + 1)};
    else if (closed)
      parts.back().next = {0};
  }
  return {"row", testing::circuit(std::move(parts)), {}, {}, {}, {}, {}, {}, {}, {}};
}

TEST(TrafficZone, searches_over_as_many_sections_as_there_are) {
  TrafficZone line = row_zone(4);
  line.waypoints = {{"first", {0, 0.5}}, {"last", {3, 0.5}}};
  EXPECT_EQ(id_onward(line, {0, 0.6}), "last");
  EXPECT_EQ(id_at(line, line.waypoint_behind({3, 0.4})), "first");
  EXPECT_EQ(id_at(line, line.next_waypoint(0)), "last");
  EXPECT_EQ(id_onward(line, {3, 0.6}), "none");
  EXPECT_EQ(id_at(line, line.waypoint_behind({0, 0.4})), "none");
  // Round a loop, back to the only one.
  TrafficZone loop = row_zone(3, true);
  loop.waypoints = {{"only", {1, 0.5}}};
  EXPECT_EQ(id_onward(loop, {1, 0.6}), "only");
  EXPECT_EQ(id_at(loop, loop.waypoint_behind({1, 0.4})), "only");
  EXPECT_EQ(id_at(loop, loop.next_waypoint(0)), "only");
  EXPECT_EQ(id_onward(loop, {2, 0.0}), "only");
  loop.waypoints = {};
  EXPECT_EQ(loop.waypoint_ahead({1, 0.6}), 0U);
  EXPECT_EQ(loop.waypoint_behind({1, 0.6}), 0U);
}

TEST(TrafficZone, finds_stations_loops_and_priorities_by_name) {
  TrafficZone zone = track_zone();
  zone.stations = {{"dock", {0, 1.0}}, {"plug", {1, 0.5}, StationKind::charger}};
  zone.loops = {{"inner", {0}}, {"outer", {1, 2}}};
  zone.priorities = {{"A/1", 3}, {"B/2", 7}};
  ASSERT_NE(zone.find_station("plug"), nullptr);
  EXPECT_EQ(zone.find_station("plug")->position.section, 1U);
  EXPECT_EQ(zone.find_station("none"), nullptr);
  ASSERT_NE(zone.find_loop("outer"), nullptr);
  EXPECT_EQ(zone.find_loop("outer")->sections.size(), 2U);
  EXPECT_EQ(zone.find_loop(""), nullptr);
  EXPECT_EQ(zone.priority_of("A/1"), 3);
  EXPECT_EQ(zone.priority_of("B/2"), 7);
  for (const char* none : {"", "A/0", "A/2", "C/1"}) EXPECT_EQ(zone.priority_of(none), 0) << none;
  EXPECT_EQ(to_string(Diagnostic::Kind::mended), "mended");
  EXPECT_EQ(to_string(Diagnostic::Kind::lost), "lost");
  EXPECT_EQ(to_string(Diagnostic::Kind::notice), "notice");
}

TEST(TrafficZone, has_spans_that_hold_their_ends) {
  const TrafficZone zone = track_zone({{"X1", {}, {{0, 0.5, 1.0}}}});
  EXPECT_EQ(zone.crossing_at({0, 0.4999}), nullptr);
  EXPECT_NE(zone.crossing_at({0, 0.5}), nullptr);
  EXPECT_NE(zone.crossing_at({0, 1.0}), nullptr);
  EXPECT_EQ(zone.crossing_at({0, 1.0001}), nullptr);
}

// Where vehicles stop
// -----------------------------------------------------------------------------------------------------

TEST(TrafficZone, lets_no_vehicle_stop_in_a_crossing_or_between_two_that_are_too_close) {
  const TrafficZone zone = testing::lacet4();
  const SectionId east = zone.circuit.find("east").value();
  EXPECT_TRUE(zone.may_stop({east, 0.2}));
  EXPECT_FALSE(zone.may_stop({east, 0.6}));
  EXPECT_FALSE(zone.may_stop({east, 0.75}));
  EXPECT_FALSE(zone.may_stop({east, 1.1}));
  EXPECT_TRUE(zone.may_stop({east, 1.2}));

  // 0.2 m free between two spans: outside both, but too short for stopping.
  const TrafficZone narrow = track_zone({{"X1", {}, {{0, 0.5, 0.8}}}, {"X2", {}, {{0, 1.0, 1.2}}}});
  EXPECT_EQ(narrow.crossing_at({0, 0.9}), nullptr);
  EXPECT_FALSE(narrow.may_stop({0, 0.9}));
  EXPECT_TRUE(narrow.may_stop({0, 1.3}));
}

TEST(TrafficZone, lets_vehicles_stop_from_the_waypoint_behind_a_crossing_on) {
  TrafficZone zone = row_zone(3);
  zone.crossings = {{"X1", {}, {{0, 0.2, 0.4}}}, {"X2", {}, {{2, 0.6, 0.8}}}};
  zone.waypoints = {{"a", {0, 0.5}}, {"b", {2, 0.7}}};
  EXPECT_TRUE(zone.may_stop({0, 0.1})) << "nothing is known to be before it";
  EXPECT_FALSE(zone.may_stop({0, 0.2}));
  EXPECT_FALSE(zone.may_stop({0, 0.4}));
  EXPECT_FALSE(zone.may_stop({0, 0.49}));
  EXPECT_TRUE(zone.may_stop({0, 0.5}));
  EXPECT_TRUE(zone.may_stop({0, 0.5 - 1e-12})) << "rounding";
  EXPECT_TRUE(zone.may_stop({1, 0.5})) << "no section in between has a crossing";
  EXPECT_TRUE(zone.may_stop({2, 0.5}));
  EXPECT_FALSE(zone.may_stop({2, 0.7})) << "a waypoint inside a crossing is a destination only";
  EXPECT_FALSE(zone.may_stop({2, 0.9}));
  // Round a loop with a crossing and no waypoint there is no position.
  TrafficZone loop = row_zone(3, true);
  EXPECT_TRUE(loop.may_stop({1, 0.5}));
  loop.crossings = {{"X1", {}, {{1, 0.6, 0.8}}}};
  for (SectionId id = 0; id < 3; ++id) EXPECT_FALSE(loop.may_stop({id, 0.5})) << id;
}

TEST(TrafficZone, packs_vehicles_where_spreading_them_wastes_room) {
  // 1 m, of which the last 5 cm are not tried; a vehicle and its gap take 0.29 m.
  TrafficZone zone = row_zone(1);
  zone.vehicle.length_m = 0.19;
  const auto at = [&](std::size_t count) {
    std::vector<double> positions_m;
    for (const TrackPosition& position : zone.start_positions(count)) positions_m.push_back(position.s_m);
    return positions_m;
  };
  using ::testing::DoubleNear;
  using ::testing::ElementsAre;
  EXPECT_THAT(at(1), ElementsAre(0.0));
  EXPECT_THAT(at(2), ElementsAre(0.0, DoubleNear(0.95, 1e-9)));
  EXPECT_THAT(
      at(3), ElementsAre(0.0, DoubleNear(0.95, 1e-9), ::testing::AnyOf(DoubleNear(0.45, 1e-9), DoubleNear(0.5, 1e-9))));
  // One behind the other, every 0.30 m.
  EXPECT_THAT(at(4), ElementsAre(0.0, DoubleNear(0.3, 1e-9), DoubleNear(0.6, 1e-9), DoubleNear(0.9, 1e-9)));
  EXPECT_EQ(at(5).size(), 4U);
}

TEST(TrafficZone, puts_vehicles_side_by_side_where_their_diagonals_have_room) {
  // Half a diagonal each: 0.2332 m for 0.20 by 0.12 m.
  const auto both = [](double apart_m) {
    const auto one = testing::section({}, 0.04);
    TrafficZone zone{
        "lanes",
        testing::circuit({testing::part("a", one), testing::part("b", testing::section({0.0, apart_m, 0.0}, 0.04))}),
        {},
        {},
        {},
        {},
        {},
        {},
        {},
        {}};
    return zone.start_positions(2).size();
  };
  EXPECT_EQ(both(0.234), 2U);
  EXPECT_EQ(both(0.232), 1U);
  // On sections that follow each other the whole room is needed.
  TrafficZone line = row_zone(2);
  line.starts = {{0, 0.9}, {1, 0.15}, {1, 0.21}};
  EXPECT_THAT(line.start_positions(2), ::testing::ElementsAre(TrackPosition{0, 0.9}, TrackPosition{1, 0.21}));
}

TEST(TrafficZone, begins_in_a_crossing_only_within_two_centimetres_behind_a_waypoint) {
  TrafficZone zone =
      track_zone({{"X1", {}, {{0, 0.0, 2.0}, {1, 0.0, 1.7}}}, {"X2", {}, {{2, 0.0, 2.0}, {3, 0.0, 1.7}}}});
  zone.waypoints = {{"A", {0, 0.5}}};
  const auto first = [&](TrackPosition start) {
    zone.starts = {start};
    const auto positions = zone.start_positions(1);
    return positions.empty() ? TrackPosition{} : positions.front();
  };
  const TrackPosition waypoint{0, 0.5};
  EXPECT_EQ(first({0, 0.5}), waypoint);
  EXPECT_EQ(first({0, 0.519}), (TrackPosition{0, 0.519}));
  EXPECT_EQ(first({0, 0.481}), (TrackPosition{0, 0.481}));
  EXPECT_EQ(first({0, 0.479}), waypoint) << "refused: behind the waypoint, which is the next one around the loop";
  EXPECT_EQ(first({0, 0.521}), waypoint) << "refused; the waypoint serves";
  EXPECT_EQ(first({1, 0.01}), waypoint) << "on another section";
}

void expect_room(const TrafficZone& zone, const std::vector<TrackPosition>& positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    EXPECT_TRUE(zone.may_stop(positions[i]));
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(distance(zone.circuit.pose_at(positions[i]), zone.circuit.pose_at(positions[j])), 0.2);
      EXPECT_FALSE(zone.circuit.distance_ahead(positions[i], positions[j], 0.29));
      EXPECT_FALSE(zone.circuit.distance_ahead(positions[j], positions[i], 0.29));
    }
  }
}

TEST(TrafficZone, starts_vehicles_at_its_starts_first_and_then_apart) {
  const TrafficZone zone = testing::lacet4();
  for (const std::size_t count : {0U, 1U, 4U, 12U, 20U}) {
    const auto positions = zone.start_positions(count);
    ASSERT_THAT(positions, SizeIs(count));
    for (std::size_t i = 0; i < std::min<std::size_t>(count, 4); ++i) EXPECT_EQ(positions[i], zone.starts[i]);
    expect_room(zone, positions);
  }
}

TEST(TrafficZone, spreads_vehicles_evenly_when_no_start_is_given) {
  const TrafficZone zone = track_zone();
  const auto positions = zone.start_positions(2);
  ASSERT_THAT(positions, SizeIs(2));
  // The track is 3 m by 1 m: two vehicles as far apart as possible.
  EXPECT_GT(distance(zone.circuit.pose_at(positions[0]), zone.circuit.pose_at(positions[1])), 2.0);
}

TEST(TrafficZone, starts_fewer_vehicles_than_requested_when_it_is_full) {
  const TrafficZone zone = track_zone();  // 7.14 m, 0.3 m for each
  const auto positions = zone.start_positions(1000);
  EXPECT_GE(positions.size(), 16U);
  EXPECT_LE(positions.size(), 23U);
  expect_room(zone, positions);
}

TEST(TrafficZone, skips_starts_where_vehicles_would_overlap) {
  TrafficZone zone = track_zone({{"X1", {}, {{0, 0.5, 0.8}}}});
  zone.starts = {{0, 0.1}, {0, 0.2}, {0, 0.6}, {2, 1.0}};
  const auto positions = zone.start_positions(2);
  EXPECT_THAT(positions, ::testing::ElementsAre(TrackPosition{0, 0.1}, TrackPosition{2, 1.0}));
}

TEST(TrafficZone, begins_on_waypoints_inside_crossings_where_there_is_no_other_position) {
  TrafficZone zone =
      track_zone({{"X1", {}, {{0, 0.0, 2.0}, {1, 0.0, 1.7}}}, {"X2", {}, {{2, 0.0, 2.0}, {3, 0.0, 1.7}}}});
  EXPECT_THAT(zone.start_positions(3), SizeIs(0));
  WaypointRules rules;
  rules.start_ids = {"A", "B", "C", "D"};
  zone.waypoints = lay_waypoints(zone.circuit, zone.crossings, rules);
  // One vehicle in each crossing.
  EXPECT_THAT(zone.start_positions(3), ::testing::ElementsAre(TrackPosition{0, 0.0}, TrackPosition{2, 0.0}));
  zone.starts = {{3, 0.0}, {1, 0.5}};
  EXPECT_THAT(zone.start_positions(3), ::testing::ElementsAre(TrackPosition{3, 0.0}, TrackPosition{0, 0.0}));
}

TEST(TrafficZone, finds_inserted_elements_and_no_removed_ones) {
  TrafficZone zone = track_zone();
  for (const TagNumber number : {5U, 3U, 9U, 1U}) zone.tags.push_back({number, {0, 0.1 * number}});
  for (const TagNumber number : {5U, 3U, 9U, 1U}) EXPECT_EQ(zone.find_tag(number)->number, number);
  EXPECT_EQ(zone.tags.front().number, 5U);  // in the order in which they came
  EXPECT_EQ(zone.tags.erase_if([](const Tag& tag) { return tag.number == 3; }), 1U);
  EXPECT_EQ(zone.find_tag(3), nullptr);
  zone.tags.replace(0, {7, {0, 0.7}});
  EXPECT_EQ(zone.find_tag(5), nullptr);
  EXPECT_EQ(zone.find_tag(7)->position.s_m, 0.7);
  const TrafficZone copy = zone;
  zone.tags.clear();
  EXPECT_EQ(zone.find_tag(9), nullptr);
  EXPECT_NE(copy.find_tag(9), nullptr);
}

TEST(TrafficZone, names_the_first_of_several_crossings_over_a_position) {
  const TrafficZone zone = track_zone({{"X1", {}, {{0, 0.5, 1.0}, {2, 0.0, 0.1}}}, {"X2", {}, {{0, 0.2, 1.5}}}});
  EXPECT_EQ(zone.crossing_at({0, 0.1}), nullptr);
  EXPECT_EQ(zone.crossing_at({0, 0.3})->name, "X2");
  EXPECT_EQ(zone.crossing_at({0, 0.7})->name, "X1");
  EXPECT_EQ(zone.crossing_at({0, 1.2})->name, "X2");
  EXPECT_EQ(zone.crossing_at({2, 0.0})->name, "X1");
  EXPECT_EQ(zone.crossing_at({1, 0.3}), nullptr);
}

TEST(TrafficZone, tries_twenty_thousand_positions_of_a_large_zone) {
  TrafficZone zone = row_zone(1);
  zone.circuit = testing::circuit({testing::part("a", testing::section({}, 3000.0))});
  // One every 15 cm, the last one 15 cm before the end.
  const auto positions = zone.start_positions(2);
  ASSERT_THAT(positions, SizeIs(2));
  EXPECT_EQ(positions[0], (TrackPosition{0, 0.0}));
  EXPECT_NEAR(positions[1].s_m, 3000.0 - 0.15, 1e-6);
}

TEST(TrafficZone, of_positions_on_no_section_is_an_error_of_the_program) {
  const TrafficZone zone = track_zone();
  const auto size = static_cast<SectionId>(zone.circuit.size());
  constexpr const char* broken = "track_position.section < circuit.size";
  EXPECT_DEATH(static_cast<void>(zone.waypoint_ahead({size, 0.0})), broken);
  EXPECT_DEATH(static_cast<void>(zone.waypoint_behind({size, 0.0})), broken);
  EXPECT_DEATH(static_cast<void>(zone.may_stop({size, 0.0})), broken);
  EXPECT_DEATH(static_cast<void>(zone.next_waypoint(zone.waypoints.size())), "index < waypoints.size");
}

}  // namespace
}  // namespace cosiva::zone
