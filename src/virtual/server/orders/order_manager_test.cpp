#include "cosiva/virtual/server/testing/server_fixture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

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

}  // namespace
}  // namespace cosiva::virtual_side
