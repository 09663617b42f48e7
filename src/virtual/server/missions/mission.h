#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

/// The task of a vehicle.
struct Mission {
  enum class Kind : std::uint8_t {
    circulate,  ///< drive along a loop permanently, or along any branch
    go,         ///< drive to a goal, and stay there until the next mission
  };
  Kind kind{Kind::circulate};
  /// Of the loop, the station or the waypoint; circulate without one: the zone's first loop, or roam.
  std::string name;
  /// The goal in another control area, "area/name"; `name` is then the station where the two areas meet. Empty: none.
  std::string beyond{};
  friend bool operator==(const Mission&, const Mission&) = default;
};

/// Length limit of the names in commands and in the persisted state [bytes].
inline constexpr std::size_t mission_name_bytes_max = 200;

/// All waypoints at the station or waypoint of that name; empty: there is none.
[[nodiscard]] std::vector<WaypointIndex> goals_of(const WaypointGraph& map, std::string_view name);
/// The zone has the mission's loop or goal.
[[nodiscard]] bool is_known(const WaypointGraph& map, const Mission& mission);
/// The loop of a mission to circulate; null: the zone has no such loop.
[[nodiscard]] const zone::Loop* loop_of(const WaypointGraph& map, const Mission& mission);

}  // namespace cosiva::virtual_side
