#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "virtual/server/commands.h"
#include "virtual/server/order_roller.h"
#include "virtual/server/outbox.h"
#include "virtual/server/proxy.h"
#include "virtual/server/server_core.h"
#include "virtual/server/traces.h"
#include "virtual/server/traffic.h"
#include "virtual/server/way_map.h"
#include "virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// The server's parts and how news travels between them. server_core.cpp: life and links; reports.cpp: what vehicles
/// say; snapshot.cpp: what the page reads.
struct ServerCore::Inside {
  explicit Inside(ServerOptions given);

  // server_core.cpp
  void begin(SimTime now);
  void on_message(const wire::Input& input);
  void on_zone(std::string_view format, std::string_view topic, std::string_view text, bool retained);
  void on_link(bool up);
  void on_tick();
  [[nodiscard]] bool settled() const;
  [[nodiscard]] Simulator::Step step_recorder();
  std::optional<Registry::Address> address_of(const std::string& topic);

  // reports.cpp
  void on_vehicle_message(Registry::Address address, const wire::Input& input);
  void on_connection(VehicleIndex vehicle, const std::string& payload);
  void on_factsheet(VehicleIndex vehicle, const std::string& payload);
  void on_state(VehicleIndex vehicle, const std::string& payload);
  void on_visualization(VehicleIndex vehicle, const std::string& payload);
  [[nodiscard]] bool take_header(VehicleIndex vehicle, VehicleTopic topic, const wire::Header& header);
  void refuse(VehicleIndex vehicle, VehicleTopic topic, const Error& error);
  /// Time stamps older than this one's are out of order.
  [[nodiscard]] SimTime clock_of(AivProxy& proxy, SimTime stamp);
  void heard(VehicleIndex vehicle, SimTime reported_at, bool has_place);
  void on_position(VehicleIndex vehicle, const wire::Header& header, const std::optional<wire::AgvPosition>& position,
                   const std::optional<wire::Velocity>& velocity);
  void place_twin(VehicleIndex vehicle, SimTime at, const Pose2& pose, const std::optional<wire::Velocity>& velocity);
  void show_events(VehicleIndex vehicle, const wire::State* before, SimTime reported_at);
  void show_event(PhysicalEvent kind, SimTime reported_at);
  void read_limits_and_tags(AivProxy& proxy);
  void tell_base_end(VehicleIndex vehicle);
  void help_lost_position(VehicleIndex vehicle);
  void ask_factsheet(VehicleIndex vehicle);
  void log_once(AivProxy& proxy, std::uint32_t note, char level, std::string text);

  // snapshot.cpp
  void write_vehicle(JsonWriter& json, VehicleIndex vehicle) const;
  void write_crossings(JsonWriter& json) const;
  void write_commands(JsonWriter& json) const;

  ServerOptions options;
  std::string topic_prefix;  ///< "<interface>/"
  Traces traces;
  Outbox outbox;
  Registry registry;
  Traffic traffic;
  ActionDesk desk;
  Simulator simulator;
  OrderRoller roller;
  Commands commands;
  std::optional<WayMap> map;

  SimTime now{};
  bool begun{false};
  bool link_up{false};
  SimTime link_up_at{};
  bool is_settled{false};
  SimTime next_heartbeat{};
  std::uint32_t heartbeat_id{0};
  std::uint64_t messages_refused{0};
  std::uint64_t strangers_logged{0};
};

}  // namespace cosiva::virtual_side
