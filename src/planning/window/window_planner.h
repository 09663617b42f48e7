#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/random.h"
#include "cosiva/planning/window/itinerary.h"
#include "cosiva/planning/window/joint_step.h"
#include "cosiva/planning/window/path_search.h"
#include "cosiva/planning/window/reservations.h"

namespace cosiva::planning {

/// A vehicle as the planner sees it at the beginning of a step.
struct Traveller {
  StateId at{};
  std::vector<Stop> stops;   ///< in their order; a vehicle without stops makes room for the others
  std::uint32_t urgency{0};  ///< in conflicts, vehicles with more of it come first
};

struct WindowOptions {
  std::uint32_t horizon = 12;  ///< steps that are planned at once, 1 to 255
  /// Three or more vehicles may move in a closed cycle, each into the cell that the next one leaves in the same step.
  /// Benchmarks permit that; real vehicles, each of which enters only what has been left, cannot.
  bool cycles = false;
  std::uint32_t group = 5;  ///< vehicles that are planned again together, at most
};

/// Plans the next steps of a whole fleet on one floor: for each vehicle a path through a window of steps, so that no
/// two bodies touch. Called once per step, it goes on with its last plan:
///
/// 1. Each path is one step longer at its far end, by a JointStep of all vehicles, and one shorter at its beginning.
/// 2. Vehicles whose stops have changed search for a better path among the others'.
/// 3. Groups of vehicles, a delayed one and those on its shortest path, are planned again one after the other, and the
/// result is
///    adopted where the sum of the group's costs has become smaller (large neighbourhood search in windows: Jiang et
///    al. 2024, "Scaling Lifelong Multi-Agent Path Finding to More Realistic Settings").
///
/// At each moment all paths together are free of contradictions (Reservations), so the third part can end after any
/// number of expansions. Same calls, options and seed: same paths, on every machine.
///
/// Invariant: after `plan` every vehicle has a path of `horizon` steps that begins where the vehicle is.
class WindowPlanner {
 public:
  /// @param floor, distances  must outlive the planner
  WindowPlanner(const Floor& floor, Distances& distances, const WindowOptions& options, std::uint64_t seed);

  /// Plans from the vehicles' present states, which must not have a cell in common. Where a vehicle is not where the
  /// last plan led it, or the number of vehicles is another one, all begin anew. A vehicle that is at its first stop
  /// waits there for its stay, whatever the plan before was; the caller subtracts the steps that have passed.
  /// @param expansions_max  nodes that the third part may examine
  void plan(std::span<const Traveller> fleet, std::uint64_t expansions_max);

  /// `horizon` + 1 states of a vehicle, the present one first.
  [[nodiscard]] std::span<const StateId> path(Vehicle vehicle) const noexcept { return reservations_.path(vehicle); }
  /// False: one of its stops cannot be reached, even on an empty floor; it goes to those before.
  [[nodiscard]] bool complete(Vehicle vehicle) const noexcept { return itineraries_[vehicle].complete(); }
  /// Nodes and candidates examined since the planner was made.
  [[nodiscard]] std::uint64_t expansions() const noexcept { return search_.expansions() + joint_.expansions(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] bool goes_on(std::span<const Traveller> fleet) const;
  void accept(std::span<const Traveller> fleet);
  void add_step(std::vector<std::vector<StateId>>& paths);
  /// False: a vehicle would have to leave before the end of its stay.
  [[nodiscard]] bool go_on(std::span<const Traveller> fleet);
  [[nodiscard]] bool stays(Vehicle vehicle) const;
  void reserve(const std::vector<std::vector<StateId>>& paths);
  void begin_anew(std::span<const Traveller> fleet);
  void replan(Vehicle vehicle, std::uint32_t limit);
  void improve(std::uint64_t expansions_max);
  /// Its path takes longer than it would on an empty floor.
  [[nodiscard]] bool is_delayed(Vehicle vehicle) const;
  void list_delayed();
  void choose_group(Vehicle vehicle);
  void add_to_group(Vehicle vehicle);
  /// False: the group has the paths of before.
  bool improve_group();
  [[nodiscard]] std::uint32_t cost(Vehicle vehicle) const { return itineraries_[vehicle].cost(path(vehicle)); }

  const Floor* floor_;
  Distances* distances_;
  WindowOptions options_;
  Random random_;
  Reservations reservations_;
  JointStep joint_;
  PathSearch search_;
  std::vector<Traveller> fleet_;
  std::vector<Itinerary> itineraries_;
  std::vector<Vehicle> delayed_;
  std::vector<Vehicle> group_;
  std::vector<std::vector<StateId>> old_paths_;  // of the group
  std::vector<StateId> found_;
};

}  // namespace cosiva::planning
