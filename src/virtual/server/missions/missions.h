#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/missions/mission.h"
#include "cosiva/virtual/server/missions/roaming.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/right_of_way/closed_sections.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::virtual_side {

/// Gives each vehicle its mission and plans its route, by travel time and never into a closed section. A vehicle
/// without a command circulates on the zone's first loop; in a zone without loops the vehicle roams: at each fork it
/// takes the least recently taken branch of those that do not end in a dead end (Roaming).
///
/// Invariant: a vehicle whose mission has no route has a complete route: nothing extends it.
class Missions {
 public:
  enum class State : std::uint8_t { driving, arrived, no_route };

  Missions(Registry& registry, MessagePublisher& publisher) : registry_{registry}, publisher_{publisher} {}

  /// Switches the zone; null: none at present. The closed sections of its configuration are closed. A vehicle whose
  /// goal or loop does not exist in the zone behaves like a vehicle without a command.
  /// @param closed  the sections that are closed instead, from an earlier run of the server; nothing: the configured
  void set_map(const WaypointGraph* map, std::optional<std::vector<zone::SectionId>> closed = {});
  [[nodiscard]] const WaypointGraph* map() const { return map_; }
  /// Takes another zone object with the same geometry: only sections that its configuration closes or opens change.
  void renew();
  void resize(std::size_t vehicles) { entries_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { entries_[vehicle] = {}; }
  void give(VehicleIndex vehicle, Mission mission);
  /// Gives a vehicle the mission that it had before a restart of the server.
  void restore(VehicleIndex vehicle, Mission mission);
  /// Closes these sections and opens all others. A zone is in force.
  void set_closed(std::vector<zone::SectionId> sections);
  [[nodiscard]] const ClosedSections& closed() const { return closed_; }

  /// Increases with every change after which a vehicle's route has to be planned again.
  [[nodiscard]] std::uint64_t revision(VehicleIndex vehicle) const { return entries_[vehicle].revision + revision_; }
  /// Plans from the best of `starts`: the sections of the route, beginning with the start's own. Nothing where there is
  /// no route; state and reason are then set.
  [[nodiscard]] std::optional<std::vector<zone::SectionId>> plan(VehicleIndex vehicle,
                                                                 std::span<const zone::TrackPosition> starts);
  /// The continuation of the route after its last section; empty: none.
  [[nodiscard]] std::vector<zone::SectionId> more(VehicleIndex vehicle, zone::SectionId last);
  /// The route ends at its goal, or cannot be extended.
  [[nodiscard]] bool complete(VehicleIndex vehicle) const { return entries_[vehicle].complete; }
  /// The goal of the last planned route; no_waypoint: none.
  [[nodiscard]] WaypointIndex goal(VehicleIndex vehicle) const { return entries_[vehicle].goal; }
  /// Whether the vehicle could continue from `from` without entering any of the sections `around`, in ascending order.
  [[nodiscard]] bool has_detour(VehicleIndex vehicle, zone::TrackPosition from, Sections around) const;
  /// Plans the vehicle's route again as if `sections`, in ascending order, were closed for this vehicle; valid until
  /// need_not_avoid(), another zone or another mission.
  void avoid(VehicleIndex vehicle, std::vector<zone::SectionId> sections);
  void need_not_avoid(VehicleIndex vehicle) { entries_[vehicle].avoided.clear(); }
  /// Whether `p` is the vehicle's goal, or at most `off_m` from the goal.
  [[nodiscard]] bool is_at(VehicleIndex vehicle, Point2 p, double off_m) const;
  /// The vehicle is stopped at `p` without an order. True: `p` is the goal, or at most `off_m` from the goal; the
  /// vehicle has arrived and stays.
  bool is_stopped_at(VehicleIndex vehicle, Point2 p, double off_m);

  /// For a vehicle whose route another part plans: why there is none at present; nothing: there is one.
  void set_no_route(VehicleIndex vehicle, const std::optional<std::string>& why);

  [[nodiscard]] const Mission& mission(VehicleIndex vehicle) const { return entries_[vehicle].mission; }
  [[nodiscard]] State state(VehicleIndex vehicle) const { return entries_[vehicle].state; }
  /// {"kind","loop"|"to","state","why"}.
  /// @param waits_for  name of the vehicle stopped at its goal; empty: none
  void write(JsonWriter& json, VehicleIndex vehicle, std::string_view waits_for) const;
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Entry {
    Mission mission;
    State state{State::driving};
    std::string why;
    std::uint64_t revision{0};
    bool complete{false};
    WaypointIndex goal{no_waypoint};
    Roaming roaming;
    std::vector<zone::SectionId> avoided;  ///< in ascending order
    void stop(const Error& error);
  };

  Registry& registry_;
  MessagePublisher& publisher_;
  const WaypointGraph* map_{};
  std::optional<zone::Router> router_;
  std::vector<Entry> entries_;
  ClosedSections closed_;
  std::vector<bool> for_ever_;  ///< by section: a vehicle can drive on from there without an end
  std::uint64_t revision_{0};
};

}  // namespace cosiva::virtual_side
