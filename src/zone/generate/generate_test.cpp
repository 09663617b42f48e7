#include "cosiva/zone/generate/generate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

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
  EXPECT_THAT(message({.aisles = 0}), HasSubstr("aisles"));
  EXPECT_THAT(message({.rows = 1000, .aisles = 1000, .bays = 10}), HasSubstr("at most 200000"));
  EXPECT_THAT(message({.bay_ratio = 1.5}), HasSubstr("from 0 to 1"));
  EXPECT_THAT(message({.vehicle = {0.0, 0.1}}), HasSubstr("vehicle"));
  EXPECT_THAT(message({.name = "a\"b"}), HasSubstr("quotes"));
}

}  // namespace
}  // namespace cosiva::zone
