#pragma once

#include "cosiva/app/battery/battery_files_arguments.h"

namespace cosiva::app {

/// `cosiva battery compare`: compares the batteries of two results of battery tests. Gives the exit status: 0 done, 1
/// the run's own checks failed, 2 bad usage or bad input.
/// @param arguments  with two files
int run_battery_compare(const BatteryFilesArguments& arguments);

}  // namespace cosiva::app
