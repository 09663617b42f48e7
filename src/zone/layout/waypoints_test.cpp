#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/layout/crossings.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using testing::part;
using testing::section;

std::vector<std::string> ids(const std::vector<Waypoint>& waypoints) {
  std::vector<std::string> all;
  for (const Waypoint& waypoint : waypoints) all.push_back(waypoint.id);
  return all;
}

Circuit line() {
  const Section first = section({}, 1.0);
  return testing::circuit({part("a", first, {1}), part("b", section(first.end(), 1.0))});
}

/// A crossing over one stretch; the crossing section does not matter to waypoints.
Crossing crossing(SectionId on, double from_m, double to_m) { return {"X", {}, {{on, from_m, to_m}}}; }

TEST(Waypoints, lie_at_joints_and_between_them) {
  EXPECT_THAT(ids(lay_waypoints(line(), {}, 0.5)), ElementsAre("a@0", "a@500", "b@0", "b@500", "b@1000"));
}

TEST(Waypoints, are_never_further_apart_than_the_spacing) {
  EXPECT_THAT(ids(lay_waypoints(line(), {}, 0.34)),
              ElementsAre("a@0", "a@333", "a@667", "b@0", "b@333", "b@667", "b@1000"));
}

TEST(Waypoints, lie_at_stop_lines_and_exits_two_centimetres_off_the_crossing) {
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.4, 0.6)}, 0.5)),
              ElementsAre("a@0", "a@380", "a@620", "b@0", "b@500", "b@1000"));
}

TEST(Waypoints, do_not_lie_where_a_vehicle_cannot_stop_between_crossings) {
  // 0.25 m free: too short for a stopped vehicle of 0.2 m and its 0.1 m; 0.35 m is enough.
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.2, 0.3), crossing(0, 0.55, 0.7)}, 0.5)),
              ElementsAre("a@0", "a@180", "a@720", "b@0", "b@500", "b@1000"));
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.2, 0.3), crossing(0, 0.65, 0.7)}, 0.5)),
              ElementsAre("a@0", "a@180", "a@320", "a@630", "a@720", "b@0", "b@500", "b@1000"));
}

TEST(Waypoints, respect_crossings_on_both_sides_of_a_joint) {
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.7, 0.9), crossing(1, 0.1, 0.3)}, 0.5)),
              ElementsAre("a@0", "a@340", "a@680", "b@320", "b@660", "b@1000"));
}

TEST(Waypoints, respect_crossings_with_a_short_section_between) {
  const Section first = section({}, 1.0);
  const Section second = section(first.end(), 0.1);
  const Circuit circuit =
      testing::circuit({part("a", first, {1}), part("short", second, {2}), part("c", section(second.end(), 1.0))});
  EXPECT_THAT(ids(lay_waypoints(circuit, {crossing(0, 0.5, 0.95), crossing(2, 0.05, 0.5)}, 1.0)),
              ElementsAre("a@0", "a@480", "c@520", "c@1000"));
  // With room enough before the second crossing a vehicle may stop at the joint behind the first.
  EXPECT_THAT(ids(lay_waypoints(circuit, {crossing(0, 0.5, 0.95), crossing(2, 0.55, 0.7)}, 1.0)),
              ElementsAre("a@0", "a@480", "a@970", "short@0", "c@0", "c@530", "c@720", "c@1000"));
}

TEST(Waypoints, put_the_stop_line_on_the_section_before_when_the_crossing_begins_at_the_joint) {
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(1, 0.0, 0.4)}, 1.0)), ElementsAre("a@0", "a@980", "b@420", "b@1000"));
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.6, 1.0)}, 1.0)), ElementsAre("a@0", "a@580", "b@20", "b@1000"));
}

TEST(Waypoints, at_a_fork_lie_before_the_stem_ends) {
  const Section stem = section({}, 1.0);
  const Circuit fork = testing::circuit({part("stem", stem, {1, 2}), part("left", section(stem.end(), 2.0, 1.0)),
                                         part("right", section(stem.end(), 2.0, -1.0))});
  const auto waypoints = lay_waypoints(fork, find_crossings(fork, {}), 1.0);
  EXPECT_THAT(ids(waypoints), ::testing::Contains("stem@980"));
  for (const Waypoint& waypoint : waypoints)
    EXPECT_TRUE(waypoint.position.section == 0 || waypoint.position.s_m > 0.3) << waypoint.id;
}

// Waypoints requested by stations and formats
// -------------------------------------------------------------------------------------------

TEST(Waypoints, lie_at_requested_positions_too_and_inside_crossings) {
  WaypointRules rules;
  rules.spacing_m = 1.0;
  rules.at = {{1, 0.25}, {0, 0.5}};
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.4, 0.6)}, rules)),
              ElementsAre("a@0", "a@380", "a@500", "a@620", "b@0", "b@250", "b@1000"));
}

TEST(Waypoints, nearer_than_two_centimetres_to_a_requested_position_serve) {
  WaypointRules rules;
  rules.spacing_m = 0.5;
  rules.at = {{0, 0.481}, {0, 0.519}, {0, 0.3}, {0, 0.31}, {0, 0.321}, {1, 1.0}, {1, 0.0}};
  EXPECT_THAT(ids(lay_waypoints(line(), {}, rules)),
              ElementsAre("a@0", "a@300", "a@321", "a@500", "b@0", "b@500", "b@1000"));
}

TEST(Waypoints, at_nodes_have_the_nodes_ids_even_inside_a_crossing) {
  WaypointRules rules;
  rules.spacing_m = 1.0;
  rules.start_ids = {"N1", "N2"};
  rules.end_ids = {"never", "N3"};
  EXPECT_THAT(ids(lay_waypoints(line(), {}, rules)), ElementsAre("N1", "N2", "N3"));
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.9, 1.0), crossing(1, 0.0, 0.1)}, rules)),
              ElementsAre("N1", "a@880", "N2", "b@120", "N3"));
  rules.at = {{1, 0.01}};
  EXPECT_THAT(ids(lay_waypoints(line(), {}, rules)), ElementsAre("N1", "N2", "N3"));
}

TEST(Waypoints, of_nodes_only_have_none_in_between) {
  WaypointRules rules;
  rules.spacing_m = 0.1;
  rules.nodes_only = true;
  EXPECT_THAT(ids(lay_waypoints(line(), {crossing(0, 0.4, 0.6)}, rules)),
              ElementsAre("a@0", "a@380", "a@620", "b@0", "b@1000"));
}

TEST(Waypoints, have_a_node_s_id_on_all_sections_that_begin_there_and_are_all_found) {
  const Section stem = section({}, 1.0);
  TrafficZone zone{"z",
                   testing::circuit({part("stem", stem, {1, 2}), part("left", section(stem.end(), 2.0, 1.0)),
                                     part("right", section(stem.end(), 2.0, -1.0))}),
                   {},
                   {},
                   {},
                   {},
                   {},
                   {},
                   {},
                   {}};
  WaypointRules rules;
  rules.start_ids = {"A", "B", "B"};
  zone.waypoints = lay_waypoints(zone.circuit, {}, rules);
  const auto found = zone.find_waypoints("B");
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(zone.waypoints[found[0]].position, (TrackPosition{1, 0.0}));
  EXPECT_EQ(zone.waypoints[found[1]].position, (TrackPosition{2, 0.0}));
  EXPECT_EQ(zone.find_waypoint("B"), &zone.waypoints[found[0]]);
  EXPECT_TRUE(zone.find_waypoints("C").empty());
}

TEST(Waypoints, are_not_mistaken_for_a_node_whose_id_looks_like_theirs) {
  WaypointRules rules;
  rules.spacing_m = 0.5;
  rules.start_ids = {"", "a@500"};
  EXPECT_THAT(ids(lay_waypoints(line(), {}, rules)), ElementsAre("a@0", "a@500+", "a@500", "b@500", "b@1000"));
}

TEST(Waypoints, have_ids_of_their_own_in_order_of_section_and_arc_length) {
  const TrafficZone zone = testing::lacet4();
  std::set<std::string> detected;
  for (std::size_t i = 0; i < zone.waypoints.size(); ++i) {
    const Waypoint& waypoint = zone.waypoints[i];
    EXPECT_TRUE(detected.insert(waypoint.id).second) << waypoint.id;
    EXPECT_EQ(zone.find_waypoint(waypoint.id), &waypoint);
    if (i == 0) continue;
    const TrackPosition& before = zone.waypoints[i - 1].position;
    EXPECT_TRUE(before.section < waypoint.position.section ||
                (before.section == waypoint.position.section && before.s_m < waypoint.position.s_m));
  }
}

TEST(Waypoints, guard_every_span_and_keep_to_their_spacing_along_a_line_cut_anywhere) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "waypoints_test/line"};
    // A line cut into sections, with spans anywhere.
    std::vector<double> begin_m{0.0};
    std::vector<Circuit::Part> parts;
    const std::size_t size = 1 + random.below(6);
    for (SectionId id = 0; id < size; ++id) {
      const double length_m = random.chance(0.3) ? random.uniform(0.01, 0.1) : random.uniform(0.2, 1.5);
      parts.push_back(part("s" + std::to_string(id), section({begin_m.back(), 0.0, 0.0}, length_m)));
      if (id + 1 < size) parts.back().next = {id + 1};
      begin_m.push_back(begin_m.back() + length_m);
    }
    const Circuit circuit = testing::circuit(std::move(parts));
    constexpr double margin_m = 0.02;
    std::vector<Crossing> crossings;
    std::vector<std::pair<double, double>> blocked_m;
    for (std::size_t i = random.below(5); i > 0; --i) {
      const auto id = static_cast<SectionId>(random.below(size));
      const double length_m = circuit.section(id).length_m();
      double from_m = random.uniform(0.0, 1.0) * length_m;
      double to_m = std::min(from_m + random.uniform(0.0, 0.3), length_m);
      if (random.chance(0.2)) from_m = 0.0;
      if (random.chance(0.2)) to_m = length_m;
      crossings.push_back(crossing(id, from_m, to_m));
      blocked_m.emplace_back(begin_m[id] + from_m - margin_m, begin_m[id] + to_m + margin_m);
    }
    const double room_m = random.uniform(0.0, 0.6);
    const double spacing_m = random.uniform(0.1, 1.0);
    // Blocked are spans with their margins, and what is between two of them that leaves less than the room.
    std::sort(blocked_m.begin(), blocked_m.end());
    std::vector<std::pair<double, double>> united_m;
    for (const auto& [from_m, to_m] : blocked_m) {
      if (!united_m.empty() && from_m - united_m.back().second < std::max(room_m - 2.0 * margin_m, 1e-12))
        united_m.back().second = std::max(united_m.back().second, to_m);
      else
        united_m.emplace_back(from_m, to_m);
    }
    std::vector<double> at_m;
    for (const Waypoint& waypoint : lay_waypoints(circuit, crossings, spacing_m, room_m))
      at_m.push_back(begin_m[waypoint.position.section] + waypoint.position.s_m);
    for (std::size_t i = 1; i < at_m.size(); ++i) RC_ASSERT(at_m[i] > at_m[i - 1]);
    constexpr double hair_m = 1e-9;
    for (const double at : at_m) {
      for (const auto& [from_m, to_m] : united_m) RC_ASSERT(at <= from_m + hair_m || at >= to_m - hair_m);
    }
    // On every free stretch one lies at, or 2 cm from, either end, and the next is never further than the spacing.
    double from_m = 0.0;
    united_m.emplace_back(begin_m.back(), begin_m.back());
    for (const auto& [until_m, next_m] : united_m) {
      if (until_m > from_m + 2.0 * margin_m) {
        double last_m = from_m;
        bool first = true;
        for (const double at : at_m) {
          if (at < from_m - hair_m || at > until_m + hair_m) continue;
          RC_ASSERT(at - last_m <= (first ? margin_m : spacing_m + margin_m) + hair_m);
          last_m = at;
          first = false;
        }
        RC_ASSERT(!first);
        RC_ASSERT(until_m - last_m <= margin_m + hair_m);
      }
      from_m = next_m;
    }
  }));
}

TEST(Waypoints, are_as_few_as_the_spacing_allows_in_spite_of_rounding) {
  const auto count = [](double length_m, double spacing_m) {
    return lay_waypoints(testing::circuit({part("a", section({}, length_m))}), {}, spacing_m).size();
  };
  EXPECT_EQ(count(1.5, 0.3), 6U);
  EXPECT_EQ(count(1.5001, 0.3), 7U);
  EXPECT_EQ(count(0.29, 0.3), 2U);
  EXPECT_EQ(count(0.021, 0.3), 2U);
  EXPECT_EQ(count(0.019, 0.3), 1U) << "two centimetres are one position";
  EXPECT_EQ(count(1.0, 0.02), 51U);
}

TEST(Waypoints, have_ids_of_whole_millimetres) {
  WaypointRules rules;
  rules.nodes_only = true;
  rules.at = {{0, 0.1004}, {0, 0.2006}, {0, -0.5}, {0, 7.0}};
  EXPECT_THAT(ids(lay_waypoints(line(), {}, rules)), ElementsAre("a@0", "a@100", "a@201", "a@1000", "b@0", "b@1000"));
}

TEST(Waypoints, keep_out_of_every_crossing_whatever_the_sections_and_the_vehicle) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "waypoints_test"};
    std::vector<Circuit::Part> parts;
    for (int i = 0; i < 4; ++i) {
      const Pose2 start{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-3.0, 3.0)};
      const auto first = static_cast<SectionId>(parts.size());
      const Section one = section(start, random.uniform(0.2, 2.0), random.uniform(-1.0, 1.0));
      parts.push_back(part("a" + std::to_string(i), one, {first + 1}));
      parts.push_back(part("b" + std::to_string(i), section(one.end(), random.uniform(0.2, 2.0))));
    }
    const Circuit circuit = testing::circuit(std::move(parts));
    const VehicleShape vehicle{random.uniform(0.05, 0.4), random.uniform(0.05, 0.3)};
    const auto crossings = find_crossings(circuit, vehicle);
    const auto waypoints = lay_waypoints(circuit, crossings, random.uniform(0.1, 1.0), stopping_room_m(vehicle));
    for (const Waypoint& waypoint : waypoints) {
      RC_ASSERT(waypoint.position.s_m >= 0.0);
      RC_ASSERT(waypoint.position.s_m <= circuit.section(waypoint.position.section).length_m());
      for (const Crossing& c : crossings) {
        for (const CrossingSpan& span : c.spans)
          RC_ASSERT(span.section != waypoint.position.section || waypoint.position.s_m < span.from_m ||
                    waypoint.position.s_m > span.to_m);
      }
    }
  }));
}

TEST(Waypoints, of_impossible_rules_are_errors_of_the_program) {
  EXPECT_DEATH(static_cast<void>(lay_waypoints(line(), {crossing(2, 0.0, 1.0)}, 0.5)), "span.section < circuit.size");
  constexpr const char* broken = "rules.spacing_m >= merge_m && rules.room_m >= 0.0";
  EXPECT_DEATH(static_cast<void>(lay_waypoints(line(), {}, 0.019)), broken);
  EXPECT_DEATH(static_cast<void>(lay_waypoints(line(), {}, 0.5, -0.01)), broken);
  EXPECT_EQ(lay_waypoints(line(), {}, 0.5, 0.0).size(), 5U);
}

}  // namespace
}  // namespace cosiva::zone
