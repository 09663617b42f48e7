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

struct Plan : soak::Plan {  ///< begins in `zone`
  zone::ZoneConfiguration other;
  std::uint32_t switches{10};
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
  const auto before_m = soak::driven_m(world);
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
  std::uint64_t seed{};
  std::string failure;
  std::uint64_t digest{};
};

Outcome run(const Plan& plan, std::uint64_t seed) {
  auto made = soak::make_world(plan, seed);
  if (!made) return {seed, to_string(made.error()), 0};
  experiments::World& world = **made;
  Random moments{seed, "switches"};
  world.run_for(from_seconds(moments.uniform(5.0, 15.0)));
  for (std::uint32_t i = 0; i < plan.switches; ++i) {
    world.command_server(R"({"command":"slow","vehicle":"CoSiVA/AIV)" + std::to_string(1 + i % plan.aivs) + R"("})");
    switch_to(world, i % 2 == 0 ? plan.other : plan.zone);
    world.run_for(500ms);
    world.command_server(R"({"command":"restart","vehicle":"*"})");
    world.run_for(from_seconds(moments.uniform(0.5, 9.5)));
    if (!world.plant().collisions().empty())
      return {seed, "after switch " + std::to_string(i + 1) + collisions_of(world), world.digest().value()};
  }
  const std::string stopped = left_stopped(world);
  return {seed, collisions_of(world) + stopped, world.digest().value()};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr,
                 "usage: switch_soak FROM.toml TO.toml [seeds] [aivs] [switches] [loss] [first_seed] [workers]\n");
    return 2;
  }
  Plan plan;
  plan.zone = soak::toml_zone(argv[1]);
  plan.other = soak::toml_zone(argv[2]);
  plan.seeds = soak::wanted_whole() ? 400 : 12;
  soak::Arguments arguments{argc, argv, 3};
  arguments.take(plan.seeds);
  arguments.take(plan.aivs);
  arguments.take(plan.switches);
  arguments.take(plan.loss);
  arguments.take(plan.first_seed);
  arguments.take(plan.workers);

  const auto outcomes = soak::run_all(
      plan, [&](std::uint64_t seed) { return run(plan, seed); },
      [](const Outcome& outcome, std::size_t) {
        if (outcome.failure.empty()) return;
        std::printf("seed %llu: %s\n", static_cast<unsigned long long>(outcome.seed), outcome.failure.c_str());
        std::fflush(stdout);
      });
  std::uint64_t failed = 0;
  Digest all;
  for (const Outcome& outcome : outcomes) {
    failed += outcome.failure.empty() ? 0U : 1U;
    all.add(outcome.digest);
  }
  std::printf("%llu seeds x %u AIVs x %u switches, %.0f %% loss: %llu failed, digest %s\n",
              static_cast<unsigned long long>(plan.seeds), plan.aivs, plan.switches, plan.loss * 100.0,
              static_cast<unsigned long long>(failed), all.hex().c_str());
  return failed == 0 ? 0 : 1;
}
