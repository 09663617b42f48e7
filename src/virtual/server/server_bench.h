#pragma once

#include <algorithm>
#include <deque>
#include <fstream>
#include <functional>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "aiv/motion.h"
#include "aiv/order_book.h"
#include "base/json_value.h"
#include "base/random.h"
#include "virtual/server/server_core.h"
#include "wire/own_messages.h"
#include "wire/topics.h"
#include "wire/vda5050/codec.h"

/// For tests: vehicles that obey VDA 5050 strictly (every order goes through aiv::OrderBook) and drive at constant
/// speed, around one ServerCore in virtual time. Nothing here knows how the server is made.
namespace cosiva::virtual_side::bench {

using namespace std::chrono_literals;
namespace vda = wire::vda5050;

inline zone::ZoneConfiguration zone_file(const std::string& name) {
  std::ifstream file{std::string(COSIVA_SOURCE_DIR) + "/zones/" + name};
  std::stringstream text;
  text << file.rdbuf();
  return {name.substr(name.rfind('.') + 1), name, text.str()};
}

/// A ring without crossings: two straights of 2 m joined by half circles of radius 0.5 m, 7.14 m round.
inline zone::ZoneConfiguration oval() {
  return {"toml", "oval", R"(
name = "oval"
format_version = 1
[vehicle]
length_m = 0.20
width_m = 0.12
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
closed = true
[[section]]
name = "south"
kind = "straight"
length_m = 2.0
[[section]]
name = "east"
kind = "arc"
radius_m = 0.5
angle_deg = 180
[[section]]
name = "north"
kind = "straight"
length_m = 2.0
[[section]]
name = "west"
kind = "arc"
radius_m = 0.5
angle_deg = 180
)"};
}

class BenchVehicle {
 public:
  BenchVehicle(const zone::TrafficZone& zone, wire::VehicleId vehicle, zone::Place start)
      : id{std::move(vehicle)}, zone_{zone}, book{zone}, motion{zone.circuit, start} {}

  wire::VehicleId id;
  std::string version{"2.1.0"};

 private:
  const zone::TrafficZone& zone_;

 public:
  std::optional<aiv::OrderBook> book;
  aiv::AivMotion motion;
  double cruise_mps{0.3};
  double speed_mps{0.0};
  double driven_m{0.0};
  bool alive{true};
  bool paused{false};
  bool position_known{true};
  bool visualizes{true};
  bool blocked{false};  ///< something stands in its way
  double charge{90.0};
  std::string profile{"normal"};
  std::set<std::string> deaf_to;  ///< instant actions it never hears
  std::set<std::string> fakes;    ///< instant actions it answers with FINISHED, and does nothing
  std::set<std::string> refuses;  ///< instant actions it answers with FAILED
  bool refuse_next_order{false};
  SimDuration clock_ahead{};
  std::vector<wire::ActionState> action_states;
  std::vector<wire::VehicleError> errors;
  std::vector<wire::Information> information;
  std::vector<wire::Order> orders;            ///< every one received
  std::vector<wire::InstantActions> actions;  ///< every one received
  std::vector<std::string> refusals;          ///< of orders, by its own rules
  bool state_due{true};

  [[nodiscard]] zone::Place place() const { return motion.place(zone_.circuit); }
  [[nodiscard]] Pose2 pose() const { return motion.pose(zone_.circuit); }

  void receive(const wire::Publish& message) {
    const auto topic = wire::parse_vda_topic(message.topic);
    if (!topic || topic->vehicle != id || !alive) return;
    if (topic->name == "order") on_order(*vda::decode_order(message.payload));
    if (topic->name == "instantActions") on_actions(*vda::decode_instant_actions(message.payload));
  }

  void step(SimDuration dt) {
    const double left_m = book->distance_to_base_end_m();
    const double wish_m = paused || blocked ? 0.0 : std::min(left_m, cruise_mps * to_seconds(dt));
    const double moved_m = motion.move(zone_.circuit, wish_m);
    driven_m += moved_m;
    const double speed = moved_m / to_seconds(dt);
    if ((speed > 0.0) != (speed_mps > 0.0)) state_due = true;
    speed_mps = speed;
    if (!book->travelled(moved_m).empty()) state_due = true;
  }

  [[nodiscard]] wire::State state(SimTime now) {
    wire::State s;
    s.header = header(now, state_header_id++);
    s.order_id = book->order_id();
    s.order_update_id = book->order_update_id();
    s.last_node_id = book->last_node_id();
    s.last_node_sequence_id = book->last_node_sequence_id();
    s.driving = speed_mps > 0.0;
    s.paused = paused;
    s.node_states = book->node_states();
    s.edge_states = book->edge_states();
    s.action_states = action_states;
    s.errors = errors;
    s.information = information;
    s.battery.charge_percent = charge;
    s.field_violation = blocked;
    s.position = position();
    s.velocity = wire::Velocity{speed_mps, 0.0, 0.0};
    return s;
  }
  [[nodiscard]] wire::Visualization visualization(SimTime now) {
    return {header(now, visualization_header_id++), position(), wire::Velocity{speed_mps, 0.0, 0.0}};
  }
  [[nodiscard]] wire::Connection connection(SimTime now, wire::ConnectionState state) {
    return {header(now, connection_header_id++), state};
  }
  [[nodiscard]] wire::Header header(SimTime now, std::uint32_t number) const {
    return {number, now + clock_ahead, version, id.manufacturer, id.serial_number};
  }
  [[nodiscard]] std::string topic(std::string_view name) const { return wire::vda_topic(id, name); }

  std::uint32_t state_header_id{0};
  std::uint32_t visualization_header_id{0};
  std::uint32_t connection_header_id{0};

 private:
  [[nodiscard]] wire::AgvPosition position() const {
    return {pose(), zone_.name, position_known, std::nullopt, std::nullopt};
  }

  void on_order(wire::Order order) {
    orders.push_back(order);
    state_due = true;
    if (refuse_next_order) {
      refuse_next_order = false;
      errors = {{"orderError",
                 wire::ErrorLevel::warning,
                 "not today",
                 {{"orderId", order.order_id}, {"orderUpdateId", std::to_string(order.order_update_id)}}}};
      return;
    }
    const auto verdict = book->offer(order, {place(), position_known});
    if (!verdict)
      refusals.push_back(to_string(verdict.error()));
    else if (*verdict == aiv::OrderBook::Verdict::accepted_new)
      errors.clear();
  }

  void on_actions(wire::InstantActions message) {
    actions.push_back(message);
    for (const wire::Action& action : message.actions) {
      if (deaf_to.contains(action.action_type)) continue;
      const auto known = std::ranges::find(action_states, action.action_id, &wire::ActionState::action_id);
      if (known != action_states.end()) continue;
      state_due = true;
      if (refuses.contains(action.action_type)) {
        action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::failed, "not supported"});
        continue;
      }
      if (fakes.contains(action.action_type)) {
        action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::finished, ""});
        continue;
      }
      if (action.action_type == "startPause") paused = true;
      if (action.action_type == "stopPause") paused = false;
      if (action.action_type == "cancelOrder") book->cancel();
      if (action.action_type == "initPosition") position_known = true;
      if (action.action_type == "setSpeedLimit") {
        profile = action.text("profile").value_or("?");
        cruise_mps = profile == "slow" ? 0.15 : profile == "fast" ? 0.5 : 0.3;
      }
      action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::finished,
                               action.action_type == "setSpeedLimit" ? profile : ""});
    }
  }
};

class ServerBench {
 public:
  explicit ServerBench(zone::ZoneConfiguration configuration = oval(), ServerOptions options = {})
      : zone{zone::Rtm::initialise(configuration)->share_zone()}, options_{std::move(options)} {
    options_.zone = std::move(configuration);
    restart_server();
  }

  std::shared_ptr<const zone::TrafficZone> zone;
  std::unique_ptr<ServerCore> server;
  std::vector<std::unique_ptr<BenchVehicle>> vehicles;
  SimTime now{virtual_epoch};
  std::vector<wire::Publish> published;
  std::vector<std::string> logs;
  Random random{1, "bench"};
  double loss{0.0};  ///< of orders, instant actions, states and visualizations
  std::function<void()> each_step;
  SimDuration latency{4ms};

  /// Killed and started anew, with what it remembered where that is asked for.
  void restart_server(bool recall = false) {
    server = std::make_unique<ServerCore>(options_);
    echoes_.clear();
    if (recall && !memory.empty()) feed(wire::InputKind::recall, "", memory);
    feed(wire::InputKind::link, "", "up");
    for (const auto& vehicle : vehicles)
      tell(*vehicle, "connection", vda::encode(vehicle->connection(now, wire::ConnectionState::online)), true);
  }

  BenchVehicle& add(const std::string& serial, zone::Place start, const std::string& manufacturer = "CoSiVA") {
    vehicles.push_back(std::make_unique<BenchVehicle>(*zone, wire::VehicleId{manufacturer, serial}, start));
    BenchVehicle& vehicle = *vehicles.back();
    tell(vehicle, "connection", vda::encode(vehicle.connection(now, wire::ConnectionState::online)));
    return vehicle;
  }
  void tell(const BenchVehicle& vehicle, std::string_view topic, std::string payload, bool retained = false) {
    feed(wire::InputKind::message, vehicle.topic(topic), std::move(payload), retained);
  }
  void connection(BenchVehicle& vehicle, wire::ConnectionState state) {
    tell(vehicle, "connection", vda::encode(vehicle.connection(now, state)));
  }
  void command(const std::string& verb, const std::string& vehicle, const std::string& id = "") {
    std::string json = R"({"command":")" + verb + R"(","vehicle":")" + vehicle + "\"";
    if (!id.empty()) json += R"(,"id":")" + id + "\"";
    feed(wire::InputKind::command, "test", json + "}");
  }
  void kill(BenchVehicle& vehicle) {
    vehicle.alive = false;
    connection(vehicle, wire::ConnectionState::connection_broken);
  }

  /// A command of any kind, as JSON.
  void ask(std::string json) { feed(wire::InputKind::command, "test", std::move(json)); }
  /// Why the server would refuse it; empty: it would not.
  [[nodiscard]] std::string refusal(const std::string& json) const {
    const auto checked = server->check_command(json);
    return checked ? "" : to_string(checked.error());
  }

  void feed(wire::InputKind kind, std::string source, std::string payload, bool flag = false) {
    act({now, kind, std::move(source), std::move(payload), flag});
    // What the server subscribes to comes back to it, as from a broker.
    while (!echoes_.empty()) {
      const wire::Publish echo = std::move(echoes_.front());
      echoes_.pop_front();
      act({now, wire::InputKind::message, echo.topic, echo.payload, false});
    }
  }
  /// What it would remember if it were killed now.
  std::string memory;

  void run_for(SimDuration duration) {
    for (const SimTime end = now + duration; now < end;) {
      now += 20ms;
      ++steps_;
      for (const auto& vehicle : vehicles) {
        if (!vehicle->alive) continue;
        vehicle->step(20ms);
        if (steps_ % 50 == 0) vehicle->state_due = true;
        const SimTime said = now - latency;
        if (vehicle->visualizes && steps_ % 5 == 0 && !random.chance(loss))
          tell(*vehicle, "visualization", vda::encode(vehicle->visualization(said)));
        if (!vehicle->state_due) continue;
        vehicle->state_due = false;
        const std::string state = vda::encode(vehicle->state(said));
        if (!random.chance(loss)) tell(*vehicle, "state", state);
      }
      feed(wire::InputKind::tick, "", "");
      if (each_step) each_step();
    }
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
  [[nodiscard]] bool logged(std::string_view words) const {
    return std::ranges::any_of(logs, [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }

 private:
  void act(const wire::Input& input) {
    effects_.clear();
    server->handle(input, effects_);
    const wire::Effects effects = std::move(effects_);
    for (const wire::Effect& effect : effects) {
      if (const auto* log = std::get_if<wire::Log>(&effect)) logs.push_back(log->text);
      if (const auto* kept = std::get_if<wire::Remember>(&effect)) memory = kept->bytes;
      const auto* message = std::get_if<wire::Publish>(&effect);
      if (message == nullptr) continue;
      published.push_back(*message);
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

}  // namespace cosiva::virtual_side::bench
