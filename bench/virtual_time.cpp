// How much faster than real time the whole platform runs in one process: plant, boards, on-board programs, network,
// server, simulator. Goal: 12 AIVs at 1 000 times real time on one core, which is 83 µs for a vehicle's second; 500
// times at least. Every component has the live platform's own cycle, so that figures compare: `World` has another,
// coarser one (WorldOptions::cycle), which this program does not use.
// Also the cost of a snapshot of the server at the end of the run.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

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
  bool texts{false};
  std::uint32_t hosted{0};
  std::uint32_t snapshots{0};
  std::size_t traces_max{virtual_side::ServerOptions{}.traces_max};
  bool json{false};
};

double cpu_ms_since(std::clock_t start) { return 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC; }

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values.empty() ? 0.0 : values[values.size() / 2];
}

/// Makes snapshots of the server, and has fresh servers continue from them.
bool measure_snapshots(const experiments::World& world, const virtual_side::ServerOptions& server_options,
                       const Options& options) {
  std::vector<double> made_ms;
  std::vector<double> continued_ms;
  std::size_t bytes = 0;
  for (std::uint32_t i = 0; i < options.snapshots; ++i) {
    std::clock_t start = std::clock();
    const auto snapshot = world.server().snapshot();
    made_ms.push_back(cpu_ms_since(start));
    virtual_side::ServerCore server{server_options};
    start = std::clock();
    const auto continued = snapshot ? server.continue_from(*snapshot) : tl::unexpected(snapshot.error());
    continued_ms.push_back(cpu_ms_since(start));
    if (!continued) {
      std::fprintf(stderr, "virtual_time: %s\n", to_string(continued.error()).c_str());
      return false;
    }
    bytes = snapshot->size();
  }
  const char* format = options.json ? "{\"hosted\":%u,\"snapshot_bytes\":%zu,\"made_ms\":%.3f,\"continued_ms\":%.3f}\n"
                                    : "snapshot with %u virtual AIVs: %zu bytes, made in %.3f ms, continued from in "
                                      "%.3f ms of processor time (medians)\n";
  if (options.snapshots > 0) std::printf(format, options.hosted, bytes, median(made_ms), median(continued_ms));
  return true;
}

int measure(const Options& options) {
  std::ifstream file{options.zone, std::ios::binary};
  experiments::WorldOptions world_options;
  world_options.zone = {"toml", options.zone, {std::istreambuf_iterator<char>{file}, {}}};
  world_options.aivs = options.aivs;
  world_options.seed = options.seed;
  world_options.as_values = !options.texts && experiments::passes_values(options.seed);
  world_options.ground_truth = !world_options.as_values;
  world_options.server.traces_max = options.traces_max;
  virtual_side::ServerOptions server_options = world_options.server;
  server_options.as_values = world_options.as_values;
  server_options.cycle = world_options.cycle.value_or(server_options.cycle);
  auto world = experiments::World::make(std::move(world_options));
  if (!world) {
    std::fprintf(stderr, "virtual_time: %s\n", to_string(world.error()).c_str());
    return 2;
  }
  if (options.hosted > 0) (*world)->run_for(std::chrono::seconds{2});
  for (std::uint32_t i = 0; i < options.hosted; ++i)
    (*world)->command_server(R"({"command":"add","virtualObject":{"kind":"aiv"}})");
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu_start = std::clock();
  (*world)->run_for(from_seconds(options.duration_s));
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;

  // By processor time: the whole platform runs on one core, and other load on the machine must not count.
  const double factor = options.duration_s / cpu_s;
  const double vehicle_second_us = 1e6 * cpu_s / (options.duration_s * options.aivs);
  double driven_m = 0.0;
  for (const auto& vehicle : (*world)->plant().vehicles()) driven_m += vehicle.distance_m;
  const std::size_t collisions = (*world)->plant().collisions().size();
  const std::uint64_t messages = (*world)->network().counters().delivered;
  const std::string digest = (*world)->digest().hex();
  const std::string estimates = (*world)->estimates().hex();
  const char* format = options.json ? "{\"aivs\":%u,\"simulated_s\":%.3f,\"cpu_s\":%.4f,\"wall_s\":%.4f,\"real_time_"
                                      "factor\":%.1f,\"vehicle_second_us\":%.2f,\"messages\":%llu,"
                                      "\"driven_m\":%.1f,\"collisions\":%zu,\"digest\":\"%s\",\"estimates\":\"%s\"}\n"
                                    : "%u AIVs, %.0f s simulated in %.2f s of one core (%.2f s by the wall): %.0f "
                                      "times real time, %.1f us for a vehicle's second; %llu messages delivered, %.1f "
                                      "m driven, %zu collisions, digest %s, estimates %s\n";
  std::printf(format, options.aivs, options.duration_s, cpu_s, wall_s, factor, vehicle_second_us,
              static_cast<unsigned long long>(messages), driven_m, collisions, digest.c_str(), estimates.c_str());
  if (!measure_snapshots(**world, server_options, options)) return 2;
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
  command.add_flag(
      "--texts", options.texts,
      "Messages and frames are passed on as texts and bytes, as with one seed in ten, instead of as values");
  command.add_option("--hosted", options.hosted, "Virtual AIVs in the server").show_default().in_range(0, 64);
  command.add_option("--snapshots", options.snapshots, "Snapshots of the server at the end, to be measured")
      .show_default();
  command.add_option("--traces", options.traces_max, "Traces that the server stores").show_default();
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
