#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/orders/course_planner.h"
#include "cosiva/virtual/server/orders/line_join.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/route_follower.h"
#include "cosiva/virtual/server/orders/wait_analysis.h"
#include "cosiva/virtual/server/orders/wait_records.h"
#include "cosiva/virtual/server/orders/yielding.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/virtual/server/testing/vehicle_fixture.h"

/// For tests: the parts of OrderManager, connected as there, around vehicles that the test positions. The test calls
/// each part by itself.
namespace cosiva::virtual_side::fixture {

class OrdersFixture {
 public:
  explicit OrdersFixture(const zone::ZoneConfiguration& configuration = oval()) {
    server.publisher.open(now, effects);
    const auto received = server.simulator.receive(now, configuration, step_recorder(server));
    COSIVA_EXPECT(received.has_value());
    map.emplace(server.simulator.zone());
    traffic.set_map(&*map);
    traffic.set_time(now);
    missions.set_map(&*map);
    context.map = &*map;
    context.lost_after = 1s;
  }

  SimTime now{virtual_epoch};
  wire::Effects effects;
  ServerContext server{};
  std::optional<WaypointGraph> map;
  Traffic traffic;
  InstantActionSender actions{server.publisher};
  Missions missions{server.registry, server.publisher};
  OrderContext context{server.registry, traffic, server.publisher, actions, missions, server.simulator};
  std::vector<OrderSession> sessions;
  PathPositions positions{context, sessions};
  WaitRecords waits;
  LineJoin joins{context, sessions, positions, waits};
  WaitAnalysis analysis{context, sessions, positions, joins, waits};
  CoursePlanner planner{context, sessions, positions};
  Yielding yielding{context, sessions, positions, joins, waits};
  RouteFollower follower{context, sessions, positions, waits, joins, planner, yielding};

  VehicleIndex add(const std::string& serial, const std::string& manufacturer = "CoSiVA") {
    const VehicleIndex vehicle = *server.registry.add({manufacturer, serial}, now);
    const std::size_t count = server.registry.size();
    AivProxy& added = proxy(vehicle);
    added.twin_link.on_appeared(
        server.simulator.appear(added.name(), added.identity.number(), added.augmented(), 1s, step_recorder(server)));
    added.connection.on_connection(wire::ConnectionState::online, now);
    traffic.resize(count);
    missions.resize(count);
    sessions.emplace_back(context, vehicle);
    positions.resize(count);
    waits.resize(count);
    joins.resize(count);
    analysis.resize(count);
    planner.resize(count);
    yielding.resize(count);
    return vehicle;
  }
  [[nodiscard]] AivProxy& proxy(VehicleIndex vehicle) { return server.registry[vehicle]; }
  [[nodiscard]] zone::SectionId section(std::string_view name) const { return *map->circuit().find(name); }
  [[nodiscard]] zone::TrackPosition at(std::string_view name, double s_m) const { return {section(name), s_m}; }

  /// The vehicle reports where its body is.
  void report(VehicleIndex vehicle, const Pose2& X_MB, double speed_mps = 0.0) {
    AivProxy& reporting = proxy(vehicle);
    server.simulator.report(*reporting.twin(), now, {now, X_MB, speed_mps});
    report_field(vehicle, &wire::State::driving, speed_mps != 0.0);
    reporting.position.on_position(next_stamp(), map->zone().name, X_MB);
    reporting.reports.on_report(now, now);
    const Twin& twin = server.simulator.twin(*reporting.twin());
    positions.set_reported(vehicle, {twin.reported_position(), twin.reported_off_m(), twin.heading_off_rad(), X_MB});
    traffic.update();
    joins.find_neighbours();
  }
  /// The vehicle reports its last state with this change.
  void report_change(VehicleIndex vehicle, const std::function<void(wire::State&)>& change) {
    AivProxy& reporting = proxy(vehicle);
    wire::State next = reporting.state() != nullptr ? *reporting.state() : wire::State{};
    ++next.header.header_id;
    next.header.timestamp = next_stamp();
    change(next);
    reporting.reported_state.on_state(std::make_shared<const wire::State>(std::move(next)), true);
  }
  /// The vehicle reports its last state with another value of this field.
  template <typename Value>
  void report_field(VehicleIndex vehicle, Value wire::State::*field, const std::type_identity_t<Value>& value) {
    report_change(vehicle, [&](wire::State& next) { next.*field = value; });
  }
  void report_at(VehicleIndex vehicle, zone::TrackPosition position, double speed_mps = 0.0) {
    report(vehicle, map->circuit().pose_at(position), speed_mps);
  }
  /// Adds a vehicle that is stopped there.
  VehicleIndex add_at(const std::string& serial, zone::TrackPosition position,
                      const std::string& manufacturer = "CoSiVA") {
    const VehicleIndex vehicle = add(serial, manufacturer);
    report_at(vehicle, position);
    return vehicle;
  }
  /// Adds a vehicle that is stopped to the left of a position of the path, turned to the left by `turned_rad`.
  VehicleIndex add_off_path(const std::string& serial, zone::TrackPosition position, double left_m,
                            double turned_rad = 0.0, const std::string& manufacturer = "CoSiVA") {
    const VehicleIndex vehicle = add(serial, manufacturer);
    report(vehicle, map->circuit().pose_at(position) * Pose2{0.0, left_m, turned_rad});
    return vehicle;
  }
  void pass(SimDuration duration) {
    now += duration;
    server.publisher.open(now, effects);
    traffic.set_time(now);
  }

  /// Extends the vehicle's order and sends the result. False: there was nothing to send.
  bool extend(VehicleIndex vehicle) {
    traffic.update();
    waits.begin(vehicle);
    const auto extension = follower.extend(vehicle);
    if (extension) sessions[vehicle].send(*extension);
    waits.record(vehicle, !extension || extension->base.empty(), now);
    return extension.has_value();
  }
  /// The vehicle reports the nodes of the order that was sent last, without the first one.
  void acknowledge(VehicleIndex vehicle) {
    const std::optional<wire::Order> order = last_order(vehicle);
    COSIVA_EXPECT(order.has_value());
    const wire::State before = *proxy(vehicle).state();
    report_change(vehicle, [&](wire::State& reported) {
      reported.order_id = order->order_id;
      reported.order_update_id = order->order_update_id;
      std::erase_if(reported.node_states, [](const wire::NodeState& node) { return !node.released; });
      for (const wire::OrderNode& node : order->nodes)
        if (&node != &order->nodes.front())
          reported.node_states.push_back({node.node_id, node.sequence_id, node.released, {}});
    });
    const OrderSession::Next next = sessions[vehicle].on_state(*proxy(vehicle).state(), &before);
    COSIVA_EXPECT(next == OrderSession::Next::nothing);
  }

  [[nodiscard]] std::vector<wire::Order> orders_to(VehicleIndex vehicle) {
    std::vector<wire::Order> orders;
    for (const wire::Effect& effect : effects)
      if (const auto* message = std::get_if<wire::Publish>(&effect);
          message && message->topic == proxy(vehicle).identity.order_topic())
        orders.push_back(*vda::decode_order(message->payload));
    return orders;
  }
  [[nodiscard]] std::optional<wire::Order> last_order(VehicleIndex vehicle) {
    const std::vector<wire::Order> orders = orders_to(vehicle);
    return orders.empty() ? std::nullopt : std::optional{orders.back()};
  }
  /// The instant actions of this type sent to the vehicle, oldest first.
  [[nodiscard]] std::vector<wire::Action> actions_to(VehicleIndex vehicle, std::string_view type) {
    std::vector<wire::Action> sent;
    for (const wire::Effect& effect : effects) {
      const auto* message = std::get_if<wire::Publish>(&effect);
      if (message == nullptr || message->topic != proxy(vehicle).identity.actions_topic()) continue;
      const wire::InstantActions decoded = *vda::decode_instant_actions(message->payload);
      for (const wire::Action& action : decoded.actions)
        if (action.action_type == type) sent.push_back(action);
    }
    return sent;
  }
  /// The vehicle reports the status of an action.
  void report_action(VehicleIndex vehicle, const wire::Action& action, wire::ActionStatus status,
                     const std::string& result = "") {
    report_change(vehicle, [&](wire::State& reported) {
      std::erase_if(reported.action_states,
                    [&](const wire::ActionState& known) { return known.action_id == action.action_id; });
      reported.action_states.push_back({action.action_id, action.action_type, status, result});
    });
    actions.on_state(vehicle, *proxy(vehicle).state());
  }
  [[nodiscard]] std::vector<std::string> logs() const {
    std::vector<std::string> lines;
    for (const wire::Effect& effect : effects)
      if (const auto* log = std::get_if<wire::Log>(&effect)) lines.push_back(std::string{log->level} + " " + log->text);
    return lines;
  }

 private:
  /// On the vehicles' clocks: each one is later than the one before.
  SimTime next_stamp() { return stamp_ += 1ms; }
  SimTime stamp_{virtual_epoch};
};

}  // namespace cosiva::virtual_side::fixture
