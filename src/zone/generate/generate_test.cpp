#include "cosiva/zone/generate/generate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/check/check.h"
#include "cosiva/zone/generate/plant_size.h"
#include "cosiva/zone/routing/route.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;

TrafficZone zone_of(const PlantOptions& options) {
  const auto text = generate_plant(options);
  EXPECT_TRUE(text) << to_string(text.error());
  auto zone = testing::read_zone(*text);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}

/// Sections that can be reached from the first, or from which it can be reached.
template <typename Neighbours>
std::size_t reached(const Circuit& circuit, const Neighbours& neighbours) {
  std::vector<bool> detected(circuit.size(), false);
  std::vector<SectionId> waiting{0};
  detected[0] = true;
  std::size_t count = 0;
  while (!waiting.empty()) {
    const SectionId id = waiting.back();
    waiting.pop_back();
    ++count;
    for (const SectionId other : neighbours(id)) {
      if (detected[other]) continue;
      detected[other] = true;
      waiting.push_back(other);
    }
  }
  return count;
}

void expect_good(const TrafficZone& zone) {
  for (const Problem& problem : problems(zone)) ADD_FAILURE() << to_string(problem, zone);
  const Circuit& circuit = zone.circuit;
  EXPECT_EQ(reached(circuit, [&](SectionId id) { return circuit.next(id); }), circuit.size());
  EXPECT_EQ(reached(circuit, [&](SectionId id) { return circuit.previous(id); }), circuit.size());
  for (const Station& station : zone.stations) {
    EXPECT_TRUE(zone.may_stop(station.position)) << station.name;
    EXPECT_EQ(zone.crossing_at(station.position), nullptr) << station.name;
  }
  for (const Loop& loop : zone.loops) {
    for (std::size_t i = 0; i < loop.sections.size(); ++i) {
      const auto next = circuit.next(loop.sections[i]);
      EXPECT_NE(std::find(next.begin(), next.end(), loop.sections[(i + 1) % loop.sections.size()]), next.end());
    }
  }
}

TEST(GeneratedPlant, has_by_default_over_a_thousand_sections_and_all_of_them_can_be_driven) {
  const TrafficZone zone = zone_of({});
  EXPECT_GT(zone.circuit.size(), 1000U);
  expect_good(zone);
  EXPECT_EQ(zone.loops.size(), 4U);
  EXPECT_EQ(zone.starts.size(), 12U);
  EXPECT_EQ(zone.start_positions(12).size(), 12U);
  const auto chargers = std::count_if(zone.stations.begin(), zone.stations.end(),
                                      [](const Station& station) { return station.kind == StationKind::charger; });
  EXPECT_EQ(chargers, 8);
  EXPECT_GT(zone.stations.size(), 150U);
  EXPECT_GT(zone.tags.size(), 300U);
}

TEST(GeneratedPlant, has_sections_of_all_kinds_branches_and_merges) {
  const TrafficZone zone = zone_of({.rows = 2, .aisles = 2, .bays = 2});
  std::size_t kinds[3] = {0, 0, 0};
  std::size_t branches = 0;
  std::size_t merges = 0;
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    ++kinds[static_cast<std::size_t>(zone.circuit.section(id).kind())];
    branches += zone.circuit.next(id).size() > 1 ? 1U : 0U;
    merges += zone.circuit.previous(id).size() > 1 ? 1U : 0U;
  }
  for (const std::size_t count : kinds) EXPECT_GT(count, 10U);
  EXPECT_GT(branches, 10U);
  EXPECT_EQ(branches, merges);
}

TEST(GeneratedPlant, is_good_whatever_its_size_and_its_vehicle) {
  expect_good(zone_of({.rows = 1, .aisles = 1, .bays = 0}));
  expect_good(zone_of({.rows = 1, .aisles = 1, .bays = 1, .seed = 7}));
  expect_good(zone_of({.rows = 3, .aisles = 3, .bays = 2, .bay_ratio = 0.5, .seed = 3, .vehicle = {0.20, 0.12}}));
  expect_good(zone_of({.rows = 2, .aisles = 4, .bays = 3, .bay_ratio = 1.0, .seed = 4, .vehicle = {2.0, 1.5}}));
}

TEST(GeneratedPlant, is_the_same_for_the_same_options_and_another_for_another_seed) {
  EXPECT_EQ(*generate_plant({.seed = 5}), *generate_plant({.seed = 5}));
  EXPECT_NE(*generate_plant({.seed = 5}), *generate_plant({.seed = 6}));
}

TEST(GeneratedPlant, is_as_large_as_requested_and_not_much_larger) {
  for (const std::size_t sections : {1'000U, 20'000U, 100'000U, 170'000U}) {
    const auto text = generate_plant(plant_of_size(sections));
    ASSERT_TRUE(text) << to_string(text.error());
    std::size_t count = 0;
    for (std::size_t at = text->find("[[section]]"); at != std::string::npos; at = text->find("[[section]]", at + 1))
      ++count;
    EXPECT_GE(count, sections);
    EXPECT_LE(count, sections + sections / 5);
    EXPECT_LT(text->size(), std::size_t{64} << 20U);
  }
}

TEST(GeneratedPlant, routes_from_any_station_to_any_other) {
  const TrafficZone zone = zone_of({.rows = 2, .aisles = 3, .bays = 2});
  const Router router{zone};
  for (const Station& from : zone.stations) {
    for (const Station& to : zone.stations)
      EXPECT_TRUE(router.plan(from.position, to.position)) << from.name << to.name;
  }
  EXPECT_TRUE(std::ranges::all_of(router.goes_on_for_ever(), [](bool ever) { return ever; }));
}

TEST(GeneratedPlant, of_impossible_options_is_refused_with_the_reason) {
  const auto message = [](const PlantOptions& options) {
    const auto text = generate_plant(options);
    return text ? std::string("made") : text.error().message;
  };
  EXPECT_THAT(message({.rows = 0}), HasSubstr("1 to 1000 rows"));
  EXPECT_THAT(message({.rows = 1001}), HasSubstr("1 to 1000 rows"));
  EXPECT_THAT(message({.aisles = 0}), HasSubstr("1 to 10000 aisles"));
  EXPECT_THAT(message({.aisles = 10'001}), HasSubstr("1 to 10000 aisles"));
  EXPECT_THAT(message({.bays = 10'001}), HasSubstr("at most 10000 bays"));
  EXPECT_THAT(message({.rows = 1000, .aisles = 1000, .bays = 10}), HasSubstr("at most 200000"));
  // Each number is at its own limit, and only all of them together are too many.
  EXPECT_THAT(message({.rows = 1000, .aisles = 10'000, .bays = 10'000}), HasSubstr("these rows, aisles and bays"));
  // 1058 aisles of 26 bays: the smallest layout above the limit, 1058 · 7 · 27 + 42 sections.
  EXPECT_THAT(message({.rows = 1, .aisles = 1058, .bays = 26}), HasSubstr("may make 200004 sections"));
  for (const double ratio : {-0.01, 1.01, 1.5, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(message({.bay_ratio = ratio}), HasSubstr("from 0 to 1")) << ratio;
  for (const double size_m : {0.0, 0.049, 5.01, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(message({.vehicle = {size_m, 0.1}}), HasSubstr("0.05 to 5 m")) << size_m;
    EXPECT_THAT(message({.vehicle = {0.1, size_m}}), HasSubstr("0.05 to 5 m")) << size_m;
  }
  for (const std::string& name : {std::string("a\"b"), std::string("a\\b"), std::string("a\x1F"), std::string("a\x7F"),
                                  std::string(), std::string(65, 'a')})
    EXPECT_THAT(message({.name = name}), HasSubstr("quotes")) << name;
}

TEST(GeneratedPlant, is_made_at_the_limits_of_its_options) {
  const PlantOptions small{.rows = 1, .aisles = 1, .bays = 1};
  const auto made = [](const PlantOptions& options) { return generate_plant(options).has_value(); };
  for (const VehicleShape vehicle : {VehicleShape{0.05, 0.05}, VehicleShape{5.0, 5.0}}) {
    PlantOptions options = small;
    options.vehicle = vehicle;
    EXPECT_TRUE(made(options)) << vehicle.length_m;
  }
  for (const double ratio : {0.0, 1.0}) {
    PlantOptions options = small;
    options.bay_ratio = ratio;
    EXPECT_TRUE(made(options)) << ratio;
  }
  for (const std::string& name : {std::string(64, 'a'), std::string("a b"), std::string("Größe")}) {
    PlantOptions options = small;
    options.name = name;
    EXPECT_TRUE(made(options)) << name;
  }
}

// Geometry
// ------------------------------------------------------------------------------------------------------

/// A plant with every bay, in which sections are found by name. All lengths are in units of the vehicle: its length, or
/// its width with a fifth more, whichever is greater.
struct Laid {
  explicit Laid(const VehicleShape& vehicle)
      : zone{zone_of({.rows = 2, .aisles = 2, .bays = 2, .bay_ratio = 1.0, .vehicle = vehicle, .starts = 5})},
        unit_m{std::max(vehicle.length_m, 1.2 * vehicle.width_m)},
        bay_offset_m{vehicle.width_m + 0.10 + 0.4 * unit_m},
        radius_m{bay_offset_m / (2.0 - std::sqrt(2.0))},
        pitch_m{7.0 * unit_m + 2.0 * std::sqrt(2.0) * radius_m},
        turn_m{named("w1xi").start().x_m - named("w1xo").end().x_m} {}

  [[nodiscard]] SectionId id(const std::string& name) const {
    const auto found = zone.circuit.find(name);
    EXPECT_TRUE(found) << name;
    return found.value_or(0);
  }
  [[nodiscard]] const Section& named(const std::string& name) const { return zone.circuit.section(id(name)); }

  TrafficZone zone;
  double unit_m;
  double bay_offset_m;
  double radius_m;  ///< of the arcs into a bay: two of 45° make the offset, (2 − √2)·R
  double pitch_m;   ///< from bay to bay
  double turn_m;    ///< the room of a quarter turn along either lane
};

constexpr VehicleShape vehicles[] = {{1.0, 0.5}, {0.5, 1.0}, {0.20, 0.12}};
constexpr double near_m = 1e-5;       // numbers are written to a micrometre
constexpr double pose_near_m = 5e-5;  // and headings to a microradian, over tracks of up to 40 m

void expect_pose(const Pose2& pose, const Pose2& wanted, const std::string& what) {
  EXPECT_NEAR(pose.x_m, wanted.x_m, pose_near_m) << what;
  EXPECT_NEAR(pose.y_m, wanted.y_m, pose_near_m) << what;
  EXPECT_NEAR(wrap_angle(pose.heading_rad - wanted.heading_rad), 0.0, near_m) << what;
}

TEST(GeneratedPlant, has_its_aisles_lanes_and_connections_where_the_vehicle_needs_them) {
  for (const VehicleShape& vehicle : vehicles) {
    const Laid laid{vehicle};
    const double unit_m = laid.unit_m;
    const double turn_m = laid.turn_m;
    const double aisle_m = 2.0 * turn_m + 4.0 * unit_m + 2.0 * laid.pitch_m;
    const double gap_m = 3.4 * unit_m;
    const double cross_west_m = 4.0 * unit_m - turn_m;
    const double cross_east_m = 23.0 * unit_m + turn_m;
    const double west_m = cross_west_m - turn_m - 5.0 * unit_m;
    const double east_m = cross_east_m + turn_m + 5.0 * unit_m;
    for (const int row : {0, 1}) {
      const double bottom_m = row * (aisle_m + gap_m);
      const double top_m = bottom_m + aisle_m;
      const std::string suffix = std::to_string(row + 1);
      expect_pose(laid.named("t" + suffix + "l1").start(), {west_m + turn_m, top_m, 0.0}, "top lane");
      expect_pose(laid.named("b" + suffix + "l1").start(), {east_m - turn_m, bottom_m, pi}, "bottom lane");
      expect_pose(laid.named("w" + suffix + "c1").start(), {west_m, bottom_m + turn_m, 0.5 * pi}, "west end");
      expect_pose(laid.named("w" + suffix + "c1").end(), {west_m, top_m - turn_m, 0.5 * pi}, "west end");
      expect_pose(laid.named("e" + suffix + "c1").start(), {east_m, top_m - turn_m, -0.5 * pi}, "east end");
      expect_pose(laid.named("e" + suffix + "c3").end(), {east_m, bottom_m + turn_m, -0.5 * pi}, "east end");
      // The first aisle of each row leads north, the second south.
      const std::string north = "a" + std::to_string(2 * row + 1);
      const std::string south = "a" + std::to_string(2 * row + 2);
      expect_pose(laid.named(north + "xi").start(), {9.0 * unit_m + turn_m, bottom_m, pi}, north);
      expect_pose(laid.named(north + "c1").start(), {9.0 * unit_m, bottom_m + turn_m, 0.5 * pi}, north);
      expect_pose(laid.named(north + "c3").end(), {9.0 * unit_m, top_m - turn_m, 0.5 * pi}, north);
      expect_pose(laid.named(north + "yo").end(), {9.0 * unit_m + turn_m, top_m, 0.0}, north);
      expect_pose(laid.named(south + "xi").start(), {18.0 * unit_m - turn_m, top_m, 0.0}, south);
      expect_pose(laid.named(south + "c1").start(), {18.0 * unit_m, top_m - turn_m, -0.5 * pi}, south);
      expect_pose(laid.named(south + "yo").end(), {18.0 * unit_m - turn_m, bottom_m, pi}, south);
    }
    // Half circles from row to row.
    const double upper_m = aisle_m + gap_m;
    expect_pose(laid.named("n1").start(), {cross_east_m, aisle_m, 0.0}, "n1");
    expect_pose(laid.named("n1").end(), {cross_east_m, upper_m, pi}, "n1");
    expect_pose(laid.named("s1").start(), {cross_west_m, upper_m, pi}, "s1");
    expect_pose(laid.named("s1").end(), {cross_west_m, aisle_m, 0.0}, "s1");
    EXPECT_NEAR(laid.named("n1").length_m(), 0.5 * pi * gap_m, near_m);
    EXPECT_EQ(laid.named("n1").kind(), SectionKind::arc);
    EXPECT_EQ(laid.zone.clearance_m, 0.10);
    EXPECT_NEAR(laid.zone.spacing_m, 2.0 * unit_m, near_m);
  }
}

TEST(GeneratedPlant, has_quarter_turns_of_two_clothoids) {
  for (const VehicleShape& vehicle : vehicles) {
    const Laid laid{vehicle};
    const double sharpest_per_m = 1.0 / (1.2 * laid.unit_m);
    for (const std::string turn : {"a1x", "a1y", "a2x", "e1y", "w2x"}) {
      const Section& in = laid.named(turn + "i");
      const Section& out = laid.named(turn + "o");
      EXPECT_EQ(in.kind(), SectionKind::clothoid);
      EXPECT_NEAR(in.curvature_at(0.0), 0.0, near_m);
      EXPECT_NEAR(in.curvature_at(in.length_m()), -sharpest_per_m, near_m);
      EXPECT_NEAR(out.curvature_at(0.0), -sharpest_per_m, near_m);
      EXPECT_NEAR(out.curvature_at(out.length_m()), 0.0, near_m);
      // Their mean curvature is half of the greatest: together they turn 90°.
      EXPECT_NEAR(in.length_m(), 0.5 * pi / sharpest_per_m, near_m);
      EXPECT_NEAR(out.length_m(), 0.5 * pi / sharpest_per_m, near_m);
      EXPECT_NEAR(wrap_angle(out.end().heading_rad - in.start().heading_rad), -0.5 * pi, 1e-4);
      // Loads tolerate 1 m/s² across, and no bend is faster than 0.6 m/s.
      const double speed_mps = std::min(0.6, std::floor(100.0 * std::sqrt(1.0 / sharpest_per_m)) / 100.0);
      EXPECT_NEAR(laid.zone.circuit.part(laid.id(turn + "i")).speed_mps_max.value_or(0.0), speed_mps, 1e-9);
      EXPECT_NEAR(laid.zone.circuit.part(laid.id(turn + "o")).speed_mps_max.value_or(0.0), speed_mps, 1e-9);
    }
    const double row_turn_mps = std::min(0.6, std::floor(100.0 * std::sqrt(1.7 * laid.unit_m)) / 100.0);
    EXPECT_NEAR(laid.zone.circuit.part(laid.id("n1")).speed_mps_max.value_or(0.0), row_turn_mps, 1e-9);
    EXPECT_FALSE(laid.zone.circuit.part(laid.id("a1c1")).speed_mps_max);
    EXPECT_FALSE(laid.zone.circuit.part(laid.id("t1l1")).speed_mps_max);
  }
}

TEST(GeneratedPlant, has_bays_next_to_its_aisles_with_the_station_in_their_centre) {
  for (const VehicleShape& vehicle : vehicles) {
    const Laid laid{vehicle};
    const double unit_m = laid.unit_m;
    std::size_t left_bays = 0;
    double shortest_m = 1e9;
    double longest_m = 0.0;
    for (const std::string strip : {"a1", "a2", "a3", "a4", "e1", "e2"}) {
      const Pose2& start = laid.named(strip + "c1").start();
      for (const int bay : {1, 2}) {
        const std::string name = strip + "b" + std::to_string(bay);
        const double at_m = 2.0 * unit_m + (bay - 1) * laid.pitch_m;
        expect_pose(laid.named(name).start(), start * Pose2{at_m, 0.0, 0.0}, name);
        expect_pose(laid.named(name + "p").start(), start * Pose2{at_m, 0.0, 0.0}, name);
        expect_pose(laid.named(name + "u").end(), laid.named(name).end(), name);
        const Section& stop = laid.named(name + "s");
        EXPECT_EQ(stop.kind(), SectionKind::straight);
        EXPECT_NEAR(laid.named(name).length_m(), stop.length_m() + 2.0 * std::sqrt(2.0) * laid.radius_m, near_m);
        const Pose2 offset = inverse(start) * stop.start();
        EXPECT_NEAR(std::fabs(offset.y_m), laid.bay_offset_m, pose_near_m);
        EXPECT_NEAR(offset.heading_rad, 0.0, near_m);
        const double side = offset.y_m > 0.0 ? 1.0 : -1.0;
        left_bays += side > 0.0 ? 1U : 0U;
        for (const auto& [suffix, turns] : {std::pair{"p", 1.0}, {"q", -1.0}, {"t", -1.0}, {"u", 1.0}}) {
          EXPECT_NEAR(laid.named(name + suffix).curvature_at(0.0), side * turns / laid.radius_m, 1e-4) << suffix;
          EXPECT_NEAR(laid.named(name + suffix).length_m(), 0.25 * pi * laid.radius_m, near_m) << suffix;
        }
        shortest_m = std::min(shortest_m, stop.length_m());
        longest_m = std::max(longest_m, stop.length_m());
        const bool charger = strip.front() == 'e';
        const Station* station = laid.zone.find_station((charger ? "charger " : "bay ") + name);
        ASSERT_NE(station, nullptr) << name;
        EXPECT_EQ(station->kind, charger ? StationKind::charger : StationKind::stop);
        EXPECT_EQ(station->position.section, laid.id(name + "s"));
        EXPECT_NEAR(station->position.s_m, 0.5 * stop.length_m(), near_m);
        EXPECT_EQ(laid.zone.circuit.part(laid.id(name + "s")).speed_mps_max, 0.4);
      }
    }
    EXPECT_EQ(laid.zone.stations.size(), 12U);
    EXPECT_GE(shortest_m, 3.5 * unit_m - near_m);
    EXPECT_LE(longest_m, 4.0 * unit_m + near_m);
    EXPECT_GT(longest_m - shortest_m, 0.1 * unit_m);
    EXPECT_GT(left_bays, 0U);
    EXPECT_LT(left_bays, 12U);
  }
}

TEST(GeneratedPlant, leads_from_every_aisle_past_each_bay_and_into_it) {
  const Laid laid{vehicles[0]};
  const auto successors = [&](const std::string& name) {
    std::vector<std::string> names;
    for (const SectionId after : laid.zone.circuit.next(laid.id(name)))
      names.push_back(laid.zone.circuit.part(after).name);
    return names;
  };
  using ::testing::ElementsAre;
  EXPECT_THAT(successors("a1xi"), ElementsAre("a1xo"));
  EXPECT_THAT(successors("a1xo"), ElementsAre("a1c1"));
  EXPECT_THAT(successors("a1c1"), ElementsAre("a1b1", "a1b1p"));
  EXPECT_THAT(successors("a1b1"), ElementsAre("a1c2"));
  EXPECT_THAT(successors("a1b1u"), ElementsAre("a1c2"));
  EXPECT_THAT(successors("a1c2"), ElementsAre("a1b2", "a1b2p"));
  EXPECT_THAT(successors("a1c3"), ElementsAre("a1yi"));
  // A lane goes on by default, and branches off at its aisles and at the connection to the next row.
  EXPECT_THAT(successors("b1l1"), ElementsAre("b1l2"));
  EXPECT_THAT(successors("b1l2"), ElementsAre("b1l3", "a1xi"));
  EXPECT_THAT(successors("b1l3"), ElementsAre("w1xi"));
  EXPECT_THAT(successors("a2yo"), ElementsAre("b1l2"));
  EXPECT_THAT(successors("n1"), ElementsAre("b2l2"));
  EXPECT_THAT(successors("s1"), ElementsAre("t1l2"));
  EXPECT_THAT(successors("w1yo"), ElementsAre("t1l1"));
  EXPECT_THAT(successors("e1yo"), ElementsAre("b1l1"));
  // The loop round a row passes along its lanes and bypasses the chargers.
  ASSERT_EQ(laid.zone.loops.size(), 2U);
  EXPECT_EQ(laid.zone.loops[0].name, "row 1");
  std::vector<std::string> round;
  for (const SectionId id : laid.zone.loops[0].sections) round.push_back(laid.zone.circuit.part(id).name);
  EXPECT_THAT(
      round, ElementsAre("b1l1", "b1l2", "b1l3", "w1xi", "w1xo", "w1c1", "w1yi", "w1yo", "t1l1", "t1l2", "t1l3", "t1l4",
                         "t1l5", "e1xi", "e1xo", "e1c1", "e1b1", "e1c2", "e1b2", "e1c3", "e1yi", "e1yo"));
}

TEST(GeneratedPlant, has_tags_evenly_along_every_section_that_is_long_enough) {
  for (const VehicleShape& vehicle : vehicles) {
    const Laid laid{vehicle};
    const double pitch_m = std::min(4.0, 4.0 * laid.unit_m);  // four fifths of the distance that the check tolerates
    std::vector<TrackPosition> wanted;
    for (SectionId id = 0; id < laid.zone.circuit.size(); ++id) {
      const double length_m = laid.zone.circuit.section(id).length_m();
      const int count = length_m < 0.25 * pitch_m ? 0 : static_cast<int>(std::ceil(length_m / pitch_m));
      for (int i = 0; i < count; ++i) wanted.push_back({id, (i + 0.5) * length_m / count});
    }
    ASSERT_EQ(laid.zone.tags.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      EXPECT_EQ(laid.zone.tags[i].number, i + 1);
      EXPECT_EQ(laid.zone.tags[i].position.section, wanted[i].section);
      EXPECT_NEAR(laid.zone.tags[i].position.s_m, wanted[i].s_m, near_m);
    }
  }
}

TEST(GeneratedPlant, starts_its_fleet_in_bays_all_over_the_layout) {
  const Laid laid{vehicles[0]};
  ASSERT_EQ(laid.zone.starts.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(laid.zone.starts[i], laid.zone.stations[i * 12 / 5].position);
  const TrafficZone full = zone_of({.rows = 1, .aisles = 1, .bays = 1, .bay_ratio = 1.0, .starts = 12});
  EXPECT_EQ(full.starts.size(), full.stations.size()) << "no more starts than bays";
}

TEST(GeneratedPlant, leaves_out_the_wanted_ratio_of_bays) {
  const auto bays = [](double ratio) {
    const TrafficZone zone = zone_of({.rows = 1, .aisles = 10, .bays = 20, .bay_ratio = ratio});
    return std::count_if(zone.stations.begin(), zone.stations.end(),
                         [](const Station& station) { return station.kind == StationKind::stop; });
  };
  EXPECT_EQ(bays(0.0), 0);
  EXPECT_EQ(bays(1.0), 200);
  // Four standard deviations of 200 draws at a quarter.
  EXPECT_NEAR(static_cast<double>(bays(0.25)), 50.0, 4.0 * std::sqrt(200 * 0.25 * 0.75));
}

TEST(GeneratedPlant, writes_the_start_of_a_section_only_where_it_does_not_continue_the_one_before) {
  const std::string text = *generate_plant({.rows = 1, .aisles = 1, .bays = 1, .bay_ratio = 1.0});
  const auto section = [&](const std::string& name) {
    const std::size_t at = text.find("[[section]]\nname = \"" + name + "\"\n");
    EXPECT_NE(at, std::string::npos) << name;
    return at == std::string::npos ? name : text.substr(at, text.find("\n\n", at) - at);
  };
  for (const char* continues : {"a1xo", "a1b1q", "a1b1s", "a1b1t", "a1b1u", "a1yo", "e1xo", "w1yo"})
    EXPECT_THAT(section(continues), ::testing::Not(HasSubstr("start = {"))) << continues;
  // The first section, those elsewhere, and the first into the bay, which is written after the section past the bay.
  for (const char* begins : {"a1xi", "e1xi", "w1xi", "a1b1p", "b1l1"})
    EXPECT_THAT(section(begins), HasSubstr("start = {")) << begins;
}

TEST(GeneratedPlant, begins_its_file_with_the_options_and_writes_numbers_to_a_micrometre) {
  const std::string text =
      *generate_plant({.name = "hangar", .rows = 2, .aisles = 3, .bays = 1, .seed = 9, .vehicle = {0.7, 0.33}});
  EXPECT_THAT(text, HasSubstr("# A synthetic plant: 2 rows of 3 aisles with up to 1 bays each, "));
  EXPECT_THAT(text, HasSubstr(" sections, seed 9.\n"));
  EXPECT_THAT(text, HasSubstr("name = \"hangar\""));
  EXPECT_THAT(text, HasSubstr("length_m = 0.7\nwidth_m = 0.33\n"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("= -0\n")));
  for (std::size_t at = text.find('.'); at != std::string::npos; at = text.find('.', at + 1)) {
    std::size_t digits = 0;
    while (at + 1 + digits < text.size() && std::isdigit(static_cast<unsigned char>(text[at + 1 + digits])) != 0)
      ++digits;
    ASSERT_LE(digits, 6U) << text.substr(at > 10 ? at - 10 : 0, 30);
  }
}

}  // namespace
}  // namespace cosiva::zone
