#include "cosiva/virtual/server/orders/path_positions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

/// On the oval: the south side runs along the x axis from the origin, 2 m.
class OnSouthSide : public testing::Test {
 protected:
  /// A new vehicle that reports a pose `left_m` to the left of the path, turned to the left by `turned_rad`.
  VehicleIndex off_path_by(double left_m, double turned_rad, const std::string& manufacturer = "CoSiVA") {
    return orders.add_off_path("AIV" + std::to_string(++number), orders.at("south", 1.0), left_m, turned_rad,
                               manufacturer);
  }
  [[nodiscard]] bool obstructs(VehicleIndex vehicle) const {
    return orders.traffic.track_position(vehicle).has_value();
  }
  int number{0};
  OrdersFixture orders;
};

TEST_F(OnSouthSide, vehicle_is_on_the_path_within_five_millimetres_and_a_fifth_of_a_radian) {
  EXPECT_FALSE(orders.positions.is_off_path(off_path_by(0.0049, 0.0)));
  EXPECT_FALSE(orders.positions.is_off_path(off_path_by(-0.0049, 0.0)));
  EXPECT_TRUE(orders.positions.is_off_path(off_path_by(0.0051, 0.0)));
  EXPECT_TRUE(orders.positions.is_off_path(off_path_by(-0.0051, 0.0)));
  EXPECT_FALSE(orders.positions.is_off_path(off_path_by(0.0, 0.199)));
  EXPECT_TRUE(orders.positions.is_off_path(off_path_by(0.0, 0.201)));
  EXPECT_TRUE(orders.positions.is_off_path(off_path_by(0.0, -0.201)));
}

TEST_F(OnSouthSide, only_a_cosiva_vehicle_without_an_order_drives_onto_the_path_by_itself) {
  const VehicleIndex vehicle = off_path_by(0.1, 0.0);
  EXPECT_TRUE(orders.positions.goes_onto_line(vehicle));
  EXPECT_FALSE(orders.positions.goes_onto_line(off_path_by(0.1, 0.0, "Acme")));
  EXPECT_FALSE(orders.positions.goes_onto_line(off_path_by(0.0, 0.0)));
  wire::State state;
  state.order_id = "O";
  state.node_states = {{orders.map->waypoint(0).id, 2, true, {}}};
  orders.sessions[vehicle].take_over(state, 0);
  EXPECT_FALSE(orders.positions.goes_onto_line(vehicle)) << "it follows an order";
  orders.positions.set_entry_point(vehicle, orders.at("south", 1.0));
  EXPECT_TRUE(orders.positions.goes_onto_line(vehicle));
}

TEST_F(OnSouthSide, vehicle_obstructs_others_on_the_path_within_20_cm_of_it) {
  EXPECT_TRUE(obstructs(off_path_by(0.199, 0.0, "Acme")));
  EXPECT_FALSE(obstructs(off_path_by(0.201, 0.0, "Acme")));
  EXPECT_FALSE(obstructs(off_path_by(0.1, 0.0))) << "a CoSiVA vehicle that is to join keeps others away by its body";
  const VehicleIndex blind = orders.add("AIV99");
  orders.positions.set_reported(blind, {std::nullopt, 0.0, 0.0, {}});
  EXPECT_FALSE(obstructs(blind));
}

TEST_F(OnSouthSide, entry_point_replaces_the_position_until_the_vehicle_is_on_the_path) {
  const VehicleIndex vehicle = off_path_by(0.1, 0.0);
  orders.positions.set_entry_point(vehicle, orders.at("south", 1.2), 0.2);
  EXPECT_EQ(orders.positions.entry_point(vehicle), orders.at("south", 1.2));
  EXPECT_EQ(orders.positions.reported(vehicle).position, orders.at("south", 1.2));
  EXPECT_EQ(orders.positions.reported(vehicle).off_m, 0.2);
  EXPECT_TRUE(orders.positions.is_off_path(vehicle));

  orders.report(vehicle, {1.1, 0.05, 0.0}, 0.2);
  EXPECT_EQ(orders.positions.reported(vehicle).position, orders.at("south", 1.2));
  EXPECT_NEAR(orders.positions.reported(vehicle).off_m, std::sqrt(0.1 * 0.1 + 0.05 * 0.05), 1e-9);
  EXPECT_EQ(orders.positions.reported(vehicle).heading_off_rad, 0.0);
  EXPECT_TRUE(obstructs(vehicle)) << "it is sent there";

  orders.report(vehicle, {1.19, 0.0051, 0.0}, 0.2);
  EXPECT_TRUE(orders.positions.entry_point(vehicle).has_value());
  orders.report(vehicle, {1.19, 0.001, 0.21}, 0.2);
  EXPECT_TRUE(orders.positions.entry_point(vehicle).has_value()) << "it has still to turn";
  orders.report(vehicle, {1.19, 0.0049, 0.19}, 0.2);
  EXPECT_FALSE(orders.positions.entry_point(vehicle).has_value());
  EXPECT_NEAR(orders.positions.reported(vehicle).position->s_m, 1.19, 1e-9);
  EXPECT_NEAR(orders.positions.reported(vehicle).off_m, 0.0049, 1e-9);
  EXPECT_NEAR(orders.positions.reported(vehicle).heading_off_rad, 0.19, 1e-9);
}

TEST_F(OnSouthSide, entry_point_at_the_end_of_a_section_is_also_reached_on_the_next_one) {
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 1.98), 0.1);
  orders.positions.set_entry_point(vehicle, orders.at("south", 1.98));
  orders.traffic.set_course(vehicle, zone::Course({orders.section("south"), orders.section("east")}));
  orders.report_at(vehicle, orders.at("east", 0.1), 0.2);
  EXPECT_FALSE(orders.positions.entry_point(vehicle).has_value());
  EXPECT_EQ(orders.positions.reported(vehicle).position->section, orders.section("east"));
}

TEST_F(OnSouthSide, entry_point_is_cleared_once) {
  const VehicleIndex vehicle = off_path_by(0.1, 0.0);
  EXPECT_FALSE(orders.positions.clear_entry_point(vehicle));
  orders.positions.set_entry_point(vehicle, orders.at("south", 1.2));
  EXPECT_TRUE(orders.positions.clear_entry_point(vehicle));
  EXPECT_FALSE(orders.positions.clear_entry_point(vehicle));
  orders.positions.forget(vehicle);
  EXPECT_FALSE(orders.positions.reported(vehicle).position.has_value());
}

TEST_F(OnSouthSide, vehicle_is_stopped_by_its_state_and_by_its_twin) {
  const VehicleIndex vehicle = off_path_by(0.0, 0.0);
  EXPECT_TRUE(orders.positions.is_stopped(vehicle));
  orders.report_field(vehicle, &wire::State::driving, true);
  EXPECT_FALSE(orders.positions.is_stopped(vehicle));
  orders.report_at(vehicle, orders.at("south", 1.0), 0.011);
  orders.report_field(vehicle, &wire::State::driving, false);
  EXPECT_FALSE(orders.positions.is_stopped(vehicle)) << "faster than 1 cm/s";
  orders.report_at(vehicle, orders.at("south", 1.0), -0.011);
  orders.report_field(vehicle, &wire::State::driving, false);
  EXPECT_FALSE(orders.positions.is_stopped(vehicle)) << "backwards too";
  orders.report_at(vehicle, orders.at("south", 1.0), 0.009);
  orders.report_field(vehicle, &wire::State::driving, false);
  EXPECT_TRUE(orders.positions.is_stopped(vehicle));
  orders.proxy(vehicle).membership.on_retired();
  EXPECT_FALSE(orders.positions.is_stopped(vehicle));
  EXPECT_EQ(orders.positions.body(vehicle).x_m, 1.0);
}

TEST(Detects, cosiva_vehicles_each_other_but_no_physical_vehicle_a_virtual_one) {
  OrdersFixture orders;
  const VehicleIndex physical = orders.add("AIV1");
  const VehicleIndex virtual_aiv = orders.add("V1", std::string(wire::virtual_manufacturer));
  const VehicleIndex foreign = orders.add("agv-1", "Acme");
  const VehicleIndex other = orders.add("AIV2");
  const VehicleIndex other_virtual = orders.add("V2", std::string(wire::virtual_manufacturer));
  const auto detects_body = [&](VehicleIndex vehicle, VehicleIndex leader) {
    return detects(orders.server.registry, vehicle, leader);
  };
  EXPECT_TRUE(detects_body(physical, other));
  EXPECT_FALSE(detects_body(physical, virtual_aiv));
  EXPECT_TRUE(detects_body(virtual_aiv, physical));
  EXPECT_TRUE(detects_body(virtual_aiv, other_virtual));
  EXPECT_FALSE(detects_body(foreign, physical));
  EXPECT_FALSE(detects_body(physical, foreign));
  EXPECT_FALSE(detects_body(physical, no_vehicle));
}

}  // namespace
}  // namespace cosiva::virtual_side
