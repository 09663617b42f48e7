#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/battery/type.h"

namespace cosiva::app {

/// A shipped type by its name ("lipo850"), or one from a file ("mine.json").
[[nodiscard]] Result<battery::BatteryType> load_battery_type(const std::string& name_or_file);

/// A percentage from the command line, as a ratio. Fails ("battery.percent") outside 0 to 100, and between 0 and 1,
/// where a ratio was probably meant.
[[nodiscard]] Result<double> ratio_of_percent(double percent, const std::string& option);

}  // namespace cosiva::app
