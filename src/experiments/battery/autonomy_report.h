#pragma once

#include <optional>
#include <span>
#include <string>

#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/virtual_rig.h"

namespace cosiva::experiments {

/// Metadata of the report in addition to the metrics.
struct ReportMetadata {
  std::string type;
  std::string source;
  std::string licence;
  std::string command;            ///< reproduces the result
  std::string load;               ///< how the batteries were drained
  std::optional<double> floor{};  ///< nothing: as in the source
};
/// Writes one self-contained HTML page.
/// The true ends are those of a test in virtual time; empty for other tests.
[[nodiscard]] std::string report_html(const AutonomyMetrics& metrics, std::span<const BatteryRun> records,
                                      std::span<const TrueEnd> ground_truth, const ReportMetadata& metadata);

}  // namespace cosiva::experiments
