#pragma once

#include <optional>

#include "cosiva/app/battery/battery_analyse_command.h"
#include "cosiva/app/battery/battery_discharge_command.h"
#include "cosiva/app/battery/battery_files_arguments.h"
#include "cosiva/app/battery/battery_fit_command.h"
#include "cosiva/app/battery/battery_plan_command.h"
#include "cosiva/app/battery/battery_ready_command.h"
#include "cosiva/app/battery/battery_test_arguments.h"
#include "cosiva/app/cli/options.h"

/// The options of `cosiva battery`.
namespace cosiva::app {

/// `cosiva battery` and its subcommands.
struct BatteryArguments {
  BatteryFitArguments fit;
  BatteryReadyArguments ready;
  BatteryTestArguments test;
  BatteryPlanArguments plan;
  BatteryAnalyseArguments analyse;
  BatteryDischargeArguments discharge;
  BatteryFilesArguments compare;
  BatteryFilesArguments check;
};

struct BatteryCommands {
  Command battery;
  Command sampled;
  Command fleet;
  Command fit;
  Command ready;
  Command plan;
  Command analyse;
  Command discharge;
  Command compare;
  Command check;
};

[[nodiscard]] BatteryCommands describe_battery(Command root, BatteryArguments& battery);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_battery_command(const BatteryCommands& commands, const BatteryArguments& battery);

}  // namespace cosiva::app
