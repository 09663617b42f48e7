#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

using VehicleIndex = std::uint32_t;
inline constexpr VehicleIndex no_vehicle = std::numeric_limits<VehicleIndex>::max();

class Traffic;

/// The vehicles that pass a chain of crossings together, and whether another one may join them (traffic.h has the
/// rules). Invariant: no crossing is in the chains of two passes.
class Convoys {
 public:
  /// A chain that was given, and the last vehicle that was given it.
  struct Pass {
    VehicleIndex last;
    std::vector<CrossingIndex> crossings;
    std::size_t row;  ///< so many pass it together
  };

  /// Forgets every pass.
  void clear() { passes_.clear(); }
  /// A vehicle was given a chain of crossings.
  void record_pass(VehicleIndex vehicle, const std::vector<CrossingIndex>& crossings);
  /// Whether a vehicle may pass a chain in convoy with the one ahead, whatever the turns.
  /// @param exit_m  from the vehicle's position to the chain's exit
  /// @param stop_m  from the vehicle's position to the chain's stop line
  [[nodiscard]] bool may_join(const Traffic& traffic, VehicleIndex vehicle, double exit_m, double stop_m);
  /// A vehicle joins the pass of the one ahead, which has one (checked).
  const Pass& join(VehicleIndex leader, VehicleIndex vehicle);
  /// What the others lose by the convoy that may_join() found last [s].
  [[nodiscard]] const std::vector<std::pair<VehicleIndex, double>>& losing() const { return losing_; }
  /// How often a vehicle joined.
  [[nodiscard]] std::uint64_t count() const { return count_; }
  void fold(Digest& digest) const;

 private:
  /// A vehicle that would join: all distances from its own position.
  struct Joining {
    VehicleIndex vehicle;
    double stop_m;
    double exit_m;
    double leader_m;  ///< to the one ahead
  };
  [[nodiscard]] bool is_kept_by(const Traffic& traffic, const std::vector<VehicleIndex>& convoy,
                                VehicleIndex joining) const;
  [[nodiscard]] bool convoy_pays(const Traffic& traffic, const Joining& joining, std::size_t at_most);

  std::vector<Pass> passes_;
  std::vector<CrossingIndex> chain_;                     ///< of the vehicle that may_join() examines
  std::vector<std::pair<VehicleIndex, double>> losing_;  ///< seconds, by the convoy that may_join() found
  std::uint64_t count_{0};
};

}  // namespace cosiva::virtual_side
