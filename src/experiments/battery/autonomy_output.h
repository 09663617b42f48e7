#pragma once

#include <span>
#include <string>

#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/virtual_rig.h"

namespace cosiva::experiments {

/// {"autonomy_s":{"mean","sd","ci95":[low,high],…},"batteries":[one for each record],…}
[[nodiscard]] std::string to_json(const AutonomyMetrics& metrics, std::span<const BatteryRun> records,
                                  std::span<const TrueEnd> ground_truth);
/// Text for a terminal.
[[nodiscard]] std::string to_text(const AutonomyMetrics& metrics, std::span<const BatteryRun> records);
/// All records' curves with the Battery Data Format's columns, + charges.
[[nodiscard]] std::string to_csv(std::span<const BatteryRun> records);

/// "0.0123", and "< 0.0001" for smaller values: no probability is zero.
[[nodiscard]] std::string chance_text(double p);

}  // namespace cosiva::experiments
