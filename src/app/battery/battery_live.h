#pragma once

#include <vector>

#include "cosiva/app/battery/battery_test_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/battery/live_rig.h"

namespace cosiva::app {

/// Runs a test on the platform that `arguments.live` names, to its end or until somebody interrupts it (what runs then
/// is known to last longer). Its state is saved at each sample where there is a file for it, and taken up from there.
/// Fails where no broker answers, no vehicle speaks within a minute, or the state cannot be read or written.
[[nodiscard]] Result<std::vector<experiments::BatteryRun>> run_live(const BatteryTestArguments& arguments,
                                                                    experiments::LiveRigOptions options);

}  // namespace cosiva::app
