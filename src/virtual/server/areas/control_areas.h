#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/orders/missions.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// Several servers on one broker, one for each control area: what the others say of theirs, and whose each vehicle is.
/// The class only keeps what was received; Ownership (virtual/server/core) claims, takes over and lets go.
class ControlAreas {
 public:
  static constexpr std::size_t vehicles_max = 4096;  ///< a flood of made-up names must not take the memory
  static constexpr std::size_t areas_max = 256;

  /// @param own  empty: the only server of its broker, and every vehicle is its own
  explicit ControlAreas(std::string own) : own_{std::move(own)} {}
  [[nodiscard]] bool several() const { return !own_.empty(); }
  [[nodiscard]] const std::string& own() const { return own_; }

  /// What is known of a vehicle whosever it is: as much as its next owner needs.
  struct Vehicle {
    wire::VehicleId id;
    std::optional<wire::Owner> owner;  ///< the last that was heard; nothing: it is nobody's
    bool owner_received{false};        ///< since our link came up
    std::optional<wire::Input> connection;
    std::optional<wire::Input> factsheet;
    std::optional<Pose2> pose;  ///< as long as it is nobody's
    SimTime pose_since{};
    SimTime pose_at{};
    std::optional<SimTime> claimed_at;
  };
  [[nodiscard]] bool owns(const wire::VehicleId& id) const;
  /// Nothing: there are too many.
  [[nodiscard]] Vehicle* vehicle(const wire::VehicleId& id);
  [[nodiscard]] auto& vehicles() { return vehicles_; }  ///< by name
  /// A message of a vehicle's, on the topic's last level; where it stands is kept while it is nobody's.
  void overhear(Vehicle& vehicle, std::string_view topic, const wire::Input& input);
  void link_up();

  /// What another server says about itself. Fails where its zone cannot be built.
  [[nodiscard]] Result<void> on_area(wire::AreaTopic topic, const wire::Input& input);
  [[nodiscard]] bool is_there(std::string_view area) const;
  [[nodiscard]] bool has_map(std::string_view name) const;
  /// The mission to "control area/name": to the station of `zone` that lies on a way of that control area from which
  /// `name` can be reached, the one nearest to its line. Fails with a sentence that says what to do.
  [[nodiscard]] Result<Mission> route_to(std::string_view to, const zone::TrafficZone& zone,
                                         const Missions& missions) const;

  /// {"name","others":[{"name","online"}]}.
  void write(JsonWriter& json) const;
  void fold(Digest& digest) const;

 private:
  struct ControlArea {
    bool online{false};
    std::shared_ptr<const zone::TrafficZone> zone;
  };
  std::string own_;
  std::map<std::string, ControlArea, std::less<>> areas_;  ///< the others
  std::map<std::string, Vehicle, std::less<>> vehicles_;
};

}  // namespace cosiva::virtual_side
