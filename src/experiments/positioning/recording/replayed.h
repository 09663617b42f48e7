#pragma once

#include <optional>

#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/trial.h"
#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments {

struct ReplayOptions {
  /// The truth is interpolated between two of its stamps no further apart than this.
  double gap_s{0.5};
  double start_sigma_m{0.05};            ///< of the start, which is the truth's first place
  double start_heading_sigma_rad{0.05};  ///< of its heading, where the truth has one
};
/// The recording as a trial, with the sensors' figures that came with it, or else what can be told without its truth:
/// odometry is cut where something was read between, and every step's end is a moment. Fails
/// ("recording.overlap") where truth and odometry share no time, ("recording.beacon") on a beacon that nobody surveyed.
[[nodiscard]] Result<Trial> replayed(const Recording& recording, const ReplayOptions& options = {});

/// σ of single ranges, told by how far each is from the line between its neighbours of the same station; needs no
/// truth. Nothing for too few.
[[nodiscard]] std::optional<double> range_noise_m(const Recording& recording);

}  // namespace cosiva::experiments
