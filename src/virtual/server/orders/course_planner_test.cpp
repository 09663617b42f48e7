#include "cosiva/virtual/server/orders/course_planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// A oval of short sections, 3.1 m round: eight of them are less than 8 m.
zone::ZoneConfiguration small_oval() {
  std::string text =
      "name = \"small\"\nformat_version = 1\n[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n"
      "[circuit]\nstart = { x = 0.0, y = 0.0, heading_deg = 0 }\nclosed = true\n";
  for (const std::string name : {"a", "b"})
    text += "[[section]]\nname = \"" + name + "1\"\nkind = \"straight\"\nlength_m = 0.6\n[[section]]\nname = \"" +
            name + "2\"\nkind = \"arc\"\nradius_m = 0.3\nangle_deg = 180\n";
  return {"toml", "small", text};
}

// --- how far ahead is planned ---------------------------------------------------------------------------------------

/// The route that is planned for a vehicle at the first waypoint, beyond the given number of sections.
void expect_planned_just_far_enough(OrdersFixture& orders, std::size_t passed) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.map->waypoint(0).position);
  ASSERT_TRUE(orders.planner.plan(vehicle));
  orders.planner.begin_route(orders.traffic.remaining(vehicle));
  WaypointIndex at = 0;
  std::size_t taken = 0;
  while (taken < passed) {
    const WaypointGraph::Stretch* stretch = orders.planner.next_stretch(vehicle, at, taken);
    ASSERT_NE(stretch, nullptr);
    at = stretch->to;
    taken += stretch->sections.size();
  }
  ASSERT_NE(orders.planner.next_stretch(vehicle, at, taken), nullptr);
  const auto rest = orders.planner.route().subspan(taken);
  const auto far_enough = [&](Sections sections) {
    double sum_m = 0.0;
    for (const zone::SectionId section : sections) sum_m += orders.map->circuit().section(section).length_m();
    return sum_m >= 8.0 && sections.size() >= 8;
  };
  EXPECT_TRUE(far_enough(rest));
  EXPECT_FALSE(far_enough(rest.first(rest.size() - 1))) << "one section at a time";
  EXPECT_EQ(orders.traffic.remaining(vehicle).size(), orders.planner.route().size())
      << "the traffic's course is longer";
  EXPECT_EQ(orders.planner.next_stretch(vehicle, at, orders.planner.route().size() + 1), nullptr);
}

TEST(PlannedRoute, reaches_eight_sections_beyond_the_base_where_these_are_long) {
  OrdersFixture orders;
  expect_planned_just_far_enough(orders, 0);
}
TEST(PlannedRoute, reaches_eight_metres_beyond_the_base_where_sections_are_short) {
  OrdersFixture orders{small_oval()};
  expect_planned_just_far_enough(orders, 0);
}
TEST(PlannedRoute, reaches_as_far_beyond_a_part_that_is_used_already) {
  OrdersFixture orders;
  expect_planned_just_far_enough(orders, 3);
}

TEST(PlannedRoute, is_known_to_the_twin) {
  OrdersFixture orders{fork()};
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.5));
  orders.missions.give(vehicle, {Mission::Kind::go, "dock"});
  ASSERT_TRUE(orders.planner.plan(vehicle));
  orders.report_at(vehicle, orders.at("entry", 0.95), 0.3);
  orders.pass(1s);
  EXPECT_LT(orders.positions.body(vehicle).y_m, -0.001) << "it is extrapolated along the bypass, to the right";
}

// --- plans ----------------------------------------------------------------------------------------------------------

class Plans : public testing::Test {
 protected:
  Plans() : orders{fork()} {}
  [[nodiscard]] std::vector<std::string> remaining(VehicleIndex vehicle) const {
    std::vector<std::string> names;
    for (const zone::SectionId section : orders.traffic.remaining(vehicle))
      names.push_back(orders.map->circuit().part(section).name);
    return names;
  }
  void go(VehicleIndex vehicle, const std::string& to) { orders.missions.give(vehicle, {Mission::Kind::go, to}); }
  void close(const std::vector<std::string>& names) {
    std::vector<zone::SectionId> sections;
    for (const std::string& name : names) sections.push_back(orders.section(name));
    orders.missions.set_closed(sections);
  }
  OrdersFixture orders;
};

TEST_F(Plans, are_made_once_for_each_mission) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.5));
  EXPECT_TRUE(orders.planner.is_outdated(vehicle));
  go(vehicle, "gate");
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_FALSE(orders.planner.is_outdated(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("south", "east", "north"));
  go(vehicle, "dock");
  EXPECT_TRUE(orders.planner.is_outdated(vehicle));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("bypass1", "bypass2", "bypass3"));
}

TEST_F(Plans, without_a_route_are_tried_again_from_another_section_or_when_sections_open) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("west", 0.5));
  go(vehicle, "gate");
  close({"south", "bypass1"});
  EXPECT_FALSE(orders.planner.plan(vehicle));
  EXPECT_FALSE(orders.planner.plan(vehicle));
  EXPECT_THAT(orders.logs(), SizeIs(1)) << "planned and logged once";
  EXPECT_THAT(remaining(vehicle), IsEmpty());
  orders.report_at(vehicle, orders.at("entry", 0.5));
  EXPECT_FALSE(orders.planner.plan(vehicle));
  EXPECT_THAT(orders.logs(), SizeIs(2));
  close({"bypass1"});
  EXPECT_TRUE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("south", "east", "north"));
}

TEST_F(Plans, lead_once_more_around_for_a_vehicle_that_has_passed_its_goal) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("north", 1.0));
  go(vehicle, "gate");
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), IsEmpty());
  orders.report_at(vehicle, orders.at("north", 1.7));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("west", "entry", "south", "east", "north"));
  orders.report_at(vehicle, orders.at("north", 1.8));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("west", "entry", "south", "east", "north")) << "it comes to the goal";
}

TEST_F(Plans, are_forgotten_with_the_vehicle) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.5));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  orders.planner.forget(vehicle);
  go(vehicle, "gate");
  EXPECT_TRUE(orders.planner.is_outdated(vehicle));
}

// --- arrival --------------------------------------------------------------------------------------------------------

/// A vehicle with a mission to the gate, which is 1.5 m along the north side.
class Arrival : public Plans {
 protected:
  Arrival() : vehicle{orders.add_at("AIV1", orders.at("north", 1.0))} {
    go(vehicle, "gate");
    EXPECT_TRUE(orders.planner.plan(vehicle));
    goal_m = orders.map->waypoint(orders.missions.goal(vehicle)).position.s_m;
  }
  bool stays(double beyond_m, double speed_mps = 0.0) {
    orders.report_at(vehicle, orders.at("north", goal_m + beyond_m), speed_mps);
    return orders.planner.stays_at_goal(vehicle);
  }
  VehicleIndex vehicle;
  double goal_m{};
};

TEST_F(Arrival, is_within_six_centimetres_before_the_goal) {
  EXPECT_FALSE(stays(-0.061));
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::driving);
  EXPECT_TRUE(stays(-0.059));
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::arrived);
}

TEST_F(Arrival, is_within_ten_centimetres_beyond_the_goal) {
  EXPECT_FALSE(stays(0.101));
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::driving);
  EXPECT_TRUE(stays(0.099));
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::arrived);
}

TEST_F(Arrival, of_a_vehicle_to_be_handed_over_is_within_its_length_where_no_route_leads_back) {
  close({"west"});
  EXPECT_FALSE(stays(0.15));
  EXPECT_FALSE(orders.planner.plan(vehicle));
  EXPECT_FALSE(stays(0.15)) << "it is not to be handed over";
  orders.missions.give(vehicle, Mission{Mission::Kind::go, "gate", "b/rack"});
  orders.report_at(vehicle, orders.at("north", goal_m + 0.15));
  EXPECT_FALSE(orders.planner.plan(vehicle));
  EXPECT_FALSE(stays(orders.map->zone().vehicle.length_m + 0.01));
  EXPECT_TRUE(stays(0.15));
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::arrived);
}

TEST_F(Arrival, is_not_recorded_while_the_vehicle_still_moves) {
  EXPECT_FALSE(stays(-0.061, 0.1));
  EXPECT_TRUE(stays(-0.059, 0.1));
  EXPECT_TRUE(stays(0.3, 0.1)) << "it has passed the goal and will stop";
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::driving);
}

TEST_F(Arrival, is_not_expected_by_the_plan_of_another_mission) {
  go(vehicle, "dock");
  EXPECT_FALSE(stays(0.3, 0.1));
}

// --- orders in force ------------------------------------------------------------------------------------------------

/// A vehicle with an order whose base ends 1.2 m or slightly more ahead of it.
class PlansBeyondBase : public Plans {
 protected:
  VehicleIndex with_order(zone::TrackPosition position) {
    const VehicleIndex vehicle = orders.add_at("AIV1", position);
    EXPECT_TRUE(orders.extend(vehicle));
    orders.acknowledge(vehicle);
    return vehicle;
  }
};

TEST_F(PlansBeyondBase, follow_a_new_mission_and_keep_the_base) {
  const VehicleIndex vehicle = with_order(orders.at("west", 0.3));
  const WaypointIndex end = orders.sessions[vehicle].base_end();
  go(vehicle, "dock");
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  EXPECT_FALSE(orders.planner.is_outdated(vehicle));
  EXPECT_EQ(orders.sessions[vehicle].base_end(), end);
  EXPECT_THAT(remaining(vehicle), ElementsAre("entry", "bypass1", "bypass2", "bypass3"));
  go(vehicle, "gate");
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("entry", "south", "east", "north"));
}

TEST_F(PlansBeyondBase, end_with_the_base_where_there_is_no_route) {
  const VehicleIndex vehicle = with_order(orders.at("west", 0.3));
  go(vehicle, "gate");
  close({"south", "bypass1"});
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  EXPECT_FALSE(orders.planner.is_outdated(vehicle));
  orders.planner.begin_route({});
  EXPECT_EQ(orders.planner.next_stretch(vehicle, orders.sessions[vehicle].base_end(), 0), nullptr);
  close({});
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  orders.planner.begin_route(beyond_base(orders.traffic, vehicle, orders.at("west", 0.3)).sections);
  EXPECT_NE(orders.planner.next_stretch(vehicle, orders.sessions[vehicle].base_end(), 0), nullptr);
}

TEST_F(PlansBeyondBase, cancel_an_order_whose_base_leads_into_a_closed_section) {
  const VehicleIndex vehicle = with_order(orders.at("west", 1.5));
  ASSERT_EQ(orders.map->waypoint(orders.sessions[vehicle].base_end()).position.section, orders.section("entry"));
  close({"entry"});
  EXPECT_FALSE(orders.planner.plan_beyond_base(vehicle));
  EXPECT_EQ(orders.sessions[vehicle].stage(), OrderSession::Stage::cancelling);
  EXPECT_EQ(orders.logs().back(),
            "i CoSiVA/AIV1: its base leads into 'entry', which is closed now; cancelled, a new order follows");
}

TEST_F(PlansBeyondBase, are_regained_by_a_vehicle_that_has_left_its_course) {
  const VehicleIndex vehicle = with_order(orders.at("west", 1.5));
  const zone::TrackPosition end = orders.map->waypoint(orders.sessions[vehicle].base_end()).position;
  orders.traffic.set_course(vehicle, {});
  ASSERT_FALSE(orders.traffic.on_course(vehicle));
  EXPECT_TRUE(orders.planner.regain(vehicle));
  EXPECT_TRUE(orders.traffic.on_course(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("entry")) << "up to the end of the base";
  EXPECT_TRUE(orders.planner.is_outdated(vehicle)) << "beyond the base a plan has to follow";
  const auto regains_from = [&](double beyond_m) {
    orders.report_at(vehicle, orders.map->circuit().advance(end, beyond_m));
    return orders.planner.regain(vehicle);
  };
  EXPECT_TRUE(regains_from(0.249));
  EXPECT_THAT(remaining(vehicle), IsEmpty()) << "it has passed the end";
  EXPECT_FALSE(regains_from(0.251)) << "more than 8 m to the end of the base";
}

// --- orders of other senders ----------------------------------------------------------------------------------------

class AdoptedCourse : public Plans {
 protected:
  AdoptedCourse() : vehicle{orders.add_at("AIV1", orders.at("west", 1.5))} {
    WaypointIndex at = orders.map->behind(orders.at("west", 1.5))->waypoint;
    for (int i = 0; i < 3; ++i) nodes.push_back(at = orders.map->stretch(at).to);
  }
  /// Of a state that lists these nodes, the first `released` of which are released.
  std::optional<WaypointIndex> end(std::size_t released) {
    wire::State state;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      state.node_states.push_back(
          {orders.map->waypoint(nodes[i]).id, 2 * static_cast<std::uint32_t>(i) + 2, i < released, {}});
    return orders.planner.adopt_course(vehicle, state);
  }
  VehicleIndex vehicle;
  std::vector<WaypointIndex> nodes;
};

TEST_F(AdoptedCourse, ends_at_the_last_released_node) {
  EXPECT_EQ(end(3), nodes[2]);
  EXPECT_EQ(end(2), nodes[1]);
  EXPECT_EQ(end(1), nodes[0]);
  EXPECT_EQ(end(0), std::nullopt);
  EXPECT_EQ(orders.map->waypoint(nodes[2]).position.section, orders.section("entry"));
  EXPECT_EQ(end(3), nodes[2]);
  EXPECT_THAT(remaining(vehicle), ElementsAre("entry"));
}

TEST_F(AdoptedCourse, needs_a_position_and_a_route_to_the_nodes) {
  nodes.front() = orders.map->behind(orders.at("north", 0.3))->waypoint;
  EXPECT_EQ(end(1), std::nullopt);
  nodes.pop_back();
  orders.positions.set_reported(vehicle, {std::nullopt, 0.0, 0.0, {}});
  EXPECT_EQ(end(1), std::nullopt);
}

TEST_F(AdoptedCourse, is_planned_anew_beyond_the_base) {
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_FALSE(orders.planner.is_outdated(vehicle));
  EXPECT_TRUE(end(1).has_value());
  EXPECT_TRUE(orders.planner.is_outdated(vehicle));
}

TEST_F(AdoptedCourse, ends_with_the_base_where_the_horizon_leads_further) {
  ASSERT_EQ(end(3), nodes[2]);
  EXPECT_THAT(remaining(vehicle), ElementsAre("entry"));
  EXPECT_EQ(end(1), nodes[0]);
  EXPECT_THAT(remaining(vehicle), IsEmpty()) << "the mission determines the course beyond the base";
}

// --- limits of the route --------------------------------------------------------------------------------------------

TEST(RouteAlongSectionsOfOneMetre, has_exactly_eight_of_them) {
  std::string text =
      "name = \"row\"\nformat_version = 1\n[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n"
      "[circuit]\nstart = { x = 0.0, y = 0.0, heading_deg = 0 }\nclosed = false\n";
  for (int i = 0; i < 12; ++i)
    text += "[[section]]\nname = \"s" + std::to_string(i) + "\"\nkind = \"straight\"\nlength_m = 1.0\n";
  OrdersFixture orders{{"toml", "row", text}};
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("s0", 0.5));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  orders.planner.begin_route({});
  EXPECT_NE(orders.planner.next_stretch(vehicle, 0, 0), nullptr);
  EXPECT_THAT(orders.planner.route(), SizeIs(8)) << "8 sections and 8 m are enough";
}

TEST_F(Plans, begin_a_route_with_what_was_planned_and_then_with_what_follows) {
  const std::vector<zone::SectionId> first{4, 0};
  const std::vector<zone::SectionId> rest{1, 2};
  const auto route = [&] {
    const Sections sections = orders.planner.route();
    return std::vector<zone::SectionId>(sections.begin(), sections.end());
  };
  orders.planner.begin_route(first, rest);
  EXPECT_THAT(route(), ElementsAre(4U, 0U, 1U, 2U));
  orders.planner.begin_route(rest);
  EXPECT_THAT(route(), ElementsAre(1U, 2U));
}

TEST_F(Plans, end_at_the_goal) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("north", 0.3));
  go(vehicle, "gate");
  ASSERT_TRUE(orders.planner.plan(vehicle));
  orders.planner.begin_route(orders.traffic.remaining(vehicle));
  WaypointIndex at = orders.map->behind(orders.at("north", 0.3))->waypoint;
  std::size_t count = 0;
  for (; count < 100; ++count) {
    const WaypointGraph::Stretch* stretch = orders.planner.next_stretch(vehicle, at, 0);
    if (stretch == nullptr) break;
    at = stretch->to;
  }
  EXPECT_EQ(at, orders.missions.goal(vehicle));
  EXPECT_GT(count, 2U);
  EXPECT_LT(count, 100U);
  const WaypointIndex last = orders.map->behind(orders.at("north", 3.4))->waypoint;
  ASSERT_GT(last, at);
  EXPECT_EQ(orders.planner.next_stretch(vehicle, last, 0), nullptr) << "the next section is not on the route";
}

TEST_F(Plans, without_a_route_leave_no_course_and_later_ones_continue_normally) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.5));
  go(vehicle, "gate");
  ASSERT_TRUE(orders.planner.plan(vehicle));
  close({"south", "bypass1"});
  EXPECT_FALSE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), IsEmpty()) << "the former course leads into a closed section";
  close({});
  EXPECT_TRUE(orders.planner.plan(vehicle));
  EXPECT_TRUE(orders.planner.plan(vehicle)) << "planned already";
  orders.planner.begin_route(orders.traffic.remaining(vehicle));
  const WaypointIndex behind = orders.map->behind(orders.at("entry", 0.5))->waypoint;
  EXPECT_NE(orders.planner.next_stretch(vehicle, behind, 0), nullptr);
}

TEST_F(Plans, of_a_roaming_vehicle_are_known_to_the_twin) {
  close({"south"});
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.5));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  orders.planner.begin_route(orders.traffic.remaining(vehicle));
  ASSERT_NE(orders.planner.next_stretch(vehicle, orders.map->behind(orders.at("entry", 0.5))->waypoint, 0), nullptr);
  orders.report_at(vehicle, orders.at("entry", 0.95), 0.3);
  orders.pass(1s);
  EXPECT_LT(orders.positions.body(vehicle).y_m, -0.001) << "it is extrapolated along the bypass, to the right";
}

// --- a node where sections part -------------------------------------------------------------------------------------

/// The fork zone with a node "fork": the branches "south" and "bypass1" begin with waypoints of that id.
class PlansAtNode : public Plans {
 protected:
  PlansAtNode() {
    zone::TrafficZone zone = orders.map->zone();
    std::vector<zone::Waypoint> waypoints(zone.waypoints.begin(), zone.waypoints.end());
    for (const char* name : {"south", "bypass1"}) {
      const zone::SectionId section = orders.section(name);
      const auto first = std::ranges::find_if(
          waypoints, [&](const zone::Waypoint& waypoint) { return waypoint.position.section >= section; });
      waypoints.insert(first, zone::Waypoint{"fork", {section, 0.0}});
    }
    zone.waypoints = std::move(waypoints);
    orders.map.emplace(std::make_shared<const zone::TrafficZone>(std::move(zone)));
    orders.traffic.set_map(&*orders.map);
    orders.missions.set_map(&*orders.map);
    south_node = orders.map->find("fork")[0];
    bypass_node = orders.map->find("fork")[1];
  }
  void put_at(VehicleIndex vehicle, zone::TrackPosition position) {
    orders.positions.set_reported(vehicle, {position, 0.0, 0.0, orders.map->circuit().pose_at(position)});
    orders.traffic.update();
  }
  void set_course(VehicleIndex vehicle, const std::vector<std::string>& names) {
    std::vector<zone::SectionId> sections;
    for (const std::string& name : names) sections.push_back(orders.section(name));
    orders.traffic.set_course(vehicle, zone::Course(std::move(sections)));
  }
  /// A vehicle on the course's first section, with an order whose base ends where "south" begins.
  VehicleIndex with_base_to_node(zone::TrackPosition position, const std::vector<std::string>& course) {
    const VehicleIndex vehicle = orders.add_at("AIV1", position);
    put_at(vehicle, position);
    set_course(vehicle, course);
    wire::State state;
    state.order_id = "O";
    state.node_states = {{"fork", 2, true, {}}};
    orders.sessions[vehicle].take_over(state, south_node);
    return vehicle;
  }
  void expect_base_end(VehicleIndex vehicle, WaypointIndex end) {
    EXPECT_EQ(orders.sessions[vehicle].base_end(), end);
    EXPECT_EQ(orders.traffic.base_end(vehicle), end);
  }
  WaypointIndex south_node{};
  WaypointIndex bypass_node{};
};

TEST_F(PlansAtNode, take_the_branch_of_the_mission_where_the_base_ends_at_the_node) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("entry", 0.5), {"entry", "south", "east"});
  go(vehicle, "dock");
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  expect_base_end(vehicle, bypass_node);
  EXPECT_THAT(remaining(vehicle), ElementsAre("bypass1", "bypass2", "bypass3"));
  go(vehicle, "gate");
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  expect_base_end(vehicle, south_node);
  EXPECT_THAT(remaining(vehicle), ElementsAre("south", "east", "north"));
}

TEST_F(PlansAtNode, keep_the_sections_of_the_base_before_the_node) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("west", 1.5), {"west", "entry", "south"});
  go(vehicle, "dock");
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  expect_base_end(vehicle, bypass_node);
  EXPECT_THAT(remaining(vehicle), ElementsAre("entry", "bypass1", "bypass2", "bypass3"));
}

TEST_F(PlansAtNode, stay_on_the_branch_that_the_vehicle_is_on_already) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("entry", 0.9), {"entry", "south", "east"});
  put_at(vehicle, orders.at("south", 0.0));
  go(vehicle, "dock");
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  expect_base_end(vehicle, south_node);
  EXPECT_THAT(remaining(vehicle), ElementsAre("east", "north", "west", "entry", "bypass1", "bypass2", "bypass3"));
}

TEST_F(PlansAtNode, leave_a_closed_branch_without_cancelling_the_order) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("entry", 0.5), {"entry", "south"});
  go(vehicle, "dock");
  close({"south"});
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  EXPECT_TRUE(orders.sessions[vehicle].is_running());
  expect_base_end(vehicle, bypass_node);
}

TEST_F(PlansAtNode, do_not_lead_into_a_closed_branch_where_all_are_closed) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("entry", 0.5), {"entry", "south"});
  go(vehicle, "gate");
  close({"south", "bypass1"});
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::no_route);
  expect_base_end(vehicle, south_node);
  EXPECT_THAT(remaining(vehicle), ElementsAre("south")) << "up to the end of the base";
  orders.planner.begin_route({});
  EXPECT_EQ(orders.planner.next_stretch(vehicle, south_node, 0), nullptr);
}

TEST_F(PlansAtNode, of_a_roaming_vehicle_take_the_branches_in_turn) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("entry", 0.5), {"entry", "south"});
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
    expect_base_end(vehicle, south_node);
    EXPECT_THAT(remaining(vehicle), ElementsAre("south"));
    EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
    expect_base_end(vehicle, bypass_node);
    EXPECT_THAT(remaining(vehicle), ElementsAre("bypass1"));
  }
}

TEST_F(PlansAtNode, of_a_roaming_vehicle_end_before_branches_that_are_all_closed) {
  const VehicleIndex vehicle = with_base_to_node(orders.at("entry", 0.5), {"entry", "south"});
  close({"south", "bypass1"});
  EXPECT_TRUE(orders.planner.plan_beyond_base(vehicle));
  expect_base_end(vehicle, south_node);
  EXPECT_EQ(orders.missions.state(vehicle), Missions::State::no_route);
}

TEST_F(PlansAtNode, of_a_vehicle_on_the_node_may_begin_with_the_other_branch) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.9));
  const VehicleIndex follower = orders.add_at("AIV2", orders.at("entry", 0.5));
  set_course(vehicle, {"entry", "south", "east"});
  set_course(follower, {"entry", "bypass1"});
  put_at(vehicle, orders.at("south", 0.03));
  go(vehicle, "dock");
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_EQ(orders.positions.reported(vehicle).position, orders.at("bypass1", 0.0));
  EXPECT_EQ(orders.traffic.track_position(vehicle), orders.at("bypass1", 0.0));
  EXPECT_THAT(remaining(vehicle), ElementsAre("bypass2", "bypass3"));
  ASSERT_THAT(orders.traffic.traversed(vehicle), SizeIs(1));
  EXPECT_EQ(orders.traffic.traversed(vehicle).front(), orders.section("entry"));
  EXPECT_NEAR(orders.traffic.reach_m(follower), 0.5 - 0.3, 1e-9) << "known to the traffic at once";
}

TEST_F(PlansAtNode, of_a_vehicle_without_a_course_begin_with_the_chosen_branch_alone) {
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("entry", 0.9));
  put_at(vehicle, orders.at("south", 0.03));
  go(vehicle, "dock");
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_THAT(remaining(vehicle), ElementsAre("bypass2", "bypass3"));
  EXPECT_THAT(orders.traffic.traversed(vehicle), IsEmpty());
}

}  // namespace
}  // namespace cosiva::virtual_side
