#pragma once

#include "cosiva/app/battery/battery_files_arguments.h"

namespace cosiva::app {

/// `cosiva battery check`: whether files are battery types, and what is wrong with them. Gives the exit status: 0 done,
/// 1 the run's own checks failed, 2 bad usage or bad input.
int run_battery_check(const BatteryFilesArguments& arguments);

}  // namespace cosiva::app
