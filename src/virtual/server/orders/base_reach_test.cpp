#include "cosiva/virtual/server/orders/base_reach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

constexpr double fast_mps = 0.5;
constexpr double braking_mps2 = 0.8;  // of the medium profile
constexpr double latency_s = 0.5;     // 0.3 s from a report to the wheels, and 0.2 s between updates

/// A vehicle on the oval that has reported at `orders.now`.
class Reach : public testing::Test {
 protected:
  Reach() {
    EXPECT_EQ(orders.map->zone().profiles.fast.speed_mps, fast_mps);
    EXPECT_EQ(orders.map->zone().profiles.medium.braking_mps2, braking_mps2);
  }
  VehicleIndex add(const std::string& manufacturer) {
    return orders.add_at("AIV" + std::to_string(++number), orders.at("south", 0.0), manufacturer);
  }
  [[nodiscard]] BaseReach reach_of(VehicleIndex vehicle) {
    return {orders.proxy(vehicle), orders.map->zone(), orders.context.rules, orders.now};
  }
  void factsheet(VehicleIndex vehicle, double speed_mps, double deceleration_mps2) {
    wire::Factsheet sheet;
    sheet.speed_max_mps = speed_mps;
    sheet.deceleration_max_mps2 = deceleration_mps2;
    orders.proxy(vehicle).factsheet.on_factsheet(std::move(sheet));
  }
  /// The length of the base that the vehicle gets now, from its reported position; 0: no order.
  double released_m(VehicleIndex vehicle) {
    if (!orders.extend(vehicle)) return 0.0;
    orders.acknowledge(vehicle);
    return *orders.traffic.base_left_m(vehicle, *orders.positions.reported(vehicle).position);
  }
  [[nodiscard]] double spacing_m() const { return orders.map->stretch(0).length_m; }
  OrdersFixture orders;
  int number{0};
};

TEST_F(Reach, of_a_cosiva_vehicle_is_that_of_the_order_rules_since_it_brakes_by_itself) {
  for (const std::string manufacturer : {"CoSiVA", "CoSiVA.virtual"}) {
    const BaseReach reach = reach_of(add(manufacturer));
    EXPECT_EQ(reach.wanted_m(), 1.2);
    EXPECT_EQ(reach.limit_m(), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(reach.extends(1.19, 100.0));
    EXPECT_FALSE(reach.extends(1.2, 1.3));
  }
}

TEST_F(Reach, of_a_third_party_vehicle_is_limited_by_its_speed_and_the_permitted_time) {
  const VehicleIndex vehicle = add("Acme");
  for (const auto& [permitted, seconds] : {std::pair{2s, 2.0}, std::pair{3s, 3.0}, std::pair{10s, 10.0}}) {
    orders.context.rules.permitted_time = permitted;
    EXPECT_NEAR(reach_of(vehicle).limit_m(), fast_mps * seconds, 1e-12);
  }
  orders.context.rules.permitted_time = 2s;
  factsheet(vehicle, 0.3, 0.0);
  EXPECT_NEAR(reach_of(vehicle).limit_m(), 0.3 * 2.0, 1e-12);
  factsheet(vehicle, 3.0, 0.0);
  EXPECT_NEAR(reach_of(vehicle).limit_m(), fast_mps * 2.0, 1e-12) << "its orders permit no more";
  EXPECT_NEAR(reach_of(vehicle).limit_m(0.15), 0.15 * 2.0, 1e-12) << "nor do those over a slow stretch";
}

TEST_F(Reach, of_a_third_party_vehicle_is_never_below_the_distance_that_keeps_it_moving) {
  const VehicleIndex vehicle = add("Acme");
  orders.context.rules.permitted_time = 10ms;
  const double needed_m = fast_mps * latency_s + fast_mps * fast_mps / (2.0 * braking_mps2);
  EXPECT_NEAR(reach_of(vehicle).needed_m(), needed_m, 1e-12);
  EXPECT_NEAR(reach_of(vehicle).limit_m(), needed_m, 1e-12);
  factsheet(vehicle, 0.5, 0.2);
  EXPECT_NEAR(reach_of(vehicle).limit_m(), 0.5 * latency_s + 0.5 * 0.5 / (2.0 * 0.2), 1e-12) << "it brakes weakly";
  factsheet(vehicle, 0.5, 5.0);
  EXPECT_NEAR(reach_of(vehicle).limit_m(), needed_m, 1e-12) << "its maximum is not how it brakes before its last node";
}

TEST_F(Reach, is_not_limited_without_a_permitted_time) {
  orders.context.rules.permitted_time = {};
  EXPECT_EQ(reach_of(add("Acme")).limit_m(), std::numeric_limits<double>::infinity());
}

TEST_F(Reach, grows_with_the_age_of_the_report_up_to_the_limit) {
  const VehicleIndex vehicle = add("Acme");
  orders.context.rules.base_reach_m = 0.1;
  const double needed_m = reach_of(vehicle).needed_m();
  EXPECT_NEAR(reach_of(vehicle).wanted_m(), needed_m, 1e-12);
  orders.pass(1s);
  EXPECT_NEAR(reach_of(vehicle).wanted_m(), needed_m + fast_mps, 1e-12) << "it may have driven this far";
  EXPECT_NEAR(reach_of(vehicle).limit_m(), 1.0, 1e-12) << "the time counts from the last report";
}

TEST_F(Reach, extends_within_the_limit_and_beyond_only_for_what_is_needed) {
  const BaseReach reach = reach_of(add("Acme"));
  EXPECT_TRUE(reach.extends(0.9, 1.0));
  EXPECT_FALSE(reach.extends(0.9, 1.0 + 1e-9));
  EXPECT_TRUE(reach.extends(reach.needed_m() - 1e-9, 5.0)) << "there is no nearer node";
  EXPECT_FALSE(reach.extends(reach.needed_m(), 5.0));
  EXPECT_FALSE(reach.extends(reach.wanted_m(), reach.wanted_m()));
}

// --- released metres against v·t
// --------------------------------------------------------------------------------------

TEST_F(Reach, releases_to_a_third_party_vehicle_no_more_metres_than_it_drives_within_the_permitted_time) {
  orders.context.rules.base_reach_m = 100.0;
  orders.context.rules.base_nodes_max = 100;
  for (const double seconds : {1.5, 2.0, 3.0, 5.0, 8.0}) {
    orders.context.rules.permitted_time = from_seconds(seconds);
    const VehicleIndex vehicle = add("Acme");
    const double base_m = released_m(vehicle);
    EXPECT_LE(base_m, fast_mps * seconds + 1e-9);
    EXPECT_GT(base_m, fast_mps * seconds - spacing_m()) << "up to the last node within the limit";
    orders.traffic.forget(vehicle);
  }
}

TEST_F(Reach, releases_to_a_cosiva_vehicle_as_much_as_before) { EXPECT_GE(released_m(add("CoSiVA")), 1.2); }

TEST_F(Reach, releases_the_next_node_where_the_permitted_time_is_too_short_to_keep_moving) {
  orders.context.rules.permitted_time = 10ms;
  const VehicleIndex vehicle = add("Acme");
  const double needed_m = reach_of(vehicle).needed_m();
  const double base_m = released_m(vehicle);
  EXPECT_GE(base_m, needed_m);
  EXPECT_LT(base_m, needed_m + spacing_m());
}

TEST_F(Reach, is_never_exceeded_from_any_reported_position_on_the_route) {
  const VehicleIndex vehicle = add("Acme");
  for (double s_m = 0.0; s_m < 2.0; s_m += 0.03) {
    orders.report_at(vehicle, orders.at("south", s_m), fast_mps);
    (void)released_m(vehicle);
    const double left_m = *orders.traffic.base_left_m(vehicle, orders.at("south", s_m));
    EXPECT_LE(left_m, fast_mps * 2.0 + 1e-9) << s_m;
    EXPECT_GE(left_m, reach_of(vehicle).needed_m() - 1e-9) << s_m << ": it need not brake";
    orders.pass(60ms);
  }
}

TEST_F(Reach, releases_nothing_more_to_a_vehicle_whose_report_gets_old) {
  orders.context.rules.base_reach_m = 100.0;
  const VehicleIndex vehicle = add("Acme");
  const double base_m = released_m(vehicle);
  ASSERT_GT(base_m, 0.0);
  for (int i = 0; i < 50; ++i) {
    orders.pass(100ms);
    EXPECT_FALSE(orders.extend(vehicle)) << "after " << 100 * (i + 1) << " ms";
  }
}

TEST(BaseReachOnline, lets_a_third_party_vehicle_keep_its_speed_and_stop_within_the_permitted_time) {
  constexpr double permitted_s = 1.5;
  ServerOptions options;
  options.permitted_time = from_seconds(permitted_s);
  ServerFixture fixture{oval(), options};
  FixtureVehicle& vehicle = fixture.add("agv-7", {0, 0.5}, "Acme");
  vehicle.cruise_mps = fast_mps;
  fixture.run_for(3s);
  int stops = 0;
  double longest_m = 0.0;
  fixture.each_step = [&] {
    if (vehicle.speed_mps < fast_mps - 1e-9) ++stops;
    longest_m = std::max(longest_m, vehicle.book->distance_to_base_end_m());
  };
  fixture.run_for(30s);
  EXPECT_EQ(stops, 0);
  EXPECT_LE(longest_m, fast_mps * permitted_s + 1e-9);
  // The server sends nothing more.
  const double before_m = vehicle.driven_m;
  double drives_for_s = 0.0;
  while (vehicle.speed_mps > 0.0 && drives_for_s < 60.0) {
    vehicle.step(20ms);
    drives_for_s += 0.02;
  }
  EXPECT_LE(drives_for_s, permitted_s + 0.04) << "and the last step, in which it stops";
  EXPECT_LE(vehicle.driven_m - before_m, fast_mps * permitted_s + 1e-9);
}

}  // namespace
}  // namespace cosiva::virtual_side
