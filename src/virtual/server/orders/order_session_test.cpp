#include "cosiva/virtual/server/orders/order_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;
using testing::SizeIs;

TEST(OrderManager, sends_a_vehicle_its_own_protocol_version) {
  ServerFixture fixture;
  FixtureVehicle& unknown_sender = fixture.add("agv-7", {0, 0.5}, "Acme");
  unknown_sender.version = "2.0.0";
  fixture.run_for(2s);
  ASSERT_FALSE(unknown_sender.orders.empty());
  EXPECT_EQ(unknown_sender.orders.front().header.version, "2.0.0");
  EXPECT_EQ(unknown_sender.orders.front().header.manufacturer, "Acme");
  EXPECT_GT(unknown_sender.driven_m, 0.1);
}

TEST(OrderManager, waits_two_seconds_after_a_refusal_and_then_sends_a_new_order) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.refuse_next_order = true;
  fixture.run_for(2s);
  ASSERT_THAT(aiv.orders, SizeIs(1));
  EXPECT_TRUE(fixture.logged("refused order"));
  fixture.run_for(3s);
  ASSERT_GE(aiv.orders.size(), 2U);
  EXPECT_NE(aiv.orders[1].order_id, aiv.orders[0].order_id);
  EXPECT_GT(aiv.driven_m, 0.1);
}

TEST(OrderManager, cancels_an_active_order_with_a_refused_update_before_sending_a_new_one) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  const std::string first = aiv.book->ids().order_id;
  aiv.refuse_next_order = true;
  fixture.run_for(10s);
  EXPECT_NE(aiv.book->ids().order_id, first);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  const bool cancelled =
      std::ranges::any_of(aiv.actions, [](const auto& m) { return m.actions[0].action_type == "cancelOrder"; });
  EXPECT_TRUE(cancelled);
  EXPECT_GT(aiv.speed_mps, 0.0);
}

TEST(OrderManager, sends_a_new_order_to_a_vehicle_that_restarted_without_its_order) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  fixture.kill(aiv);
  fixture.run_for(5s);
  aiv.alive = true;
  aiv.book.emplace(*fixture.zone);
  fixture.connection(aiv, wire::ConnectionState::online);
  const double driven_m = aiv.driven_m;
  fixture.run_for(10s);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_GT(aiv.driven_m, driven_m + 2.0);
}

TEST(OrderManager, does_not_modify_an_order_over_unknown_nodes) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  wire::State state = aiv.state(fixture.now);
  state.order_id = "theirs";
  state.node_states = {{"somewhere", 2, true, std::nullopt}};
  aiv.alive = false;
  for (int i = 0; i < 30; ++i) {
    state.header.header_id++;
    state.header.timestamp = fixture.now;
    fixture.send(aiv, "state", vda::encode(state));
    fixture.run_for(100ms);
  }
  EXPECT_THAT(fixture.published_on(aiv.topic("order")), IsEmpty());
  EXPECT_TRUE(fixture.logged("left alone"));
}

/// A vehicle on the oval that has just been sent its first order, update 0; the first node is behind the vehicle.
class Session : public testing::Test {
 protected:
  using Next = OrderSession::Next;
  using Stage = OrderSession::Stage;
  Session() : vehicle{orders.add_at("AIV1", orders.at("south", 0.55))} {
    EXPECT_TRUE(orders.extend(vehicle));
    order = *orders.last_order(vehicle);
  }
  OrderSession& session() { return orders.sessions[vehicle]; }
  /// What the vehicle reports once it has accepted the order.
  [[nodiscard]] wire::State accepted() const {
    wire::State state;
    state.order_id = order.order_id;
    state.order_update_id = order.order_update_id;
    for (const wire::OrderNode& node : order.nodes)
      if (node.sequence_id > 0) state.node_states.push_back({node.node_id, node.sequence_id, node.released, {}});
    return state;
  }
  [[nodiscard]] wire::State without_order(std::vector<wire::VehicleError> errors = {}) const {
    wire::State state;
    state.errors = std::move(errors);
    return state;
  }
  [[nodiscard]] wire::VehicleError refusal(const std::string& type = "orderError", const std::string& order_id = "",
                                           const std::string& update = "") const {
    wire::VehicleError error{type, wire::ErrorLevel::warning, "not today", {}};
    if (!order_id.empty()) error.references.push_back({"orderId", order_id});
    if (!update.empty()) error.references.push_back({"orderUpdateId", update});
    return error;
  }
  std::size_t cancellations() { return orders.actions_to(vehicle, "cancelOrder").size(); }
  [[nodiscard]] std::string digest() {
    Digest digest;
    session().fold(digest);
    return digest.hex();
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
  wire::Order order;
};

TEST_F(Session, order_numbers_nodes_and_edges_and_bounds_the_deviation) {
  EXPECT_EQ(order.order_id.substr(0, 5), "AIV1-");
  EXPECT_EQ(order.order_update_id, 0U);
  const double since_first_m =
      0.55 - orders.map->waypoint(orders.map->find(order.nodes[0].node_id).front()).position.s_m;
  ASSERT_EQ(order.edges.size() + 1, order.nodes.size());
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    const wire::OrderNode& node = order.nodes[i];
    EXPECT_EQ(node.sequence_id, 2 * i);
    EXPECT_NEAR(*node.position->allowed_deviation_xy_m, i == 0 ? 0.1 + since_first_m : 0.1, 1e-9) << i;
    EXPECT_EQ(node.position->map_id, "oval");
    if (i == 0) continue;
    const wire::OrderEdge& edge = order.edges[i - 1];
    EXPECT_EQ(edge.sequence_id, 2 * i - 1);
    EXPECT_NEAR(*edge.max_speed_mps, orders.map->zone().profiles.fast.speed_mps, 1e-9);
    const Point2 from{order.nodes[i - 1].position->x_m, order.nodes[i - 1].position->y_m};
    EXPECT_GE(*edge.length_m + 1e-3, distance(from, Point2{node.position->x_m, node.position->y_m}));
  }
  const auto released = [](const wire::OrderNode& node) { return node.released; };
  EXPECT_EQ(std::ranges::count_if(order.nodes, released), static_cast<std::ptrdiff_t>(order.nodes.size()) - 4);
  EXPECT_TRUE(session().has_horizon());
  const WaypointIndex end = session().base_end();
  EXPECT_EQ(orders.map->waypoint(end).id, order.nodes[order.nodes.size() - 5].node_id);
  EXPECT_EQ(orders.traffic.base_end(vehicle), end);
}

TEST_F(Session, order_is_repeated_every_300_ms_while_the_vehicle_is_online) {
  EXPECT_TRUE(session().awaits_acknowledgement());
  orders.pass(299ms);
  EXPECT_FALSE(session().repeat_when_due());
  orders.pass(1ms);
  orders.proxy(vehicle).connection.on_connection(wire::ConnectionState::connection_broken, orders.now);
  EXPECT_FALSE(session().repeat_when_due());
  orders.proxy(vehicle).connection.on_connection(wire::ConnectionState::online, orders.now);
  EXPECT_TRUE(session().repeat_when_due());
  EXPECT_FALSE(session().repeat_when_due());
  orders.pass(299ms);
  EXPECT_FALSE(session().repeat_when_due());
  orders.pass(1ms);
  EXPECT_TRUE(session().repeat_when_due());
  const auto sent = orders.orders_to(vehicle);
  ASSERT_THAT(sent, SizeIs(3));
  EXPECT_EQ(sent[2].header.header_id, sent[0].header.header_id + 2);
  EXPECT_EQ(sent[2].nodes, sent[0].nodes);
}

TEST_F(Session, order_is_acknowledged_by_the_state_that_lists_its_base) {
  EXPECT_EQ(session().on_state(without_order(), nullptr), Next::nothing) << "not received yet";
  EXPECT_TRUE(session().awaits_acknowledgement());
  EXPECT_EQ(session().on_state(accepted(), nullptr), Next::nothing);
  EXPECT_FALSE(session().awaits_acknowledgement());
  EXPECT_FALSE(orders.traffic.base_passed(vehicle));
  wire::State at_end = accepted();
  std::erase_if(at_end.node_states, [](const wire::NodeState& node) { return node.released; });
  at_end.last_node_id = orders.map->waypoint(session().base_end()).id;
  at_end.last_node_sequence_id = 2 * static_cast<std::uint32_t>(order.nodes.size() - 5);
  EXPECT_EQ(session().on_state(at_end, nullptr), Next::nothing);
  EXPECT_TRUE(orders.traffic.base_passed(vehicle));
}

TEST_F(Session, update_is_pending_until_the_vehicle_reports_it) {
  orders.acknowledge(vehicle);
  const wire::State before_update = accepted();
  orders.pass(1s);
  orders.report_at(vehicle, orders.at("south", 0.9));
  ASSERT_TRUE(orders.extend(vehicle));
  const wire::Order update = *orders.last_order(vehicle);
  EXPECT_EQ(update.order_id, order.order_id);
  EXPECT_EQ(update.order_update_id, 1U);
  EXPECT_EQ(update.nodes.front().node_id, order.nodes[order.nodes.size() - 5].node_id);
  EXPECT_EQ(update.nodes.front().sequence_id, order.nodes[order.nodes.size() - 5].sequence_id);
  EXPECT_EQ(update.nodes.front().position->allowed_deviation_xy_m, 0.1);
  EXPECT_TRUE(session().awaits_acknowledgement());
  EXPECT_EQ(session().on_state(before_update, nullptr), Next::nothing);
  EXPECT_TRUE(session().awaits_acknowledgement());
  orders.acknowledge(vehicle);
  EXPECT_FALSE(session().awaits_acknowledgement());
  EXPECT_EQ(session().on_state(before_update, nullptr), Next::nothing);
  EXPECT_TRUE(session().awaits_acknowledgement()) << "the vehicle has lost the update";
}

TEST_F(Session, order_that_the_vehicle_does_not_have_any_more_is_dropped) {
  orders.acknowledge(vehicle);
  EXPECT_EQ(session().on_state(without_order(), nullptr), Next::drop);
  wire::State other = accepted();
  other.order_id = "theirs";
  EXPECT_EQ(session().on_state(other, nullptr), Next::drop_then_adopt);
  wire::State cancelled = accepted();
  cancelled.node_states.clear();
  EXPECT_EQ(session().on_state(cancelled, nullptr), Next::drop) << "the route continues";
}

TEST_F(Session, order_that_was_never_acknowledged_is_void_when_the_vehicle_follows_another) {
  wire::State other = accepted();
  other.order_id = "theirs";
  EXPECT_EQ(session().on_state(other, nullptr), Next::drop_then_adopt);
}

TEST_F(Session, update_that_this_server_did_not_send_is_taken_over) {
  wire::State other = accepted();
  other.order_update_id = 4;
  EXPECT_EQ(session().on_state(other, nullptr), Next::adopt);
  EXPECT_EQ(orders.logs().back(), "w CoSiVA/AIV1: follows update 4 up to " +
                                      order.nodes[order.nodes.size() - 5].node_id +
                                      ", which this server did not send; taking it over");
  wire::State shorter = accepted();
  ASSERT_TRUE(shorter.node_states[1].released);
  for (std::size_t i = 1; i < shorter.node_states.size(); ++i) shorter.node_states[i].released = false;
  EXPECT_EQ(session().on_state(shorter, nullptr), Next::adopt) << "the same update with another base";
}

TEST_F(Session, refusal_counts_where_it_names_this_order_and_update) {
  const std::string id = order.order_id;
  struct Case {
    const char* what;
    wire::VehicleError error;
    bool refuses;
  };
  const std::vector<Case> cases{
      {"this order", refusal("orderError", id), true},
      {"this update", refusal("orderUpdateError", id, "0"), true},
      {"another order", refusal("orderError", "other"), false},
      {"another update", refusal("orderError", id, "1"), false},
      {"no reference", refusal("noRouteError"), true},
      {"an update alone", refusal("validationError", "", "7"), true},
      {"an error of another kind", refusal("batteryError", id, "0"), false},
  };
  for (const Case& one : cases) {
    OrderSession copy = session();
    EXPECT_EQ(copy.on_state(without_order({one.error}), nullptr), one.refuses ? Next::drop : Next::nothing) << one.what;
    EXPECT_EQ(copy.wait_until(), one.refuses ? orders.now + 2s : SimTime{}) << one.what;
  }
  EXPECT_THAT(orders.logs(), testing::Contains("w CoSiVA/AIV1: refused order '" + id +
                                               "' update 0 (noRouteError: not today); a new one follows"));
}

TEST_F(Session, refusal_without_a_reference_counts_only_while_it_is_new) {
  const wire::State before = without_order({refusal()});
  EXPECT_EQ(session().on_state(without_order({refusal()}), &before), Next::nothing) << "an old warning";
  const wire::State clean = without_order();
  wire::State accepts = accepted();
  accepts.errors = {refusal()};
  EXPECT_EQ(session().on_state(accepts, &clean), Next::nothing) << "the vehicle has accepted the order";
  EXPECT_FALSE(session().awaits_acknowledgement());
}

TEST_F(Session, refusal_by_a_vehicle_that_still_has_nodes_cancels_its_order_first) {
  wire::State state = accepted();
  state.order_id = "older";
  state.errors = {refusal("orderError", order.order_id)};
  EXPECT_EQ(session().on_state(state, nullptr), Next::nothing);
  EXPECT_EQ(session().stage(), Stage::cancelling);
  EXPECT_EQ(cancellations(), 1U);
  EXPECT_EQ(session().wait_until(), orders.now + 2s);
  EXPECT_EQ(session().on_state(state, nullptr), Next::nothing);
  EXPECT_EQ(session().on_state(without_order(), nullptr), Next::drop);
}

TEST_F(Session, cancellation_is_sent_again_after_five_seconds_to_a_vehicle_that_is_online) {
  session().cancel();
  EXPECT_EQ(session().stage(), Stage::cancelling);
  EXPECT_FALSE(session().is_running());
  orders.pass(4999ms);
  session().cancel_again_when_due();
  EXPECT_EQ(cancellations(), 1U);
  orders.pass(1ms);
  orders.proxy(vehicle).connection.on_connection(wire::ConnectionState::offline, orders.now);
  session().cancel_again_when_due();
  EXPECT_EQ(cancellations(), 1U);
  orders.proxy(vehicle).connection.on_connection(wire::ConnectionState::online, orders.now);
  session().cancel_again_when_due();
  session().cancel_again_when_due();
  const auto sent = orders.actions_to(vehicle, "cancelOrder");
  ASSERT_THAT(sent, SizeIs(2));
  EXPECT_NE(sent[0].action_id, sent[1].action_id);
  EXPECT_EQ(sent[0].blocking_type, wire::BlockingType::hard);
}

TEST_F(Session, running_order_is_not_cancelled_again) {
  orders.pass(10s);
  session().cancel_again_when_due();
  EXPECT_EQ(cancellations(), 0U);
  EXPECT_TRUE(session().is_running());
}

TEST_F(Session, order_that_another_sender_cancelled_gets_no_updates_and_is_cancelled_after_five_seconds) {
  session().stop_extending();
  EXPECT_EQ(session().stage(), Stage::cancelling);
  EXPECT_EQ(cancellations(), 0U);
  orders.pass(5s);
  session().cancel_again_when_due();
  EXPECT_EQ(cancellations(), 1U);
  session().drop();
  session().stop_extending();
  EXPECT_EQ(session().stage(), Stage::none) << "there is no order";
}

TEST_F(Session, dropped_order_leaves_nothing_to_repeat_or_to_cancel) {
  session().cancel();
  session().drop();
  EXPECT_EQ(session().stage(), Stage::none);
  EXPECT_EQ(session().base_end(), no_waypoint);
  EXPECT_EQ(orders.traffic.base_end(vehicle), no_waypoint);
  orders.pass(1s);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_EQ(cancellations(), 1U) << "a repeated cancelOrder would cancel the next order";
  EXPECT_FALSE(session().repeat_when_due());
  EXPECT_EQ(session().on_state(without_order(), nullptr), Next::nothing);
  EXPECT_EQ(session().on_state(accepted(), nullptr), Next::adopt);
  ASSERT_TRUE(orders.extend(vehicle));
  const wire::Order next = *orders.last_order(vehicle);
  EXPECT_NE(next.order_id, order.order_id);
  EXPECT_EQ(next.order_update_id, 0U);
  EXPECT_EQ(next.nodes.front().sequence_id, 0U);
  EXPECT_EQ(session().on_state(without_order(), nullptr), Next::nothing) << "the new order was never acknowledged";
}

TEST_F(Session, order_on_the_zone_before_is_cancelled) {
  session().leave_zone();
  EXPECT_EQ(session().stage(), Stage::cancelling);
  EXPECT_EQ(session().base_end(), no_waypoint);
  EXPECT_EQ(cancellations(), 1U);
  session().leave_zone();
  EXPECT_EQ(cancellations(), 1U);
}

TEST_F(Session, order_that_another_master_extends_with_every_state_is_logged_once) {
  OrderSession fresh{orders.context, vehicle};
  wire::State state = accepted();
  const std::size_t before = orders.logs().size();
  for (std::uint32_t update = 0; update < 100; ++update) {
    state.order_update_id = update;
    ASSERT_EQ(fresh.on_state(state, nullptr), Next::adopt) << update;
    fresh.take_over(state, std::nullopt);
  }
  EXPECT_EQ(orders.logs().size(), before + 1);
  state.order_id = "another";
  ASSERT_EQ(fresh.on_state(state, nullptr), Next::drop_then_adopt);
  fresh.take_over(state, std::nullopt);
  EXPECT_EQ(orders.logs().size(), before + 2) << "a change";
}

TEST_F(Session, order_over_this_zone_s_nodes_can_be_taken_over) {
  OrderSession fresh{orders.context, vehicle};
  wire::State state = accepted();
  EXPECT_TRUE(fresh.can_take_over(state));
  EXPECT_EQ(fresh.on_state(state, nullptr), Next::adopt);
  fresh.take_over(state, std::nullopt);
  EXPECT_TRUE(fresh.is_running());
  EXPECT_FALSE(fresh.awaits_acknowledgement());
  const std::string end = order.nodes[order.nodes.size() - 5].node_id;
  EXPECT_EQ(orders.map->waypoint(fresh.base_end()).id, end);
  EXPECT_EQ(orders.traffic.base_end(vehicle), fresh.base_end());
  EXPECT_EQ(orders.logs().back(),
            "i CoSiVA/AIV1: took over order '" + order.order_id + "', update 0, base up to " + end);
  EXPECT_EQ(fresh.on_state(state, nullptr), Next::nothing) << "it is the same order";
  EXPECT_FALSE(fresh.awaits_acknowledgement());
  orders.pass(1s);
  EXPECT_FALSE(fresh.repeat_when_due()) << "this server did not send it";
}

TEST_F(Session, order_without_an_id_or_over_other_nodes_is_left_alone_and_logged_once) {
  OrderSession fresh{orders.context, vehicle};
  wire::State state = accepted();
  state.order_id = "theirs";
  state.node_states.front().node_id = "elsewhere";
  EXPECT_FALSE(fresh.can_take_over(state));
  const std::string line =
      "i CoSiVA/AIV1: follows order 'theirs' over nodes that are not this zone's; left alone until it is done";
  EXPECT_EQ(orders.logs().back(), line);
  EXPECT_FALSE(fresh.can_take_over(state));
  const auto logs = orders.logs();
  EXPECT_EQ(std::ranges::count(logs, line), 1);
  state.order_id = "another";
  EXPECT_FALSE(fresh.can_take_over(state));
  EXPECT_THAT(orders.logs().back(), testing::HasSubstr("'another'"));
  wire::State nameless = accepted();
  nameless.order_id.clear();
  EXPECT_FALSE(OrderSession(orders.context, vehicle).can_take_over(nameless));
}

TEST_F(Session, base_of_a_vehicle_at_the_end_of_its_base_ends_at_its_last_node) {
  OrderSession fresh{orders.context, vehicle};
  wire::State state = accepted();
  for (wire::NodeState& node : state.node_states) node.released = false;
  state.last_node_id = order.nodes[1].node_id;
  state.last_node_sequence_id = 2;
  ASSERT_TRUE(fresh.can_take_over(state));
  fresh.take_over(state, std::nullopt);
  EXPECT_EQ(orders.map->waypoint(fresh.base_end()).id, order.nodes[1].node_id);
  EXPECT_TRUE(orders.traffic.base_passed(vehicle));
  EXPECT_EQ(fresh.on_state(state, nullptr), Next::nothing);
}

TEST_F(Session, digest_depends_on_stage_order_update_and_base) {
  const std::string running = digest();
  OrderSession copy = session();
  copy.set_base_end(0);
  Digest other_base;
  copy.fold(other_base);
  EXPECT_NE(other_base.hex(), running);
  orders.acknowledge(vehicle);
  EXPECT_EQ(digest(), running);
  session().stop_extending();
  EXPECT_NE(digest(), running);
}

// --- the messages themselves ----------------------------------------------------------------------------------------

TEST_F(Session, order_names_each_node_and_edge_of_the_zone_s_graph) {
  WaypointIndex at = orders.map->find(order.nodes.front().node_id).front();
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    const wire::OrderNode& node = order.nodes[i];
    EXPECT_EQ(node.node_id, orders.map->waypoint(at).id);
    EXPECT_NEAR(node.position->x_m, orders.map->point(at).x_m, 1e-9) << i;
    EXPECT_NEAR(node.position->y_m, orders.map->point(at).y_m, 1e-9) << i;
    EXPECT_FALSE(node.position->theta_rad.has_value());
    EXPECT_THAT(node.actions, IsEmpty());
    if (i + 1 == order.nodes.size()) break;
    const WaypointGraph::Stretch& stretch = orders.map->stretch(at);
    const wire::OrderEdge& edge = order.edges[i];
    EXPECT_EQ(edge.edge_id, stretch.edge_id);
    EXPECT_EQ(edge.start_node_id, node.node_id);
    EXPECT_EQ(edge.end_node_id, orders.map->waypoint(stretch.to).id);
    EXPECT_EQ(edge.released, order.nodes[i + 1].released);
    EXPECT_NEAR(*edge.length_m, stretch.length_m, 1e-9) << i;
    EXPECT_THAT(edge.actions, IsEmpty());
    at = stretch.to;
  }
}

TEST_F(Session, order_is_summarised_in_the_traces) {
  const std::size_t end = order.nodes.size() - 5;
  EXPECT_THAT(orders.server.traces.to_json(0, 1000),
              testing::HasSubstr(order.order_id + " update 0: base " + order.nodes.front().node_id + " to " +
                                 order.nodes[end].node_id + ", horizon to " + order.nodes.back().node_id));
  orders.acknowledge(vehicle);
  orders.context.rules.horizon = 0;
  orders.report_at(vehicle, orders.at("south", 0.9));
  ASSERT_TRUE(orders.extend(vehicle));
  EXPECT_FALSE(session().has_horizon());
  const wire::Order update = *orders.last_order(vehicle);
  EXPECT_TRUE(update.nodes.back().released);
  EXPECT_THAT(orders.server.traces.to_json(0, 1000),
              testing::HasSubstr(order.order_id + " update 1: base " + order.nodes[end].node_id + " to " +
                                 update.nodes.back().node_id + ", horizon to " + update.nodes.back().node_id));
}

TEST(OrderOverASlowSection, limits_the_speed_on_that_section_s_edges_alone) {
  zone::ZoneConfiguration configuration = oval();
  const std::string name = "name = \"east\"\n";
  configuration.text.insert(configuration.text.find(name) + name.size(), "speed_mps_max = 0.2\n");
  OrdersFixture orders{configuration};
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("south", 1.2));
  ASSERT_TRUE(orders.extend(vehicle));
  const wire::Order order = *orders.last_order(vehicle);
  const double fast_mps = orders.map->zone().profiles.fast.speed_mps;
  ASSERT_GT(fast_mps, 0.2);
  int slow = 0;
  for (const wire::OrderEdge& edge : order.edges) {
    const WaypointIndex start = orders.map->find(edge.start_node_id).front();
    const bool on_east = orders.map->waypoint(start).position.section == orders.section("east");
    EXPECT_NEAR(*edge.max_speed_mps, on_east ? 0.2 : fast_mps, 1e-9) << edge.edge_id;
    slow += on_east ? 1 : 0;
  }
  EXPECT_GT(slow, 1);
  EXPECT_LT(slow, static_cast<int>(order.edges.size()));
}

TEST(OrderEdges, are_driven_backwards_where_vehicles_travel_in_indirect_direction) {
  for (const bool indirect : {false, true}) {
    const auto direction = indirect ? zone::TravelDirection::indirect : zone::TravelDirection::direct;
    OrdersFixture orders{zone::in_travel_direction(oval(), direction).value()};
    const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("south", 1.2));
    ASSERT_TRUE(orders.extend(vehicle));
    const wire::Order order = *orders.last_order(vehicle);
    ASSERT_FALSE(order.edges.empty());
    for (const wire::OrderEdge& edge : order.edges)
      EXPECT_EQ(edge.backwards, indirect ? std::optional{true} : std::nullopt) << edge.edge_id;
  }
}

// --- the end of a path ----------------------------------------------------------------------------------------------

TEST(OrderToADeadEnd, is_done_when_the_vehicle_reports_its_last_node) {
  OrdersFixture orders{{"toml", "lane",
                        "name = \"lane\"\nformat_version = 1\n[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n"
                        "[circuit]\nstart = { x = 0.0, y = 0.0, heading_deg = 0 }\nclosed = false\n"
                        "[[section]]\nname = \"lane\"\nkind = \"straight\"\nlength_m = 4.0\n"}};
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("lane", 3.5));
  ASSERT_TRUE(orders.extend(vehicle));
  const wire::Order order = *orders.last_order(vehicle);
  ASSERT_TRUE(order.nodes.back().released) << "nothing follows";
  EXPECT_FALSE(orders.sessions[vehicle].has_horizon());
  orders.acknowledge(vehicle);
  wire::State state;
  state.order_id = order.order_id;
  state.last_node_id = order.nodes.back().node_id;
  state.last_node_sequence_id = order.nodes.back().sequence_id;
  EXPECT_EQ(orders.sessions[vehicle].on_state(state, nullptr), OrderSession::Next::drop);
}

// --- refusals of updates --------------------------------------------------------------------------------------------

/// The vehicle has acknowledged its order, and update 1 is pending.
class PendingUpdate : public Session {
 protected:
  PendingUpdate() {
    orders.acknowledge(vehicle);
    orders.report_at(vehicle, orders.at("south", 0.9));
    EXPECT_TRUE(orders.extend(vehicle));
    EXPECT_TRUE(session().awaits_acknowledgement());
  }
  Next report_with(const wire::VehicleError& error) {
    const wire::State before = accepted();
    wire::State state = before;
    state.errors = {error};
    return session().on_state(state, &before);
  }
};

TEST_F(PendingUpdate, is_refused_by_a_new_error_without_a_reference) {
  EXPECT_EQ(report_with(refusal("orderUpdateError")), Next::nothing);
  EXPECT_EQ(session().stage(), Stage::cancelling);
  EXPECT_EQ(session().wait_until(), orders.now + 2s);
  EXPECT_THAT(orders.logs(), testing::Contains("w CoSiVA/AIV1: refused order '" + order.order_id +
                                               "' update 1 (orderUpdateError: not today); a new one follows"));
}

TEST_F(PendingUpdate, is_not_refused_by_an_error_that_names_the_order_before) {
  EXPECT_EQ(report_with(refusal("orderUpdateError", order.order_id, "0")), Next::nothing);
  EXPECT_TRUE(session().is_running());
  EXPECT_EQ(report_with(refusal("orderUpdateError", order.order_id, "1")), Next::nothing);
  EXPECT_EQ(session().stage(), Stage::cancelling);
}

// --- orders taken over ----------------------------------------------------------------------------------------------

TEST_F(Session, order_whose_base_ends_at_an_unknown_node_is_left_alone) {
  wire::State state = accepted();
  for (wire::NodeState& node : state.node_states) node.released = false;
  state.last_node_id = "elsewhere";
  EXPECT_FALSE(OrderSession(orders.context, vehicle).can_take_over(state));
}

TEST_F(Session, order_taken_over_ends_where_its_course_does) {
  OrderSession fresh{orders.context, vehicle};
  fresh.take_over(accepted(), WaypointIndex{7});
  EXPECT_EQ(fresh.base_end(), 7U);
  EXPECT_EQ(orders.traffic.base_end(vehicle), 7U);
}

TEST_F(Session, order_taken_over_is_continued_with_its_own_numbers) {
  wire::State state = accepted();
  state.order_id = "theirs";
  state.order_update_id = 6;
  session() = OrderSession{orders.context, vehicle};
  session().take_over(state, std::nullopt);
  orders.report_at(vehicle, orders.at("south", 0.9));
  ASSERT_TRUE(orders.extend(vehicle));
  const wire::Order update = *orders.last_order(vehicle);
  const wire::OrderNode& end = order.nodes[order.nodes.size() - 5];
  EXPECT_EQ(update.order_id, "theirs");
  EXPECT_EQ(update.order_update_id, 7U);
  EXPECT_EQ(update.nodes.front().node_id, end.node_id);
  EXPECT_EQ(update.nodes.front().sequence_id, end.sequence_id);
  EXPECT_EQ(update.edges.front().sequence_id, end.sequence_id + 1);
  EXPECT_TRUE(session().awaits_acknowledgement());
  orders.pass(300ms);
  EXPECT_TRUE(session().repeat_when_due());
}

TEST_F(Session, digest_distinguishes_orders_and_updates) {
  const auto digest_of = [&](const std::string& id, std::uint32_t update) {
    OrderSession fresh{orders.context, vehicle};
    wire::State state = accepted();
    state.order_id = id;
    state.order_update_id = update;
    fresh.take_over(state, WaypointIndex{3});
    Digest digest;
    fresh.fold(digest);
    return digest.hex();
  };
  EXPECT_EQ(digest_of("a", 1), digest_of("a", 1));
  EXPECT_NE(digest_of("a", 1), digest_of("b", 1));
  EXPECT_NE(digest_of("a", 1), digest_of("a", 2));
}

// --- cancelOrder ----------------------------------------------------------------------------------------------------

TEST_F(Session, cancellation_replaces_the_one_before) {
  session().cancel();
  session().cancel();
  orders.pass(300ms);
  orders.actions.tick(orders.server.registry, true);
  const auto sent = orders.actions_to(vehicle, "cancelOrder");
  ASSERT_THAT(sent, SizeIs(3)) << "two, of which the second is repeated";
  EXPECT_EQ(sent[2].action_id, sent[1].action_id);
}

TEST_F(Session, cancellation_is_repeated_for_less_than_three_seconds) {
  session().cancel();
  orders.pass(2999ms);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_EQ(cancellations(), 2U);
  orders.pass(1ms);
  session().cancel();
  orders.pass(3s);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_EQ(cancellations(), 3U);
}

TEST_F(Session, cancellation_is_not_followed_once_the_vehicle_lists_it) {
  session().cancel();
  ASSERT_NE(orders.actions.find(1), nullptr) << "the first action of all";
  orders.report_action(vehicle, orders.actions_to(vehicle, "cancelOrder").front(), wire::ActionStatus::running);
  EXPECT_EQ(orders.actions.find(1), nullptr);
}

}  // namespace
}  // namespace cosiva::virtual_side
