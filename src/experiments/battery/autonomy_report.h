#pragma once

#include <optional>
#include <span>
#include <string>

#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/virtual_rig.h"

namespace cosiva::experiments {

/// What the report states besides the figures.
struct ReportMetadata {
  std::string type;
  std::string source;
  std::string licence;
  std::string command;            ///< that gives the same again
  std::string load;               ///< how the batteries were drained
  std::optional<double> floor{};  ///< nothing: as the source had it
};
/// One HTML page that needs nothing else.
/// The true ends are those of a test in virtual time; empty for other tests.
[[nodiscard]] std::string report_html(const AutonomyMetrics& metrics, std::span<const BatteryRun> records,
                                      std::span<const TrueEnd> ground_truth, const ReportMetadata& metadata);

}  // namespace cosiva::experiments
