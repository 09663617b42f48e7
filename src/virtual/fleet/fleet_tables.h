#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/virtual/fleet/ground.h"
#include "cosiva/virtual/fleet/passes.h"
#include "cosiva/virtual/fleet/state.h"

namespace cosiva::virtual_side {

/// The gap that a vehicle needs to the one ahead: its clearance, the distance after which a crossing counts as left,
/// and a margin for rounding.
inline constexpr double gap_needed_m = aiv::clearance_m + Ground::left_m + 0.01;

/// The data of a fleet: its zone, and an entry for each vehicle, section, crossing and copy. Positions along a
/// vehicle's path are counted as described at State.
struct FleetTables {
  FleetTables(Ground fleet_ground, const FleetOptions& fleet_options);

  struct Route {
    std::vector<zone::SectionId> sections;
    double goal_s_m;  ///< on the last section
  };

  Ground ground;
  FleetOptions options;
  Numbers numbers;
  State state;
  std::vector<Copy> copies;              ///< one more entry than copies
  std::vector<std::uint32_t> front;      ///< by copy and section: the farthest vehicle on it, or none
  std::vector<std::uint32_t> rear;       ///< by copy and section: the vehicle that entered last
  std::vector<CrossingState> crossings;  ///< by copy and crossing
  std::vector<Block> blocks;
  std::vector<Route> routes;
  std::vector<Fleet::Vehicle> arrived;  ///< each block writes to the range of its vehicles; then gathered
  std::size_t arrivals{0};
  std::size_t commanded_vehicles{0};  ///< vehicles with a goal or an instruction
  std::uint32_t step_number{0};       ///< of the next step

  [[nodiscard]] std::size_t bytes() const;
};

/// Index into front and rear for a section of a copy.
[[nodiscard]] inline std::size_t list_index(const Ground& ground, std::uint32_t copy, zone::SectionId section) {
  return std::size_t{copy} * ground.size() + section;
}

}  // namespace cosiva::virtual_side
