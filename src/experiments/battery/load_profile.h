#pragma once

#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// The load of one vehicle, ten times per second, while the whole platform drove: power [W] and distance [m] in each
/// step.
struct LoadProfile {
  std::vector<double> power_w;
  std::vector<double> moved_m;
  /// Mean over all steps [W].
  [[nodiscard]] double mean_w() const;
  /// Mean speed [m/s].
  [[nodiscard]] double mean_mps() const;
};
/// Duration of one step of a profile.
inline constexpr double load_step_s = 0.1;

/// Lets a world drive and records each vehicle's load, `warm_up` after its fleet is complete. Fails where the fleet is
/// not complete in two minutes.
[[nodiscard]] Result<std::vector<LoadProfile>> measure_loads(WorldOptions options, SimDuration warm_up,
                                                             SimDuration length);

}  // namespace cosiva::experiments
