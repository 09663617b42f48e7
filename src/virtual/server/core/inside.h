#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/virtual/server/core/augmented_parts.h"
#include "cosiva/virtual/server/core/master_control.h"
#include "cosiva/virtual/server/core/server_context.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/right_of_way/way_map.h"
#include "cosiva/virtual/server/view/battery_desk.h"
#include "cosiva/virtual/server/view/gvs_desk.h"
#include "cosiva/virtual/server/zones/zone_edits.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// The server's parts and how news travels between them. server_core.cpp: life and links; zone.cpp: zones as they come
/// and their edits; zone_switch.cpp: from one zone to another while vehicles drive; operator.cpp: what is asked of it;
/// virtual_world.cpp: what is added only virtually; hand_over.cpp: from hall to hall; memory.cpp: what is kept over a
/// crash; reports.cpp and own_reports.cpp: what vehicles say; talk.cpp: what they say to each other; snapshot.cpp and
/// vehicle_json.cpp: what the page reads.
struct ServerCore::Inside : ServerContext, MasterControl, AugmentedParts {
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
  std::optional<VehicleIndex> register_vehicle(const wire::VehicleId& id);

  // zone.cpp
  /// How a configuration came: it was given, somebody published it just now, or the broker had kept it.
  enum class ZoneCame { given, published, retained };
  void on_zone(const zone::ZoneConfiguration& configuration, ZoneCame came);
  [[nodiscard]] bool waits_for_others(const zone::ZoneConfiguration& configuration, ZoneCame came);
  void take_waiting_zone();
  bool take_zone(const zone::ZoneConfiguration& configuration);
  void drive_on(const std::shared_ptr<const zone::TrafficZone>& zone);
  void start_over(const std::shared_ptr<const zone::TrafficZone>& zone);
  void publish_zone();
  void take_priority(VehicleIndex vehicle);
  void edit_zone(const JsonValue& command);
  void switch_zone(const JsonValue& command);

  // zone_switch.cpp
  [[nodiscard]] Result<zone::ZoneConfiguration> switch_wanted(const JsonValue& command) const;
  void note_refused(const std::string& origin, const std::string& why);
  void note_switch(std::string from);
  void follow_switch();
  [[nodiscard]] bool changing_map(VehicleIndex vehicle) const;
  [[nodiscard]] bool all_stand_off_old_map() const;
  [[nodiscard]] bool nobody_changes_map() const;
  [[nodiscard]] std::string parked(VehicleIndex vehicle) const;
  void write_zone(JsonWriter& json) const;

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
  void recall_zone();
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
  void set_present(AivProxy& proxy);
  /// When a position was taken, on the vehicle's own clock; nothing where a newer or the same one is known.
  [[nodiscard]] std::optional<SimTime> fresh_position_stamp(AivProxy& proxy, const wire::Header& header) const;
  void on_position(VehicleIndex vehicle, SimTime stamp, const wire::AgvPosition& position,
                   const std::optional<wire::Velocity>& velocity);
  void place_twin(VehicleIndex vehicle, SimTime at, const Pose2& pose, const std::optional<wire::Velocity>& velocity);
  void trace_section(const AivProxy& proxy, zone::Place before);
  void show_events(VehicleIndex vehicle, const wire::State* before, SimTime reported_at);
  void show_event(const AivProxy& proxy, PhysicalEvent kind, SimTime reported_at);
  void read_limits_and_tags(AivProxy& proxy);
  void tell_base_end(VehicleIndex vehicle);
  void help_lost_position(VehicleIndex vehicle);
  void ask_factsheet(VehicleIndex vehicle);
  void log_once(AivProxy& proxy, std::uint32_t note, char level, std::string text);

  // talk.cpp
  /// Talk between vehicles: told to the virtual ones that listen, and shown, once a second from each.
  void on_intent(const wire::Input& input);
  void trace_intent(AivProxy& proxy, const wire::Input& input);

  // vehicle_json.cpp
  void write_vehicle(JsonWriter& json, VehicleIndex vehicle) const;
  void write_agent(JsonWriter& json, VehicleIndex vehicle, bool lost) const;
  void write_reserved(JsonWriter& json, VehicleIndex vehicle) const;
  void write_boards(JsonWriter& json, const wire::BoardsReport& report) const;

  // snapshot.cpp
  void write_things(JsonWriter& json) const;
  void write_obstacles(JsonWriter& json) const;
  void write_crossings(JsonWriter& json) const;
  void write_commands(JsonWriter& json) const;

  BatteryDesk batteries;
  GvsDesk gvs;
  ZoneEdits edits;
  std::optional<WayMap> map;

  /// The last time that the zone became another one while vehicles were there.
  struct Switched {
    SimTime at{};
    std::string from;
    bool sent_off{false};  ///< nobody moves on the old map any more
    bool counted{false};   ///< everybody is on the new one, or has been given up
    std::optional<SimTime> first_moving;
    std::size_t anchored{0};
    std::vector<std::string> parked;
  };
  std::optional<Switched> switched;
  struct Refused {
    SimTime at{};
    std::string origin;
    std::string why;
  };
  std::optional<Refused> refused_zone;
  bool zone_switched_here{false};  ///< the zone in force was asked for as a command: nobody else serves it
  /// Retained configurations of a new connection: each waits until all are there.
  std::optional<zone::ZoneConfiguration> waiting_zone;
  bool zone_confirmed{false};  ///< the one in force is among them

  /// What was remembered and waits: the zone's edits for the zone, the virtual AIVs for the vehicles to be known.
  struct RecalledAiv {
    std::string serial;
    std::string section;
    double s_m;
  };
  std::optional<JsonValue> recalled_zone;
  std::optional<zone::ZoneConfiguration>
      recalled_given;  ///< the zone that the one in `recalled_zone` took the place of
  std::vector<RecalledAiv> recalled_aivs;
  std::vector<std::string> recalled_pauses;
  std::string remembered;
  SimTime remember_at{};

  std::optional<SimTime> ticked_at;
  bool begun{false};
};

}  // namespace cosiva::virtual_side
