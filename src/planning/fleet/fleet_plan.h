#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/floor/distances.h"
#include "cosiva/planning/floor/floor.h"
#include "cosiva/planning/passing/passing_order.h"
#include "cosiva/planning/search/configuration_search.h"
#include "cosiva/planning/window/window_planner.h"

namespace cosiva::planning {

struct FleetPlanOptions {
  WindowOptions window;
  std::uint64_t expansions_max = 20'000;  ///< of one step of the plan
  std::uint32_t planned_min = 2;          ///< moves that a vehicle with stops should have planned, besides granted ones
  std::uint32_t unfinished_max = 8;  ///< moves, granted or planned, of a vehicle that the others are too far before
  std::uint32_t stuck_steps = 24;    ///< in which a vehicle comes no nearer, until a search is made for it
  std::uint64_t configurations_max =
      5'000;  ///< of the first such search; each further one may examine twice as many, up to 16 times
};

/// The plan of a fleet while it is executed: WindowPlanner makes joint steps, PassingOrder decides which of their moves
/// may begin. The plan is made step by step, as far before the vehicles as they need it to keep moving.
///
/// A plan has no times: a vehicle that is late delays those that pass after it, and no others. For a vehicle that comes
/// no nearer to its stop for long, in the plan, ConfigurationSearch finds steps of the whole fleet, or proves that
/// there are none.
///
/// Invariant: the planner's present states are the ends of what is planned.
class FleetPlan {
 public:
  /// @param floor  must outlive the plan
  FleetPlan(const Floor& floor, const FleetPlanOptions& options, std::uint64_t seed)
      : FleetPlan{floor, floor, options, seed} {}
  /// @param floor  of the moves that may have been granted before
  /// @param open   the same without what is obstructed now: of the moves that are planned; both must outlive the plan
  FleetPlan(const Floor& floor, const Floor& open, const FleetPlanOptions& options, std::uint64_t seed);

  /// Begins with vehicles at a standstill in these states, which have no cell in common, without stops.
  void begin(std::span<const StateId> states);
  /// Likewise, with vehicles that have been granted moves before: see PassingOrder::begin.
  void begin(std::span<const GrantedMoves> granted);
  [[nodiscard]] std::size_t vehicles() const noexcept { return fleet_.size(); }
  [[nodiscard]] const PassingOrder& order() const noexcept { return order_; }

  /// What the vehicle still has to do: its stops that have not ended, the present one first. Where they are those of
  /// before without the ones that have ended, the plan goes on.
  void set_stops(Vehicle vehicle, std::span<const Stop> stops, std::uint32_t urgency);
  /// In its next granted move, the vehicle is clear of the beginning: see PassingOrder::clear.
  void clear(Vehicle vehicle) { order_.clear(vehicle); }
  /// The vehicle has arrived at the end of its next granted move.
  void arrive(Vehicle vehicle) {
    order_.arrive(vehicle);
    steps_since_change_ = 0;
  }
  /// Plans as far as the vehicles need it, and not further before the latest of them than `unfinished_max` moves. After
  /// two windows of steps without an arrival or other stops, no further steps are made.
  void plan();
  /// Gives up what has not been granted; `plan` then begins anew from the ends of the granted moves. For a vehicle that
  /// is late: the others need not wait for it longer than for the moves granted to it. Without effect while the steps
  /// that a search has found are being driven: begun anew each time, they would never come to their end.
  void replan();
  /// Grants the next planned move, see PassingOrder::grant; none beyond a stop that has not ended.
  [[nodiscard]] bool grant(Vehicle vehicle);

  /// All stops of the vehicle can be reached, were it alone.
  [[nodiscard]] bool reachable(Vehicle vehicle) const { return planner_.complete(vehicle); }
  /// What the last search for the vehicle has come to; none: there was no need of one since its stops have changed.
  [[nodiscard]] std::optional<SearchResult> search_result(Vehicle vehicle) const { return progress_[vehicle].searched; }
  /// Joint steps made, and how often the plan was made again from the ends of granted moves, since the beginning.
  [[nodiscard]] std::uint64_t steps() const noexcept { return steps_; }
  [[nodiscard]] std::uint64_t replans() const noexcept { return replans_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// How far the plan has come with a vehicle's stops.
  struct Progress {
    std::vector<Stop> stops;                           // those that have not ended in reality
    std::size_t ended{0};                              // of them, in the plan
    std::uint32_t stayed{0};                           // steps at the next one, in the plan
    Distances::Steps nearest{Distances::unreachable};  // to the next one, in the plan
    std::uint32_t stuck{0};                            // steps since it was so near
    std::optional<SearchResult> searched;
    std::uint64_t configurations_max{0};  // of the last search
  };

  [[nodiscard]] bool wants_step() const;
  [[nodiscard]] bool is_late() const;
  void add_step();
  void advance(std::span<const StateId> next);
  void count_stops(Vehicle vehicle, bool stays);
  void watch(Vehicle vehicle);
  [[nodiscard]] Distances::Steps away(Vehicle vehicle);  // from its next stop, in the plan
  [[nodiscard]] std::optional<Vehicle> most_stuck() const;
  [[nodiscard]] bool search_for(Vehicle vehicle);

  FleetPlanOptions options_;
  Distances distances_;
  WindowPlanner planner_;
  ConfigurationSearch search_;
  PassingOrder order_;
  std::vector<Traveller> fleet_;  // at the ends of what is planned
  std::vector<Progress> progress_;
  std::vector<StateId> next_;
  struct Found {
    Vehicle vehicle{};
    std::uint64_t moves{0};  // of that vehicle, up to the end of the steps found
  };
  Found found_;  // by the last search
  std::uint64_t steps_{0};
  std::uint32_t steps_since_change_{0};
  std::uint64_t replans_{0};
};

}  // namespace cosiva::planning
