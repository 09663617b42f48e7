#pragma once

#include "cosiva/app/battery/battery_test_arguments.h"

namespace cosiva::app {

/// `cosiva battery sampled`: battery after battery on one vehicle. Gives the exit status: 0 done, 1 the run's own
/// checks failed, 2 bad usage or bad input.
int run_battery_sampled(const BatteryTestArguments& arguments);
/// `cosiva battery fleet`: a battery on each vehicle of a fleet. Gives the exit status as run_battery_sampled does.
int run_battery_fleet(const BatteryTestArguments& arguments);

}  // namespace cosiva::app
