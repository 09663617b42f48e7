#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/leaders.h"
#include "cosiva/virtual/fleet/path_survey.h"
#include "cosiva/virtual/fleet/presence.h"

namespace cosiva::virtual_side {

/// Puts a fleet's vehicles into its zone before the first step. Invariant: the blocks contain every vehicle once, in
/// order.
class Placement {
 public:
  Placement(FleetTables& tables, Leaders& leaders, PathSurvey& survey, Presence& presence);

  /// Fails ("fleet.start") as described at Fleet::make().
  [[nodiscard]] Result<void> put(std::span<const FleetStart> starts);

 private:
  void lay_blocks();
  [[nodiscard]] Result<void> line_up();

  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  std::vector<Copy>& copies_;
  std::vector<std::uint32_t>& front_;
  std::vector<std::uint32_t>& rear_;
  std::vector<CrossingState>& crossings_;
  std::vector<Block>& blocks_;
  std::vector<std::uint32_t>& arrived_;
  std::size_t& commanded_vehicles_;
  Leaders& leaders_;
  PathSurvey& survey_;
  Presence& presence_;
};

}  // namespace cosiva::virtual_side
