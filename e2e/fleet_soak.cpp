// The fleet with a lossy network, over many seeds: no collision, and no vehicle waits for ever.
//
//   fleet_soak ZONE.toml [seeds=50] [aivs=12] [minutes=10] [loss=0.02] [first_seed=1] [convoys=on] [workers=cores]
//
// Each seed is one run of the whole platform in virtual time; every second one also has three virtual AIVs among the
// physical ones, and two persons who walk across their paths. Prints a line per seed that fails and one for all; exit 1
// when one failed, 2 on bad usage. 50 seeds with COSIVA_LONG=1, whatever number is given.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/world/world.h"
#include "e2e/soak.h"

namespace {

using namespace cosiva;

struct Plan : soak::Plan {
  double minutes{10.0};
};

struct Outcome : soak::Outcome {
  double longest_wait_s{};
  double matched_ratio{};
};

constexpr double longest_wait_allowed_s = 60.0;

/// Across two loops, where no vehicle has to stop in a crossing for them.
constexpr const char* people[] = {
    R"({"command":"add","virtualObject":{"kind":"person","id":"P1","path":[[0.9,-0.9],[1.6,-1.6]],"speed":0.2,"repeat":"back and forth"}})",
    R"({"command":"add","virtualObject":{"kind":"person","id":"P2","path":[[-0.9,0.9],[-1.6,1.6]],"speed":0.15,"repeat":"back and forth"}})"};

void add_what_is_only_virtual(experiments::World& world) {
  world.run_for(std::chrono::seconds{10});
  for (const char* person : people) world.command_server(person);
  for (const char* id : {"V1", "V2", "V3"}) {
    world.command_server(std::string(R"({"command":"add","virtualObject":{"kind":"aiv","id":")") + id + "\"}}");
    world.run_for(std::chrono::seconds{5});
  }
}

Outcome run(const Plan& plan, std::uint64_t seed) {
  Outcome outcome;
  outcome.seed = seed;
  auto world = soak::make_world(plan, seed);
  if (!world) {
    outcome.failure = to_string(world.error());
    return outcome;
  }
  const SimTime end = (*world)->now() + from_seconds(plan.minutes * 60.0);
  if (seed % 2 == 0) add_what_is_only_virtual(**world);
  (*world)->run_for(end - (*world)->now());
  outcome.evaluate(**world);
  const auto summary = JsonValue::parse((*world)->plant().summary_json());
  outcome.longest_wait_s = summary ? summary->number("longest_wait_s").value_or(1e9) : 1e9;
  JsonWriter json;
  (*world)->server().write_bijection(json);
  const auto bijection = JsonValue::parse(json.text());
  outcome.matched_ratio = bijection ? bijection->number("matched_ratio").value_or(0.0) : 0.0;
  if (outcome.longest_wait_s > longest_wait_allowed_s)
    outcome.fail("a vehicle waited " + std::to_string(outcome.longest_wait_s) + " s");
  return outcome;
}

void print_line(const Outcome& o) {
  std::printf(
      "seed %llu: %.0f m driven (slowest %.0f m), longest wait %.1f s, %.0f deadlocks, %.0f resolved, matched %.4f, "
      "digest %s%s%s\n",
      static_cast<unsigned long long>(o.seed), o.distance_m, o.slowest_m, o.longest_wait_s, o.deadlocks.detected,
      o.deadlocks.resolved, o.matched_ratio, o.digest.c_str(),
      o.failure.empty() ? "" : "  FAILED: ", o.failure.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr,
                 "usage: fleet_soak ZONE.toml [seeds] [aivs] [minutes] [loss] [first_seed] [convoys] [workers]\n");
    return 2;
  }
  Plan plan;
  plan.zone = soak::toml_zone(argv[1]);
  plan.seeds = 50;
  plan.loss = 0.02;
  plan.workers = std::max(1U, std::thread::hardware_concurrency());
  soak::Arguments arguments{argc, argv, 2};
  arguments.take(plan.seeds);
  if (soak::wanted_whole()) plan.seeds = 50;
  arguments.take(plan.aivs);
  arguments.take(plan.minutes);
  arguments.take(plan.loss);
  arguments.take(plan.first_seed);
  arguments.take(plan.convoys);
  arguments.take(plan.workers);

  const soak::Stopwatch stopwatch;
  const auto outcomes = soak::run_all(
      plan, [&](std::uint64_t seed) { return run(plan, seed); },
      [](const Outcome& outcome, std::size_t) { print_line(outcome); });
  const double took_s = stopwatch.seconds();
  std::size_t failed = 0;
  std::size_t collisions = 0;
  double longest_wait_s = 0.0;
  double driven_m = 0.0;
  double unresolved = 0.0;
  for (const Outcome& outcome : outcomes) {
    failed += outcome.failure.empty() ? 0U : 1U;
    collisions += outcome.collisions;
    longest_wait_s = std::max(longest_wait_s, outcome.longest_wait_s);
    driven_m += outcome.distance_m;
    unresolved += outcome.deadlocks.detected - outcome.deadlocks.resolved;
  }
  const double simulated_s = plan.minutes * 60.0 * static_cast<double>(plan.seeds);
  std::printf(
      "%llu seeds x %u AIVs x %.0f min, %.0f %% loss, convoys %s: %zu collisions, %.0f deadlocks unresolved, %.0f m "
      "driven, longest wait %.1f s, %.0f x real time\n",
      static_cast<unsigned long long>(plan.seeds), plan.aivs, plan.minutes, plan.loss * 100.0,
      plan.convoys ? "on" : "off", collisions, unresolved, driven_m, longest_wait_s, simulated_s / took_s);
  return failed == 0 ? 0 : 1;
}
