#pragma once

#include <optional>
#include <string>

#include "cosiva/experiments/positioning/metrology/reference_budget.h"
#include "cosiva/physical/vision/calibration.h"

/// The error budget of a camera's ground truth, from its calibration or from a file of its own.
namespace cosiva::app {

/// Inputs of the budget that a calibration does not contain.
struct CalibrationFiles {
  std::optional<double> tag_height_error_m;
  std::optional<double> mount_error_m;
  std::optional<vision::PoseResiduals> poses;
};

/// The budget part by part; an unknown part is listed as not given.
/// @param file  of the calibration, for the sources
[[nodiscard]] experiments::ReferenceBudget budget_of(const vision::Calibration& calibration, const std::string& file,
                                                     const CalibrationFiles& local_path);

/// Reads a reference_budget.json or a calibration.json. Fails as their readers do, with the file.
[[nodiscard]] Result<experiments::ReferenceBudget> load_reference_budget(const std::string& file);

}  // namespace cosiva::app
