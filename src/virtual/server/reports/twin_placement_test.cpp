#include "cosiva/virtual/server/reports/twin_placement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;
using testing::SizeIs;

/// One vehicle on the fork zone, 0.5 m along "entry", which another master control drives: the test writes its
/// messages.
class Placed : public testing::Test {
 protected:
  Placed() { vehicle.alive = false; }
  static ServerOptions watching() {
    ServerOptions options;
    options.drive = false;
    return options;
  }
  [[nodiscard]] wire::State next_state() {
    fixture.now += 100ms;
    wire::State state = vehicle.state(fixture.now);
    state.velocity.reset();
    return state;
  }
  void send(const wire::State& state) { fixture.send(vehicle, "state", vda::encode(state)); }
  void send_nodes(const std::vector<wire::NodeState>& nodes, const std::string& last_node = "") {
    wire::State state = next_state();
    state.node_states = nodes;
    state.last_node_id = last_node;
    send(state);
  }
  [[nodiscard]] JsonValue shown() const { return fixture.aiv("Acme/agv-7"); }
  [[nodiscard]] JsonValue::Array reserved() const { return *shown().find("reserved")->array(); }
  /// Without the bypass: the first five sections are a loop.
  [[nodiscard]] double distance_to(const zone::Waypoint& waypoint) const {
    if (waypoint.position.section > 4) return 100.0;
    return fixture.zone->circuit.shortest_route({0, 0.5}, waypoint.position, 100.0)->length_m;
  }
  /// The first waypoint that is more than `m` from the vehicle.
  [[nodiscard]] const zone::Waypoint& beyond(double m) const {
    const zone::Waypoint* found = nullptr;
    for (const zone::Waypoint& waypoint : fixture.zone->waypoints) {
      const double away_m = distance_to(waypoint);
      if (away_m > m && away_m < 99.0 && (found == nullptr || away_m < distance_to(*found))) found = &waypoint;
    }
    return *found;
  }
  /// The end of the reserved path is drawn at this waypoint.
  void expect_end(const zone::Waypoint& waypoint) const {
    const JsonValue::Array points = reserved();
    ASSERT_FALSE(points.empty());
    const Pose2 end = fixture.zone->circuit.pose_at(waypoint.position);
    EXPECT_NEAR(*(*points.back().array())[0].number(), end.x_m, 1e-4);
    EXPECT_NEAR(*(*points.back().array())[1].number(), end.y_m, 1e-4);
  }
  ServerFixture fixture{fork(), watching()};
  FixtureVehicle& vehicle{fixture.add("agv-7", {0, 0.5}, "Acme")};
};

TEST_F(Placed, vehicle_has_a_base_to_the_last_released_node_of_its_first_state) {
  const zone::Waypoint& first = beyond(0.2);
  const zone::Waypoint& second = beyond(distance_to(first) + 0.1);
  const zone::Waypoint& third = beyond(distance_to(second) + 0.1);
  send_nodes({{first.id, 2, true, {}}, {second.id, 4, true, {}}, {third.id, 6, false, {}}});
  expect_end(second);
  send_nodes({{first.id, 2, true, {}}, {second.id, 4, true, {}}, {third.id, 6, true, {}}});
  expect_end(third);
}

TEST_F(Placed, vehicle_without_a_released_node_has_a_base_to_its_last_node) {
  const zone::Waypoint& last = beyond(0.4);
  send_nodes({{beyond(distance_to(last) + 0.1).id, 6, false, {}}}, last.id);
  expect_end(last);
}

TEST_F(Placed, vehicle_without_nodes_or_with_an_unknown_one_has_no_base) {
  send_nodes({}, beyond(0.4).id);
  EXPECT_THAT(reserved(), IsEmpty());
  send_nodes({{"nowhere", 2, true, {}}});
  EXPECT_THAT(reserved(), IsEmpty());
}

TEST_F(Placed, vehicle_has_a_drawn_base_of_eight_metres_at_most) {
  const zone::Waypoint& far = beyond(8.0);
  ASSERT_LT(distance_to(far), 10.0);
  send_nodes({{far.id, 2, true, {}}});
  EXPECT_THAT(reserved(), IsEmpty());
  const zone::Waypoint& near = beyond(7.0);
  ASSERT_LE(distance_to(near), 8.0);
  send_nodes({{near.id, 2, true, {}}});
  expect_end(near);
}

TEST_F(Placed, vehicle_at_the_end_of_its_base_has_no_reserved_path) {
  const zone::Waypoint& end = beyond(0.2);
  vehicle.put(fixture.zone->circuit.pose_at(end.position));
  send_nodes({{end.id, 2, true, {}}});
  EXPECT_NEAR(*shown().number("s"), end.position.s_m, 1e-9);
  EXPECT_THAT(reserved(), IsEmpty());
}

TEST_F(Placed, vehicle_that_moves_is_not_extrapolated_beyond_the_end_of_its_base) {
  const zone::Waypoint& end = beyond(0.05);
  const double left_m = distance_to(end);
  wire::State state = next_state();
  state.velocity = wire::Velocity{1.0, 0.0, 0.0};
  state.node_states = {{end.id, 2, true, {}}};
  send(state);
  std::vector<PositionRecord> records;
  fixture.server->positions(fixture.now + 900ms, records);
  ASSERT_THAT(records, SizeIs(1));
  ASSERT_LT(left_m, 0.85);
  EXPECT_NEAR(records[0].x_m, 0.5 + left_m, 1e-5) << "0.9 m without a base";
}

TEST_F(Placed, vehicle_that_reports_no_velocity_stays_where_it_is) {
  vehicle.put({0.5, 0.35, 0.3});  // off the circuit, where a twin is extrapolated by dead reckoning
  send(next_state());
  EXPECT_EQ(shown().number("speed"), 0.0);
  EXPECT_TRUE(shown().find("section")->is_null());
  EXPECT_TRUE(shown().find("s")->is_null());
  EXPECT_THAT(reserved(), IsEmpty());
  std::vector<PositionRecord> records;
  fixture.server->positions(fixture.now + 500ms, records);
  ASSERT_THAT(records, SizeIs(1));
  EXPECT_FLOAT_EQ(records[0].x_m, 0.5F);
  EXPECT_FLOAT_EQ(records[0].y_m, 0.35F);
  EXPECT_FLOAT_EQ(records[0].heading_rad, 0.3F);
}

TEST_F(Placed, vehicle_is_on_the_circuit_where_it_names_this_map_or_none) {
  const auto section_on = [&](const std::string& map_id) {
    vehicle.map_id = map_id;
    send(next_state());
    return shown().text("section");
  };
  EXPECT_EQ(section_on("fork"), "entry");
  EXPECT_FALSE(section_on("elsewhere").has_value());
  EXPECT_EQ(section_on(""), "entry");
}

}  // namespace
}  // namespace cosiva::virtual_side
