#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/components.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {

inline constexpr CrossingIndex no_crossing = std::numeric_limits<CrossingIndex>::max();

/// One vehicle cannot continue before another has left.
struct Wait {
  VehicleIndex waiter{no_vehicle};
  VehicleIndex blocker{no_vehicle};
  WaitReason why{WaitReason::ahead};
  CrossingIndex crossing{no_crossing};  ///< that causes the wait, if any
  friend bool operator==(const Wait&, const Wait&) = default;
};

/// Vehicles that wait for each other in a cycle: none of them can continue before all others have.
struct Knot {
  std::vector<VehicleIndex> members;  ///< ascending; at least two
  /// The shortest cycle from the first member back to that member; each wait begins where the previous one ends. Where
  /// each vehicle waits for one other only, the cycle contains all members.
  std::vector<Wait> cycle;
};

/// The wait-for graph at one moment. A vehicle that waits for several vehicles waits for all of them, so every cycle is
/// a deadlock: the knots are the strongly connected components of more than one vehicle.
///
/// Invariant: each wait is between two different vehicles of the graph, and each knot has a cycle through its first
/// member.
class WaitGraph {
 public:
  /// Clears the graph for vehicles 0 … count − 1; retains the allocated memory.
  void begin(std::size_t count);
  /// Adds a wait between two different vehicles below `count`; other waits are ignored, as no vehicle waits for itself.
  void add(const Wait& wait);
  /// All knots, sorted by their first members. Takes time linear in vehicles and waits; the result does not depend on
  /// the order in which the waits were added.
  [[nodiscard]] const std::vector<Knot>& find_knots();

  /// To be called after find_knots(): sorted by who, whom and why.
  [[nodiscard]] std::span<const Wait> waits() const { return waits_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void sort_waits();
  [[nodiscard]] std::vector<Wait> cycle_through(VehicleIndex first);

  std::size_t count_{0};
  std::vector<Wait> waits_;
  std::vector<std::size_t> first_;      ///< of each vehicle's waits, plus one past the end
  std::vector<VehicleIndex> blockers_;  ///< of each wait
  StrongComponents components_;
  std::vector<std::size_t> came_by_;  ///< for the cycle: the wait that led to each vehicle
  std::vector<VehicleIndex> reached_;
  std::vector<Knot> knots_;
};

}  // namespace cosiva::virtual_side
