// The cost of an autonomy test with the whole platform in the loop (`cosiva battery fleet --whole`): plant, boards,
// on-board programs, network, server, simulator and procedure, in virtual time on one core, at the live platform's own
// cycle. Goal: 12 AIVs for ten hours in 40 s.
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "cosiva/app/cli/options.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/platform_rig.h"

namespace {

using namespace cosiva;

struct Options {
  std::string zone{source_dir() + "/zones/lacet4.toml"};
  std::uint32_t aivs{12};
  double scale{0.5};
  std::uint64_t seed{1};
  bool json{false};
};

experiments::WorldOptions world_options(const Options& options) {
  std::ifstream file{options.zone, std::ios::binary};
  experiments::WorldOptions world;
  world.zone = {"toml", options.zone, {std::istreambuf_iterator<char>{file}, {}}};
  world.aivs = options.aivs;
  world.seed = options.seed;
  return world;
}

experiments::VirtualRigOptions rig_options(const Options& options) {
  experiments::VirtualRigOptions rig;
  rig.procedure.vehicles = options.aivs;
  rig.procedure.floor = 0.0;
  rig.procedure.temperature_max_c = 60.0;
  rig.battery.type = *battery::shipped_type("lipo850");
  rig.battery.design = {2, 1, options.scale};
  rig.battery.gauge = battery::GaugeMethod::counter;
  rig.seed = options.seed;
  return rig;
}

int measure(const Options& options) {
  auto rig = experiments::PlatformRig::make(world_options(options), rig_options(options));
  if (!rig) {
    std::fprintf(stderr, "whole: %s\n", to_string(rig.error()).c_str());
    return 2;
  }
  const std::clock_t cpu_start = std::clock();
  const SimTime start = rig->now();
  while (!rig->done()) rig->step();
  const double cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  const double simulated_s = to_seconds(rig->now() - start);

  const auto metrics = experiments::analyse(rig->procedure().records(), options.aivs);
  double driven_m = 0.0;
  for (const auto& record : rig->procedure().records()) driven_m += record.distance_m;
  const std::size_t collisions = rig->world().plant().collisions().size();
  const double each_us = 1e6 * cpu_s / (simulated_s * options.aivs);
  constexpr double ten_hours_s = 36'000.0;
  const char* format =
      options.json ? "{\"aivs\":%u,\"simulated_s\":%.1f,\"cpu_s\":%.3f,\"vehicle_second_us\":%.2f,"
                     "\"ten_hours_s\":%.2f,\"autonomy_s\":%.2f,\"failed\":%zu,\"driven_m\":%.1f,\"collisions\":%zu}\n"
                   : "%u AIVs: %.0f s simulated in %.2f s of one core, %.1f us for a vehicle's second, %.1f s for ten "
                     "hours; autonomy %.2f s, %zu failed, %.1f m driven, %zu collisions\n";
  std::printf(format, options.aivs, simulated_s, cpu_s, each_us, cpu_s * ten_hours_s / simulated_s, metrics.at_s,
              metrics.failed, driven_m, collisions);
  return collisions == 0 && metrics.failed == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"Measures an autonomy test with the whole platform in the loop"};
  const cosiva::app::Command command = line.root();
  command.add_option("--zone", options.zone, "Zone file").show_default();
  command.add_option("--aivs", options.aivs, "Vehicles").show_default().in_range(1, 1000);
  command.add_option("--scale", options.scale, "Battery: two LiPo cells of 0.85 Ah times this; 5.2 last ten hours")
      .show_default()
      .in_range(0.01, 100.0);
  command.add_option("--seed", options.seed, "Seed of the run").show_default();
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
