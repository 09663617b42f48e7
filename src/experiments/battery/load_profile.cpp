#include "cosiva/experiments/battery/load_profile.h"

#include "cosiva/experiments/runs/world/fleet.h"

namespace cosiva::experiments {
namespace {

constexpr SimDuration step = std::chrono::milliseconds{100};

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

}  // namespace

double LoadProfile::mean_w() const { return mean_of(power_w); }
double LoadProfile::mean_mps() const { return mean_of(moved_m) / load_step_s; }

Result<std::vector<LoadProfile>> measure_loads(WorldOptions options, SimDuration warm_up, SimDuration length) {
  const std::uint32_t aivs = options.aivs;
  // The traces are not read.
  options.as_values = passes_values(options.seed);
  options.ground_truth = false;
  auto world = World::make(std::move(options));
  if (!world) return tl::unexpected(world.error());
  const SimTime latest = (*world)->now() + std::chrono::minutes{2};
  while (!fleet_is_complete((*world)->server(), aivs)) {
    if ((*world)->now() > latest) return fail("battery.fleet", "the fleet was not complete within two minutes");
    (*world)->run_for(step);
  }
  (*world)->run_for(warm_up);
  std::vector<LoadProfile> loads(aivs);
  std::vector<double> before_m;
  for (const auto& vehicle : (*world)->plant().vehicles()) before_m.push_back(vehicle.distance_m);
  for (SimDuration done{}; done < length; done += step) {
    (*world)->run_for(step);
    const auto vehicles = (*world)->plant().vehicles();
    for (std::size_t v = 0; v < aivs; ++v) {
      loads[v].power_w.push_back(vehicles[v].power.load_w);
      loads[v].moved_m.push_back(vehicles[v].distance_m - before_m[v]);
      before_m[v] = vehicles[v].distance_m;
    }
  }
  return loads;
}

}  // namespace cosiva::experiments
