// Traffic without unresolved deadlocks: fleets in a control area with disturbances, over many seeds.
//
//   deadlock_soak ZONE.toml [seeds] [aivs=12] [minutes] [loss=0.05] [first_seed=1] [workers=2] [convoys=on]
//
// 100 seeds of 30 minutes with COSIVA_LONG=1, hours on a slow machine; without it 2 of 3. Each seed is one run of the
// whole platform in virtual time: messages are lost, vehicles are stopped and restarted, persons step in, some of them
// only virtual. At the end all disturbances are removed, and within a minute every vehicle must have driven on. A line
// for each seed, with the server's messages about its deadlocks, and a line for all; exit 1 when there was a collision,
// a deadlock that was not resolved, or a vehicle that did not drive on, 2 on bad usage.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "cosiva/experiments/runs/world/test_disturbance.h"
#include "cosiva/experiments/runs/world/world.h"
#include "e2e/soak.h"

namespace {

using namespace cosiva;
using experiments::testing::DeadlockMetrics;

struct Plan : soak::Plan {
  double minutes{3.0};
};

struct Outcome : soak::Outcome {
  std::vector<std::string> reported;  ///< by the server, about deadlocks
};

/// All disturbances are removed: every vehicle drives on.
void sync_time(experiments::World& world, Outcome& outcome) {
  world.run_for(std::chrono::seconds{15});
  const auto before_m = soak::driven_m(world);
  world.run_for(std::chrono::seconds{60});
  const auto after_m = soak::driven_m(world);
  for (std::size_t v = 0; v < after_m.size(); ++v)
    if (after_m[v] - before_m[v] < 1.0) outcome.fail("AIV" + std::to_string(v + 1) + " does not drive on");
}

Outcome run(const Plan& plan, std::uint64_t seed) {
  Outcome outcome;
  outcome.seed = seed;
  auto world = soak::make_world(plan, seed);
  if (!world) {
    outcome.failure = to_string(world.error());
    return outcome;
  }
  experiments::testing::Disturbance disturbance{**world, plan.zone, seed};
  for (double s = 0.0; s < plan.minutes * 60.0; s += 1.0) disturbance.second();
  disturbance.end();
  sync_time(**world, outcome);
  outcome.evaluate(**world);
  for (const auto& collision : (*world)->plant().collisions())
    outcome.reported.push_back("collision of " + collision.a + " and " + collision.b + " at " +
                               to_iso8601(collision.at));
  for (const std::string& line : (*world)->log())
    if (line.find("deadlock ") != std::string::npos) outcome.reported.push_back(line);
  return outcome;
}

void print_line(const Outcome& o, std::size_t done, const Plan& plan) {
  std::printf(
      "seed %llu: %.0f m driven (slowest %.0f m), %.0f cycles closed, %.0f deadlocks, %.0f resolved, longest %.1f s, "
      "longest wait %.1f s, digest %s (%zu of %llu)%s%s\n",
      static_cast<unsigned long long>(o.seed), o.distance_m, o.slowest_m, o.deadlocks.cycles, o.deadlocks.detected,
      o.deadlocks.resolved, o.deadlocks.longest_s, o.deadlocks.longest_wait_s, o.digest.c_str(), done,
      static_cast<unsigned long long>(plan.seeds), o.failure.empty() ? "" : "  FAILED: ", o.failure.c_str());
  for (const std::string& line : o.reported) std::printf("  %s\n", line.c_str());
  std::fflush(stdout);
}

int summarise(const Plan& plan, const std::vector<Outcome>& outcomes, double took_s) {
  std::size_t failed = 0;
  std::size_t collisions = 0;
  DeadlockMetrics all;
  for (const Outcome& outcome : outcomes) {
    failed += outcome.failure.empty() ? 0U : 1U;
    collisions += outcome.collisions;
    all.cycles += outcome.deadlocks.cycles;
    all.detected += outcome.deadlocks.detected;
    all.resolved += outcome.deadlocks.resolved;
    all.longest_s = std::max(all.longest_s, outcome.deadlocks.longest_s);
    all.longest_wait_s = std::max(all.longest_wait_s, outcome.deadlocks.longest_wait_s);
  }
  const double simulated_s = (plan.minutes * 60.0 + 75.0) * static_cast<double>(plan.seeds);
  std::printf(
      "%s: %llu seeds x %u AIVs x %.0f min, %.0f %% loss, convoys %s: %zu collisions, %.0f cycles closed, %.0f "
      "deadlocks, "
      "%.0f unresolved, longest deadlock %.1f s, longest wait %.1f s, %zu seeds failed, %.0f x real time\n",
      plan.zone.origin.c_str(), static_cast<unsigned long long>(plan.seeds), plan.aivs, plan.minutes, plan.loss * 100.0,
      plan.convoys ? "on" : "off", collisions, all.cycles, all.detected, all.detected - all.resolved, all.longest_s,
      all.longest_wait_s, failed, simulated_s / took_s);
  return failed == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr,
                 "usage: deadlock_soak ZONE.toml [seeds] [aivs] [minutes] [loss] [first_seed] [workers] [convoys]\n");
    return 2;
  }
  Plan plan;
  plan.zone = soak::toml_zone(argv[1]);
  plan.seeds = 2;
  plan.loss = 0.05;
  if (soak::wanted_whole()) {
    plan.seeds = 100;
    plan.minutes = 30.0;
  }
  soak::Arguments arguments{argc, argv, 2};
  arguments.take(plan.seeds);
  arguments.take(plan.aivs);
  arguments.take(plan.minutes);
  arguments.take(plan.loss);
  arguments.take(plan.first_seed);
  arguments.take(plan.workers);
  arguments.take(plan.convoys);

  const soak::Stopwatch stopwatch;
  const auto outcomes = soak::run_all(
      plan, [&](std::uint64_t seed) { return run(plan, seed); },
      [&](const Outcome& outcome, std::size_t done) { print_line(outcome, done, plan); });
  return summarise(plan, outcomes, stopwatch.seconds());
}
