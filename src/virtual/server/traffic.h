#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "base/digest.h"
#include "virtual/server/way_map.h"

namespace cosiva::virtual_side {

using VehicleIndex = std::uint32_t;
inline constexpr VehicleIndex no_vehicle = std::numeric_limits<VehicleIndex>::max();

/// Distances that keep vehicles apart; all between the vehicles' middles, beyond one vehicle's length.
struct TrafficRules {
  double gap_m{0.10};            ///< from the end of a base to the vehicle ahead
  double room_m{0.15};           ///< from a crossing's exit to the vehicle ahead
  double request_within_m{0.7};  ///< of the stop line: nearer than this, a crossing is asked for
  double look_ahead_m{6.0};      ///< for the vehicle ahead
};

/// Who may go where: the vehicle ahead, and the crossings (release is reservation).
///
/// What a vehicle holds follows from where it last said it was and from the base it was given: every crossing on the
/// way between. So nothing has to be given back by hand, a crossing lost in a restart is found again, and a vehicle
/// that stands in one holds it whatever happened. New crossings are granted in whole chains or not at all, first come
/// first served; hence nobody holds one while waiting for the next, and nobody starves.
class Traffic {
 public:
  explicit Traffic(TrafficRules rules = {}) : rules_{rules} {}

  void set_map(const WayMap* map);  ///< forgets every place, hold and request
  void resize(std::size_t vehicles);

  /// The last reported place; nothing: it is not on the way of others.
  void set_place(VehicleIndex vehicle, std::optional<zone::Place> place);
  /// The end of the base it was given, whether it has said so or not; no_waypoint: none.
  void set_base_end(VehicleIndex vehicle, WaypointIndex end);

  /// Works out vehicles ahead and holds from places and bases; call after changes and before asking.
  void update();

  struct Ahead {
    VehicleIndex vehicle{no_vehicle};
    double distance_m{std::numeric_limits<double>::infinity()};
  };
  [[nodiscard]] const Ahead& ahead(VehicleIndex vehicle) const { return vehicles_[vehicle].ahead; }
  /// How far the end of a base may reach from the vehicle's last reported place.
  [[nodiscard]] double reach_m(VehicleIndex vehicle) const;
  [[nodiscard]] bool holds_all(VehicleIndex vehicle, double distance_m);

  struct Answer {
    bool granted{false};
    CrossingIndex waits_for{0};           ///< the first that is not free, when a crossing is what it waits for
    VehicleIndex blocked_by{no_vehicle};  ///< who holds it, stands in the way beyond, or asked earlier
  };
  /// Asks for the chain that begins at `stop`, `distance_m` ahead of the vehicle's place. The first asking fixes its
  /// turn.
  Answer request(VehicleIndex vehicle, WaypointIndex stop, double distance_m);
  void withdraw(VehicleIndex vehicle);

  [[nodiscard]] VehicleIndex holder(CrossingIndex crossing) const { return holders_[crossing]; }
  /// Who waits for a crossing, first come first.
  [[nodiscard]] std::vector<VehicleIndex> waiting(CrossingIndex crossing) const;
  [[nodiscard]] double standing_m() const;  ///< a vehicle's length and the gap

  void fold(Digest& digest) const;

 private:
  struct Vehicle {
    std::optional<zone::Place> place;
    WaypointIndex base_end{no_waypoint};
    Ahead ahead;
    std::vector<CrossingIndex> needs;
  };
  struct Request {
    VehicleIndex vehicle;
    std::vector<CrossingIndex> crossings;
    bool has_room{false};
  };
  void find_ahead(VehicleIndex vehicle);
  void settle_holds();

  TrafficRules rules_;
  const WayMap* map_{};
  std::vector<Vehicle> vehicles_;
  std::vector<VehicleIndex> holders_;  ///< by crossing
  std::vector<Request> queue_;         ///< oldest first
  std::vector<CrossingIndex> scratch_;
  bool dirty_{true};
};

}  // namespace cosiva::virtual_side
