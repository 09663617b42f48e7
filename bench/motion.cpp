// How many AIV moves (A30: travel, switch sections, one pose) one core makes per second, on a loop of straights, arcs
// and clothoids (goal: 50 million per second), and on sections of a kind that a program adds (5 million per second).
#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bench/ring.h"
#include "cosiva/aiv/motion/motion.h"
#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_shapes.h"

namespace {

using namespace cosiva;

struct Fleet {
  std::vector<aiv::AivMotion> aivs;
  std::vector<double> DTT_m;
  std::vector<Pose2> poses;
};

/// Vehicles all over the loop, each with a step of 0.5 to 4 cm: 0.1 to 0.8 m/s at 50 Hz, an end of section about every
/// 30 moves.
Fleet make_fleet(const zone::Circuit& circuit, std::size_t count) {
  Random random{1, "bench/motion"};
  Fleet fleet;
  for (std::size_t i = 0; i < count; ++i) {
    const auto section = static_cast<zone::SectionId>(random.below(circuit.size()));
    const double s_m = random.uniform(0.0, circuit.section(section).length_m());
    fleet.aivs.emplace_back(circuit, zone::TrackPosition{section, s_m});
    fleet.DTT_m.push_back(random.uniform(0.005, 0.04));
  }
  fleet.poses.resize(count);
  return fleet;
}

void BM_move_and_pose(benchmark::State& state) {
  const zone::Circuit circuit = fixture::mixed_loop();
  Fleet fleet = make_fleet(circuit, static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    aiv::move_all(circuit, fleet.aivs, fleet.DTT_m, fleet.poses);
    benchmark::DoNotOptimize(fleet.poses.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_move_and_pose)->Arg(12)->Arg(1'000)->Arg(100'000);

/// Two sine waves, there and back, joined by two half circles.
zone::Circuit sine_loop() {
  std::vector<zone::Circuit::Part> parts;
  Pose2 start;
  for (const char* name : {"there", "back"}) {
    parts.push_back({name, *zone::Section::make(start, zone::test::sine_shape(0.1, 1.5, 2.0)), std::nullopt, {}});
    parts.push_back({std::string(name) + " turn",
                     *zone::Section::make(parts.back().section.end(), 0.6 * pi, 1.0 / 0.6),
                     std::nullopt,
                     {}});
    start = parts.back().section.end();
  }
  for (zone::SectionId id = 0; id < parts.size(); ++id) parts[id].next = {(id + 1) % 4};
  return *zone::Circuit::make("sine", std::move(parts));
}

void BM_move_and_pose_of_a_user_s_kind(benchmark::State& state) {
  const zone::Circuit circuit = sine_loop();
  Fleet fleet;
  Random random{1, "sine"};
  for (int i = 0; i < 1'000; ++i) {
    fleet.aivs.emplace_back(circuit, zone::TrackPosition{i % 2 == 0 ? 0U : 2U, random.uniform(0.0, 3.0)});
    fleet.DTT_m.push_back(random.uniform(0.005, 0.04));
  }
  // Always on the waves: each round trip begins anew.
  const std::vector<aiv::AivMotion> before = fleet.aivs;
  fleet.poses.resize(fleet.aivs.size());
  for (auto _ : state) {
    fleet.aivs = before;
    aiv::move_all(circuit, fleet.aivs, fleet.DTT_m, fleet.poses);
    benchmark::DoNotOptimize(fleet.poses.back());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(fleet.aivs.size()));
}
BENCHMARK(BM_move_and_pose_of_a_user_s_kind);

void BM_move(benchmark::State& state) {
  const zone::Circuit circuit = fixture::mixed_loop();
  Fleet fleet = make_fleet(circuit, static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    aiv::move_all(circuit, fleet.aivs, fleet.DTT_m, {});
    benchmark::DoNotOptimize(fleet.aivs.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_move)->Arg(1'000);

/// A whole lap in one request: 16 sections switched in one move.
void BM_move_one_lap(benchmark::State& state) {
  const zone::Circuit circuit = fixture::mixed_loop();
  aiv::AivMotion motion{circuit, {0, 0.1}};
  const double lap_m = circuit.total_length_m();
  for (auto _ : state) benchmark::DoNotOptimize(motion.move(circuit, lap_m));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_move_one_lap);

}  // namespace
