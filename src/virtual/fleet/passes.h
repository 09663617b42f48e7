#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/base/result.h"
#include "cosiva/fuzzy/narrow_rules.h"
#include "cosiva/virtual/fleet/state.h"

/// The passes over vehicles that make up a step; they contain the arithmetic, and no decision except the agents' own.
namespace cosiva::virtual_side {

/// Values common to all vehicles, computed once.
struct Numbers {
  double dt_s;
  double length_m;            ///< of a vehicle on its path: occupied_m()
  double sensed_m;            ///< bodies further ahead do not count
  double braking_distance_m;  ///< of the medium profile (agent_rules.h)
  double medium_mps;
  double late_s;        ///< reaction time of its brakes, for lines and bodies alike: one square root instead of two
  double hardest_mps2;  ///< braking
  double weakest_mps2;
  std::array<zone::SpeedProfile, 4> profiles;  ///< by number
  bool has_limits;                             ///< of sections
  bool has_caps;                               ///< of vehicles
  bool has_turns;
};
[[nodiscard]] Numbers numbers_of(const zone::TrafficZone& zone, const FleetOptions& options);

/// Number of vehicles that are decided together.
inline constexpr std::size_t lanes = fuzzy::lanes;

/// An agent's rules, narrowed to the inputs of a fleet's vehicle: nothing is known of other vehicles at crossings, and
/// no battery runs low. Usually no vehicle has a goal or an instruction either.
struct FleetRules {
  std::vector<aiv::AgentInput> inputs;  ///< in the rule base's order
  std::size_t concerns;                 ///< number of outputs that state a speed
  fuzzy::NarrowRules usual;             ///< without goals and instructions
  fuzzy::NarrowRules all;
};
[[nodiscard]] Result<FleetRules> narrow(const aiv::AgentRules& rules);
/// A stop nearer than this is reached at once, so that the vehicle stops exactly there.
inline constexpr double snap_m = 1e-3;

/// Perceives and decides: profile and next speed of vehicles first…last, from the others' state at the end of the last
/// step.
/// @param next   an entry for each of them: its speed at the end of this step [m/s]
/// @param rules  null: the crisp ones
/// @param more   some vehicle has a goal or an instruction
/// @return       the smallest gap; far_m: no vehicle has a leader
[[nodiscard]] double decide(State& state, const Numbers& numbers, const FleetRules* rules, bool more,
                            std::uint32_t first, std::uint32_t last, double* next);

/// Moves vehicles first…last on, on their sections or beyond their ends, and records the events of each.
void move(State& state, const Numbers& numbers, std::uint32_t first, std::uint32_t last, const double* next);

}  // namespace cosiva::virtual_side
