#pragma once

#include <optional>

#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/trial.h"
#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments {

struct ReplayOptions {
  /// Greatest distance of two stamps between which the ground truth is interpolated.
  double gap_s{0.5};
  double start_sigma_m{0.05};            ///< of the start, which is the first position of the ground truth
  double start_heading_sigma_rad{0.05};  ///< of its heading, where the ground truth has one
};
/// Converts the recording into a trial, with the sensor parameters of the recording, or else with those that can be
/// estimated without its ground truth: odometry is cut at measurements between its stamps, and every step's end is a
/// moment. Fails ("recording.overlap") where ground truth and odometry have no common time, ("recording.beacon") on a
/// beacon without surveyed position.
[[nodiscard]] Result<Trial> replayed(const Recording& recording, const ReplayOptions& options = {});

/// σ of single ranges, estimated from the distance of each range from the line between its neighbours of the same
/// station; needs no ground truth. Nothing for too few ranges.
[[nodiscard]] std::optional<double> range_noise_m(const Recording& recording);

}  // namespace cosiva::experiments
