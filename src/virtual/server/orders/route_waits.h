#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/proxy.h"

namespace cosiva::virtual_side {

/// How long vehicles wait on their routes, and how often they arrive. A wait is time in which the remaining route of a
/// vehicle does not become shorter than it has been before; at its goal, and without one, a vehicle does not wait.
///
/// Invariant: `ended_[s]` counts the ended waits of s to s + 1 seconds, and no count precedes `counted_s_min`.
class RouteWaits {
 public:
  /// Shorter waits are not counted: vehicles stop briefly wherever they turn.
  static constexpr std::uint32_t counted_s_min = 1;

  struct Route {
    std::uint32_t goal{};   ///< distinguishes goals
    std::uint32_t steps{};  ///< moves that remain
    std::uint32_t next{};   ///< the same at the end of the move that the vehicle drives; `steps` where it is stopped
  };

  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }
  /// To be called once per tick. @param route  nothing: the vehicle has no goal, has arrived, or may not drive
  void record(VehicleIndex vehicle, std::optional<Route> route, SimTime now);
  /// The vehicle has arrived at its goal.
  void arrive(VehicleIndex vehicle) { ++vehicles_[vehicle].arrivals; }

  /// How long the vehicle's present wait has lasted; 0: none.
  [[nodiscard]] SimDuration waited(VehicleIndex vehicle, SimTime now) const {
    return vehicles_[vehicle].goal ? now - vehicles_[vehicle].since : SimDuration{};
  }
  [[nodiscard]] SimDuration longest() const { return longest_; }
  /// The 99th percentile of the waits that have ended, rounded up to seconds; 0 without any.
  [[nodiscard]] std::uint32_t p99_s() const;
  /// {"waits","wait_p99_s","longest_wait_s","arrivals","least_arrivals"}; the last one of all vehicles that have a
  /// route
  void write(JsonWriter& json) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Vehicle {
    std::optional<std::uint32_t> goal;
    std::uint32_t nearest{std::numeric_limits<std::uint32_t>::max()};  // steps
    SimTime since{};                                                   // when the remaining route was shortest
    std::uint32_t arrivals{0};
    bool has_route{false};  // has ever had one
  };
  void end_wait(Vehicle& vehicle, SimTime now);

  std::vector<Vehicle> vehicles_;
  std::vector<std::uint32_t> ended_;  // waits by their whole seconds
  SimDuration longest_{};
};

}  // namespace cosiva::virtual_side
