#pragma once

#include <optional>
#include <string>

#include "cosiva/experiments/positioning/metrology/reference_budget.h"
#include "cosiva/physical/vision/calibration.h"

/// The error budget of a camera's truth, from its calibration or from a file of its own.
namespace cosiva::app {

/// What a calibration does not know of itself.
struct CalibrationFiles {
  std::optional<double> tag_height_error_m;
  std::optional<double> mount_error_m;
  std::optional<vision::PoseResiduals> poses;
};

/// Part by part; what nobody has told stands there as not told.
/// @param file  that the calibration stands in, for the sources
[[nodiscard]] experiments::ReferenceBudget budget_of(const vision::Calibration& calibration, const std::string& file,
                                                     const CalibrationFiles& local_path);

/// A reference_budget.json or a calibration.json. Fails as their readers do, with the file.
[[nodiscard]] Result<experiments::ReferenceBudget> load_reference_budget(const std::string& file);

}  // namespace cosiva::app
