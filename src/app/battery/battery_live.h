#pragma once

#include <vector>

#include "cosiva/app/battery/battery_test_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/battery/live_rig.h"

namespace cosiva::app {

/// Runs a test on the platform that `arguments.live` names, to its end or until the operator interrupts it (running
/// batteries are then booked as lasting longer). The state is saved at each sample where a state file is given, and the
/// test continues from it. Fails where no broker responds, no vehicle reports within a minute, or the state cannot be
/// read or written.
[[nodiscard]] Result<std::vector<experiments::BatteryRun>> run_live(const BatteryTestArguments& arguments,
                                                                    experiments::LiveRigOptions options);

}  // namespace cosiva::app
