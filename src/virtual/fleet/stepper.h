#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/base/workers.h"
#include "cosiva/virtual/fleet/crossing_grants.h"
#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/pose_writer.h"
#include "cosiva/virtual/fleet/section_changes.h"

namespace cosiva::virtual_side {

/// Makes steps: all vehicles perceive and decide, all move, and then the events are handled in the order of the
/// vehicles. Invariant: between steps all blocks have made the same number of steps.
class Stepper {
 public:
  /// @param rules  the rules of the agents' speed choice; none: the crisp ones
  /// @param vehicles  number of vehicles of the fleet
  Stepper(FleetTables& tables, CrossingGrants& grants, SectionChanges& changes, PoseWriter& poses,
          std::optional<FleetRules> rules, std::size_t vehicles);

  /// As Fleet::step().
  void step(Workers& workers, std::uint32_t steps);

 private:
  void step_block(Block& block);
  void step_in_parts(Workers& workers, Block& block);
  void record_gap(Block& block, double detected_m) const;
  void warm_up(Block& block);
  void gather_arrivals();

  const Numbers& numbers_;
  State& state_;
  std::vector<Copy>& copies_;
  std::vector<Block>& blocks_;
  std::vector<std::uint32_t>& arrived_;
  std::size_t& arrivals_;
  std::uint32_t& step_number_;
  const std::size_t& commanded_vehicles_;
  CrossingGrants& grants_;
  SectionChanges& changes_;
  PoseWriter& poses_;
  std::optional<FleetRules> rules_;  ///< none: the crisp ones
  std::vector<double> part_gap_m_;   ///< of each part of a large copy, in this step
};

}  // namespace cosiva::virtual_side
