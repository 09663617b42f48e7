#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::virtual_side {

/// The task of a vehicle.
struct Mission {
  enum class Kind : std::uint8_t {
    circulate,  ///< drive along a loop permanently, or along any branch
    go,         ///< drive to a goal, and stay there until the next mission
  };
  Kind kind{Kind::circulate};
  std::string
      name;  ///< of the loop, the station or the waypoint; circulate without one: the zone's first loop, or roam
  /// The goal in another control area, "area/name"; `name` is then the station where the two areas meet. Empty: none.
  std::string beyond{};
  friend bool operator==(const Mission&, const Mission&) = default;
};

/// Gives each vehicle its mission and plans its route, by travel time and never into a closed section. A vehicle
/// without a command circulates on the zone's first loop; in a zone without loops the vehicle roams: at each fork it
/// takes the least recently taken branch of those that do not end in a dead end.
class Missions {
 public:
  enum class State : std::uint8_t { driving, arrived, no_route };

  Missions(Registry& registry, MessagePublisher& publisher) : registry_{registry}, publisher_{publisher} {}

  /// Returns the mission to a goal in another control area, "area/name", or an error.
  using Abroad = std::function<Result<Mission>(std::string_view to)>;
  void set_abroad(Abroad abroad) { abroad_ = std::move(abroad); }

  /// Switches the zone; null: none at present. The closed sections of its configuration are closed. A vehicle whose
  /// goal or loop does not exist in the zone behaves like a vehicle without a command.
  void set_map(const WaypointGraph* map);
  /// Takes another zone object with the same geometry: only sections that its configuration closes or opens change.
  void renew();
  void resize(std::size_t vehicles) { entries_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { entries_[vehicle] = {}; }
  void give(VehicleIndex vehicle, Mission mission);
  /// The zone has the mission's loop or goal.
  [[nodiscard]] bool known(const Mission& mission) const;
  [[nodiscard]] bool has_position(std::string_view name) const { return !goals(name).empty(); }

  /// Fails with a message that states what to do and lists the names most similar to the requested one.
  [[nodiscard]] Result<void> check(const MissionCommand& command) const;
  [[nodiscard]] Result<void> check(const SectionCommand& command) const;
  /// Executes a command that check() accepts.
  void follow(const MissionCommand& command);
  void follow(const SectionCommand& command);

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
  [[nodiscard]] bool is_closed(zone::SectionId section) const;

  [[nodiscard]] const Mission& mission(VehicleIndex vehicle) const { return entries_[vehicle].mission; }
  [[nodiscard]] State state(VehicleIndex vehicle) const { return entries_[vehicle].state; }
  /// {"kind","loop"|"to","state","why"}.
  /// @param waits_for  name of the vehicle stopped at its goal; empty: none
  void write(JsonWriter& json, VehicleIndex vehicle, std::string_view waits_for) const;
  [[nodiscard]] std::vector<std::string> closed_names() const;

  /// {"zone","closed":[…],"missions":[…]}; only when it differs from the defaults of a new server.
  [[nodiscard]] bool worth_remembering() const;
  void write_persisted(JsonWriter& json) const;
  /// Restores the persisted missions for the zone of that name; each vehicle gets its mission when it is registered.
  void restore(const JsonValue& memory);
  void registered(VehicleIndex vehicle);
  void fold(Digest& digest) const;

 private:
  struct Entry {
    Mission mission;
    State state{State::driving};
    std::string why;
    std::uint64_t revision{0};
    bool complete{false};
    WaypointIndex goal{no_waypoint};
    std::map<zone::SectionId, std::uint64_t> taken;  ///< when each branch was last taken, counted in forks
    std::uint64_t forks{0};
    std::vector<zone::SectionId> avoided;  ///< sorted
  };
  struct Persisted {
    std::string vehicle;
    Mission mission;
  };
  [[nodiscard]] std::vector<WaypointIndex> goals(std::string_view name) const;
  [[nodiscard]] const zone::Loop* loop_of(const Entry& entry) const;
  [[nodiscard]] Result<void> check_map() const;
  [[nodiscard]] Result<std::vector<VehicleIndex>> addressed(const std::vector<std::string>& names) const;
  void closed_changed();
  /// The sections that are closed or in `avoided`; sorted.
  [[nodiscard]] std::vector<zone::SectionId> shut(Sections avoided) const;
  void restore_for_zone();
  /// Of the open sections in `choice`; no_section: none is open.
  [[nodiscard]] zone::SectionId least_recent(const Entry& entry, Sections choice) const;
  [[nodiscard]] std::vector<zone::SectionId> branch(Entry& entry, zone::SectionId last);
  void no_route(Entry& entry, const Error& error);

  Registry& registry_;
  MessagePublisher& publisher_;
  Abroad abroad_;
  const WaypointGraph* map_{};
  std::optional<zone::Router> router_;
  std::vector<Entry> entries_;
  std::vector<zone::SectionId> closed_;      ///< sorted
  std::vector<zone::SectionId> configured_;  ///< closed by the zone's own configuration
  std::vector<bool> for_ever_;
  std::uint64_t revision_{0};
  std::vector<Persisted> persisted_;  ///< of vehicles not registered yet
  struct PersistedClosed {
    std::string zone;
    std::vector<std::string> sections;
  };
  std::optional<PersistedClosed> persisted_closed_;
};

}  // namespace cosiva::virtual_side
