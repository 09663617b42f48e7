#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

/// Missions and closed sections that persist over a crash of the server.
///
/// Invariant: at most as many missions are stored for vehicles not registered yet as the registry can have vehicles.
class PersistedMissions {
 public:
  PersistedMissions(const Registry& registry, Missions& missions) : registry_{registry}, missions_{missions} {}

  /// The missions differ from the defaults of a new server.
  [[nodiscard]] bool worth_remembering() const;
  /// {"zone","closed":[…],"missions":[…]}
  void write(JsonWriter& json) const;
  /// Restores what write() wrote: the closed sections for the zone of that name, and each vehicle's mission when the
  /// vehicle is registered.
  void restore(const JsonValue& memory);
  void registered(VehicleIndex vehicle);
  /// The vehicle's entry will be removed, and its mission forgotten: a vehicle of this name gets the mission again.
  void removed(VehicleIndex vehicle);
  /// The restored closed sections, once, if they belong to the zone of `map`; null: no zone is in force.
  [[nodiscard]] std::optional<std::vector<zone::SectionId>> take_closed(const WaypointGraph* map);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Persisted {
    std::string vehicle;
    Mission mission;
  };
  struct PersistedClosed {
    std::string zone;
    std::vector<std::string> sections;
  };
  const Registry& registry_;
  Missions& missions_;
  std::vector<Persisted> missions_left_;  ///< of vehicles not registered yet
  std::optional<PersistedClosed> closed_;
};

}  // namespace cosiva::virtual_side
