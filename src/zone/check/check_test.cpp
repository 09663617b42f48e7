#include "cosiva/zone/check/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::part;
using testing::section;
using ::testing::SizeIs;

TrafficZone zone_of(std::vector<Circuit::Part> parts, double gap_m = 1e-3, double kink_rad = 1e-3) {
  auto circuit = Circuit::make("z", std::move(parts), gap_m, kink_rad);
  EXPECT_TRUE(circuit) << to_string(circuit.error());
  TrafficZone zone{"z", std::move(*circuit), {}, {}, {}, {}, {}, {}, {}, {}};
  zone.profiles = {{0.15, 0.3, 0.6}, {0.30, 0.5, 0.8}, {0.50, 0.8, 1.0}};
  zone.beacons = BeaconGrid{0.05, {-50.0, -50.0}, 3000, 3000};  // no distance counts as unread
  return zone;
}

std::vector<Problem> of_code(const TrafficZone& zone, std::string_view code, const CheckLimits& limits = {}) {
  std::vector<Problem> found;
  for (const Problem& problem : problems(zone, limits))
    if (problem.code == code) found.push_back(problem);
  return found;
}

TEST(Check, has_no_findings_in_the_ready_zones) {
  for (const char* name : {"lacet4.toml", "indus8.toml"})
    for (const Problem& problem : problems(testing::zone_file(name)))
      ADD_FAILURE() << to_string(problem, testing::zone_file(name));
}

TEST(Check, finds_every_gap_and_every_kink_of_a_loosely_joined_circuit) {
  const Section a = section({}, 1.0);
  const Section b = section({1.004, 0.0, 0.0}, 1.0);
  const Section c = section({2.004, 0.0, 0.01}, 1.0);
  const TrafficZone zone = zone_of({part("a", a, {1}), part("b", b, {2}), part("c", c)}, 0.1, 0.1);
  const auto gaps = of_code(zone, "circuit.gap");
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_EQ(gaps[0].severity, Problem::Severity::error);
  EXPECT_EQ(gaps[0].position, (TrackPosition{0, 1.0}));
  EXPECT_THAT(gaps[0].text, HasSubstr("0.004 m"));
  const auto kinks = of_code(zone, "circuit.kink");
  ASSERT_THAT(kinks, SizeIs(1));
  EXPECT_EQ(kinks[0].position, (TrackPosition{1, 1.0}));
  EXPECT_THAT(kinks[0].text, HasSubstr("0.573°"));
}

TEST(Check, counts_no_turn_on_the_spot_as_a_kink) {
  Circuit::Part stem = part("a", section({}, 1.0), {1});
  stem.pivots = true;
  const TrafficZone zone = zone_of({stem, part("b", section({1.0, 0.0, pi / 2.0}, 1.0))});
  EXPECT_THAT(of_code(zone, "circuit.kink"), IsEmpty());
}

TEST(Check, distinguishes_a_bend_too_tight_for_the_vehicle_from_one_too_fast_for_its_load) {
  TrafficZone zone = zone_of({part("a", section({}, 0.1, 1.0 / 0.059))});
  EXPECT_THAT(of_code(zone, "zone.vehicle"), SizeIs(1));
  // 0.5 m/s on a radius of 0.2 m: 1.25 m/s²; √(1.0 · 0.2) = 0.447 m/s is slow enough.
  zone = zone_of({part("a", section({}, 0.1, -1.0 / 0.2))});
  EXPECT_THAT(of_code(zone, "zone.vehicle"), IsEmpty());
  const auto fast = of_code(zone, "zone.speed");
  ASSERT_THAT(fast, SizeIs(1));
  EXPECT_EQ(fast[0].severity, Problem::Severity::warning);
  EXPECT_THAT(fast[0].text, HasSubstr("1.25 m/s²"));
  EXPECT_THAT(fast[0].text, HasSubstr("0.44 m/s"));
  Circuit::Part slow = part("a", section({}, 0.1, -1.0 / 0.2));
  slow.speed_mps_max = 0.44;
  EXPECT_THAT(of_code(zone_of({slow}), "zone.speed"), IsEmpty());
}

/// A loop with a spur off it that ends, and a section onto it from outside.
TrafficZone loop_with_spur() {
  const Section south = section({}, 2.0);
  const Section east = section(south.end(), pi * 0.5, 2.0);
  const Section north = section(east.end(), 2.0);
  const Section west = section(north.end(), pi * 0.5, 2.0);
  const Section spur = section(south.end(), 1.0);
  const Section far = section(spur.end(), 1.0);
  const Section ramp = section({-1.0, 0.0, 0.0}, 1.0);
  return zone_of({part("south", south, {1, 4}), part("east", east, {2}), part("north", north, {3}),
                  part("west", west, {0}), part("spur", spur, {5}), part("far", far), part("ramp", ramp, {0})});
}

TEST(Check, reports_dead_ends_sections_into_them_and_sections_that_no_other_leads_to) {
  const TrafficZone zone = loop_with_spur();
  const auto ends = of_code(zone, "zone.dead_end");
  ASSERT_THAT(ends, SizeIs(1));
  EXPECT_EQ(ends[0].position, (TrackPosition{5, 1.0}));
  EXPECT_EQ(ends[0].at, (Point2{4.0, 0.0}));
  const auto into = of_code(zone, "zone.no_return");
  ASSERT_THAT(into, SizeIs(1));
  EXPECT_EQ(into[0].position.section, 4U);
  const auto outside = of_code(zone, "zone.no_entry");
  ASSERT_THAT(outside, SizeIs(1));
  EXPECT_EQ(outside[0].position.section, 6U);
}

TEST(Check, reports_stations_that_no_vehicle_can_reach) {
  TrafficZone zone = loop_with_spur();
  zone.stations = {{"dock", {2, 1.0}}, {"gate", {6, 0.5}}, {"end", {5, 0.5}}};
  zone.starts = {{0, 1.0}};
  const auto found = of_code(zone, "zone.unreachable");
  ASSERT_THAT(found, SizeIs(3));
  EXPECT_EQ(found[0].severity, Problem::Severity::error);
  EXPECT_THAT(found[0].text, HasSubstr("station 'gate' cannot be reached from any of the starts"));
  EXPECT_THAT(found[1].text, HasSubstr("station 'dock' cannot be reached from station 'end'"));
  EXPECT_THAT(found[2].text, HasSubstr("station 'gate' cannot be reached from station 'dock' and 1 other"));
}

TEST(Check, counts_closed_sections_as_absent) {
  TrafficZone zone = loop_with_spur();
  zone.stations = {{"dock", {2, 1.0}}};
  zone.starts = {{0, 1.0}};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), IsEmpty());
  zone.closed = {1};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), SizeIs(1));
  // A vehicle on a closed section may leave it.
  zone.closed = {0};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), IsEmpty());
}

TEST(Check, reaches_a_station_behind_on_the_same_section_only_by_going_round) {
  TrafficZone zone = zone_of({part("a", section({}, 2.0))});
  zone.stations = {{"first", {0, 0.5}}, {"second", {0, 1.5}}};
  const auto found = of_code(zone, "zone.unreachable");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("'first' cannot be reached from station 'second'"));
}

TEST(Check, reports_starts_where_no_vehicle_begins) {
  TrafficZone zone = loop_with_spur();
  zone.waypoints = {{"w", {0, 0.0}}, {"w", {4, 0.0}}};
  zone.starts = {{0, 0.5}, {0, 0.7}, {4, 0.5}};
  zone.closed = {4};
  const auto found = of_code(zone, "zone.start");
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_THAT(found[0].text, HasSubstr("start 2 is nearer than 0.30 m to one before it"));
  EXPECT_THAT(found[1].text, HasSubstr("start 3 lies on a closed section"));
}

TEST(Check, reports_a_station_in_a_crossing) {
  TrafficZone zone = loop_with_spur();
  zone.crossings = {{"X1", {2.0, 0.0}, {{1, 0.0, 0.3}, {4, 0.0, 0.3}}}};
  zone.stations = {{"dock", {1, 0.2}}};
  ASSERT_THAT(of_code(zone, "zone.station"), SizeIs(1));
  EXPECT_THAT(of_code(zone, "zone.station")[0].text, HasSubstr("crossing X1"));
}

TEST(Check, reports_the_longest_distance_without_tag_or_beacon) {
  TrafficZone zone = zone_of({part("a", section({}, 12.0))});
  zone.beacons.reset();
  zone.tags = {{1, {0, 2.0}}, {2, {0, 9.0}}};
  const auto found = of_code(zone, "zone.unread");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].position, (TrackPosition{0, 2.0}));
  EXPECT_THAT(found[0].text, HasSubstr("7.00 m"));
  zone.tags.push_back({3, {0, 5.0}});
  EXPECT_THAT(of_code(zone, "zone.unread"), IsEmpty());
  EXPECT_THAT(of_code(zone, "zone.unread", {.unread_max_m = 3.0}), SizeIs(1));
}

TEST(Check, reports_a_track_that_is_driven_both_ways) {
  const Section there = section({}, 3.0);
  const Section back = section({3.0, 0.0, pi}, 3.0);
  Circuit::Part out = part("there", there, {1});
  Circuit::Part home = part("back", back, {0});
  out.pivots = home.pivots = true;
  const auto found = of_code(zone_of({out, home}), "zone.single_track");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("'back' and 'there' are one track of 3.00 m"));
  // An arc out and a straight back have the same ends, but are two tracks.
  const Section bow = section({}, pi, 1.0);
  Circuit::Part round = part("bow", bow, {1});
  Circuit::Part chord = part("chord", section({0.0, 2.0, -pi / 2.0}, 2.0), {0});
  round.pivots = chord.pivots = true;
  EXPECT_THAT(of_code(zone_of({round, chord}), "zone.single_track"), IsEmpty());
}

TEST(Check, counts_findings_that_it_does_not_list) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 7; ++i) parts.push_back(part("s" + std::to_string(i), section({0.0, 1.0 * i, 0.0}, 1.0)));
  const auto ends = of_code(zone_of(std::move(parts)), "zone.dead_end", {.of_one_code = 3});
  ASSERT_THAT(ends, SizeIs(4));
  EXPECT_THAT(ends[3].text, HasSubstr("and 4 more"));
}

TEST(Check, lists_ten_tracks_that_are_driven_both_ways_and_counts_the_others) {
  std::vector<Circuit::Part> parts;
  for (SectionId i = 0; i < 12; ++i) {
    parts.push_back(part("there" + std::to_string(i), section({0.0, 5.0 * i, 0.0}, 3.0), {2 * i + 1}));
    parts.push_back(part("back" + std::to_string(i), section({3.0, 5.0 * i, pi}, 3.0), {2 * i}));
    parts[2 * i].pivots = parts[2 * i + 1].pivots = true;
  }
  const auto found = of_code(zone_of(std::move(parts)), "zone.single_track");
  ASSERT_THAT(found, SizeIs(11));
  EXPECT_THAT(found[9].text, HasSubstr("'back9' and 'there9'"));
  EXPECT_EQ(found[10].text, "and 2 more like those above, up to here");
}

TEST(Check, tolerates_joints_up_to_its_limits_and_turns_on_the_spot_at_any_angle) {
  const auto joined = [](double gap_m, double kink_rad, bool pivots = false) {
    auto a = part("a", section({}, 1.0), {1});
    a.pivots = pivots;
    return zone_of({a, part("b", section({1.0, gap_m, kink_rad}, 1.0))}, 1.0, 1.0);
  };
  const auto codes = [](const TrafficZone& zone, const CheckLimits& limits = {}) {
    return std::pair{of_code(zone, "circuit.gap", limits).size(), of_code(zone, "circuit.kink", limits).size()};
  };
  using Found = std::pair<std::size_t, std::size_t>;
  EXPECT_EQ(codes(joined(0.0009, 0.0009)), (Found{0, 0}));
  EXPECT_EQ(codes(joined(0.0011, 0.0011)), (Found{1, 1}));
  EXPECT_EQ(codes(joined(-0.0011, -0.0011)), (Found{1, 1}));
  EXPECT_EQ(codes(joined(0.0011, 0.5, true)), (Found{1, 0}));
  EXPECT_EQ(codes(joined(0.5, 0.5), {.gap_m = 0.5, .kink_rad = 0.5}), (Found{0, 0}));
  const auto kink = of_code(joined(0.0, 0.5), "circuit.kink");
  EXPECT_EQ(kink[0].severity, Problem::Severity::error);
  EXPECT_THAT(kink[0].text, HasSubstr("turns by 28.6479° at once from 'a' to 'b'"));
}

TEST(Check, reports_a_bend_where_it_is_sharpest_and_the_speed_that_it_allows) {
  const auto bend = [](double length_m, double start_per_m, double end_per_m, std::optional<double> limit_mps = {}) {
    auto made = Section::make({}, length_m, start_per_m, (end_per_m - start_per_m) / length_m);
    EXPECT_TRUE(made);
    auto one = part("a", std::move(*made));
    one.speed_mps_max = limit_mps;
    return zone_of({one});
  };
  // 0.5 m/s on a radius of 0.25 m: 1 m/s² exactly, which is tolerated.
  EXPECT_THAT(of_code(bend(0.5, 4.0, 4.0), "zone.speed"), IsEmpty());
  EXPECT_THAT(of_code(bend(0.5, 4.01, 4.01), "zone.speed"), SizeIs(1));
  EXPECT_THAT(of_code(bend(0.5, 4.01, 4.01, 0.49), "zone.speed"), IsEmpty());
  EXPECT_THAT(of_code(bend(0.5, 4.01, 4.01, 9.0), "zone.speed"), SizeIs(1)) << "no vehicle is faster than its profile";
  EXPECT_THAT(of_code(bend(0.5, 4.01, 4.01, 9.0), "zone.speed")[0].text, HasSubstr("at 0.50 m/s"));
  EXPECT_EQ(of_code(bend(0.5, 0.0, 5.0), "zone.speed")[0].position, (TrackPosition{0, 0.5}));
  EXPECT_EQ(of_code(bend(0.5, -5.0, 0.0), "zone.speed")[0].position, (TrackPosition{0, 0.0}));
  EXPECT_EQ(of_code(bend(0.5, 5.0, 5.0), "zone.speed")[0].position, (TrackPosition{0, 0.0}));
  // √(1/5) = 0.447 m/s, and a half of the lateral acceleration 0.316 m/s.
  EXPECT_THAT(of_code(bend(0.5, 5.0, 5.0), "zone.speed")[0].text, HasSubstr("limit it to 0.44 m/s"));
  EXPECT_THAT(of_code(bend(0.5, 5.0, 5.0), "zone.speed", {.lateral_mps2 = 0.5})[0].text,
              HasSubstr("limit it to 0.31 m/s"));
  // A body 0.12 m wide turns on the spot at a radius of 0.06 m.
  EXPECT_THAT(of_code(bend(0.1, 1.0 / 0.0601, 1.0 / 0.0601), "zone.vehicle"), IsEmpty());
  const auto tight = of_code(bend(0.1, 1.0 / 0.0599, 1.0 / 0.0599), "zone.vehicle");
  ASSERT_THAT(tight, SizeIs(1));
  EXPECT_EQ(tight[0].severity, Problem::Severity::error);
  EXPECT_THAT(tight[0].text, HasSubstr("radius of 0.0599 m, less than half the vehicle's width of 0.12 m"));
}

TEST(Check, counts_the_stations_that_do_not_lead_to_another_one) {
  // Four parallel tracks, one station each, in order of driving along the last.
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 4; ++i) parts.push_back(part("s" + std::to_string(i), section({0.0, 1.0 * i, 0.0}, 1.0)));
  TrafficZone zone = zone_of(std::move(parts));
  zone.stations = {{"a", {0, 0.5}}, {"b", {1, 0.5}}};
  auto found = of_code(zone, "zone.unreachable");
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].severity, Problem::Severity::warning);
  EXPECT_EQ(found[0].text, "station 'a' cannot be reached from station 'b'");
  EXPECT_EQ(found[1].text, "station 'b' cannot be reached from station 'a'");
  EXPECT_EQ(found[1].position, (TrackPosition{1, 0.5}));
  zone.stations.push_back({"c", {2, 0.5}});
  EXPECT_EQ(of_code(zone, "zone.unreachable")[0].text, "station 'a' cannot be reached from station 'b' and 1 other");
  zone.stations.push_back({"d", {3, 0.5}});
  found = of_code(zone, "zone.unreachable");
  ASSERT_THAT(found, SizeIs(4));
  EXPECT_EQ(found[0].text, "station 'a' cannot be reached from station 'b' and 2 others");
  EXPECT_EQ(found[3].text, "station 'd' cannot be reached from station 'a' and 2 others");
  // On one section, the same position can be reached without driving.
  zone.stations = {{"a", {0, 0.5}}, {"b", {0, 0.5}}};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), IsEmpty());
}

TEST(Check, counts_a_closed_section_as_left_but_never_entered) {
  // Round from "south" over "east" and "north"; "north" closed.
  TrafficZone zone = loop_with_spur();
  zone.stations = {{"dock", {2, 1.0}}};
  zone.closed = {2};
  zone.starts = {{2, 0.5}};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), IsEmpty()) << "ahead on the section where it starts";
  zone.starts = {{2, 1.5}};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), SizeIs(1)) << "behind, and no route back";
  zone.closed.clear();
  EXPECT_THAT(of_code(zone, "zone.unreachable"), IsEmpty());
  zone.starts.clear();
  zone.stations = {{"gate", {6, 0.5}}};
  EXPECT_THAT(of_code(zone, "zone.unreachable"), IsEmpty()) << "no start to come from";
}

// TrafficZone::start_positions takes such a start.
TEST(Check, permits_a_start_inside_a_crossing_at_a_waypoint_only) {
  TrafficZone zone = loop_with_spur();
  zone.waypoints = {{"w", {0, 0.0}}, {"node", {0, 1.6}}, {"w", {2, 0.0}}};
  zone.crossings = {{"X1", {}, {{0, 1.5, 1.8}}}};
  zone.starts = {{0, 1.6}};
  EXPECT_THAT(of_code(zone, "zone.start"), IsEmpty());
  EXPECT_THAT(zone.start_positions(1), ElementsAre(TrackPosition{0, 1.6}));
  for (const double s_m : {1.57, 1.63}) {
    zone.starts = {{0, s_m}};
    EXPECT_THAT(of_code(zone, "zone.start"), SizeIs(1)) << s_m;
  }
}

TEST(Check, distinguishes_starts_that_are_too_near_from_those_where_no_vehicle_may_stop) {
  TrafficZone zone = loop_with_spur();
  zone.waypoints = {{"w", {0, 0.0}}, {"w", {2, 0.0}}};
  zone.crossings = {{"X1", {}, {{0, 1.5, 1.8}}}};
  // A vehicle and its gap take 0.30 m.
  zone.starts = {{0, 0.5}, {0, 0.81}, {0, 1.1}, {0, 1.6}, {0, 1.9}, {2, 1.0}};
  const auto found = of_code(zone, "zone.start");
  ASSERT_THAT(found, SizeIs(3));
  EXPECT_EQ(found[0].severity, Problem::Severity::error);
  EXPECT_EQ(found[0].text, "start 4 lies where no vehicle may stop") << "in the crossing";
  EXPECT_EQ(found[0].position, (TrackPosition{0, 1.6}));
  EXPECT_EQ(found[1].text, "start 5 lies where no vehicle may stop") << "no waypoint since the crossing";
  EXPECT_EQ(found[2].severity, Problem::Severity::warning);
  EXPECT_EQ(found[2].text, "start 3 is nearer than 0.30 m to one before it; no vehicle begins here");
}

TEST(Check, tolerates_five_metres_without_tag_or_beacon) {
  const auto unread = [](std::vector<Circuit::Part> parts) {
    TrafficZone zone = zone_of(std::move(parts));
    zone.beacons.reset();
    return of_code(zone, "zone.unread");
  };
  EXPECT_THAT(unread({part("a", section({}, 5.0))}), IsEmpty());
  const auto found = unread({part("a", section({}, 2.0), {1}), part("b", section({2.0, 0.0, 0.0}, 3.1))});
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].severity, Problem::Severity::warning);
  EXPECT_THAT(found[0].text, HasSubstr("for 5.10 m from here to 'b'; expected one every 5.00 m"));
  const Section half = section({}, 0.5 * pi, 2.0);
  const auto round = unread({part("a", half, {1}), part("b", section(half.end(), 0.5 * pi, 2.0), {0})});
  ASSERT_THAT(round, SizeIs(1));
  EXPECT_THAT(round[0].text, HasSubstr("can circulate for ever without a tag or a beacon, 3.1416 m each time"));
}

TEST(Check, counts_what_is_beyond_its_list_only_where_there_is_more) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 4; ++i) parts.push_back(part("s" + std::to_string(i), section({0.0, 1.0 * i, 0.0}, 1.0)));
  const TrafficZone zone = zone_of(std::move(parts));
  EXPECT_THAT(of_code(zone, "zone.dead_end", {.of_one_code = 4}), SizeIs(4));
  const auto found = of_code(zone, "zone.dead_end", {.of_one_code = 3});
  ASSERT_THAT(found, SizeIs(4));
  EXPECT_EQ(found[3].text, "and 1 more like those above, up to here");
  EXPECT_EQ(found[3].severity, Problem::Severity::warning);
  EXPECT_EQ(found[3].position, (TrackPosition{3, 1.0}));
  EXPECT_EQ(found[3].at, (Point2{1.0, 3.0}));
}

TEST(Check, lists_findings_by_severity_then_code_then_section) {
  TrafficZone zone = loop_with_spur();
  zone.stations = {{"gate", {6, 0.5}}};
  zone.starts = {{0, 1.0}};
  std::vector<std::string> codes;
  for (const Problem& problem : problems(zone)) codes.push_back(problem.code);
  EXPECT_THAT(codes, ElementsAre("zone.unreachable", "zone.dead_end", "zone.no_entry", "zone.no_return"));
  EXPECT_EQ(to_string(Problem::Severity::error), "error");
  EXPECT_EQ(to_string(Problem::Severity::warning), "warning");
  EXPECT_EQ(to_string(Problem::Severity::notice), "notice");
}

TEST(Check, lists_errors_first_and_names_their_location) {
  TrafficZone zone = loop_with_spur();
  zone.stations = {{"gate", {6, 0.5}}};
  zone.starts = {{0, 1.0}};
  const auto all = problems(zone);
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(to_string(all[0], zone).substr(0, 55), "error zone.unreachable at 'ramp' 0.50 m (-0.50, 0.00): ");
  bool warned = false;
  for (const Problem& problem : all) {
    warned = warned || problem.severity == Problem::Severity::warning;
    EXPECT_TRUE(!warned || problem.severity == Problem::Severity::warning);
  }
}

TEST(Check, reports_a_wide_bend_that_is_driven_too_fast) {
  // 2 m/s on a radius of 2 m: 2 m/s²; √(1.0 · 2) = 1.414 m/s is slow enough.
  TrafficZone zone = zone_of({part("a", section({}, 1.0, 0.5))});
  EXPECT_THAT(of_code(zone, "zone.speed"), IsEmpty());
  zone.profiles.fast.speed_mps = 2.0;
  const auto found = of_code(zone, "zone.speed");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].text, "at 2.00 m/s vehicles are pushed outward with 2.00 m/s² in 'a'; limit it to 1.41 m/s");
}

TEST(Check, takes_a_radius_of_exactly_half_the_width_for_too_tight) {
  TrafficZone zone = zone_of({part("a", section({}, 0.1, 4.0))});
  zone.vehicle.width_m = 0.5;
  EXPECT_THAT(of_code(zone, "zone.vehicle"), SizeIs(1));
  zone.vehicle.width_m = 0.4375;
  EXPECT_THAT(of_code(zone, "zone.vehicle"), IsEmpty());
}

TEST(Check, tolerates_starts_exactly_a_vehicle_and_its_gap_apart) {
  TrafficZone zone = loop_with_spur();
  zone.vehicle.length_m = 0.4;  // and 0.1 m of gap
  zone.waypoints = {{"w", {0, 0.0}}};
  zone.starts = {{0, 0.5}, {0, 1.0}};
  EXPECT_THAT(of_code(zone, "zone.start"), IsEmpty());
  zone.starts = {{0, 0.5}, {0, 0.9375}};
  EXPECT_THAT(of_code(zone, "zone.start"), SizeIs(1));
}

TEST(Check, tries_only_as_many_stations_as_twenty_million_steps_allow) {
  TrafficZone zone = zone_of({part("a", section({}, 2.0))});
  for (int i = 0; i < 4500; ++i) zone.stations.push_back({"s" + std::to_string(i), {0, 2.0 * i / 4500}});
  // 20 million / (1 section + 4500 stations) = 4443, and one more; all but the first lie beyond it.
  const auto found = of_code(zone, "zone.unreachable");
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].text, "station 's0' cannot be reached from station 's1' and 4442 others");
}

}  // namespace
}  // namespace cosiva::zone
