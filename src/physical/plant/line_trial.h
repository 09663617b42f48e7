#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {

/// One drive of an emulated vehicle with one line-tracking algorithm, alone on a zone's floor.
struct LineTrialOptions {
  std::string algorithm;  ///< one of line_tracking_names()
  double speed_mps{0.4};
  double distance_m{20.0};
  double line_offset_sd_m{0.0005};  ///< as PlantNoise
  std::uint64_t seed{1};            ///< of the line's unevenness
};

/// The true offset of the vehicle's centre from its path, left positive; not counted: the first 0.5 m.
struct LineTrial {
  std::vector<double> distance_m;  ///< since the start, about every centimetre
  std::vector<double> offset_m;    ///< there
  double rms_m{};
  double worst_m{};
  bool line_lost{false};  ///< the trial ended there
};

/// Fails where the algorithm is unknown, or the speed, the distance or the zone's path permits no trial.
[[nodiscard]] Result<LineTrial> run_line_trial(const zone::TrafficZone& zone, const LineTrialOptions& options);

/// The algorithms of the emulated PILS; the first is the usual one.
[[nodiscard]] std::vector<std::string> line_trackings();

}  // namespace cosiva::physical
