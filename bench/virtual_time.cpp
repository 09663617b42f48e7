// How much faster than real time the whole platform runs in one process: plant, boards, on-board programs, network,
// server, simulator. Goal: 12 AIVs at 500 times real time on one core.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>

#include "cosiva/app/cli/options.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/runs/world/world.h"

namespace {

using namespace cosiva;

struct Options {
  std::string zone{source_dir() + "/zones/lacet4.toml"};
  std::uint32_t aivs{12};
  double duration_s{600.0};
  std::uint64_t seed{1};
  bool as_values{false};
  double hz{0.0};
  bool json{false};
};

int measure(const Options& options) {
  std::ifstream file{options.zone, std::ios::binary};
  experiments::WorldOptions world_options;
  world_options.zone = {"toml", options.zone, {std::istreambuf_iterator<char>{file}, {}}};
  world_options.aivs = options.aivs;
  world_options.seed = options.seed;
  world_options.as_values = options.as_values;
  world_options.ground_truth = !options.as_values;
  if (options.hz > 0.0) world_options.cycle = from_seconds(1.0 / options.hz);
  auto world = experiments::World::make(std::move(world_options));
  if (!world) {
    std::fprintf(stderr, "virtual_time: %s\n", to_string(world.error()).c_str());
    return 2;
  }
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
  (*world)->run_for(from_seconds(options.duration_s));
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;

  // By processor time: the whole platform runs on one core, and other load on the machine must not count.
  const double factor = options.duration_s / cpu_s;
  double driven_m = 0.0;
  for (const auto& vehicle : (*world)->plant().vehicles()) driven_m += vehicle.distance_m;
  const std::size_t collisions = (*world)->plant().collisions().size();
  const std::uint64_t messages = (*world)->network().counters().delivered;
  const std::string digest = (*world)->digest().hex();
  const char* format = options.json ? "{\"aivs\":%u,\"simulated_s\":%.3f,\"cpu_s\":%.4f,\"wall_s\":%.4f,\"real_time_"
                                      "factor\":%.1f,\"messages\":%llu,"
                                      "\"driven_m\":%.1f,\"collisions\":%zu,\"digest\":\"%s\"}\n"
                                    : "%u AIVs, %.0f s simulated in %.2f s of one core (%.2f s by the wall): %.0f "
                                      "times real time; %llu messages delivered, %.1f m driven, %zu "
                                      "collisions, digest %s\n";
  std::printf(format, options.aivs, options.duration_s, cpu_s, wall_s, factor,
              static_cast<unsigned long long>(messages), driven_m, collisions, digest.c_str());
  return collisions == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"Measures how much faster than real time a fleet runs in virtual time"};
  const cosiva::app::Command command = line.root();
  command.add_option("--zone", options.zone, "Zone file").show_default();
  command.add_option("--aivs", options.aivs, "Vehicles").show_default().in_range(1, 1000);
  command.add_option("--duration", options.duration_s, "Simulated seconds").show_default().positive();
  command.add_option("--seed", options.seed, "Seed of the run").show_default();
  command.add_option("--hz", options.hz, "Rate of every component, 10 to 50; 0: the live platform's own rates")
      .show_default()
      .in_range(0.0, 50.0);
  command.add_flag("--as-values", options.as_values, "Messages are passed on as values, without their texts");
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
