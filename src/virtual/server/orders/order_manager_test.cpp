#include "cosiva/virtual/server/orders/order_manager.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;

/// The order with another header.
wire::Order content_of(wire::Order order, const wire::Header& header) {
  order.header = header;
  return order;
}

std::vector<wire::Order> orders_to(const ServerFixture& fixture, const FixtureVehicle& aiv) {
  std::vector<wire::Order> orders;
  for (const wire::Publish& message : fixture.published_on(aiv.topic("order")))
    orders.push_back(*vda::decode_order(message.payload));
  return orders;
}

/// The requirements of VDA 5050 2.1 §6.6 on a sequence of orders, checked message by message.
void expect_stitched(const std::vector<wire::Order>& orders) {
  std::string order_id;
  std::uint32_t update_id = 0;
  const wire::OrderNode* base_end = nullptr;
  const wire::Order* before = nullptr;
  std::uint32_t header_id = 0;  // of the previous message; a restarted server starts counting again
  for (const wire::Order& order : orders) {
    const std::uint32_t header_id_before = std::exchange(header_id, order.header.header_id);
    ASSERT_EQ(order.edges.size() + 1, order.nodes.size());
    for (std::size_t i = 0; i < order.nodes.size(); ++i) {
      EXPECT_EQ(order.nodes[i].sequence_id, order.nodes[0].sequence_id + 2 * i) << "gapless";
      EXPECT_EQ(order.nodes[i].sequence_id % 2, 0U);
      ASSERT_TRUE(order.nodes[i].position.has_value());
      EXPECT_TRUE(order.nodes[i].position->allowed_deviation_xy_m.has_value());
      EXPECT_FALSE(order.nodes[i].position->theta_rad.has_value());
      if (i == 0) continue;
      const wire::OrderEdge& edge = order.edges[i - 1];
      EXPECT_EQ(edge.sequence_id, order.nodes[i].sequence_id - 1);
      EXPECT_EQ(edge.start_node_id, order.nodes[i - 1].node_id);
      EXPECT_EQ(edge.end_node_id, order.nodes[i].node_id);
      EXPECT_EQ(edge.edge_id, edge.start_node_id + "-" + edge.end_node_id);
      EXPECT_TRUE(order.nodes[i - 1].released || !order.nodes[i].released) << "no released node after the horizon";
      EXPECT_EQ(edge.released, order.nodes[i].released);
    }
    if (before != nullptr && order.order_id == before->order_id && order.order_update_id == before->order_update_id) {
      EXPECT_EQ(order, content_of(*before, order.header)) << "repeated unchanged";
      EXPECT_GT(order.header.header_id, header_id_before) << "but with its own header";
      continue;
    }
    if (order.order_id != order_id) {
      EXPECT_EQ(order.order_update_id, 0U);
    } else {
      EXPECT_EQ(order.order_update_id, update_id + 1);
      ASSERT_NE(base_end, nullptr);
      EXPECT_EQ(order.nodes[0].node_id, base_end->node_id);
      EXPECT_EQ(order.nodes[0].sequence_id, base_end->sequence_id);
      EXPECT_TRUE(order.nodes.size() > 1 && order.nodes[1].released) << "an update extends the base";
    }
    order_id = order.order_id;
    update_id = order.order_update_id;
    before = &order;
    for (const wire::OrderNode& node : order.nodes)
      if (node.released) base_end = &node;
  }
}

TEST(OrderManager, lets_an_idle_vehicle_circulate_permanently) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(120s);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  // 0.3 m/s for 120 s, minus the first second of startup: five laps of 7.14 m without a stop.
  EXPECT_GT(aiv.driven_m, 34.5);
  expect_stitched(aiv.orders);
  EXPECT_EQ(aiv.orders.front().order_update_id, 0U);
  EXPECT_EQ(aiv.orders.front().nodes.front().position->map_id, "oval");
  for (const wire::Order& order : aiv.orders) EXPECT_EQ(order.order_id, aiv.orders.front().order_id);
}

TEST(OrderManager, limits_the_base_and_announces_a_horizon_of_four) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  double longest_m = 0.0;
  fixture.each_step = [&] { longest_m = std::max(longest_m, aiv.book->distance_to_base_end_m()); };
  fixture.run_for(30s);
  // 1.2 m ahead, and at most one stretch (0.3 m) more.
  EXPECT_GT(longest_m, 1.0);
  EXPECT_LE(longest_m, 1.5 + 0.02);
  for (const wire::Order& order : aiv.orders)
    EXPECT_EQ(std::ranges::count_if(order.nodes, [](const auto& n) { return !n.released; }), 4);
}

TEST(OrderManager, never_lays_a_base_twice_over_one_position) {
  // A loop shorter than the maximum base.
  ServerFixture fixture{{"toml", "ring", R"(
name = "ring"
format_version = 1
[vehicle]
length_m = 0.10
width_m = 0.06
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
closed = true
[[section]]
name = "east"
kind = "arc"
radius_m = 0.16
angle_deg = 180
[[section]]
name = "west"
kind = "arc"
radius_m = 0.16
angle_deg = 180
)"}};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  fixture.each_step = [&] {
    std::set<std::string> base;
    for (const wire::NodeState& node : aiv.book->node_states()) {
      EXPECT_TRUE(!node.released || base.insert(node.node_id).second) << node.node_id;
    }
  };
  fixture.run_for(20s);
  EXPECT_GT(aiv.driven_m, 4.0);
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST(OrderManager, starts_an_order_at_the_waypoint_behind_the_vehicle_with_a_deviation_that_covers_the_distance) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.55});
  fixture.run_for(2s);
  ASSERT_FALSE(aiv.orders.empty());
  const wire::OrderNode& first = aiv.orders.front().nodes.front();
  const zone::Waypoint* waypoint = fixture.zone->find_waypoint(first.node_id);
  ASSERT_NE(waypoint, nullptr);
  EXPECT_LE(waypoint->position.s_m, 0.55);
  EXPECT_GE(*first.position->allowed_deviation_xy_m, 0.55 - waypoint->position.s_m);
}

TEST(OrderManager, repeats_an_order_unchanged_until_it_is_acknowledged) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.loss = 1.0;
  fixture.run_for(100ms);
  fixture.send(aiv, "state", vda::encode(aiv.state(fixture.now)));
  fixture.run_for(1500ms);
  const std::vector<wire::Order> sent = orders_to(fixture, aiv);
  ASSERT_GE(sent.size(), 3U);
  for (const wire::Order& order : sent) EXPECT_EQ(order, content_of(sent.front(), order.header));
  EXPECT_EQ(sent[1].header.timestamp - sent[0].header.timestamp, 300ms) << "each has its own time stamp";
}

TEST(OrderManager, counts_every_order_message_to_a_vehicle_including_repetitions) {
  ServerFixture fixture;
  fixture.loss = 0.3;
  const FixtureVehicle& first = fixture.add("AIV1", {0, 0.5});
  const FixtureVehicle& second = fixture.add("AIV2", {2, 0.5});
  fixture.run_for(60s);
  for (const FixtureVehicle* aiv : {&first, &second}) {
    const std::vector<wire::Order> sent = orders_to(fixture, *aiv);
    std::size_t again = 0;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_EQ(sent[i].header.header_id, i);
      if (i > 0 && sent[i].order_id == sent[i - 1].order_id && sent[i].order_update_id == sent[i - 1].order_update_id)
        ++again;
    }
    EXPECT_GT(again, 5U) << aiv->id.serial_number;
    EXPECT_GT(sent.size(), again + 20U) << aiv->id.serial_number;
  }
}

TEST(OrderManager, survives_a_link_that_loses_every_tenth_message) {
  ServerFixture fixture;
  fixture.loss = 0.1;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(120s);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_GT(aiv.driven_m, 30.0);
  // Lost messages are missing on the vehicle's side, so only the messages that the server published are a complete
  // sequence.
  expect_stitched(orders_to(fixture, aiv));
}

TEST(OrderManager, sends_no_orders_when_the_server_only_observes) {
  ServerOptions watching;
  watching.drive = false;
  ServerFixture fixture{oval(), watching};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  EXPECT_THAT(aiv.orders, IsEmpty());
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("status"), "stopped");
}

TEST(OrderManager, takes_over_an_order_after_a_restart_and_continues_it) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(20s);
  const std::string order_id = aiv.book->ids().order_id;
  const double driven_m = aiv.driven_m;
  fixture.restart_server();
  fixture.run_for(20s);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_EQ(aiv.book->ids().order_id, order_id);
  EXPECT_GT(aiv.driven_m, driven_m + 5.0);
  EXPECT_TRUE(fixture.logged("took over order"));
  expect_stitched(aiv.orders);
}

TEST(OrderManager, sends_no_order_after_a_restart_before_all_online_vehicles_have_reported) {
  ServerFixture fixture;
  FixtureVehicle& first = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& unresponsive = fixture.add("AIV2", {2, 0.5});
  unresponsive.alive = false;
  fixture.run_for(1500ms);
  EXPECT_THAT(first.orders, IsEmpty());
  fixture.run_for(1s);
  EXPECT_FALSE(first.orders.empty()) << "after 2 s at most";
}

TEST(OrderManager, sends_no_order_to_a_returned_vehicle_before_it_reports_its_position) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  fixture.kill(aiv);
  fixture.run_for(5s);
  const std::size_t orders = aiv.orders.size();
  aiv.book.emplace(*fixture.zone);
  aiv.motion = aiv::AivMotion{fixture.zone->circuit, {2, 0.5}};  // carried elsewhere
  fixture.connection(aiv, wire::ConnectionState::online);
  wire::State blind = aiv.state(fixture.now);
  blind.position.reset();
  fixture.send(aiv, "state", vda::encode(blind));
  fixture.run_for(500ms);
  EXPECT_EQ(aiv.orders.size(), orders);
  aiv.alive = true;
  fixture.run_for(2s);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_GT(aiv.orders.size(), orders);
}

TEST(OrderManager, extends_the_base_of_a_vehicle_that_passed_its_end_into_the_next_section) {
  ServerFixture fixture{zone_file("../e2e/areas/area_b.toml")};
  const zone::Circuit& circuit = fixture.zone->circuit;
  FixtureVehicle& other = fixture.add("AIV2", {*circuit.find("b_east"), 0.05});
  other.blocked = true;  // where the path from the gate merges
  FixtureVehicle& aiv = fixture.add("AIV1", {*circuit.find("gate"), 0.3});
  fixture.run_for(4s);
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"rack_b"})");
  fixture.run_for(4s);
  ASSERT_EQ(aiv.book->last_node().node_id, "gate@580") << "20 mm before the gate's end";
  ASSERT_EQ(aiv.book->distance_to_base_end_m(), 0.0);
  aiv.motion.shift(circuit, 0.03, std::array{*circuit.find("b_out1")});
  ASSERT_EQ(circuit.part(aiv.track_position().section).name, "b_out1");
  fixture.run_for(4s);
  other.blocked = false;
  fixture.run_for(40s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("mission")->text("state"), "arrived");
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST(OrderManager, drives_a_vehicle_that_reports_only_once_a_second) {
  ServerFixture fixture;
  FixtureVehicle& slow = fixture.add("agv-7", {0, 0.5}, "Acme");
  slow.visualizes = false;  // only one state per second, and the states at its nodes
  fixture.run_for(60s);
  EXPECT_THAT(slow.refusals, IsEmpty());
  EXPECT_GT(slow.driven_m, 17.0);
  EXPECT_EQ(fixture.aiv("Acme/agv-7").flag("lost"), false);
}

TEST(OrderManager, sends_the_last_known_position_to_a_vehicle_that_lost_its_position) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  aiv.position_known = false;
  const Pose2 last = aiv.pose();
  aiv.blocked = true;
  fixture.run_for(3s);
  const auto init =
      std::ranges::find_if(aiv.actions, [](const auto& m) { return m.actions[0].action_type == "initPosition"; });
  ASSERT_NE(init, aiv.actions.end());
  EXPECT_NEAR(*init->actions[0].number("x"), last.x_m, 0.05);
  EXPECT_EQ(init->actions[0].text("mapId"), "oval");
  EXPECT_TRUE(aiv.position_known);
}

// --- the manager alone ----------------------------------------------------------------------------------------------

/// An OrderManager, and vehicles that the test positions.
struct ManagedVehicles {
  explicit ManagedVehicles(const zone::ZoneConfiguration& configuration = oval()) : orders{configuration} {
    manager.set_map(&*orders.map);
  }
  VehicleIndex managed(VehicleIndex added) {
    manager.resize(orders.server.registry.size());
    manager.set_reported_pose(added, orders.positions.reported(added));
    return added;
  }
  VehicleIndex add_at(const std::string& serial, zone::TrackPosition position) {
    return managed(orders.add_at(serial, position));
  }
  /// Adds a vehicle that gets no orders.
  VehicleIndex add_still(const std::string& serial, zone::TrackPosition position) {
    const VehicleIndex added = add_at(serial, position);
    orders.proxy(added).settings.on_cancel();
    return added;
  }
  void report_at(VehicleIndex vehicle, zone::TrackPosition position, double speed_mps = 0.0) {
    orders.report_at(vehicle, position, speed_mps);
    manager.set_reported_pose(vehicle, orders.positions.reported(vehicle));
  }
  void report_state(VehicleIndex vehicle, const std::function<void(wire::State&)>& change) {
    const wire::State before = *orders.proxy(vehicle).state();
    orders.report_change(vehicle, change);
    manager.on_state(vehicle, &before);
  }
  void acknowledge(VehicleIndex vehicle) {
    const wire::Order order = *orders.last_order(vehicle);
    report_state(vehicle, [&](wire::State& state) {
      state.order_id = order.order_id;
      state.order_update_id = order.order_update_id;
      std::erase_if(state.node_states, [](const wire::NodeState& node) { return !node.released; });
      for (const wire::OrderNode& node : order.nodes)
        if (&node != &order.nodes.front())
          state.node_states.push_back({node.node_id, node.sequence_id, node.released, {}});
    });
  }
  void report_no_order(VehicleIndex vehicle) {
    report_state(vehicle, [](wire::State& state) { state.node_states.clear(); });
  }
  void report_foreign_order(VehicleIndex vehicle) {
    report_state(vehicle, [](wire::State& state) {
      state.order_id = "theirs";
      state.node_states = {{"elsewhere", 2, true, {}}};
    });
  }
  void tick(bool drive = true, bool send_off = true) { manager.tick(drive, send_off, 1h); }
  void tick_after(SimDuration duration) {
    orders.pass(duration);
    tick();
  }
  /// Sends a vehicle its order, which it acknowledges.
  VehicleIndex with_order(const std::string& serial, zone::TrackPosition position) {
    const VehicleIndex added = add_at(serial, position);
    tick();
    acknowledge(added);
    return added;
  }
  bool yields_by(VehicleIndex vehicle, Means means, VehicleIndex other) {
    return manager.yield(vehicle, means, std::vector<Wait>{{other, vehicle, WaitReason::turn}});
  }
  [[nodiscard]] std::size_t sent(VehicleIndex vehicle) { return orders.orders_to(vehicle).size(); }
  [[nodiscard]] std::size_t cancelled(VehicleIndex vehicle) { return orders.actions_to(vehicle, "cancelOrder").size(); }
  [[nodiscard]] std::ptrdiff_t logged(std::string_view phrase) const {
    const std::vector<std::string> lines = orders.logs();
    return std::ranges::count_if(lines,
                                 [&](const std::string& line) { return line.find(phrase) != std::string::npos; });
  }
  [[nodiscard]] std::string digest() const {
    Digest digest;
    manager.fold(digest);
    return digest.hex();
  }
  OrdersFixture orders;
  OrderManager manager{orders.server.registry, orders.traffic,  orders.server.publisher,
                       orders.actions,         orders.missions, orders.server.simulator};
};

TEST(ManagedOrders, are_counted_as_orders_updates_and_repetitions) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.5));
  managed.tick();
  managed.tick_after(299ms);
  EXPECT_EQ(managed.manager.counters().repeated, 0U);
  managed.tick_after(1ms);
  managed.acknowledge(vehicle);
  managed.report_at(vehicle, managed.orders.at("south", 0.9), 0.2);
  managed.tick_after(200ms);
  EXPECT_EQ(managed.manager.counters().orders, 1U);
  EXPECT_EQ(managed.manager.counters().updates, 1U);
  EXPECT_EQ(managed.manager.counters().repeated, 1U);
  EXPECT_EQ(managed.sent(vehicle), 3U);
  EXPECT_TRUE(managed.manager.has_order(vehicle));
}

TEST(ManagedOrders, are_updated_every_200_ms_at_most) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  managed.report_at(vehicle, managed.orders.at("south", 0.9), 0.2);
  managed.tick_after(199ms);
  EXPECT_EQ(managed.sent(vehicle), 1U);
  managed.tick_after(1ms);
  EXPECT_EQ(managed.sent(vehicle), 2U);
}

TEST(ManagedOrders, follow_a_refusal_after_exactly_two_seconds) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.5));
  managed.tick();
  const std::string first = managed.orders.last_order(vehicle)->order_id;
  managed.report_state(vehicle, [&](wire::State& state) {
    state.errors = {{"orderError", wire::ErrorLevel::warning, "not today", {wire::Reference{"orderId", first}}}};
  });
  EXPECT_FALSE(managed.manager.has_order(vehicle));
  managed.tick_after(1999ms);
  EXPECT_EQ(managed.sent(vehicle), 1U);
  managed.tick_after(1ms);
  EXPECT_EQ(managed.sent(vehicle), 2U);
  EXPECT_NE(managed.orders.last_order(vehicle)->order_id, first);
}

TEST(ManagedOrders, begin_only_where_vehicles_may_be_sent_off_and_continue_while_the_server_drives) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.5));
  managed.tick(false);
  managed.tick(true, false);
  EXPECT_EQ(managed.sent(vehicle), 0U);
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 1U);
  managed.orders.pass(300ms);
  managed.tick(false, false);
  EXPECT_EQ(managed.sent(vehicle), 2U) << "a pending order is repeated in any case";
  managed.acknowledge(vehicle);
  managed.report_at(vehicle, managed.orders.at("south", 0.9), 0.2);
  managed.orders.pass(200ms);
  managed.tick(false);
  EXPECT_EQ(managed.sent(vehicle), 2U);
  managed.tick(true, false);
  EXPECT_EQ(managed.sent(vehicle), 3U);
}

TEST(ManagedOrders, are_not_sent_to_a_vehicle_that_follows_another_sender_s_order) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.5));
  managed.report_foreign_order(vehicle);
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 0U);
  EXPECT_EQ(managed.logged("follows order 'theirs'"), 1);
  managed.report_no_order(vehicle);
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 1U);
}

TEST(ManagedOrders, that_an_operator_cancelled_get_no_updates_until_the_vehicle_has_no_nodes) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  managed.manager.stop_extending(vehicle);
  EXPECT_FALSE(managed.manager.has_order(vehicle));
  managed.report_at(vehicle, managed.orders.at("south", 0.9));
  managed.tick_after(1s);
  EXPECT_EQ(managed.sent(vehicle), 1U);
  managed.report_no_order(vehicle);
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 2U);
  EXPECT_EQ(managed.orders.last_order(vehicle)->order_update_id, 0U);
}

TEST(ManagedOrders, of_a_vehicle_that_is_stopped_without_a_reason_are_cancelled) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  managed.tick();
  managed.tick_after(11999ms);
  EXPECT_EQ(managed.cancelled(vehicle), 0U);
  managed.tick_after(1ms);
  EXPECT_EQ(managed.cancelled(vehicle), 1U);
  EXPECT_EQ(managed.orders.logs().back(),
            "w CoSiVA/AIV1: is stopped with base ahead and reports no reason; cancelled, a new order follows");
}

TEST(ManagedWaits, are_interrupted_while_the_server_does_not_drive) {
  ManagedVehicles managed;
  managed.add_at("AIV1", managed.orders.at("south", 0.0));
  managed.add_still("AIV2", managed.orders.at("south", 0.5));
  managed.tick();
  managed.tick_after(3s);
  EXPECT_EQ(managed.manager.longest_wait(), 3s);
  managed.orders.pass(5s);
  managed.tick(false);
  managed.tick_after(1s);
  managed.tick_after(2s);
  EXPECT_EQ(managed.manager.longest_wait(), 3s) << "the second wait lasts for two seconds so far";
  managed.tick_after(2s);
  EXPECT_EQ(managed.manager.longest_wait(), 4s);
}

TEST(ManagedWaits, for_crossings_are_withdrawn_while_the_server_does_not_drive) {
  ManagedVehicles managed{zone_file("lacet4.toml")};
  for (const zone::SectionId straight : {0U, 2U, 4U, 6U})
    managed.add_at("AIV" + std::to_string(straight), {straight, 0.6});
  managed.tick();
  EXPECT_FALSE(managed.orders.traffic.requests().empty());
  managed.tick(false);
  EXPECT_THAT(managed.orders.traffic.requests(), IsEmpty());
}

/// A vehicle 0.2 m to the left of the path, and another one where it would join the path.
struct ManagedJoin : ManagedVehicles {
  ManagedJoin()
      : vehicle{managed(orders.add_off_path("AIV1", orders.at("south", 1.0), 0.2))},
        other{add_still("AIV2", orders.at("south", 1.0))} {}
  std::vector<wire::Action> commanded() { return orders.actions_to(vehicle, "joinLine"); }
  /// Waits for a second, and is sent to another position.
  void begin() {
    tick();
    tick_after(1s);
    ASSERT_EQ(commanded().size(), 1U);
  }
  VehicleIndex vehicle;
  VehicleIndex other;
};

TEST(ManagedJoins, begin_after_a_second_and_an_order_follows) {
  ManagedJoin managed;
  managed.tick();
  managed.tick_after(999ms);
  EXPECT_THAT(managed.commanded(), IsEmpty());
  managed.tick_after(1ms);
  ASSERT_EQ(managed.commanded().size(), 1U);
  managed.tick_after(1s);
  EXPECT_EQ(managed.sent(managed.vehicle), 0U);
  managed.report_at(managed.vehicle, managed.orders.at("south", *managed.commanded()[0].number("x")));
  managed.orders.report_action(managed.vehicle, managed.commanded()[0], wire::ActionStatus::finished);
  managed.tick();
  EXPECT_EQ(managed.sent(managed.vehicle), 1U);
  EXPECT_EQ(managed.commanded().size(), 1U);
}

TEST(ManagedJoins, end_with_the_order_of_another_sender) {
  ManagedJoin managed;
  managed.begin();
  ASSERT_NE(managed.orders.actions.find(1), nullptr);
  managed.report_foreign_order(managed.vehicle);
  EXPECT_EQ(managed.orders.actions.find(1), nullptr);
}

TEST(ManagedJoins, of_an_off_path_vehicle_with_an_order_are_known_to_the_traffic) {
  ManagedVehicles managed;
  const VehicleIndex vehicle =
      managed.managed(managed.orders.add_off_path("AIV1", managed.orders.at("south", 1.0), 0.2));
  EXPECT_TRUE(managed.manager.is_off_path(vehicle));
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 1U);
  EXPECT_TRUE(managed.orders.traffic.track_position(vehicle).has_value());
}

TEST(ManagedMoves, towards_the_leader_end_with_the_order) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.0));
  const VehicleIndex leader =
      managed.add_still("AIV2", managed.orders.at("south", managed.orders.map->stretch(0).length_m + 0.25));
  ASSERT_TRUE(managed.yields_by(vehicle, Means::move_up, leader));
  managed.report_no_order(vehicle);
  ASSERT_FALSE(managed.manager.has_order(vehicle));
  managed.tick_after(1s);
  EXPECT_EQ(managed.sent(vehicle), 1U) << "there is no room for a stretch";
}

// --- vehicles removed, and zones switched ---------------------------------------------------------------------------

TEST(ForgottenVehicle, gets_a_new_order_once_it_reports_its_position) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  managed.manager.forget(vehicle);
  EXPECT_FALSE(managed.manager.has_order(vehicle));
  managed.report_no_order(vehicle);
  managed.tick_after(1s);
  EXPECT_EQ(managed.sent(vehicle), 1U);
  managed.report_at(vehicle, managed.orders.at("south", 0.5));
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 2U);
  EXPECT_EQ(managed.cancelled(vehicle), 0U);
}

TEST(ForgottenVehicle, does_not_join_the_path_any_more) {
  ManagedJoin managed;
  managed.begin();
  managed.manager.forget(managed.vehicle);
  managed.report_at(managed.vehicle, managed.orders.at("south", 1.45));
  managed.tick();
  EXPECT_EQ(managed.sent(managed.vehicle), 1U);
}

TEST(ForgottenVehicle, begins_to_wait_again) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.0));
  managed.add_still("AIV2", managed.orders.at("south", 0.5));
  managed.tick();
  managed.manager.forget(vehicle);
  managed.report_at(vehicle, managed.orders.at("south", 0.0));
  managed.tick_after(5s);
  EXPECT_EQ(managed.manager.longest_wait(), 0s);
}

TEST(ForgottenVehicle, is_not_unresponsive_since_its_former_order) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  managed.tick();
  managed.orders.pass(11s);
  managed.manager.forget(vehicle);
  managed.report_no_order(vehicle);
  managed.report_at(vehicle, managed.orders.at("south", 0.5));
  managed.tick();
  ASSERT_EQ(managed.sent(vehicle), 2U);
  managed.acknowledge(vehicle);
  managed.tick_after(1s);
  EXPECT_EQ(managed.cancelled(vehicle), 0U);
}

TEST(ForgottenVehicle, is_planned_for_again) {
  ManagedVehicles managed{fork()};
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("entry", 0.3));
  managed.orders.missions.give(vehicle, {Mission::Kind::go, "gate"});
  managed.orders.missions.set_closed({managed.orders.section("south"), managed.orders.section("bypass1")});
  managed.tick();
  managed.tick();
  EXPECT_EQ(managed.logged("no route"), 1);
  managed.manager.forget(vehicle);
  managed.report_at(vehicle, managed.orders.at("entry", 0.3));
  managed.tick();
  EXPECT_EQ(managed.logged("no route"), 2);
  managed.manager.set_map(&*managed.orders.map);
  managed.report_at(vehicle, managed.orders.at("entry", 0.3));
  managed.tick();
  EXPECT_EQ(managed.logged("no route"), 3);
}

TEST(ForgottenVehicle, does_not_yield) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  const VehicleIndex other = managed.add_still("AIV2", managed.orders.at("north", 0.5));
  ASSERT_TRUE(managed.yields_by(vehicle, Means::wait, other));
  EXPECT_TRUE(managed.manager.yields(vehicle));
  managed.manager.forget(vehicle);
  EXPECT_FALSE(managed.manager.yields(vehicle));
}

TEST(SwitchedZone, cancels_the_orders_and_needs_new_positions) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  managed.manager.set_map(&*managed.orders.map);
  EXPECT_EQ(managed.cancelled(vehicle), 1U);
  EXPECT_FALSE(managed.manager.has_order(vehicle));
  managed.report_no_order(vehicle);
  managed.tick_after(1s);
  EXPECT_EQ(managed.sent(vehicle), 1U);
  managed.report_at(vehicle, managed.orders.at("south", 0.5));
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 2U);
}

TEST(SwitchedZone, ends_joining_and_yielding) {
  ManagedJoin managed;
  managed.begin();
  ASSERT_TRUE(managed.yields_by(managed.other, Means::wait, managed.vehicle));
  managed.manager.set_map(&*managed.orders.map);
  EXPECT_EQ(managed.orders.actions.find(1), nullptr);
  EXPECT_FALSE(managed.manager.yields(managed.other));
  managed.report_at(managed.vehicle, managed.orders.at("south", 1.45));
  managed.tick();
  EXPECT_EQ(managed.sent(managed.vehicle), 1U);
}

TEST(SwitchedZone, that_is_missing_stops_everything) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.5));
  managed.manager.set_map(nullptr);
  managed.report_foreign_order(vehicle);
  managed.tick();
  EXPECT_EQ(managed.sent(vehicle), 0U);
  EXPECT_THAT(managed.orders.logs(), IsEmpty());
}

// --- the digest -----------------------------------------------------------------------------------------------------

/// After an order of a vehicle that was then forgotten, with or without an update or a repetition.
std::string digest_after_order(bool repeated, bool updated) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.add_at("AIV1", managed.orders.at("south", 0.5));
  managed.tick();
  managed.orders.pass(300ms);
  if (repeated) managed.tick();
  managed.acknowledge(vehicle);
  managed.report_at(vehicle, managed.orders.at("south", 0.9), 0.2);
  managed.orders.pass(200ms);
  if (updated) managed.tick();
  managed.manager.forget(vehicle);
  return managed.digest();
}

TEST(ManagedOrders, count_in_the_digest) {
  ManagedVehicles managed;
  managed.add_at("AIV1", managed.orders.at("south", 0.5));
  const std::string order = digest_after_order(false, false);
  EXPECT_NE(order, managed.digest());
  EXPECT_NE(digest_after_order(true, false), order);
  EXPECT_NE(digest_after_order(false, true), order);
  EXPECT_NE(digest_after_order(false, true), digest_after_order(true, false));
}

TEST(ManagedOrders, and_vehicles_that_yield_count_in_the_digest) {
  ManagedVehicles managed;
  const VehicleIndex vehicle = managed.with_order("AIV1", managed.orders.at("south", 0.5));
  const VehicleIndex other = managed.add_still("AIV2", managed.orders.at("north", 0.5));
  const std::string before = managed.digest();
  ASSERT_TRUE(managed.yields_by(vehicle, Means::wait, other));
  EXPECT_NE(managed.digest(), before);
}

}  // namespace
}  // namespace cosiva::virtual_side
