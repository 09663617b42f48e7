#include "cosiva/virtual/server/orders/route_follower.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::ContainsRegex;
using testing::IsEmpty;
using testing::SizeIs;

// --- which vehicles get orders --------------------------------------------------------------------------------------

struct Hindrance {
  std::string name;
  std::function<void(OrdersFixture&, VehicleIndex)> happen;
};

std::vector<Hindrance> hindrances() {
  return {
      {"manual mode",
       [](auto& orders, auto vehicle) {
         orders.report_field(vehicle, &wire::State::operating_mode, wire::OperatingMode::manual);
       }},
      {"pause", [](auto& orders, auto vehicle) { orders.report_field(vehicle, &wire::State::paused, true); }},
      {"emergency stop",
       [](auto& orders, auto vehicle) { orders.report_field(vehicle, &wire::State::e_stop, wire::EStop::manual); }},
      {"cancelled by an operator", [](auto& orders, auto vehicle) { orders.proxy(vehicle).settings.on_cancel(); }},
      {"offline", [](auto& orders, auto vehicle) { orders.proxy(vehicle).connection.on_offline(orders.now); }},
      {"no state in this session",
       [](auto& orders, auto vehicle) { orders.proxy(vehicle).reported_state.on_session(); }},
      {"position lost",
       [](auto& orders, auto vehicle) { orders.proxy(vehicle).position.on_lost(orders.now + 1h, "oval", orders.now); }},
      {"another map",
       [](auto& orders, auto vehicle) {
         orders.proxy(vehicle).position.on_position(orders.now + 1h, "elsewhere", {1.0, 0.0, 0.0});
       }},
      {"not on the circuit",
       [](auto& orders, auto vehicle) {
         orders.positions.set_reported(vehicle, {std::nullopt, 0.0, 0.0, {}});
       }},
  };
}

class Orders : public testing::Test {
 protected:
  [[nodiscard]] bool go_to(VehicleIndex vehicle) const { return orders.follower.may_extend(vehicle); }
  /// A vehicle whose reported pose is this far from the path, with this heading error.
  VehicleIndex off_path_by(double off_m, double heading_off_rad, const std::string& manufacturer = "Acme") {
    const VehicleIndex vehicle = orders.add_at("AIV" + std::to_string(++number), orders.at("south", 1.0), manufacturer);
    orders.positions.set_reported(vehicle, {orders.at("south", 1.0), off_m, heading_off_rad, {1.0, 0.0, 0.0}});
    return vehicle;
  }
  OrdersFixture orders;
  int number{0};
};

TEST_F(Orders, go_to_no_vehicle_that_cannot_drive_or_that_others_control) {
  for (const Hindrance& hindrance : hindrances()) {
    const VehicleIndex vehicle = orders.add_at("AIV" + std::to_string(++number), orders.at("south", 1.0));
    EXPECT_TRUE(go_to(vehicle)) << hindrance.name;
    hindrance.happen(orders, vehicle);
    EXPECT_FALSE(go_to(vehicle)) << hindrance.name;
  }
  EXPECT_FALSE(go_to(orders.add("AIV99"))) << "it has not reported its state yet";
}

TEST_F(Orders, go_to_a_vehicle_that_does_not_name_its_map) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("south", 1.0));
  orders.proxy(vehicle).position.on_position(orders.now + 1h, "", {1.0, 0.0, 0.0});
  EXPECT_TRUE(go_to(vehicle));
}

TEST_F(Orders, go_to_a_vehicle_until_it_is_lost) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("south", 1.0));
  orders.pass(orders.proxy(vehicle).reports.longest_silence(1s));
  EXPECT_TRUE(go_to(vehicle));
  orders.pass(1ms);
  EXPECT_FALSE(go_to(vehicle));
}

TEST_F(Orders, go_to_vehicles_within_thirty_centimetres_and_sixty_degrees_of_the_path) {
  EXPECT_TRUE(go_to(off_path_by(0.30, 0.0)));
  EXPECT_FALSE(go_to(off_path_by(0.3001, 0.0)));
  EXPECT_TRUE(go_to(off_path_by(0.0, pi / 3.0)));
  EXPECT_FALSE(go_to(off_path_by(0.0, pi / 3.0 + 1e-6)));
  EXPECT_FALSE(go_to(off_path_by(0.0, -pi / 3.0 - 1e-6)));
  EXPECT_TRUE(go_to(off_path_by(0.0, 2.0, "CoSiVA"))) << "it turns onto the path by itself";
}

// --- how far a base reaches -----------------------------------------------------------------------------------------

void limit_base(OrdersFixture& orders, double reach_m, std::size_t nodes_max = 16) {
  orders.context.rules = OrderRules{reach_m};
  orders.context.rules.base_nodes_max = nodes_max;
}
/// The lengths of an order's released edges.
std::vector<double> base_lengths(const wire::Order& order) {
  std::vector<double> lengths;
  for (const wire::OrderEdge& edge : order.edges)
    if (edge.released) lengths.push_back(*edge.length_m);
  return lengths;
}
std::size_t horizon_size(const wire::Order& order) { return order.edges.size() - base_lengths(order).size(); }

/// A vehicle at the first waypoint of the oval.
class Base : public testing::Test {
 protected:
  Base() : vehicle{orders.add_at("AIV1", orders.at("south", 0.0))} {}
  wire::Order extended() {
    EXPECT_TRUE(orders.extend(vehicle));
    return *orders.last_order(vehicle);
  }
  [[nodiscard]] double spacing_m() const { return orders.map->stretch(0).length_m; }
  [[nodiscard]] const WaitRecord& wait() const { return orders.waits[vehicle]; }
  OrdersFixture orders;
  VehicleIndex vehicle;
};

TEST_F(Base, ends_at_the_first_waypoint_that_is_as_far_as_a_base_is_to_reach) {
  double exact_m = 0.0;
  for (WaypointIndex at = 0; at < 3; ++at) exact_m += orders.map->stretch(at).length_m;
  limit_base(orders, exact_m);
  EXPECT_THAT(base_lengths(extended()), SizeIs(3)) << "exactly as far";
  orders.sessions[vehicle].drop();
  limit_base(orders, exact_m + 1e-6);
  EXPECT_THAT(base_lengths(extended()), SizeIs(4));
}

TEST_F(Base, has_at_most_the_given_number_of_stretches_and_the_horizon_too) {
  orders.context.rules.base_nodes_max = 2;
  orders.context.rules.horizon = 3;
  const wire::Order order = extended();
  EXPECT_THAT(base_lengths(order), SizeIs(2));
  EXPECT_EQ(horizon_size(order), 3U);
  for (std::size_t i = 0; i + 1 < order.nodes.size(); ++i)
    EXPECT_EQ(orders.map->waypoint(orders.map->stretch(orders.map->find(order.nodes[i].node_id).front()).to).id,
              order.nodes[i + 1].node_id)
        << "each waypoint follows the one before";
}

TEST_F(Base, of_a_new_order_covers_the_oval_once_from_any_waypoint) {
  limit_base(orders, 100.0, 100);
  for (WaypointIndex start = 0; start < orders.map->size(); ++start) {
    orders.report_at(vehicle, orders.map->circuit().advance(orders.map->waypoint(start).position, 0.001));
    const wire::Order order = extended();
    EXPECT_EQ(order.nodes.front().node_id, orders.map->waypoint(start).id);
    EXPECT_EQ(base_lengths(order).size() + 1, orders.map->size()) << start;
    orders.sessions[vehicle].drop();
  }
}

TEST_F(Base, of_an_order_on_the_oval_is_extended_up_to_the_waypoint_behind_the_vehicle) {
  EXPECT_FALSE(base_lengths(extended()).empty());
  orders.acknowledge(vehicle);
  limit_base(orders, 100.0, 100);
  orders.report_at(vehicle, orders.at("south", 1.5 * spacing_m()), 0.2);
  EXPECT_FALSE(base_lengths(extended()).empty());
  EXPECT_EQ(orders.sessions[vehicle].base_end(), 1U) << "the vehicle is between waypoints 1 and 2";
}

TEST_F(Base, of_a_vehicle_exactly_on_a_waypoint_is_extended_up_to_the_waypoint_before) {
  EXPECT_FALSE(base_lengths(extended()).empty());
  orders.acknowledge(vehicle);
  limit_base(orders, 100.0, 100);
  orders.report_at(vehicle, orders.map->waypoint(2).position, 0.2);
  EXPECT_FALSE(base_lengths(extended()).empty());
  EXPECT_EQ(orders.sessions[vehicle].base_end(), 1U);
}

TEST_F(Base, keeps_a_body_and_the_gap_behind_the_leader) {
  const VehicleIndex leader = orders.add_at("AIV2", orders.at("south", 1.0));
  const double room_m = 1.0 - 0.20 - 0.10;
  EXPECT_THAT(base_lengths(extended()), SizeIs(static_cast<std::size_t>(std::floor(room_m / spacing_m()))));
  EXPECT_EQ(wait().blocker, leader);
  EXPECT_EQ(wait().why, WaitReason{}) << "the other one is in front";
  EXPECT_FALSE(wait().crossing.has_value());
  EXPECT_FALSE(wait().since.has_value()) << "it got a base; it is informed early";
}

TEST_F(Base, is_extended_once_nearer_to_the_leader_when_the_vehicle_moves_up) {
  const VehicleIndex leader = orders.add_at("AIV2", orders.at("south", spacing_m() + 0.25));
  EXPECT_FALSE(orders.extend(vehicle));
  EXPECT_EQ(wait().blocker, leader);
  EXPECT_EQ(wait().since, orders.now);
  const std::vector<Wait> waits{{leader, vehicle, WaitReason::turn}};
  ASSERT_TRUE(orders.yielding.yield(vehicle, Means::move_up, waits));
  EXPECT_THAT(base_lengths(extended()), SizeIs(1));
  EXPECT_FALSE(orders.yielding.moves_up(vehicle));
}

TEST_F(Base, ends_before_a_body_next_to_the_path) {
  const VehicleIndex body = orders.add_off_path("AIV2", orders.at("south", 1.0), 0.15);
  // Bodies of 0.12 m width, 0.15 m apart: less than the clearance of 0.04 m between them.
  const wire::Order order = extended();
  double reach_m = 0.0;
  for (const double length_m : base_lengths(order)) reach_m += length_m;
  EXPECT_LT(reach_m, 1.0 - 0.20);
  EXPECT_GT(reach_m, 0.0);
  EXPECT_EQ(wait().blocker, body);
  EXPECT_EQ(wait().why, WaitReason::off_path);
}

/// A vehicle on the fork zone whose base ends on the north side: one lap is more than the 8 m that a base is searched.
class PastItsBase : public testing::Test {
 protected:
  PastItsBase() : orders{fork()}, vehicle{orders.add_at("AIV1", orders.at("north", 0.5))} {
    EXPECT_TRUE(orders.extend(vehicle));
    orders.acknowledge(vehicle);
  }
  bool extended_beyond_end(double beyond_m) {
    const zone::TrackPosition end = orders.map->waypoint(orders.sessions[vehicle].base_end()).position;
    orders.report_at(vehicle, orders.map->circuit().advance(end, beyond_m));
    return orders.extend(vehicle);
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
};

TEST_F(PastItsBase, vehicle_continues_its_order_up_to_a_quarter_of_a_metre) {
  EXPECT_TRUE(extended_beyond_end(0.24));
  EXPECT_EQ(orders.sessions[vehicle].stage(), OrderSession::Stage::running);
}

TEST_F(PastItsBase, vehicle_further_on_gets_a_new_order) {
  EXPECT_FALSE(extended_beyond_end(0.30));
  EXPECT_EQ(orders.sessions[vehicle].stage(), OrderSession::Stage::cancelling);
  EXPECT_EQ(orders.sessions[vehicle].wait_until(), orders.now + 2s);
  EXPECT_THAT(orders.actions_to(vehicle, "cancelOrder"), SizeIs(1));
  EXPECT_THAT(orders.logs(), Contains("w CoSiVA/AIV1: is not on the route of its order; cancelled, a new one follows"));
}

TEST_F(Base, is_not_extended_but_its_horizon_removed_where_the_mission_ends_at_its_end) {
  (void)extended();
  orders.acknowledge(vehicle);
  const std::string end = orders.map->waypoint(orders.sessions[vehicle].base_end()).id;
  orders.missions.give(vehicle, {Mission::Kind::go, end});
  const wire::Order update = extended();
  EXPECT_EQ(update.order_update_id, 1U);
  ASSERT_THAT(update.nodes, SizeIs(1));
  EXPECT_EQ(update.nodes.front().node_id, end);
  EXPECT_FALSE(orders.sessions[vehicle].has_horizon());
  orders.acknowledge(vehicle);
  EXPECT_FALSE(orders.extend(vehicle)) << "nothing is announced any more";
}

// --- the first node of an order -------------------------------------------------------------------------------------

/// The oval with waypoints only at the joints of its sections: the south side is 2 m long.
class FirstNode : public testing::Test {
 protected:
  static zone::ZoneConfiguration oval_of_joints() {
    zone::ZoneConfiguration configuration = oval();
    configuration.text += "\n[waypoints]\nspacing_m = 1000.0\n";
    return configuration;
  }
  /// The id of the first node of an order to a vehicle there, and the deviation that its node allows.
  std::pair<std::string, double> of_order_from(zone::TrackPosition position, double off_m = 0.0) {
    OrdersFixture orders{oval_of_joints()};
    const VehicleIndex vehicle = orders.add_off_path("agv-1", position, off_m, 0.0, "Acme");
    orders.missions.give(vehicle, {Mission::Kind::go, north});
    if (!orders.extend(vehicle)) return {"none", 0.0};
    const wire::OrderNode node = orders.last_order(vehicle)->nodes.front();
    return {node.node_id, *node.position->allowed_deviation_xy_m};
  }
  OrdersFixture any{oval_of_joints()};
  std::string south{any.map->waypoint(any.map->behind(any.at("south", 0.5))->waypoint).id};
  std::string east{any.map->waypoint(any.map->behind(any.at("east", 0.5))->waypoint).id};
  std::string north{any.map->waypoint(any.map->behind(any.at("north", 0.5))->waypoint).id};
};

TEST_F(FirstNode, is_the_one_behind_the_vehicle_unless_it_is_far_behind_and_the_next_one_near) {
  const auto expect = [&](double s_m, const std::string& id, double away_m) {
    const auto [node, deviation_m] = of_order_from(any.at("south", s_m));
    EXPECT_EQ(node, id) << s_m;
    EXPECT_NEAR(deviation_m, 0.10 + away_m, 1e-9) << s_m;
  };
  ASSERT_NE(south, east);
  expect(0.0, south, 0.0);
  expect(0.9, south, 0.9);
  expect(1.1, south, 1.1);
  expect(1.89, south, 1.89);
  expect(1.91, east, 0.09);
}

TEST_F(FirstNode, allows_the_distance_of_the_vehicle_from_the_path_in_addition) {
  EXPECT_NEAR(of_order_from(any.at("south", 0.5), 0.15).second, 0.10 + 0.5 + 0.15, 1e-9);
}

// --- crossings ------------------------------------------------------------------------------------------------------

/// The fork zone: the stop line is the last waypoint before the fork, on the section "entry".
class Chain : public testing::Test {
 protected:
  Chain() : orders{fork()}, stop{orders.map->behind(orders.at("entry", 1.0))->waypoint} {}
  [[nodiscard]] zone::TrackPosition before_stop(double before_m) const {
    return orders.map->circuit().advance(orders.map->waypoint(stop).position, -before_m);
  }
  VehicleIndex add_before_stop(const std::string& serial, double before_m) {
    return orders.add_at(serial, before_stop(before_m));
  }
  OrdersFixture orders;
  WaypointIndex stop;
};

TEST_F(Chain, is_released_as_a_whole_from_70_cm_before_its_stop_line_on) {
  const VehicleIndex near = add_before_stop("AIV1", 0.69);
  limit_base(orders, 0.70);
  ASSERT_TRUE(orders.extend(near));
  EXPECT_EQ(orders.sessions[near].base_end(), orders.map->chain(stop).exit) << "although a base need not reach so far";
}

TEST_F(Chain, is_not_requested_by_a_vehicle_further_from_its_stop_line) {
  const VehicleIndex far = add_before_stop("AIV1", 0.71);
  ASSERT_TRUE(orders.extend(far));
  EXPECT_EQ(orders.sessions[far].base_end(), stop) << "it may drive to the stop line";
  EXPECT_THAT(orders.traffic.requests(), IsEmpty());
  EXPECT_FALSE(orders.waits[far].crossing.has_value());
}

TEST_F(Chain, longer_than_a_third_party_vehicle_may_drive_without_control_is_released_only_when_it_would_brake) {
  // At 0.5 m/s it may drive 0.5 m, and needs 0.41 m ahead of it.
  orders.context.rules.permitted_time = 1s;
  ASSERT_GT(orders.map->chain(stop).length_m, 0.5);
  const VehicleIndex far = orders.add_at("AIV1", before_stop(0.45), "Acme");
  ASSERT_TRUE(orders.extend(far));
  EXPECT_EQ(orders.sessions[far].base_end(), stop);
  EXPECT_THAT(orders.traffic.requests(), IsEmpty());
  orders.acknowledge(far);
  orders.report_at(far, before_stop(0.40), 0.5);
  ASSERT_TRUE(orders.extend(far));
  EXPECT_EQ(orders.sessions[far].base_end(), orders.map->chain(stop).exit) << "no vehicle stops in a crossing";
}

TEST_F(Chain, that_another_vehicle_occupies_is_waited_for) {
  const VehicleIndex inside = orders.add_at("AIV1", orders.at("bypass1", 0.1));
  const VehicleIndex vehicle = add_before_stop("AIV2", 0.0);
  orders.missions.give(vehicle, {Mission::Kind::go, "gate"});
  EXPECT_FALSE(orders.extend(vehicle));
  EXPECT_EQ(orders.waits[vehicle].blocker, inside);
  EXPECT_EQ(orders.waits[vehicle].since, orders.now);
}

/// Two vehicles at the stop line of the clover's eastward straight, the first one half through.
class Convoy : public testing::Test {
 protected:
  Convoy() : orders{zone_file("lacet4.toml")} {
    for (WaypointIndex i = 0; i < orders.map->size() && stop == no_waypoint; ++i)
      if (orders.map->waypoint(i).position.section == 0 && orders.map->stretch(i).crosses) stop = i;
    leader = orders.add_at("AIV1", before_stop(0.0));
    EXPECT_TRUE(orders.extend(leader));
    orders.acknowledge(leader);
    // Its base leads 0.8 m beyond the exit, so that another vehicle has room behind it.
    limit_base(orders, 2.0);
    orders.report_at(leader, before_stop(-0.1), 0.2);
    EXPECT_TRUE(orders.extend(leader));
    orders.acknowledge(leader);
    orders.report_at(leader, before_stop(-0.35), 0.2);
    follower = orders.add_at("AIV2", before_stop(0.0));
  }
  [[nodiscard]] zone::TrackPosition before_stop(double before_m) const {
    return orders.map->circuit().advance(orders.map->waypoint(stop).position, -before_m);
  }
  OrdersFixture orders;
  WaypointIndex stop{no_waypoint};
  VehicleIndex leader{};
  VehicleIndex follower{};
};

TEST_F(Convoy, leads_a_base_through_the_chain_behind_the_leader_and_explains_why) {
  ASSERT_TRUE(orders.extend(follower));
  EXPECT_EQ(orders.traffic.convoys(), 1U);
  const double left_m = *orders.traffic.base_left_m(follower, *orders.positions.reported(follower).position);
  EXPECT_NEAR(left_m, orders.map->chain(stop).length_m, 1e-9) << "to the exit, and not nearer to the leader";
  EXPECT_THAT(orders.server.traces.to_json(0, 1000),
              ContainsRegex("convoy of 2 through X[0-9]+ and X[0-9]+, behind CoSiVA/AIV1"));
}

TEST_F(Convoy, is_not_formed_behind_a_leader_that_will_not_make_room) {
  orders.report_field(leader, &wire::State::paused, true);
  EXPECT_FALSE(orders.extend(follower));
  EXPECT_EQ(orders.traffic.convoys(), 0U);
  EXPECT_EQ(orders.waits[follower].blocker, leader);
}

TEST_F(Convoy, is_not_formed_behind_a_leader_that_yields) {
  const std::vector<Wait> waits{{follower, leader, WaitReason::turn}};
  ASSERT_TRUE(orders.yielding.yield(leader, Means::wait, waits));
  EXPECT_FALSE(orders.extend(follower));
  EXPECT_EQ(orders.traffic.convoys(), 0U);
}

TEST_F(Convoy, is_not_formed_by_a_vehicle_whose_sensor_does_not_detect_the_leader) {
  const VehicleIndex foreign = orders.add_at("agv-1", before_stop(0.0), "Acme");
  orders.report_at(follower, before_stop(3.0));
  EXPECT_FALSE(orders.extend(foreign));
  EXPECT_EQ(orders.traffic.convoys(), 0U);
}

// --- vehicles off the path ---------------------------------------------------------------------------------------

TEST(OffPathVehicle, is_sent_to_the_nearest_position_of_the_path_unless_a_body_is_there) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 0.9), 0.25);
  ASSERT_TRUE(orders.extend(vehicle));
  ASSERT_TRUE(orders.positions.entry_point(vehicle).has_value());
  EXPECT_NEAR(orders.positions.entry_point(vehicle)->s_m, 0.9, 1e-9);
  EXPECT_TRUE(orders.traffic.track_position(vehicle).has_value());
  const double since_m = 0.9 - orders.map->waypoint(orders.map->behind(orders.at("south", 0.9))->waypoint).position.s_m;
  EXPECT_NEAR(*orders.last_order(vehicle)->nodes.front().position->allowed_deviation_xy_m, 0.10 + since_m + 0.25, 1e-6);

  const VehicleIndex later = orders.add_off_path("AIV2", orders.at("south", 0.9), -0.25);
  EXPECT_FALSE(orders.extend(later));
  EXPECT_EQ(orders.waits[later].blocker, vehicle);
  EXPECT_EQ(orders.waits[later].why, WaitReason::off_path);
  EXPECT_FALSE(orders.positions.entry_point(later).has_value());
}

TEST(OffPathVehicle, that_got_no_order_stays_off_the_path_for_the_others) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 0.9), 0.25);
  const VehicleIndex behind = orders.add_at("AIV2", orders.at("south", 0.2));
  orders.follower.keep_off_path(vehicle);
  orders.positions.set_entry_point(vehicle, orders.at("south", 0.9));
  orders.traffic.set_position(vehicle, orders.at("south", 0.9));
  orders.traffic.update();
  EXPECT_NEAR(orders.traffic.reach_m(behind), 0.9 - 0.2 - 0.3, 1e-9) << "up to a body and the gap behind it";
  orders.follower.keep_off_path(vehicle);
  EXPECT_FALSE(orders.positions.entry_point(vehicle).has_value());
  EXPECT_FALSE(orders.traffic.track_position(vehicle).has_value());
  EXPECT_GT(orders.traffic.reach_m(behind), 6.0);
}

// --- updates --------------------------------------------------------------------------------------------------------

TEST_F(Base, of_an_update_begins_at_the_end_of_the_base_with_the_usual_deviation) {
  (void)extended();
  orders.acknowledge(vehicle);
  const std::string end = orders.map->waypoint(orders.sessions[vehicle].base_end()).id;
  orders.report_at(vehicle, orders.at("south", 0.9), 0.2);
  const wire::Order update = extended();
  EXPECT_EQ(update.order_update_id, 1U);
  EXPECT_EQ(update.nodes.front().node_id, end);
  EXPECT_EQ(update.nodes.front().position->allowed_deviation_xy_m, 0.10);
}

TEST_F(Base, that_ends_behind_the_leader_gets_no_further_message_until_there_is_room) {
  const VehicleIndex leader = orders.add_at("AIV2", orders.at("south", 1.0));
  EXPECT_FALSE(extended().nodes.back().released) << "it announces a horizon";
  orders.acknowledge(vehicle);
  EXPECT_FALSE(orders.extend(vehicle));
  EXPECT_THAT(orders.orders_to(vehicle), SizeIs(1));
  EXPECT_EQ(wait().blocker, leader);
  EXPECT_EQ(wait().since, orders.now);
}

TEST_F(Base, may_be_shorter_than_a_metre) {
  limit_base(orders, 0.5);
  EXPECT_THAT(base_lengths(extended()), SizeIs(2)) << "two of 0.286 m";
}

TEST_F(Base, is_extended_for_a_vehicle_whose_course_was_lost) {
  const wire::Order order = extended();
  orders.acknowledge(vehicle);
  orders.report_at(vehicle, orders.at("south", 0.9), 0.2);
  orders.traffic.set_course(vehicle, {});
  const wire::Order update = extended();
  EXPECT_EQ(update.order_id, order.order_id);
  EXPECT_EQ(update.order_update_id, 1U);
  // The base ends at 1.43 m: 0.53 m are left, and three stretches of about 0.27 m reach 1.2 m.
  EXPECT_THAT(base_lengths(update), SizeIs(3));
}

TEST(BaseIntoASection, closed_meanwhile_is_cancelled_and_not_extended) {
  OrdersFixture orders{fork()};
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("west", 1.5));
  ASSERT_TRUE(orders.extend(vehicle));
  orders.acknowledge(vehicle);
  ASSERT_EQ(orders.map->waypoint(orders.sessions[vehicle].base_end()).position.section, orders.section("entry"));
  orders.missions.set_closed({orders.section("entry")});
  EXPECT_FALSE(orders.extend(vehicle));
  EXPECT_EQ(orders.sessions[vehicle].stage(), OrderSession::Stage::cancelling);
  EXPECT_THAT(orders.orders_to(vehicle), SizeIs(1));
}

TEST(BaseBeyondItsEnd, is_as_long_as_usual_where_the_vehicle_is_in_the_next_section_already) {
  // Waypoints 0.19 m apart: the vehicle is 0.22 m beyond the last one of the north side, and 3 cm along the west side.
  OrdersFixture orders{fork("[waypoints]\nspacing_m = 0.2\n")};
  const WaypointIndex last = orders.map->behind(orders.at("north", 3.41))->waypoint;
  const auto from_last = [&](double beyond_m) {
    return orders.map->circuit().advance(orders.map->waypoint(last).position, beyond_m);
  };
  const VehicleIndex vehicle = orders.add_at("AIV1", from_last(-1.25));
  ASSERT_TRUE(orders.extend(vehicle));
  ASSERT_EQ(orders.sessions[vehicle].base_end(), last);
  orders.acknowledge(vehicle);
  orders.report_at(vehicle, from_last(0.22), 0.2);
  ASSERT_EQ(orders.positions.reported(vehicle).position->section, orders.section("west"));
  ASSERT_TRUE(orders.extend(vehicle));
  // 0.190 m to the west side, and then parts of 0.1885 m: six of them exceed 1.2 m.
  EXPECT_THAT(base_lengths(*orders.last_order(vehicle)), SizeIs(7));
}

TEST(BaseAroundAMerge, enters_no_section_again_that_the_base_contains_already) {
  OrdersFixture orders{fork()};
  TrafficRules rules;
  rules.request_within_m = 100.0;
  orders.traffic = Traffic{rules};
  orders.traffic.set_map(&*orders.map);
  orders.traffic.set_time(orders.now);
  orders.missions.set_closed({orders.section("south")});  // which the vehicle leaves
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("south", 1.2));
  ASSERT_TRUE(orders.extend(vehicle));
  const auto section_of = [&](WaypointIndex at) { return orders.map->waypoint(at).position.section; };
  const zone::SectionId east = orders.section("east");
  ASSERT_EQ(section_of(orders.sessions[vehicle].base_end()), east);
  orders.acknowledge(vehicle);
  limit_base(orders, 100.0, 100);
  ASSERT_TRUE(orders.extend(vehicle));
  const WaypointIndex end = orders.sessions[vehicle].base_end();
  EXPECT_GE(section_of(end), orders.section("bypass1")) << "before the merge of the bypass";
  ASSERT_FALSE(orders.map->stretch(end).sections.empty());
  EXPECT_EQ(orders.map->stretch(end).sections.back(), east);
}

TEST(NodeOfAShortSide, is_the_one_behind_up_to_a_metre) {
  // The south side is 1.08 m long, with waypoints only at the joints.
  const auto deviation_m = [](double s_m) {
    zone::ZoneConfiguration configuration = oval();
    const std::string long_side = "length_m = 2.0";
    for (std::size_t at = configuration.text.find(long_side); at != std::string::npos;
         at = configuration.text.find(long_side))
      configuration.text.replace(at, long_side.size(), "length_m = 1.08");
    configuration.text += "\n[waypoints]\nspacing_m = 1000.0\n";
    OrdersFixture orders{configuration};
    const VehicleIndex vehicle = orders.add_at("agv-1", orders.at("south", s_m), "Acme");
    orders.missions.give(vehicle, {Mission::Kind::go, "north@0"});
    EXPECT_TRUE(orders.extend(vehicle));
    return *orders.last_order(vehicle)->nodes.front().position->allowed_deviation_xy_m;
  };
  EXPECT_NEAR(deviation_m(1.0), 0.10 + 1.0, 1e-9) << "the node behind";
  EXPECT_NEAR(deviation_m(1.001), 0.10 + 0.079, 1e-9) << "the node ahead";
}

TEST(OffPathVehicle, that_was_sent_to_the_path_is_the_leader_of_the_others_at_once) {
  OrdersFixture orders;
  const VehicleIndex behind = orders.add_at("AIV1", orders.at("south", 0.2));
  const VehicleIndex vehicle = orders.add_off_path("AIV2", orders.at("south", 0.9), 0.25);
  ASSERT_TRUE(orders.extend(vehicle));
  EXPECT_NEAR(orders.traffic.reach_m(behind), 0.9 - 0.2 - 0.3, 1e-6);
}

TEST(OffPathVehicle, that_cannot_join_the_path_withdraws_what_it_requested) {
  OrdersFixture orders{zone_file("lacet4.toml")};
  const auto spans = orders.map->zone().crossings.front().spans;
  ASSERT_GE(spans.size(), 2U);
  ASSERT_NE(spans[0].section, spans[1].section);
  orders.add_at("AIV1", {spans[0].section, 0.5 * (spans[0].from_m + spans[0].to_m)});
  const zone::TrackPosition before = orders.map->circuit().advance({spans[1].section, spans[1].from_m}, -0.3);
  const VehicleIndex vehicle = orders.add_off_path("AIV2", before, 0.25);
  orders.traffic.set_position(vehicle, before);
  orders.traffic.update();
  ASSERT_FALSE(orders.traffic.request(vehicle, 0.6, 0.3).granted) << "another vehicle is in the crossing";
  ASSERT_THAT(orders.traffic.requests(), SizeIs(1));
  const VehicleIndex other = orders.add_off_path("AIV3", before, 0.30);  // as close as bodies can be
  EXPECT_FALSE(orders.extend(vehicle));
  EXPECT_EQ(orders.waits[vehicle].blocker, other);
  EXPECT_EQ(orders.waits[vehicle].why, WaitReason::off_path);
  EXPECT_THAT(orders.traffic.requests(), IsEmpty());
}

}  // namespace
}  // namespace cosiva::virtual_side
