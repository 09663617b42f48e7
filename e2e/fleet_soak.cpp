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
#include <cstdlib>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/runs/world/test_disturbance.h"
#include "cosiva/experiments/runs/world/world.h"
#include "e2e/soak.h"

namespace {

using namespace cosiva;

struct Plan {
  zone::ZoneConfiguration zone;
  std::uint64_t seeds{50};
  std::uint32_t aivs{12};
  double minutes{10.0};
  double loss{0.02};
  std::uint64_t first_seed{1};
  bool convoys{true};
  unsigned workers{std::max(1U, std::thread::hardware_concurrency())};
};

struct Outcome {
  std::uint64_t seed{};
  std::size_t collisions{};
  double longest_wait_s{};
  double distance_m{};
  double slowest_m{};
  double matched_ratio{};
  experiments::testing::DeadlockMetrics deadlocks;
  std::string digest;
  std::string failure;
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
  experiments::WorldOptions options;
  options.zone = plan.zone;
  options.aivs = plan.aivs;
  options.seed = seed;
  options.network.loss = plan.loss;
  options.server.convoys = plan.convoys;
  auto world = experiments::World::make(std::move(options));
  if (!world) {
    outcome.failure = to_string(world.error());
    return outcome;
  }
  const SimTime end = (*world)->now() + from_seconds(plan.minutes * 60.0);
  if (seed % 2 == 0) add_what_is_only_virtual(**world);
  (*world)->run_for(end - (*world)->now());
  outcome.digest = (*world)->digest().hex();
  outcome.collisions = (*world)->plant().collisions().size();
  const auto summary = JsonValue::parse((*world)->plant().summary_json());
  outcome.longest_wait_s = summary ? summary->number("longest_wait_s").value_or(1e9) : 1e9;
  JsonWriter json;
  (*world)->server().write_bijection(json);
  const auto bijection = JsonValue::parse(json.text());
  outcome.matched_ratio = bijection ? bijection->number("matched_ratio").value_or(0.0) : 0.0;
  outcome.slowest_m = 1e9;
  for (const auto& vehicle : (*world)->plant().vehicles()) {
    outcome.distance_m += vehicle.distance_m;
    outcome.slowest_m = std::min(outcome.slowest_m, vehicle.distance_m);
  }
  outcome.deadlocks = experiments::testing::deadlock_metrics(**world);
  if (outcome.deadlocks.open > 0.0) outcome.failure = "a deadlock is not resolved; ";
  if (outcome.collisions != 0) outcome.failure += std::to_string(outcome.collisions) + " collisions";
  if (outcome.longest_wait_s > longest_wait_allowed_s) {
    outcome.failure += (outcome.failure.empty() ? "" : ", ") + std::string("a vehicle waited ") +
                       std::to_string(outcome.longest_wait_s) + " s";
  }
  return outcome;
}

std::vector<Outcome> run_all(const Plan& plan) {
  std::vector<Outcome> outcomes(plan.seeds);
  std::mutex print;
  soak::each(plan.seeds, plan.workers, [&](std::uint64_t i) {
    outcomes[i] = run(plan, plan.first_seed + i);
    const std::scoped_lock lock{print};
    const Outcome& o = outcomes[i];
    std::printf(
        "seed %llu: %.0f m driven (slowest %.0f m), longest wait %.1f s, %.0f deadlocks, %.0f resolved, matched "
        "%.4f, "
        "digest %s%s%s\n",
        static_cast<unsigned long long>(o.seed), o.distance_m, o.slowest_m, o.longest_wait_s, o.deadlocks.detected,
        o.deadlocks.resolved, o.matched_ratio, o.digest.c_str(),
        o.failure.empty() ? "" : "  FAILED: ", o.failure.c_str());
    std::fflush(stdout);
  });
  return outcomes;
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
  if (argc > 2) plan.seeds = std::strtoull(argv[2], nullptr, 10);
  if (soak::wanted_whole()) plan.seeds = 50;
  if (argc > 3) plan.aivs = static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10));
  if (argc > 4) plan.minutes = std::strtod(argv[4], nullptr);
  if (argc > 5) plan.loss = std::strtod(argv[5], nullptr);
  if (argc > 6) plan.first_seed = std::strtoull(argv[6], nullptr, 10);
  if (argc > 7) plan.convoys = std::string_view{argv[7]} != "off";
  if (argc > 8) plan.workers = static_cast<unsigned>(std::strtoul(argv[8], nullptr, 10));

  const auto started = std::chrono::steady_clock::now();
  const std::vector<Outcome> outcomes = run_all(plan);
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
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
