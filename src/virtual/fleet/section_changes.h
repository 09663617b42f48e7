#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/crossing_grants.h"
#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/leaders.h"
#include "cosiva/virtual/fleet/path_survey.h"
#include "cosiva/virtual/fleet/paths.h"

namespace cosiva::virtual_side {

/// Handles the events of vehicles at the ends of sections, at stop lines and at goals. Invariant: after its events are
/// handled a vehicle is on its section, and the section has a successor if the vehicle drives beyond it.
class SectionChanges {
 public:
  SectionChanges(FleetTables& tables, const Paths& paths, Leaders& leaders, PathSurvey& survey, CrossingGrants& grants);

  /// Handles the events of vehicle i in this step.
  void handle_events(Block& block, std::uint32_t i);
  /// Vehicle i, at the end of its section, starts to turn on the spot towards the next one if a bend requires this.
  void begin_turn(std::uint32_t i);

 private:
  void switch_section(Block& block, std::uint32_t i);
  void move_across(Block& block, std::uint32_t i);
  void turn_on(std::uint32_t i);

  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  std::vector<std::uint32_t>& front_;
  std::vector<std::uint32_t>& rear_;
  std::vector<FleetTables::Route>& routes_;
  std::vector<std::uint32_t>& arrived_;
  const Paths& paths_;
  Leaders& leaders_;
  PathSurvey& survey_;
  CrossingGrants& grants_;
};

}  // namespace cosiva::virtual_side
