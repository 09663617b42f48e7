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

/// What a vehicle is at, besides driving.
enum Mode : std::uint8_t {
  turning = 1U << 0U,    ///< on the spot, at the end of its section
  sent = 1U << 1U,       ///< it has a goal
  at_goal = 1U << 2U,    ///< and stands there
  commanded = 1U << 3U,  ///< to go where it stands already: it arrives in the next step
  requests = 1U << 4U,   ///< stands in its copy's queue
  absent = 1U << 5U,     ///< not in the zone
};

/// What a pass over the vehicles found that is more than arithmetic.
enum Event : std::uint8_t {
  passed = 1U << 0U,   ///< the end of its section, or of something that it holds
  nears = 1U << 1U,    ///< a stop line: time to ask
  halted = 1U << 2U,   ///< exactly where it was to stop
  goes_on = 1U << 3U,  ///< a manoeuvre, or what it was told
};

/// What of a vehicle only matters when something happens to it: side by side, because then all of it does.
struct Own {
  double release_at{far_m};           ///< where it has left the next of the crossings that it holds
  double clear_at{far_m};             ///< up to here its way is reserved
  double chain_at{far_m};             ///< where the first section of the chain begins that it holds
  double own_mps{far_m};              ///< its own limit
  double traversed_m{};               ///< on sections before this one, less where it began
  std::uint32_t behind{Fleet::none};  ///< the next one on the same section
  std::uint32_t copy{};
  std::uint32_t line_chain{no_chain};  ///< what begins at line_at
  std::uint32_t held_chain{no_chain};
  std::uint32_t entered_step{};  ///< its section
  std::uint32_t laps{};
  zone::SectionId began_on{};
  std::uint32_t route{Fleet::none};  ///< which of the routes; one that circulates has none
  std::uint32_t route_step{};        ///< which of its sections it is on
  std::int16_t priority{};
  std::uint16_t held_next{};  ///< of the chain's crossings, the next to be left
};

/// One that asks for a chain of crossings, with all that decides whose turn it is.
struct Waiting {
  std::uint32_t vehicle;
  std::uint32_t requested_step;
  std::uint32_t chain;
  std::int32_t priority;
};

/// All that moves, one entry per vehicle in each array: a pass reads and writes only what it needs. Places named `_at`
/// are on the vehicle's own way, counted from the start of the section that it is on, and far_m where there is none.
struct State {
  std::vector<double> s_m;       ///< of its middle
  std::vector<double> v_mps;     ///< at the end of the last step
  std::vector<double> next_mps;  ///< as decided in this step; only where a block is too large for it to be forgotten
  std::vector<double> offset_m;  ///< where the section of the one ahead begins
  std::vector<double> halt_at;   ///< the first place to stop: before a line not granted, a turn, a goal, a dead end
  std::vector<double> line_at;   ///< the next stop line
  std::vector<double> goal_at;
  std::vector<double> event_at;  ///< the next place where more is to be done than to move
  std::vector<double> cap_mps;   ///< its own limit, the section's, the lower
  std::vector<double> slow_at;   ///< where the next lower limit begins that counts; only in zones with limits
  std::vector<double> slow_mps;
  std::vector<double> x_m;
  std::vector<double> y_m;
  std::vector<double> heading_rad;
  std::vector<double> turn_left_rad;  ///< of the turn on the spot that it is in; only in zones with turns
  std::vector<double> turn_radps;
  std::vector<std::uint32_t> leader;  ///< who is ahead; itself: nobody near enough
  std::vector<zone::SectionId> section;
  std::vector<std::uint32_t> waited_steps;
  std::vector<std::int8_t> profile;   ///< as chosen last; below 0: nothing yet
  std::vector<std::uint8_t> imposed;  ///< a profile, or no_profile
  std::vector<std::uint8_t> mode;
  std::vector<std::uint8_t> event;
  std::vector<Own> own;
  std::vector<Waiting> queue;  ///< each copy's part holds those who ask, who goes first first

  void resize(std::size_t vehicles, bool limits, bool turns);
  [[nodiscard]] std::size_t bytes() const;
};
inline constexpr std::uint8_t no_profile = 4;

/// So many vehicles are stepped together at most without an array for what they have decided.
inline constexpr std::uint32_t forgets_vehicles = 1024;

/// Of one crossing in one copy.
struct CrossingState {
  std::uint32_t holder{Fleet::none};
  std::uint64_t claimed_pass{0};  ///< somebody who goes first wants it, in this pass over the queue
};

/// One copy of the zone: which vehicles are its, and what it keeps of sections and crossings.
struct Copy {
  std::uint32_t first;  ///< vehicle; the next copy's first is behind the last
  std::uint32_t waiting{0};
  std::uint32_t due_step{0};   ///< nothing changes for those who wait before this step
  std::uint32_t sort_step{0};  ///< nor their order before this one
};

/// Whole copies that one worker steps, and what only it writes.
struct alignas(64) Block {
  std::uint32_t first_copy{};
  std::uint32_t last_copy{};  ///< behind the last
  std::uint32_t first{};
  std::uint32_t last{};
  std::uint64_t pass{0};  ///< counts looks at queues
  std::uint64_t collisions{0};
  double smallest_gap_m{far_m};               ///< ever seen
  std::uint32_t now{0};                       ///< the step that it makes, or that comes next
  std::uint32_t arrivals{0};                  ///< at the beginning of its part of `arrived`
  std::vector<std::uint64_t> occupied_steps;  ///< by section, of vehicles that have left it
  std::vector<std::uint64_t> grants;          ///< by crossing
  std::vector<std::uint64_t> waited_steps;
  // For searches against the direction of driving: how far off a section is, if it was seen in this search.
  std::vector<double> detected_m;
  std::vector<std::uint64_t> detection_search;
  std::vector<zone::SectionId> open;
  std::uint64_t search{0};
};

}  // namespace cosiva::virtual_side
