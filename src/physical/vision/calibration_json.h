#pragma once

#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/calibration.h"

namespace cosiva::vision {

/// The file: JSON in the form that `docs/guide/gvs.md` defines. Reading fails ("gvs.calibration") with the field.
[[nodiscard]] std::string to_json(const Calibration& calibration);
[[nodiscard]] Result<Calibration> read_calibration(std::string_view text, const std::string& file);

}  // namespace cosiva::vision
