// The traffic zone is switched repeatedly while a fleet drives, over many seeds: no vehicles ever touch, no twin is
// lost, and every vehicle that is not off-route drives on.
//
//   switch_soak FROM.toml TO.toml [seeds=12] [aivs=12] [switches=10] [loss=0] [first_seed=1] [workers=2]
//
// 400 seeds with COSIVA_LONG=1. Each seed is one run of the whole platform in virtual time; a vehicle is commanded to
// drive slowly just before each switch, all are restarted after it, and the next one comes 1 to 10 s later, at a time
// drawn from the seed. A line for each seed that fails, and one for all with a digest of every run; exit 1 when any
// failed, 2 on bad usage.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/runs/world/world.h"
#include "e2e/soak.h"

namespace {

using namespace cosiva;
using namespace std::chrono_literals;

struct Plan {
  std::vector<zone::ZoneConfiguration> zones;  ///< in turn
  std::uint64_t seeds{12};
  std::uint32_t aivs{12};
  std::uint32_t switches{10};
  double loss{0.0};
  std::uint64_t first_seed{1};
  unsigned workers{2};
};

void switch_to(experiments::World& world, const zone::ZoneConfiguration& zone) {
  JsonWriter json;
  json.begin_object().field("command", "switch").key("zone");
  write_json(json, zone);
  json.end_object();
  world.command_server(json.take());
}

std::string collisions_of(const experiments::World& world) {
  std::string text;
  for (const auto& collision : world.plant().collisions())
    text += "\n  " + to_iso8601(collision.at) + " " + collision.a + " touches " + collision.b;
  return text;
}

/// The vehicles that are stopped after a minute without further switches, and are not off-route.
std::string left_stopped(experiments::World& world) {
  world.run_for(60s);
  std::vector<double> before_m;
  for (const auto& vehicle : world.plant().vehicles()) before_m.push_back(vehicle.distance_m);
  world.run_for(60s);
  std::string text;
  const auto shot = JsonValue::parse(world.server().snapshot_json(), std::size_t{1} << 24U);
  for (const JsonValue& aiv : *shot->find("aivs")->array()) {
    const auto v = static_cast<std::size_t>(*aiv.number("number")) - 1;
    if (world.plant().vehicles()[v].distance_m - before_m[v] < 1.0 && !aiv.text("offRoute"))
      text += "\n  " + *aiv.text("id") + " is stopped, waits for " + aiv.text("waitsFor").value_or("no vehicle");
  }
  return text;
}

struct Outcome {
  std::string wrong;  ///< empty: no failure
  std::uint64_t digest{};
};

Outcome run(const Plan& plan, std::uint64_t seed) {
  experiments::WorldOptions options;
  options.zone = plan.zones[0];
  options.aivs = plan.aivs;
  options.seed = seed;
  options.network.loss = plan.loss;
  auto made = experiments::World::make(std::move(options));
  if (!made) return {to_string(made.error()), 0};
  experiments::World& world = **made;
  Random moments{seed, "switches"};
  world.run_for(from_seconds(moments.uniform(5.0, 15.0)));
  for (std::uint32_t i = 0; i < plan.switches; ++i) {
    world.command_server(R"({"command":"slow","vehicle":"CoSiVA/AIV)" + std::to_string(1 + i % plan.aivs) + R"("})");
    switch_to(world, plan.zones[(i + 1) % plan.zones.size()]);
    world.run_for(500ms);
    world.command_server(R"({"command":"restart","vehicle":"*"})");
    world.run_for(from_seconds(moments.uniform(0.5, 9.5)));
    if (!world.plant().collisions().empty())
      return {"after switch " + std::to_string(i + 1) + collisions_of(world), world.digest().value()};
  }
  const std::string stopped = left_stopped(world);
  return {collisions_of(world) + stopped, world.digest().value()};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr,
                 "usage: switch_soak FROM.toml TO.toml [seeds] [aivs] [switches] [loss] [first_seed] [workers]\n");
    return 2;
  }
  Plan plan;
  plan.zones = {soak::toml_zone(argv[1]), soak::toml_zone(argv[2])};
  if (soak::wanted_whole()) plan.seeds = 400;
  if (argc > 3) plan.seeds = std::strtoull(argv[3], nullptr, 10);
  if (argc > 4) plan.aivs = static_cast<std::uint32_t>(std::strtoul(argv[4], nullptr, 10));
  if (argc > 5) plan.switches = static_cast<std::uint32_t>(std::strtoul(argv[5], nullptr, 10));
  if (argc > 6) plan.loss = std::strtod(argv[6], nullptr);
  if (argc > 7) plan.first_seed = std::strtoull(argv[7], nullptr, 10);
  if (argc > 8) plan.workers = static_cast<unsigned>(std::strtoul(argv[8], nullptr, 10));

  std::uint64_t failed = 0;
  std::vector<std::uint64_t> digests(plan.seeds);
  std::mutex print;
  soak::each(plan.seeds, plan.workers, [&](std::uint64_t i) {
    const std::uint64_t seed = plan.first_seed + i;
    const Outcome outcome = run(plan, seed);
    digests[i] = outcome.digest;
    if (outcome.wrong.empty()) return;
    const std::scoped_lock lock{print};
    ++failed;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), outcome.wrong.c_str());
    std::fflush(stdout);
  });
  Digest all;
  for (const std::uint64_t digest : digests) all.add(digest);
  std::printf("%llu seeds x %u AIVs x %u switches, %.0f %% loss: %llu failed, digest %s\n",
              static_cast<unsigned long long>(plan.seeds), plan.aivs, plan.switches, plan.loss * 100.0,
              static_cast<unsigned long long>(failed), all.hex().c_str());
  return failed == 0 ? 0 : 1;
}
