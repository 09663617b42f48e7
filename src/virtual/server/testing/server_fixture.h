#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/random.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/testing/vehicle_fixture.h"
#include "cosiva/wire/own/own_messages.h"

/// For tests: the bench's vehicles around one ServerCore in virtual time. Nothing here knows how the server is made.
namespace cosiva::virtual_side::fixture {

class ServerFixture {
 public:
  explicit ServerFixture(zone::ZoneConfiguration configuration = oval(), ServerOptions options = {})
      : zone{zone::Rtm::initialise(configuration)->shared_zone()}, options_{std::move(options)} {
    options_.zone = std::move(configuration);
    restart_server();
  }

  std::shared_ptr<const zone::TrafficZone> zone;
  std::unique_ptr<ServerCore> server;
  std::vector<std::unique_ptr<FixtureVehicle>> vehicles;
  SimTime now{virtual_epoch};
  std::vector<wire::Publish> published;
  std::vector<std::string> logs;
  Random random{1, "bench"};
  double loss{0.0};  ///< of orders, instant actions, states and visualizations
  std::function<void()> each_step;
  SimDuration latency{4ms};
  bool broker_frozen{false};  ///< its connections stay open, and nothing passes

  /// Killed and started anew, with what it remembered where that is asked for.
  void restart_server(bool restore = false) {
    server = std::make_unique<ServerCore>(options_);
    echoes_.clear();
    if (restore && !persisted.empty()) feed(wire::InputKind::restore, "", persisted);
    feed(wire::InputKind::link, "", "up");
    for (const auto& vehicle : vehicles)
      send(*vehicle, "connection", vda::encode(vehicle->connection(now, wire::ConnectionState::online)), true);
  }

  /// From its next start on, the server has to receive the zone.
  void forget_zone() { options_.zone.reset(); }

  FixtureVehicle& add(const std::string& serial, zone::TrackPosition start,
                      const std::string& manufacturer = "CoSiVA") {
    vehicles.push_back(std::make_unique<FixtureVehicle>(zone, wire::VehicleId{manufacturer, serial}, start));
    FixtureVehicle& vehicle = *vehicles.back();
    vehicle.takes_zones = manufacturer == wire::our_manufacturer;
    send(vehicle, "connection", vda::encode(vehicle.connection(now, wire::ConnectionState::online)));
    return vehicle;
  }
  void send(const FixtureVehicle& vehicle, std::string_view topic, std::string payload, bool retained = false) {
    feed(wire::InputKind::message, vehicle.topic(topic), std::move(payload), retained);
  }
  void connection(FixtureVehicle& vehicle, wire::ConnectionState state) {
    send(vehicle, "connection", vda::encode(vehicle.connection(now, state)));
  }
  void command(const std::string& kind, const std::string& vehicle, const std::string& id = "") {
    std::string json = R"({"command":")" + kind + R"(","vehicle":")" + vehicle + "\"";
    if (!id.empty()) json += R"(,"id":")" + id + "\"";
    feed(wire::InputKind::command, "test", json + "}");
  }
  void kill(FixtureVehicle& vehicle) {
    vehicle.alive = false;
    connection(vehicle, wire::ConnectionState::connection_broken);
  }

  /// A command of any kind, as JSON.
  void send_command(std::string json) { feed(wire::InputKind::command, "test", std::move(json)); }
  /// Why the server would refuse it; empty: it would not.
  [[nodiscard]] std::string refusal(const std::string& json) const {
    const auto checked = server->check_command(DecodedCommand{json});
    return checked ? "" : to_string(checked.error());
  }

  void feed(wire::InputKind kind, std::string source, std::string payload, bool flag = false,
            std::shared_ptr<const wire::InProcessMessage> typed = {}) {
    if (kind == wire::InputKind::message && source.starts_with(wire::zone_topic_prefix))
      for (const auto& vehicle : vehicles) vehicle->receive({source, payload, 1, true});
    act({now, kind, std::move(source), std::move(payload), flag, std::move(typed)});
    // What the server subscribes to comes back to it, as from a broker.
    while (!echoes_.empty()) {
      const wire::Publish echo = std::move(echoes_.front());
      echoes_.pop_front();
      act({now, wire::InputKind::message, echo.topic, echo.payload, false});
    }
  }
  /// What it would remember if it were killed now.
  std::string persisted;

  void run_for(SimDuration duration) {
    for (const SimTime end = now + duration; now < end;) {
      now += 20ms;
      ++steps_;
      for (const auto& vehicle : vehicles) {
        if (!vehicle->alive) continue;
        vehicle->step(20ms);
        if (broker_frozen) continue;
        if (steps_ % 50 == 0) vehicle->state_due = true;
        const SimTime sent_at = now - latency;
        if (vehicle->visualizes && steps_ % 5 == 0 && !random.chance(loss))
          send(*vehicle, "visualization", vda::encode(vehicle->visualization(sent_at)));
        if (!vehicle->state_due) continue;
        vehicle->state_due = false;
        const std::string state = vda::encode(vehicle->state(sent_at));
        if (!random.chance(loss)) send(*vehicle, "state", state);
      }
      feed(wire::InputKind::tick, "", "");
      if (each_step) each_step();
    }
  }

  /// How many pairs of vehicles touch now.
  [[nodiscard]] int touches() const {
    int count = 0;
    for (std::size_t i = 0; i < vehicles.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (touch(vehicles[i]->pose(), vehicles[j]->pose(), zone->vehicle)) ++count;
    return count;
  }
  [[nodiscard]] JsonValue snapshot() const { return *JsonValue::parse(server->snapshot_json()); }
  [[nodiscard]] JsonValue bijection() const {
    JsonWriter json;
    server->write_bijection(json);
    return *JsonValue::parse(json.text());
  }
  [[nodiscard]] JsonValue aiv(const std::string& name) const {
    const JsonValue all = snapshot();
    for (const JsonValue& one : *all.find("aivs")->array())
      if (one.text("id") == name) return one;
    return {};
  }
  [[nodiscard]] JsonValue command_entry(const std::string& id) const {
    const JsonValue all = snapshot();
    for (const JsonValue& one : *all.find("commands")->array())
      if (one.text("id") == id) return one;
    return {};
  }
  [[nodiscard]] std::vector<wire::Publish> published_on(std::string_view topic) const {
    std::vector<wire::Publish> found;
    std::ranges::copy_if(published, std::back_inserter(found), [&](const auto& p) { return p.topic == topic; });
    return found;
  }
  [[nodiscard]] bool logged(std::string_view phrase) const {
    return std::ranges::any_of(logs, [&](const std::string& line) { return line.find(phrase) != std::string::npos; });
  }

 private:
  void act(const wire::Input& input) {
    effects_.clear();
    server->handle(input, effects_);
    const wire::Effects effects = std::move(effects_);
    for (const wire::Effect& effect : effects) {
      if (const auto* log = std::get_if<wire::Log>(&effect)) logs.push_back(log->text);
      if (const auto* kept = std::get_if<wire::Persist>(&effect)) persisted = kept->bytes;
      const auto* message = std::get_if<wire::Publish>(&effect);
      if (message == nullptr) continue;
      published.push_back(*message);
      if (broker_frozen) continue;
      for (const std::string& filter : server->subscriptions())
        if (wire::topic_matches(filter, message->topic)) echoes_.push_back(*message);
      if (random.chance(loss)) continue;
      for (const auto& vehicle : vehicles) vehicle->receive(*message);
    }
  }

  ServerOptions options_;
  wire::Effects effects_;
  std::deque<wire::Publish> echoes_;
  std::uint64_t steps_{0};
};

}  // namespace cosiva::virtual_side::fixture
