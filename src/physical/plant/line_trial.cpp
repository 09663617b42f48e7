#include "cosiva/physical/plant/line_trial.h"

#include <algorithm>
#include <cmath>

#include "cosiva/physical/boards/line_tracker.h"
#include "cosiva/physical/plant/vehicle_dynamics.h"

namespace cosiva::physical {
namespace {

constexpr double speed_mps_min = 0.02;
constexpr double speed_mps_max = 1.5;
constexpr double distance_m_min = 1.0;
constexpr double distance_m_max = 100'000.0;
constexpr double run_in_m = 0.5;
constexpr double step_s = 0.01;

Result<void> check(const LineTrialOptions& options) {
  if (std::ranges::count(line_tracking_names(), options.algorithm) == 0) {
    std::string names;
    for (const std::string& name : line_tracking_names()) names += (names.empty() ? "" : ", ") + name;
    return fail("line.algorithm", "expected one of " + names, options.algorithm);
  }
  if (!(options.speed_mps >= speed_mps_min && options.speed_mps <= speed_mps_max))
    return fail("line.speed", "expected a speed from 0.02 to 1.5 m/s", "speed");
  if (!(options.distance_m >= distance_m_min && options.distance_m <= distance_m_max))
    return fail("line.distance", "expected a distance from 1 to 100000 m", "distance");
  return {};
}

}  // namespace

std::vector<std::string> line_trackings() { return line_tracking_names(); }

Result<LineTrial> run_line_trial(const zone::TrafficZone& zone, const LineTrialOptions& options) {
  if (auto good = check(options); !good) return tl::unexpected(good.error());
  const auto starts = zone.start_positions(1);
  if (starts.empty()) return fail("line.zone", "zone '" + zone.name + "' has no position to start from");
  LineVehicle vehicle{zone.circuit, starts.front(), options.line_offset_sd_m, Random{options.seed, "line"}};
  LineTracker pils{options.algorithm};
  const DriveCommand command{options.speed_mps, 1.0, 1.0, 0};
  LineTrial trial;
  double driven_m = 0.0;
  double recorded_m = -1.0;
  double squares_m2 = 0.0;
  double counted_m = 0.0;
  // A vehicle at a crossing of sharp bends turns on the spot; a path that ends stops the vehicle.
  const double duration_s = 10.0 + 20.0 * options.distance_m / options.speed_mps;
  for (double t_s = 0.0; driven_m < options.distance_m && t_s < duration_s && !trial.line_lost; t_s += step_s) {
    vehicle.step(&command, pils, step_s);
    const double step_m = std::fabs(vehicle.step_distance_m());
    driven_m += step_m;
    trial.line_lost = vehicle.following() && pils.line_lost() && driven_m > run_in_m;
    if (driven_m < run_in_m || !vehicle.following()) continue;
    const double offset_m = vehicle.lateral_error_m();
    squares_m2 += offset_m * offset_m * step_m;
    counted_m += step_m;
    trial.worst_m = std::max(trial.worst_m, std::fabs(offset_m));
    if (driven_m - recorded_m < 0.01) continue;
    recorded_m = driven_m;
    trial.distance_m.push_back(driven_m);
    trial.offset_m.push_back(offset_m);
  }
  if (driven_m < options.distance_m && !trial.line_lost)
    return fail("line.zone", "the path of zone '" + zone.name + "' ends after " + std::to_string(driven_m) + " m");
  trial.rms_m = counted_m > 0.0 ? std::sqrt(squares_m2 / counted_m) : 0.0;
  return trial;
}

}  // namespace cosiva::physical
