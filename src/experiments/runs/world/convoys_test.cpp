// Convoys over the whole platform: several vehicles of the same direction pass a crossing together. Where convoys save
// time, throughput increases; elsewhere nothing changes; no vehicle starves and no vehicles collide (A3, A10).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/runs/world/test_disturbance.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

std::unique_ptr<World> fleet_of(std::uint32_t aivs, std::uint64_t seed, bool convoys, const char* zone = "lacet4",
                                double loss = 0.0) {
  WorldOptions options;
  options.zone = testing::zone_named(zone);
  options.aivs = aivs;
  options.seed = seed;
  options.network.loss = loss;
  options.rules.kind = aiv::SpeedRules::Kind::fuzzy;
  options.server.convoys = convoys;
  options.as_values = true;  // the same run, in less time
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value());
  return std::move(*world);
}

/// The convoys in the traces: "convoy of 2 through X1 and X4, behind CoSiVA/AIV1", with the receiver.
struct ConvoyTrace {
  std::string vehicle;
  std::string text;
};
std::vector<ConvoyTrace> convoy_traces(const World& world) {
  std::vector<ConvoyTrace> reported;
  const auto traces = JsonValue::parse(world.server().traces_json(0, 100'000), std::size_t{1} << 26U);
  for (const JsonValue& trace : *traces->find("traces")->array())
    if (trace.text("kind") == "convoy") reported.push_back({*trace.text("to"), *trace.text("content")});
  return reported;
}

struct Metrics {
  double laps_per_h{0.0};
  double slowest_m{1e9};
  double longest_wait_s{0.0};
};
/// The first ten seconds, while the fleet starts, do not count.
Metrics measure(std::uint32_t aivs, bool convoys) {
  constexpr int seeds = 3;
  constexpr double lap_m = 17.31;
  constexpr double took_h = seeds * 120.0 / 3600.0;
  Metrics metrics;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto world = fleet_of(aivs, seed, convoys);
    world->run_for(10s);
    std::vector<double> before_m;
    for (const auto& v : world->plant().vehicles()) before_m.push_back(v.distance_m);
    world->run_for(120s);
    EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << seed;
    EXPECT_EQ(convoy_traces(*world).empty(), !convoys || aivs < 8) << seed;
    for (const auto& v : world->plant().vehicles()) {
      const double driven_m = v.distance_m - before_m[v.number - 1];
      metrics.laps_per_h += driven_m / lap_m / took_h;
      metrics.slowest_m = std::min(metrics.slowest_m, driven_m);
    }
    metrics.longest_wait_s = std::max(metrics.longest_wait_s, testing::deadlock_metrics(*world).longest_wait_s);
  }
  return metrics;
}

/// Results for 4 to 20 AIVs are in docs/guide/agents.md.
TEST(ConvoysStatistics, increase_throughput_of_a_crowded_clover_without_starvation) {
  const Metrics with = measure(12, true);
  const Metrics without = measure(12, false);
  std::printf("12 AIVs: %.0f laps an hour with, %.0f without; longest wait %.1f s and %.1f s\n", with.laps_per_h,
              without.laps_per_h, with.longest_wait_s, without.longest_wait_s);
  EXPECT_GT(with.laps_per_h, 1.08 * without.laps_per_h);
  EXPECT_GT(with.slowest_m, without.slowest_m) << "not at the expense of one vehicle";
  EXPECT_LT(with.longest_wait_s, 10.0) << "no vehicle waits so long that no other may pass it";
}

/// Not equal to the last bit: with convoys a vehicle that must wait for a third one lets others pass (CloverTurns).
TEST(Convoys, change_nothing_without_close_followers) {
  const Metrics with = measure(4, true);
  const Metrics without = measure(4, false);
  EXPECT_GE(with.laps_per_h, without.laps_per_h);
  EXPECT_LE(with.laps_per_h, 1.02 * without.laps_per_h);
}

TEST(Convoys, are_explained_in_the_traces) {
  const auto world = fleet_of(12, 1, true);
  world->run_for(60s);
  const auto reported = convoy_traces(*world);
  ASSERT_FALSE(reported.empty());
  EXPECT_THAT(reported.front().text, ::testing::MatchesRegex("convoy of [23] through X[1-4] and X[1-4], behind "
                                                             "CoSiVA/AIV[0-9]+"));
}

TEST(ConvoysStatistics, wait_behind_a_vehicle_stopped_in_the_crossing_and_continue_with_it) {
  const auto world = fleet_of(12, 1, true);
  int stopped = 0;
  for (int i = 0; i < 600 && stopped < 5; ++i) {
    const std::size_t before = convoy_traces(*world).size();
    world->run_for(100ms);
    const auto reported = convoy_traces(*world);
    if (reported.size() == before) continue;
    const std::string leader = reported.back().text.substr(reported.back().text.rfind(' ') + 1);
    world->command_server(R"({"command":"stop","vehicle":")" + leader + "\"}");
    world->run_for(6s);
    EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << leader;
    world->command_server(R"({"command":"restart","vehicle":")" + leader + "\"}");
    world->run_for(4s);
    ++stopped;
  }
  EXPECT_EQ(stopped, 5);
  std::vector<double> before_m;
  for (const auto& v : world->plant().vehicles()) before_m.push_back(v.distance_m);
  world->run_for(40s);
  for (const auto& v : world->plant().vehicles()) EXPECT_GT(v.distance_m, before_m[v.number - 1] + 3.0) << v.number;
}

TEST(ConvoysStatistics, cause_no_collision_among_persons_stops_and_lost_messages) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const auto world = fleet_of(12, seed, true, "lacet4", 0.05);
    testing::Disturbance disturbance{*world, testing::zone_named("lacet4"), seed};
    for (int s = 0; s < 180; ++s) disturbance.second();
    disturbance.end();
    world->run_for(30s);
    EXPECT_FALSE(convoy_traces(*world).empty());
    EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << seed;
    EXPECT_EQ(testing::deadlock_metrics(*world).open, 0.0) << seed;
  }
}

TEST(Convoys, of_physical_and_virtual_AIVs_cause_no_collision) {
  const auto world = fleet_of(8, 3, true);
  world->run_for(5s);
  for (int i = 1; i <= 4; ++i) {
    world->command_server(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V)" + std::to_string(i) + "\"}}");
    world->run_for(5s);
  }
  world->run_for(90s);
  const auto reported = convoy_traces(*world);
  ASSERT_FALSE(reported.empty());
  for (const ConvoyTrace& one : reported) {
    if (one.vehicle.starts_with("CoSiVA.virtual")) continue;
    EXPECT_THAT(one.text, ::testing::Not(::testing::HasSubstr("CoSiVA.virtual")))
        << one.vehicle << " does not detect its leader";
  }
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(Convoys, give_the_same_digest_for_the_same_seed) {
  const auto run = [](bool convoys) {
    const auto world = fleet_of(12, 2, convoys);
    world->run_for(30s);
    return world->digest().hex();
  };
  EXPECT_EQ(run(true), run(true));
  EXPECT_NE(run(true), run(false));
}

}  // namespace
}  // namespace cosiva::experiments
