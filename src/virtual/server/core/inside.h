#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/virtual/server/core/augmented_parts.h"
#include "cosiva/virtual/server/core/master_control.h"
#include "cosiva/virtual/server/core/position_view.h"
#include "cosiva/virtual/server/core/server_context.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/core/server_view.h"
#include "cosiva/virtual/server/core/twin_placement.h"
#include "cosiva/virtual/server/core/vehicle_lifecycle.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// The server's parts and how news travels between them. server_core.cpp: life and links; zone.cpp: zones as they come
/// and their edits; zone_switch.cpp: from one zone to another while vehicles drive; operator.cpp: what is asked of it;
/// virtual_world.cpp: what is added only virtually; hand_over.cpp: from hall to hall; memory.cpp: what is kept over a
/// crash; reports.cpp and own_reports.cpp: what vehicles say; talk.cpp: what they say to each other; snapshot.cpp and
/// vehicle_json.cpp: what the page reads.
struct ServerCore::Inside : ServerContext, MasterControl, AugmentedParts, InstrumentParts {
  explicit Inside(ServerOptions given);

  // server_core.cpp
  void begin(SimTime now);
  void on_message(const wire::Input& input);
  void on_link(bool up);
  void on_tick();
  void settle();
  [[nodiscard]] bool settled() const;
  std::optional<Registry::Address> address_of(const std::string& topic);
  void on_battery(const wire::Input& input);
  void on_gvs(const wire::Input& input);

  // operator.cpp
  [[nodiscard]] Result<void> check_command(std::string_view json) const;
  void on_command(std::string_view json);
  [[nodiscard]] Result<wire::Publish> world_command(const JsonValue& command) const;
  void say_battery_ready(wire::Publish message);

  // hand_over.cpp
  /// Takes what is of other halls, and of vehicles that are not ours. False: it is for us.
  [[nodiscard]] bool is_for_halls(const wire::Input& input);
  void on_owner(const wire::VehicleId& id, const wire::Input& input);
  /// @param kept  the broker had kept the message
  void take_over(Halls::Vehicle& vehicle, bool kept);
  void let_go(VehicleIndex vehicle, const std::string& hall);
  /// Its sequence follows from the last that was heard.
  void say_owner(const Halls::Vehicle& vehicle, wire::Owner owner);
  void say_lost_owners();
  void claim_vehicles();
  void hand_over_arrived();

  // virtual_world.cpp
  void follow(const ThingCommand& asked);
  bool add_aiv(const std::string& serial, zone::Place place);
  void remove_aiv(VehicleIndex vehicle);
  void place_recalled_aivs();
  void silence_orphans();
  void update_virtual_world();
  void look_for_passed_obstacles();

  // memory.cpp
  void recall(std::string_view bytes);
  void recall_things(const JsonValue& memory);
  [[nodiscard]] std::string memory() const;
  void remember();

  // reports.cpp
  void on_vehicle_message(Registry::Address address, const wire::Input& input);
  void on_connection(VehicleIndex vehicle, const wire::Input& input);
  void on_factsheet(VehicleIndex vehicle, const wire::Input& input);
  void on_state(VehicleIndex vehicle, const wire::Input& input);
  void on_visualization(VehicleIndex vehicle, const wire::Input& input);
  // own_reports.cpp
  void on_felt(VehicleIndex vehicle, const wire::Input& input);
  void on_seen(VehicleIndex vehicle, const wire::Input& input);
  void on_boards(VehicleIndex vehicle, const wire::Input& input);
  [[nodiscard]] bool take_own_stamp(AivProxy& proxy, std::optional<SimTime>& last, SimTime stamp);
  [[nodiscard]] bool is_vehicle(VehicleIndex seer, Point2 p, double radius_m, SimTime seen_at) const;
  void look_through(VehicleIndex vehicle, const wire::Ranges& ranges);
  void forget_where_clear(VehicleIndex vehicle, double clear_m);
  void on_ghost(AivProxy& proxy, VehicleTopic topic, const wire::Input& input);
  [[nodiscard]] bool take_header(VehicleIndex vehicle, VehicleTopic topic, const wire::Header& header);
  void refuse(VehicleIndex vehicle, VehicleTopic topic, const wire::Input& input, const Error& error);
  /// Time stamps older than this one's are out of order.
  [[nodiscard]] SimTime clock_of(AivProxy& proxy, SimTime stamp);
  /// Takes note of a report: once per message, whatever it carries.
  void on_report(VehicleIndex vehicle, SimTime reported_at);
  /// When a position was taken, on the vehicle's own clock; nothing where a newer or the same one is known.
  [[nodiscard]] std::optional<SimTime> fresh_position_stamp(AivProxy& proxy, const wire::Header& header) const;
  void on_position(VehicleIndex vehicle, SimTime stamp, const wire::AgvPosition& position,
                   const std::optional<wire::Velocity>& velocity);
  void show_events(VehicleIndex vehicle, const wire::State* before, SimTime reported_at);
  void read_limits_and_tags(AivProxy& proxy);
  void help_lost_position(VehicleIndex vehicle);
  void ask_factsheet(VehicleIndex vehicle);
  void log_once(AivProxy& proxy, std::uint32_t note, char level, std::string text);

  // talk.cpp
  /// Talk between vehicles: told to the virtual ones that listen, and shown, once a second from each.
  void on_intent(const wire::Input& input);
  void trace_intent(AivProxy& proxy, const wire::Input& input);

  VehicleLifecycle vehicles{*this, *this, *this};
  TwinPlacement twins{*this, *this};
  ZoneSession zones{*this, *this, *this, vehicles, twins};
  ServerView view{*this, *this, *this, zones, *this};
  PositionView position_view{*this, *this};
  /// Virtual AIVs of the state file that wait until the vehicles are known.
  struct RecalledAiv {
    std::string serial;
    std::string section;
    double s_m;
  };
  std::vector<RecalledAiv> recalled_aivs;
  std::string remembered;
  SimTime remember_at{};

  std::optional<SimTime> ticked_at;
  bool begun{false};
};

}  // namespace cosiva::virtual_side
