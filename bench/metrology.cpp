// Qualification of the arc-length filter in virtual time: runs of 100 m, simulated, estimated and evaluated, on one
// core.
#include <chrono>
#include <cstdio>
#include <ctime>

#include "bench/zones.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/zone/rtm/rtm.h"

namespace {

using namespace cosiva;

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  const cosiva::app::CommandLine line{"Times the qualification of position estimators"};
  const cosiva::app::Command command = line.root();
  std::size_t runs = 1000;
  double distance_m = 100.0;
  double rate_hz = 20.0;
  std::string algorithm = "arc_kalman";
  command.add_option("--runs", runs);
  command.add_option("--distance", distance_m);
  command.add_option("--rate", rate_hz, "odometry per second, at 0.5 m/s");
  command.add_option("--algorithm", algorithm);
  if (const auto status = line.parse(argc, argv)) return *status;

  experiments::Simulation simulation{fixture::lacet4_track()};
  simulation.distance_m = distance_m;
  simulation.odometry_hz = rate_hz;
  simulation.turns = !algorithm.starts_with("arc");
  const estimation::Registry registry;
  const auto registered = registry.find(algorithm);
  if (!registered) {
    std::fprintf(stderr, "%s\n", to_string(registered.error()).c_str());
    return 2;
  }
  const experiments::Candidate candidate{
      algorithm, "", (*registered)->backtracks,
      [&](const estimation::Setting& setting) { return registry.make(algorithm, setting); }};
  const double start_s = processor_s();
  const auto result =
      experiments::qualify({candidate}, runs,
                           [&](std::size_t index, experiments::Trial& room) -> Result<const experiments::Trial*> {
                             experiments::simulate(simulation, index + 1, room);
                             return &room;
                           },
                           {});
  const double took_s = processor_s() - start_s;
  if (!result || result->algorithms[0].failed) return 1;
  const experiments::Qualified& one = result->algorithms[0];
  std::printf("%zu runs of %.0f m, odometry at %.0f Hz, %s: %.3f s of one core\n", runs, distance_m, rate_hz,
              algorithm.c_str(), took_s);
  std::printf("rmse %.3f mm, limit %.3f mm, digest %s\n", 1e3 * one.rmse_m.value, 1e3 * one.limit_m.value_or(0.0),
              result->digest.hex().c_str());
  return 0;
}
