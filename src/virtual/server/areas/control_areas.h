#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// Several servers on one broker, one for each control area: what the other servers publish, and the owner of each
/// vehicle. The class only stores what was received; Ownership (virtual/server/core) claims, takes over and releases
/// vehicles.
///
/// Invariant: at most vehicles_max vehicles and areas_max other areas are stored, each vehicle under its own name; the
/// server's own area is none of the others.
class ControlAreas {
 public:
  static constexpr std::size_t vehicles_max = 4096;  ///< limits the memory that a flood of invented names can occupy
  static constexpr std::size_t areas_max = 256;

  /// @param own  empty: this is the only server of its broker and owns every vehicle
  explicit ControlAreas(std::string own) : own_{std::move(own)} {}
  [[nodiscard]] bool several() const { return !own_.empty(); }
  [[nodiscard]] const std::string& own() const { return own_; }

  /// What is known of a vehicle of any owner: as much as the next owner needs.
  struct Vehicle {
    wire::VehicleId id;
    std::optional<wire::Owner> owner;  ///< as last received; nothing: no server owns the vehicle
    bool owner_received{false};        ///< received since the link came up
    std::optional<wire::Input> connection;
    std::optional<wire::Input> factsheet;
    std::optional<Pose2> pose;  ///< while no server owns the vehicle
    SimTime pose_since{};
    SimTime pose_at{};
    std::optional<SimTime> claimed_at;
  };
  [[nodiscard]] bool owns(const wire::VehicleId& id) const;
  /// Null: there are too many vehicles.
  [[nodiscard]] Vehicle* vehicle(const wire::VehicleId& id);
  [[nodiscard]] auto& vehicles() { return vehicles_; }  ///< by name
  /// Takes a message of a vehicle. The vehicle's pose is stored while no server owns the vehicle.
  /// @param topic  the topic's last level
  void overhear(Vehicle& vehicle, std::string_view topic, const wire::Input& input);
  void link_up();

  /// Takes what another server publishes about itself. Fails where its zone cannot be built.
  [[nodiscard]] Result<void> on_area(wire::AreaTopic topic, const wire::Input& input);
  [[nodiscard]] bool is_there(std::string_view area) const;
  [[nodiscard]] bool has_map(std::string_view name) const;
  /// The mission to "area/name": to the station of `zone` on a section of that control area from which `name` can be
  /// reached, and of these to the station nearest to that area's path. Fails with a message that states what to do.
  [[nodiscard]] Result<Mission> route_to(std::string_view to, const zone::TrafficZone& zone,
                                         const Missions& missions) const;

  /// {"name","others":[{"name","online"}]}.
  void write(JsonWriter& json) const;
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct ControlArea {
    bool online{false};
    std::shared_ptr<const zone::Rtm> rtm;  ///< of the zone that it published last; null: none yet
  };
  std::string own_;
  std::map<std::string, ControlArea, std::less<>> areas_;  ///< the other control areas
  std::map<std::string, Vehicle, std::less<>> vehicles_;
};

}  // namespace cosiva::virtual_side
