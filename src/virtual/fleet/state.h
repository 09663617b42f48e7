#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/virtual/fleet/ground.h"
#include "cosiva/zone/circuit/pose_table.h"

namespace cosiva::virtual_side {

inline constexpr std::uint32_t no_chain = std::numeric_limits<std::uint32_t>::max();

/// Memory that a vector has allocated for its elements.
template <typename T>
[[nodiscard]] std::size_t allocated_bytes(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

/// The state of a vehicle besides driving.
enum Mode : std::uint8_t {
  turning = 1U << 0U,     ///< on the spot, at the end of its section
  sent = 1U << 1U,        ///< the vehicle has a goal
  at_goal = 1U << 2U,     ///< and is stopped there
  commanded = 1U << 3U,   ///< sent to its present position: the vehicle arrives in the next step
  requesting = 1U << 4U,  ///< is in its copy's queue
  absent = 1U << 5U,      ///< not in the zone
};

/// Events found by a pass over the vehicles, which need more than arithmetic.
enum Event : std::uint8_t {
  passed = 1U << 0U,   ///< the end of its section, or of something that it holds
  nears = 1U << 1U,    ///< a stop line: time for a request
  halted = 1U << 2U,   ///< exactly at its stopping position
  goes_on = 1U << 3U,  ///< a manoeuvre or a command in progress
};

/// Data of a vehicle that is needed only for its events: stored together, because an event needs all of it.
struct Own {
  double release_at{far_m};           ///< where the vehicle has left the next of the crossings that it holds
  double clear_at{far_m};             ///< the path is reserved up to here
  double chain_at{far_m};             ///< where the first section of the held chain begins
  double own_mps{far_m};              ///< its own limit
  double traversed_m{};               ///< driven on sections before this one, less the start position
  std::uint32_t behind{Fleet::none};  ///< the next one on the same section
  std::uint32_t copy{};
  std::uint32_t line_chain{no_chain};  ///< begins at line_at
  std::uint32_t held_chain{no_chain};
  std::uint32_t entered_step{};  ///< of entry into its section
  std::uint32_t laps{};
  zone::SectionId began_on{};
  std::uint32_t route{Fleet::none};  ///< index of its route; a vehicle that circulates has none
  std::uint32_t route_step{};        ///< index of the present section in the route
  std::int16_t priority{};
  std::uint16_t held_next{};  ///< of the chain's crossings, the next one to leave
};

/// A request for a chain of crossings, with all data that decides the order of grants.
struct Waiting {
  std::uint32_t vehicle;
  std::uint32_t requested_step;
  std::uint32_t chain;
  std::int32_t priority;
};

/// All dynamic data, one entry per vehicle in each array: a pass reads and writes only what it needs. Positions named
/// `_at` are on the vehicle's own path, counted from the start of its present section, and far_m if there is none.
struct State {
  std::vector<double> s_m;       ///< of its body origin
  std::vector<double> v_mps;     ///< at the end of the last step
  std::vector<double> next_mps;  ///< as decided in this step; only for blocks larger than forgets_vehicles
  std::vector<double> offset_m;  ///< start of the leader's section
  std::vector<double> halt_at;   ///< the first stopping position: before a line not granted, a turn, a goal, a dead end
  std::vector<double> line_at;   ///< the next stop line
  std::vector<double> goal_at;
  std::vector<double> event_at;  ///< the next position that needs more than a plain move
  std::vector<double> cap_mps;   ///< the lower of its own limit and the section's
  std::vector<double> slow_at;   ///< start of the next lower limit that counts; only in zones with limits
  std::vector<double> slow_mps;
  std::vector<double> x_m;
  std::vector<double> y_m;
  std::vector<double> heading_rad;
  std::vector<double> turn_left_rad;  ///< of the present turn on the spot; only in zones with turns
  std::vector<double> turn_radps;
  std::vector<std::uint32_t> leader;  ///< the vehicle itself: no leader near enough
  std::vector<zone::SectionId> section;
  std::vector<std::uint32_t> waited_steps;
  std::vector<std::int8_t> profile;   ///< the last choice; below 0: none yet
  std::vector<std::uint8_t> imposed;  ///< a profile, or no_profile
  std::vector<std::uint8_t> mode;
  std::vector<std::uint8_t> event;
  std::vector<Own> own;
  std::vector<Waiting> queue;  ///< each copy's part contains its requests, the first to be granted first

  void resize(std::size_t vehicles, bool limits, bool turns);
  [[nodiscard]] std::size_t bytes() const;
};
inline constexpr std::uint8_t no_profile = 4;

/// Largest number of vehicles that are stepped together without an array for their decisions.
inline constexpr std::uint32_t forgets_vehicles = 1024;

/// Of one crossing in one copy.
struct CrossingState {
  std::uint32_t holder{Fleet::none};
  std::uint64_t claimed_pass{0};  ///< in this pass over the queue, a request of higher rank needs it
};

/// One copy of the zone: its vehicles, and its data on sections and crossings.
struct Copy {
  std::uint32_t first;  ///< vehicle; the vehicles end before the next copy's first
  std::uint32_t waiting{0};
  std::uint32_t due_step{0};   ///< nothing changes for waiting vehicles before this step
  std::uint32_t sort_step{0};  ///< nor does their order before this one
};

/// Whole copies that one worker steps, with the data that only this worker writes.
struct alignas(64) Block {
  std::uint32_t first_copy{};
  std::uint32_t last_copy{};  ///< behind the last
  std::uint32_t first{};
  std::uint32_t last{};
  std::uint64_t pass{0};  ///< counts passes over queues
  std::uint64_t collisions{0};
  double smallest_gap_m{far_m};               ///< of the whole run
  std::uint32_t now{0};                       ///< the present step, or the next one
  std::uint32_t arrivals{0};                  ///< at the start of its part of `arrived`
  std::vector<std::uint64_t> occupied_steps;  ///< by section, of vehicles that have left it
  std::vector<std::uint64_t> grants;          ///< by crossing
  std::vector<std::uint64_t> waited_steps;
  // For searches against the direction of travel: the distance of a section, if this search has reached it.
  std::vector<double> detected_m;
  std::vector<std::uint64_t> detection_search;
  std::vector<zone::SectionId> open;
  std::uint64_t search{0};
};

}  // namespace cosiva::virtual_side
