#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "cosiva/app/battery/battery_analyse_command.h"
#include "cosiva/app/battery/battery_discharge_command.h"
#include "cosiva/app/battery/battery_files_arguments.h"
#include "cosiva/app/battery/battery_fit_command.h"
#include "cosiva/app/battery/battery_plan_command.h"
#include "cosiva/app/battery/battery_ready_command.h"
#include "cosiva/app/battery/battery_test_arguments.h"

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
  CLI::App* battery;
  CLI::App* sampled;
  CLI::App* fleet;
  CLI::App* fit;
  CLI::App* ready;
  CLI::App* plan;
  CLI::App* analyse;
  CLI::App* discharge;
  CLI::App* compare;
  CLI::App* check;
};

[[nodiscard]] BatteryCommands describe_battery(CLI::App& root, BatteryArguments& battery);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_battery_command(const BatteryCommands& commands, const BatteryArguments& battery);

}  // namespace cosiva::app
