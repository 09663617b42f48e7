#include "cosiva/zone/check/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cosiva::zone
