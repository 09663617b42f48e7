#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

using VehicleIndex = std::uint32_t;
inline constexpr VehicleIndex no_vehicle = std::numeric_limits<VehicleIndex>::max();

class Traffic;

/// The two lists, of crossings or of vehicles, have an element in common.
[[nodiscard]] bool intersect(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b);

/// The vehicles that pass a chain of crossings together, and whether another vehicle may join them (traffic.h states
/// the rules).
/// Invariant: no crossing is in the chains of two passes.
class Convoys {
 public:
  /// A granted chain, and the last vehicle that was granted the chain.
  struct Pass {
    VehicleIndex last;
    std::vector<CrossingIndex> crossings;
    std::size_t row;  ///< number of vehicles that pass the chain together
  };

  /// Discards all passes.
  void clear() { passes_.clear(); }
  /// Records that a vehicle was granted a chain of crossings.
  void record_pass(VehicleIndex vehicle, const std::vector<CrossingIndex>& crossings);
  /// Whether a vehicle may pass a chain in convoy with its leader, regardless of the order of requests.
  /// @param exit_m  from the vehicle's position to the chain's exit
  /// @param stop_m  from the vehicle's position to the chain's stop line
  [[nodiscard]] bool may_join(const Traffic& traffic, VehicleIndex vehicle, double exit_m, double stop_m);
  /// Adds a vehicle to the pass of its leader, which has a pass (checked).
  const Pass& join(VehicleIndex leader, VehicleIndex vehicle);
  /// The time that the other vehicles lose by the convoy that may_join() found last [s].
  [[nodiscard]] const std::vector<std::pair<VehicleIndex, double>>& losing() const { return losing_; }
  /// Number of times that a vehicle joined a pass.
  [[nodiscard]] std::uint64_t count() const { return count_; }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// A vehicle that would join; all distances are measured from its own position.
  struct Joining {
    VehicleIndex vehicle;
    double stop_m;
    double exit_m;
    double leader_m;  ///< to its leader
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
