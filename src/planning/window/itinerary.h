#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/planning/floor/distances.h"
#include "cosiva/planning/floor/floor.h"

namespace cosiva::planning {

/// A goal of a vehicle and the steps that it stays there, for example to pick up a load.
struct Stop {
  GoalId goal{};
  std::uint32_t stay{0};
  friend bool operator==(const Stop&, const Stop&) = default;
};

/// The stops of one vehicle in their order, with the distances that a search needs.
///
/// Invariant: every leg's table belongs to its stop's goal; `after` of a leg is the time from its arrival to the end of
/// the last stay, on an otherwise empty floor.
class Itinerary {
 public:
  /// How far a vehicle has come.
  struct Progress {
    std::uint32_t leg{0};
    std::uint32_t at_goal{0};  ///< steps at the end of which it was at the leg's goal, its arrival included
    friend bool operator==(const Progress&, const Progress&) = default;
  };

  Itinerary() = default;
  /// Stops from the first one that cannot be reached are left out: see `complete`. A vehicle without stops may be
  /// anywhere.
  Itinerary(StateId at, std::span<const Stop> stops, const Floor& floor, Distances& distances);

  [[nodiscard]] bool complete() const noexcept { return complete_; }  ///< all stops can be reached
  [[nodiscard]] bool idle() const noexcept { return legs_.empty(); }
  [[nodiscard]] std::uint32_t legs() const noexcept { return static_cast<std::uint32_t>(legs_.size()); }
  [[nodiscard]] bool done(Progress progress) const noexcept { return progress.leg == legs_.size(); }

  /// At the beginning, in this state.
  [[nodiscard]] Progress start(StateId at) const noexcept { return next({}, at); }
  /// One step later, in this state.
  [[nodiscard]] Progress next(Progress progress, StateId at) const noexcept;
  /// The vehicle has arrived at a stop and has to stay.
  [[nodiscard]] static bool staying(Progress progress) noexcept { return progress.at_goal > 0; }
  /// Steps that are needed at least from this state to the end of the last stay; 0 when all is done.
  [[nodiscard]] std::uint32_t remaining(Progress progress, StateId at) const noexcept {
    if (done(progress)) return 0;
    return legs_[progress.leg].to[at] + legs_[progress.leg].after - (progress.at_goal > 0 ? progress.at_goal - 1 : 0);
  }
  /// Moves to the goal of the present leg; 0 when all is done.
  [[nodiscard]] std::uint32_t to_goal(Progress progress, StateId at) const noexcept {
    return done(progress) ? 0U : legs_[progress.leg].to[at];
  }
  /// Of a path that begins now: its cost, that is the step in which the last stay ends (a bound from below, if it ends
  /// after the path).
  [[nodiscard]] std::uint32_t cost(std::span<const StateId> path) const noexcept;
  /// At the end of a path that begins now.
  [[nodiscard]] Progress end(std::span<const StateId> path) const noexcept;

 private:
  struct Leg {
    const Distances::Steps* to{};
    std::uint32_t stay{};
    std::uint32_t after{};
  };

  std::vector<Leg> legs_;
  bool complete_{true};
};

}  // namespace cosiva::planning
