#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/components.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {

inline constexpr CrossingIndex no_crossing = std::numeric_limits<CrossingIndex>::max();

/// One vehicle cannot go on before another has gone.
struct Wait {
  VehicleIndex waiter{no_vehicle};
  VehicleIndex blocker{no_vehicle};
  WaitReason why{WaitReason::ahead};
  CrossingIndex crossing{no_crossing};  ///< that it is about, if any
  friend bool operator==(const Wait&, const Wait&) = default;
};

/// Vehicles that wait for each other in a ring: none of them can go on before all others have.
struct Knot {
  std::vector<VehicleIndex> members;  ///< ascending; at least two
  /// The shortest ring that leads from the first member back to it, each wait beginning where the one before ends.
  /// Where everybody waits for one other, it goes through all members.
  std::vector<Wait> cycle;
};

/// Who waits for whom, at one moment. Whoever waits for several waits for all of them, so every ring is a deadlock: the
/// knots are the strongly connected components of more than one vehicle.
class WaitGraph {
 public:
  /// Empties it, for vehicles 0 … count − 1; keeps its memory.
  void begin(std::size_t count);
  /// Both within the count, and not the same (ignored otherwise: nobody waits for itself).
  void add(const Wait& wait);
  /// All knots, by their first members. In time linear in vehicles and waits; the same for the same waits in whatever
  /// order they came.
  [[nodiscard]] const std::vector<Knot>& find_knots();

  /// After find_knots(): sorted by who, whom and why.
  [[nodiscard]] std::span<const Wait> waits() const { return waits_; }
  [[nodiscard]] std::span<const Wait> waits_of(VehicleIndex waiter) const;

 private:
  void sort_waits();
  [[nodiscard]] std::vector<Wait> cycle_through(VehicleIndex first);

  std::size_t count_{0};
  std::vector<Wait> waits_;
  std::vector<std::size_t> first_;      ///< of each vehicle's waits, and one behind the last
  std::vector<VehicleIndex> blockers_;  ///< of each wait
  StrongComponents components_;
  std::vector<std::size_t> came_by_;  ///< for the ring: the wait that led to each
  std::vector<VehicleIndex> reached_;
  std::vector<Knot> knots_;
};

}  // namespace cosiva::virtual_side
