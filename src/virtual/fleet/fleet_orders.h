#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/crossing_grants.h"
#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/leaders.h"
#include "cosiva/virtual/fleet/path_survey.h"
#include "cosiva/virtual/fleet/paths.h"
#include "cosiva/virtual/fleet/section_changes.h"

namespace cosiva::virtual_side {

/// Executes commands to vehicles while they drive. Invariant: a vehicle's route begins with the section that it is on.
class FleetOrders {
 public:
  FleetOrders(FleetTables& tables, const Paths& paths, Leaders& leaders, PathSurvey& survey, CrossingGrants& grants,
              SectionChanges& changes);

  /// As Fleet::send().
  [[nodiscard]] bool send(std::uint32_t i, std::span<const zone::SectionId> route, double goal_s_m);
  /// As Fleet::circulate().
  void circulate(std::uint32_t i);
  /// As Fleet::committed().
  std::span<const zone::SectionId> committed(std::uint32_t i);
  /// Vehicle i drives to this position on its path in any case.
  [[nodiscard]] double committed_m(std::uint32_t i) const;

 private:
  void take_route(std::uint32_t i, std::span<const zone::SectionId> route);
  void follow_anew(std::uint32_t i);

  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  std::vector<std::uint32_t>& front_;
  std::vector<FleetTables::Route>& routes_;
  std::size_t& commanded_vehicles_;
  const Paths& paths_;
  Leaders& leaders_;
  PathSurvey& survey_;
  CrossingGrants& grants_;
  SectionChanges& changes_;
  std::vector<zone::SectionId> committed_sections_;
};

}  // namespace cosiva::virtual_side
