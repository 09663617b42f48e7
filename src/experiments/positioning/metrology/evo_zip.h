#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/experiments/positioning/metrology/alignment.h"

namespace cosiva::experiments {

/// Writes the input of evo's evo_res: a zip with info.json, stats.json, error_array.npy and timestamps.npy,
/// uncompressed.
/// @param errors_m  of one run
/// @param alignment  that was applied before
[[nodiscard]] std::string evo_zip(std::string_view title, const std::vector<double>& times_s,
                                  const std::vector<double>& errors_m, Alignment alignment = Alignment::none);

}  // namespace cosiva::experiments
