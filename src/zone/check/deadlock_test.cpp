#include "cosiva/zone/check/deadlock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "cosiva/base/math.h"
#include "cosiva/zone/generate/generate.h"
#include "cosiva/zone/layout/crossings.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::part;
using testing::section;
using ::testing::SizeIs;

TrafficZone zone_of(std::vector<Circuit::Part> parts) {
  auto circuit = Circuit::make("z", std::move(parts));
  EXPECT_TRUE(circuit) << to_string(circuit.error());
  TrafficZone zone{"z", std::move(*circuit), {}, {}, {}, {}, {}, {}, {}, {}};
  zone.crossings = find_crossings(zone.circuit, zone.vehicle);
  zone.waypoints = lay_waypoints(zone.circuit, zone.crossings);
  return zone;
}

std::vector<Problem> of_code(const TrafficZone& zone, std::string_view code) {
  std::vector<Problem> found;
  for (const Problem& problem : deadlock_spots(zone))
    if (problem.code == code) found.push_back(problem);
  return found;
}

/// Two straights of `straight_m` and two half circles of 0.5 m radius.
TrafficZone oval(double straight_m) {
  const Section south = section({}, straight_m);
  const Section east = section(south.end(), pi * 0.5, 2.0);
  const Section north = section(east.end(), straight_m);
  const Section west = section(north.end(), pi * 0.5, 2.0);
  return zone_of(
      {part("south", south, {1}), part("east", east, {2}), part("north", north, {3}), part("west", west, {0})});
}

TEST(DeadlockSpots, report_how_many_vehicles_a_loop_has_room_for) {
  const TrafficZone zone = oval(3.0);
  const auto found = of_code(zone, "deadlock.loop");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].severity, Problem::Severity::notice);
  EXPECT_EQ(found[0].position, (TrackPosition{0, 0.0}));
  const std::size_t most = vehicles_going_round(zone, {0, 1, 2, 3});
  // 9.14 m round, a vehicle and its gap 0.30 m: 30 at most, and one of them must have room to move.
  EXPECT_LE(most, 29U);
  EXPECT_GE(most, 14U);
  EXPECT_THAT(found[0].text, HasSubstr("room for " + std::to_string(most) + " vehicles"));
  EXPECT_THAT(found[0].text, HasSubstr("with " + std::to_string(most + 1) + " no vehicle in it can move"));
  EXPECT_THAT(deadlock_spots(zone), SizeIs(1));
}

TEST(DeadlockSpots, count_positions_a_vehicle_s_length_and_gap_apart_all_the_way_round) {
  TrafficZone zone = oval(3.0);
  const double round_m = zone.circuit.total_length_m();
  const auto with_positions = [&](std::vector<double> on_south) {
    Listed<Waypoint, WaypointKeys> waypoints;
    std::vector<Waypoint> all;
    for (const double s_m : on_south) all.push_back({"w" + std::to_string(s_m), {0, s_m}});
    zone.waypoints = std::move(all);
    return vehicles_going_round(zone, {0, 1, 2, 3});
  };
  ASSERT_GT(round_m, 9.0);
  EXPECT_EQ(with_positions({}), 0U);
  EXPECT_EQ(with_positions({1.0}), 0U) << "the only position: a vehicle that leaves it must come back to it";
  EXPECT_EQ(with_positions({1.0, 1.3}), 1U);
  EXPECT_EQ(with_positions({1.0, 1.2}), 0U) << "too near for two";
  EXPECT_EQ(with_positions({1.0, 1.2, 1.4, 1.6}), 1U);
  EXPECT_EQ(with_positions({1.0, 1.1, 1.4, 1.7}), 2U);
}

TEST(DeadlockSpots, are_counted_for_each_named_loop_and_not_for_the_rest) {
  TrafficZone zone = oval(3.0);
  zone.loops = {{"round", {2, 3, 0, 1}}};
  const auto found = of_code(zone, "deadlock.loop");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("loop 'round' has room for"));
  EXPECT_EQ(found[0].position.section, 2U);
}

TEST(DeadlockSpots, of_a_part_with_branches_are_its_positions) {
  const Section south = section({}, 2.0);
  const Section east = section(south.end(), pi * 0.5, 2.0);
  const Section north = section(east.end(), 2.0);
  const Section west = section(north.end(), pi * 0.5, 2.0);
  const Section wide = section(south.end(), pi, 1.0);
  const Section back = section(wide.end(), 2.0);
  const Section home = section(back.end(), pi, 1.0);
  const TrafficZone zone =
      zone_of({part("south", south, {1, 4}), part("east", east, {2}), part("north", north, {3}),
               part("west", west, {0}), part("wide", wide, {5}), part("back", back, {6}), part("home", home, {0})});
  const auto found = of_code(zone, "deadlock.loop");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("the 7 sections that lead round from 'south'"));
}

TEST(DeadlockSpots, are_cycles_of_crossings_without_room_between_them) {
  TrafficZone zone = oval(3.0);
  EXPECT_THAT(of_code(zone, "deadlock.no_room"), IsEmpty());
  // One crossing next to another all the way round, as where four sections cross in too small a square.
  std::vector<Crossing> crossings;
  for (SectionId id = 0; id < 4; ++id) {
    const double length_m = zone.circuit.section(id).length_m();
    crossings.push_back({"X" + std::to_string(id + 1), {}, {{id, 0.0, length_m}}});
  }
  zone.crossings = crossings;
  const auto found = of_code(zone, "deadlock.no_room");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("over 4 sections without a waiting position"));
  EXPECT_THAT(of_code(zone, "deadlock.loop")[0].text, HasSubstr("no position where a vehicle can wait"));
}

TEST(DeadlockSpots, are_rows_of_crossings_longer_than_is_reserved_at_once) {
  const auto row = [](int sections) {
    std::vector<Circuit::Part> parts;
    for (int i = 0; i < sections; ++i)
      parts.push_back(part("s" + std::to_string(i), section({1.0 * i, 0.0, 0.0}, 1.0),
                           i + 1 < sections ? std::vector{static_cast<SectionId>(i + 1)} : std::vector<SectionId>{}));
    TrafficZone zone = zone_of(std::move(parts));
    std::vector<Crossing> crossings;
    std::vector<Waypoint> waypoints;
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      crossings.push_back({"X" + std::to_string(id), {}, {{id, 0.0, 1.0}}});
      waypoints.push_back({"w" + std::to_string(id), {id, 0.5}});
    }
    zone.crossings = crossings;
    zone.waypoints = waypoints;
    return of_code(zone, "deadlock.no_room");
  };
  EXPECT_THAT(row(static_cast<int>(reserved_at_once_max)), IsEmpty());
  const auto found = row(static_cast<int>(reserved_at_once_max) + 4);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].position.section, 0U);
  EXPECT_THAT(found[0].text, HasSubstr("over 20 stretches"));
}

/// There and back on one track of three sections, with turns on the spot at both ends.
TrafficZone there_and_back() {
  const auto piece = [](const char* name, const Section& line, std::vector<SectionId> next) {
    Circuit::Part made = part(name, line, std::move(next));
    made.pivots = true;
    return made;
  };
  return zone_of({piece("a", section({}, 1.0), {1}), piece("b", section({1.0, 0.0, 0.0}, 1.0), {2}),
                  piece("c", section({2.0, 0.0, 0.0}, 1.0), {3}), piece("c back", section({3.0, 0.0, pi}, 1.0), {4}),
                  piece("b back", section({2.0, 0.0, pi}, 1.0), {5}),
                  piece("a back", section({1.0, 0.0, pi}, 1.0), {0})});
}

TEST(DeadlockSpots, are_tracks_driven_both_ways_where_a_vehicle_may_stop) {
  TrafficZone zone = there_and_back();
  EXPECT_EQ(opposites(zone), (std::vector<SectionId>{5, 4, 3, 2, 1, 0}));
  EXPECT_THAT(of_code(zone, "deadlock.single_track"), IsEmpty()) << "reserved from end to end";
  EXPECT_THAT(of_code(zone, "deadlock.no_room"), IsEmpty())
      << "a vehicle that turns round holds the return path already";
  // As where a format declares that a vehicle may stop there.
  zone.crossings = std::vector<Crossing>{};
  zone.waypoints = std::vector<Waypoint>{{"b", {1, 0.5}}};
  const auto found = of_code(zone, "deadlock.single_track");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("one track of 3.00 m driven both ways"));
}

TEST(DeadlockSpots, are_ends_that_are_left_in_the_direction_of_entry) {
  const auto found = of_code(there_and_back(), "deadlock.dead_end");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("'c', 'a back' can only be left in the direction of entry"));
}

TEST(DeadlockSpots, of_the_ready_zones_are_how_many_they_have_room_for) {
  for (const char* name : {"lacet4.toml", "indus8.toml"}) {
    const TrafficZone zone = testing::zone_file(name);
    for (const Problem& problem : deadlock_spots(zone)) EXPECT_EQ(problem.code, "deadlock.loop") << problem.text;
  }
}

}  // namespace
}  // namespace cosiva::zone
