#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/app/platform/up_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {

/// A run of the whole platform as requested by the command line and its scenario together, fully checked.
struct RunPlan {
  UpArguments arguments;  ///< zone, aivs, seed and duration are the scenario's, unless given on the command line
  std::string name;
  zone::Rtm rtm;
  std::optional<experiments::Scenario> scenario;
  std::string scenario_file;
  std::string zone_file;                 ///< where edits may be saved: the given file; empty for a ready zone
  std::optional<aiv::SpeedRules> rules;  ///< of all AIVs; nothing: the built-in ones
  std::vector<physical::VehicleEquipment> equipment{};
  /// The crossing units: those that a scenario adds later begin switched off.
  std::vector<experiments::WorldUnit> units{};
};

/// Fails on a scenario or a zone that is missing or bad, on a scenario that does not fit, on too many vehicles. Prints
/// each option of the command line that overrides the scenario.
[[nodiscard]] Result<RunPlan> plan_run(const UpArguments& arguments);

}  // namespace cosiva::app
