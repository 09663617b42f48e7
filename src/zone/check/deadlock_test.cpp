#include "cosiva/zone/check/deadlock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
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

/// Sets the waypoints of a zone; a waypoint outside crossings is a waiting position.
void set_waypoints(TrafficZone& zone, const std::vector<TrackPosition>& positions) {
  std::vector<Waypoint> waypoints;
  for (const TrackPosition& position : positions)
    waypoints.push_back({"w" + std::to_string(waypoints.size()), position});
  zone.waypoints = std::move(waypoints);
}

TEST(DeadlockSpots, count_the_most_positions_that_keep_their_distance_round_the_loop) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "deadlock_test"};
    const Section half = section({}, pi * 0.5, 2.0);
    TrafficZone zone = zone_of({part("a", half, {1}), part("b", section(half.end(), pi * 0.5, 2.0), {0})});
    const double round_m = pi;
    std::vector<double> at_m(1 + random.below(10));
    for (double& s_m : at_m) s_m = random.uniform(0.0, random.chance(0.5) ? 1.0 : round_m);
    std::sort(at_m.begin(), at_m.end());
    std::vector<TrackPosition> positions;
    for (const double s_m : at_m)
      positions.push_back(s_m < 0.5 * round_m ? TrackPosition{0, s_m} : TrackPosition{1, s_m - 0.5 * round_m});
    set_waypoints(zone, positions);
    // Every choice of positions, and whether neighbours in it, round the loop, are a vehicle and its gap apart.
    std::size_t most = 0;
    for (std::uint32_t chosen = 1; chosen < (1U << at_m.size()); ++chosen) {
      std::vector<double> taken_m;
      for (std::size_t i = 0; i < at_m.size(); ++i)
        if ((chosen >> i & 1U) != 0) taken_m.push_back(at_m[i]);
      bool apart = taken_m.size() == 1 || taken_m.front() + round_m - taken_m.back() >= 0.30;
      for (std::size_t i = 1; i < taken_m.size(); ++i) apart = apart && taken_m[i] - taken_m[i - 1] >= 0.30;
      if (apart) most = std::max(most, taken_m.size());
    }
    RC_ASSERT(vehicles_going_round(zone, {0, 1}) == most - 1);
  }));
}

TEST(DeadlockSpots, count_no_position_in_a_crossing) {
  TrafficZone zone = oval(3.0);
  set_waypoints(zone, {{0, 0.0}, {0, 1.0}, {0, 2.0}, {2, 0.0}});
  EXPECT_EQ(vehicles_going_round(zone, {0, 1, 2, 3}), 3U);
  zone.crossings = std::vector<Crossing>{{"X1", {}, {{0, 0.9, 1.1}}}};
  EXPECT_EQ(vehicles_going_round(zone, {0, 1, 2, 3}), 2U);
  EXPECT_THAT(of_code(zone, "deadlock.loop")[0].text,
              HasSubstr("the loop from 'south' has room for 2 vehicles to circulate; with 3 no vehicle"));
  set_waypoints(zone, {{0, 0.0}, {0, 2.0}});
  EXPECT_THAT(of_code(zone, "deadlock.loop")[0].text, HasSubstr("room for 1 vehicle to circulate; with 2 no"));
}

TEST(DeadlockSpots, of_sections_that_lead_round_over_several_branches_are_their_waiting_positions) {
  const auto start = section({}, 1.0);
  TrafficZone zone = zone_of([&] {
    std::vector<Circuit::Part> parts{part("stem", start, {1, 2}),
                                     part("left", section(start.end(), pi, 1.0), {3}),
                                     part("right", section(start.end(), pi, 1.0), {3}),
                                     part("back", section({1.0, 2.0, pi}, 1.0), {4}),
                                     part("home", section({0.0, 2.0, pi}, pi, 1.0), {0}),
                                     part("siding", section({5.0, 5.0, 0.0}, 1.0))};
    return parts;
  }());
  zone.crossings = std::vector<Crossing>{};
  set_waypoints(zone, {{0, 0.5}, {2, 0.5}, {3, 0.2}, {5, 0.5}});
  auto found = of_code(zone, "deadlock.loop");
  ASSERT_THAT(found, SizeIs(1)) << "a siding leads nowhere";
  EXPECT_EQ(found[0].position, (TrackPosition{0, 0.0}));
  EXPECT_THAT(found[0].text,
              HasSubstr("the 5 sections that lead round from 'stem' have waiting positions for at most 3 "
                        "vehicles; with more than 2 no vehicle in them can move"));
  // A section of 1 m takes four vehicles of 0.3 m, the last one with its centre still on it, however many waypoints.
  std::vector<TrackPosition> many;
  for (int i = 0; i < 10; ++i) many.push_back({0, 0.1 * i});
  set_waypoints(zone, many);
  EXPECT_THAT(of_code(zone, "deadlock.loop")[0].text, HasSubstr("for at most 4 vehicles; with more than 3"));
  set_waypoints(zone, {{1, 0.5}});
  EXPECT_THAT(of_code(zone, "deadlock.loop")[0].text, HasSubstr("for at most 1 vehicle; with more than 0"));
  set_waypoints(zone, {});
  EXPECT_THAT(of_code(zone, "deadlock.loop")[0].text, HasSubstr("for at most 0 vehicles; with more than 0"));
}

TEST(DeadlockSpots, are_sections_that_follow_themselves) {
  const TrafficZone zone =
      zone_of({part("round", section({}, 2.0 * pi * 0.5, 2.0), {0}), part("line", section({5.0, 0.0, 0.0}, 1.0))});
  const auto found = of_code(zone, "deadlock.loop");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("the loop from 'round' has room for"));
}

/// Sections of 1 m in a row, each with `waypoints` waypoints in a crossing over all of it; at the end the successors of
/// the last.
TrafficZone crowded_row(int sections, int waypoints, std::vector<SectionId> last_next = {}) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < sections; ++i) {
    parts.push_back(part("s" + std::to_string(i), section({1.0 * i, 0.0, 0.0}, 1.0),
                         i + 1 < sections ? std::vector{static_cast<SectionId>(i + 1)} : last_next));
  }
  TrafficZone zone = zone_of(std::move(parts));
  std::vector<Crossing> crossings;
  std::vector<TrackPosition> positions;
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    crossings.push_back({"X" + std::to_string(id), {}, {{id, 0.0, 1.0}}});
    for (int i = 0; i < waypoints; ++i) positions.push_back({id, 0.1 * (i + 1)});
  }
  zone.crossings = crossings;
  set_waypoints(zone, positions);
  return zone;
}

TEST(DeadlockSpots, are_long_rows_in_both_directions_of_one_track) {
  Circuit::Part there = part("there", section({}, 1.0), {1});
  Circuit::Part back = part("back", section({1.0, 0.0, pi}, 1.0), {0});
  there.pivots = back.pivots = true;
  TrafficZone zone = zone_of({there, back});
  zone.crossings = std::vector<Crossing>{{"X1", {}, {{0, 0.0, 1.0}, {1, 0.0, 1.0}}}};
  std::vector<TrackPosition> positions;
  for (const SectionId id : {0U, 1U})
    for (int i = 1; i <= 17; ++i) positions.push_back({id, 0.05 * i});
  set_waypoints(zone, positions);
  const auto found = of_code(zone, "deadlock.no_room");
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_THAT(found[0].text, HasSubstr("from 'there' on crossings follow each other over 17 stretches"));
  EXPECT_THAT(found[1].text, HasSubstr("from 'back' on crossings follow each other over 17 stretches"));
}

TEST(DeadlockSpots, are_rows_from_seventeen_stretches_on_and_end_at_a_waiting_position) {
  const auto no_room = [](const TrafficZone& zone) { return of_code(zone, "deadlock.no_room"); };
  EXPECT_THAT(no_room(crowded_row(16, 1)), IsEmpty());
  EXPECT_THAT(no_room(crowded_row(17, 1)), SizeIs(1));
  EXPECT_THAT(no_room(crowded_row(8, 2)), IsEmpty());
  EXPECT_THAT(no_room(crowded_row(9, 2))[0].text,
              HasSubstr("from 's0' on crossings follow each other over 18 stretches"));
  // A section without waypoints is a stretch, too.
  EXPECT_THAT(no_room(crowded_row(16, 0)), IsEmpty());
  EXPECT_THAT(no_room(crowded_row(17, 0)), SizeIs(1));
  TrafficZone divided = crowded_row(20, 1);
  divided.crossings.erase_if([](const Crossing& crossing) { return crossing.name == "X10"; });
  EXPECT_THAT(no_room(divided), IsEmpty());
}

TEST(DeadlockSpots, report_a_row_where_it_begins_and_count_its_longest_branch) {
  // s0 … s16, and a branch of three more from s14.
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 17; ++i) {
    std::vector<SectionId> next;
    if (i < 16) next.push_back(static_cast<SectionId>(i + 1));
    if (i == 14) next.push_back(17);
    parts.push_back(part("s" + std::to_string(i), section({1.0 * i, 0.0, 0.0}, 1.0), next));
  }
  for (int i = 0; i < 3; ++i)
    parts.push_back(part("b" + std::to_string(i), section({15.0 + i, 0.0, 0.0}, 1.0),
                         i < 2 ? std::vector{static_cast<SectionId>(18 + i)} : std::vector<SectionId>{}));
  auto circuit = Circuit::make("z", std::move(parts));
  ASSERT_TRUE(circuit);
  TrafficZone zone{"z", std::move(*circuit), {}, {}, {}, {}, {}, {}, {}, {}};  // no waypoint at all
  const auto found = of_code(zone, "deadlock.no_room");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].position, (TrackPosition{0, 0.0}));
  EXPECT_THAT(found[0].text, HasSubstr("over 18 stretches")) << "15 and the longer branch of 3";
}

TEST(DeadlockSpots, are_round_trips_of_one_section_without_room) {
  TrafficZone zone = zone_of({part("round", section({}, 2.0 * pi * 0.5, 2.0), {0})});
  zone.waypoints = std::vector<Waypoint>{};
  const auto found = of_code(zone, "deadlock.no_room");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("go round from 'round' over 1 sections"));
}

TEST(DeadlockSpots, name_the_section_of_a_single_track_where_a_vehicle_may_stop) {
  TrafficZone zone = there_and_back();
  zone.crossings = std::vector<Crossing>{};
  set_waypoints(zone, {{4, 0.5}});
  auto found = of_code(zone, "deadlock.single_track");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].position, (TrackPosition{4, 0.0})) << "in the opposite direction";
  EXPECT_THAT(found[0].text, HasSubstr("'a' to 'c' are one track of 3.00 m"));
  EXPECT_THAT(found[0].text, HasSubstr("may stop on 'b back'"));
  set_waypoints(zone, {{0, 0.5}, {5, 0.5}, {1, 0.5}});
  found = of_code(zone, "deadlock.single_track");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("may stop on 'a' while"));
}

TEST(DeadlockSpots, end_a_single_track_where_a_vehicle_may_leave_it) {
  const auto piece = [](const char* name, const Section& line, std::vector<SectionId> next) {
    Circuit::Part made = part(name, line, std::move(next));
    made.pivots = true;
    return made;
  };
  // A track of two sections there and back, with a branch off between them.
  TrafficZone zone =
      zone_of({piece("a", section({}, 1.0), {1, 4}), piece("b", section({1.0, 0.0, 0.0}, 1.0), {2}),
               piece("b back", section({2.0, 0.0, pi}, 1.0), {3}), piece("a back", section({1.0, 0.0, pi}, 1.0), {0}),
               piece("off", section({1.0, 0.0, 0.5 * pi}, 1.0), {})});
  zone.crossings = std::vector<Crossing>{};
  set_waypoints(zone, {{0, 0.5}, {1, 0.5}, {2, 0.5}, {3, 0.5}});
  const auto found = of_code(zone, "deadlock.single_track");
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_THAT(found[0].text, HasSubstr("'a' is one track of 1.00 m"));
  EXPECT_THAT(found[1].text, HasSubstr("'b' is one track of 1.00 m"));
}

TEST(DeadlockSpots, name_five_dead_ends_and_count_the_rest) {
  const auto ends = [](int number) {
    std::vector<Circuit::Part> parts;
    for (int i = 0; i < number; ++i) {
      const auto id = static_cast<SectionId>(2 * i);
      auto in = part("in" + std::to_string(i), section({0.0, 1.0 * i, 0.0}, 1.0), {id + 1});
      in.pivots = true;
      parts.push_back(std::move(in));
      parts.push_back(part("out" + std::to_string(i), section({1.0, 1.0 * i, pi}, 1.0)));
    }
    const auto found = of_code(zone_of(std::move(parts)), "deadlock.dead_end");
    return found.empty() ? std::string() : found[0].text;
  };
  EXPECT_EQ(ends(1).substr(0, 9), "'in0' can");
  EXPECT_THAT(ends(5), ::testing::StartsWith("'in0', 'in1', 'in2', 'in3', 'in4' can only be left"));
  EXPECT_THAT(ends(7), ::testing::StartsWith("'in0', 'in1', 'in2', 'in3', 'in4' and 2 more can only be left"));
}

TEST(DeadlockSpots, take_two_sections_for_opposites_whose_centres_are_within_half_a_width) {
  const auto pair_of = [](double aside_m) {
    // An arc with a sagitta of `aside_m` over 2 m: R = (1 + h²)/2h, half its angle is 2·atan(h).
    const double half_rad = 2.0 * std::atan(aside_m);
    const double radius_m = (1.0 + aside_m * aside_m) / (2.0 * aside_m);
    const Section bow = section({0.0, 0.0, half_rad}, 2.0 * half_rad * radius_m, -1.0 / radius_m);
    return opposites(zone_of({part("there", bow), part("back", section({2.0, 0.0, pi}, 2.0))}));
  };
  EXPECT_EQ(pair_of(0.059), (std::vector<SectionId>{1, 0}));
  EXPECT_EQ(pair_of(0.061), (std::vector<SectionId>{no_section, no_section}));
  const auto ends = [](double off_m) {
    return opposites(
        zone_of({part("there", section({}, 2.0)), part("back", section({2.0 + off_m, 0.0, pi}, 2.0 + off_m))}));
  };
  EXPECT_EQ(ends(0.004), (std::vector<SectionId>{1, 0})) << "ends are compared to a centimetre";
  EXPECT_EQ(ends(0.02), (std::vector<SectionId>{no_section, no_section}));
}

TEST(DeadlockSpots, of_the_ready_zones_are_how_many_they_have_room_for) {
  for (const char* name : {"lacet4.toml", "indus8.toml"}) {
    const TrafficZone zone = testing::zone_file(name);
    for (const Problem& problem : deadlock_spots(zone)) EXPECT_EQ(problem.code, "deadlock.loop") << problem.text;
  }
}

TEST(DeadlockSpots, count_positions_exactly_a_vehicle_and_its_gap_apart) {
  TrafficZone zone = zone_of({part("a", section({}, 4.0))});
  zone.vehicle.length_m = 0.4;  // and 0.1 m of gap
  const auto going_round = [&](double first_m, double second_m) {
    set_waypoints(zone, {{0, first_m}, {0, second_m}});
    return vehicles_going_round(zone, {0});
  };
  EXPECT_EQ(going_round(0.5, 1.0), 1U);
  EXPECT_EQ(going_round(0.5, 0.9375), 0U);
  EXPECT_EQ(going_round(0.0, 3.5), 1U) << "0.5 m beyond the end of the round";
  EXPECT_EQ(going_round(0.0, 3.5625), 0U);
}

Circuit::Part turning(const char* name, const Pose2& start, std::vector<SectionId> next) {
  Circuit::Part made = part(name, section(start, 1.0), std::move(next));
  made.pivots = true;
  return made;
}

TEST(DeadlockSpots, follow_a_single_track_from_its_beginning_whatever_the_order_of_its_sections) {
  TrafficZone zone = zone_of({turning("b", {1.0, 0.0, 0.0}, {2}), turning("a", {0.0, 0.0, 0.0}, {0}),
                              turning("c", {2.0, 0.0, 0.0}, {3}), turning("c back", {3.0, 0.0, pi}, {4}),
                              turning("b back", {2.0, 0.0, pi}, {5}), turning("a back", {1.0, 0.0, pi}, {1})});
  zone.crossings = std::vector<Crossing>{};
  set_waypoints(zone, {{0, 0.5}});
  const auto found = of_code(zone, "deadlock.single_track");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].position, (TrackPosition{0, 0.0}));
  EXPECT_EQ(found[0].text,
            "'a' to 'c' are one track of 3.00 m driven both ways, and a vehicle may stop on 'b' while another comes "
            "from the other direction; there is no room to pass");
}

TEST(DeadlockSpots, follow_a_single_track_once_round_a_circle) {
  // Three thirds of a circle of 0.5 m radius, driven in both directions: "e" to the left, "w" back over the same.
  const double third_m = pi / 3.0;
  const Section e0 = section({}, third_m, 2.0);
  const Section e1 = section(e0.end(), third_m, 2.0);
  const Section e2 = section(e1.end(), third_m, 2.0);
  const auto back = [&](const Section& of) {
    return section({of.end().x_m, of.end().y_m, wrap_angle(of.end().heading_rad + pi)}, third_m, -2.0);
  };
  TrafficZone zone = zone_of({part("e0", e0, {1}), part("e1", e1, {2}), part("e2", e2, {0}), part("w0", back(e0), {5}),
                              part("w1", back(e1), {3}), part("w2", back(e2), {4})});
  EXPECT_EQ(opposites(zone), (std::vector<SectionId>{3, 4, 5, 0, 1, 2}));
  zone.crossings = std::vector<Crossing>{};
  set_waypoints(zone, {{0, 0.5}});
  const auto found = of_code(zone, "deadlock.single_track");
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0].text, HasSubstr("'e1' to 'e0' are one track of 3.1416 m"));
  EXPECT_THAT(found[0].text, HasSubstr("may stop on 'e0' while"));
}

}  // namespace
}  // namespace cosiva::zone
