#include "cosiva/aiv/onboard/factsheet.h"

#include <gtest/gtest.h>

#include <chrono>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

TEST(Factsheet, states_the_zone_s_vehicle_and_its_fastest_profile) {
  zone::TrafficZone zone = test::lacet4();
  zone.profiles = {{0.1, 0.9, 0.3}, {0.6, 0.2, 0.4}, {0.5, 0.7, 0.8}};
  using std::chrono::milliseconds;
  const wire::Factsheet sheet =
      make_factsheet(zone, {milliseconds{1000}, milliseconds{50}, milliseconds{100}}, usual_actions());
  EXPECT_EQ(sheet.series_name, "CoSiVA AIV");
  EXPECT_EQ(sheet.speed_min_mps, 0.0);
  EXPECT_EQ(sheet.speed_max_mps, 0.6);
  EXPECT_EQ(sheet.acceleration_max_mps2, 0.9);
  EXPECT_EQ(sheet.deceleration_max_mps2, 0.8);
  EXPECT_EQ(sheet.height_m, 0.10);
  EXPECT_EQ(sheet.width_m, 0.12);
  EXPECT_EQ(sheet.length_m, 0.20);
  EXPECT_EQ(sheet.min_order_interval_s, 0.1);
  EXPECT_EQ(sheet.min_state_interval_s, 0.05);
  EXPECT_EQ(sheet.default_state_interval_s, 1.0);
  EXPECT_EQ(sheet.visualization_interval_s, 0.1);
  for (const auto& action : sheet.actions) {
    EXPECT_TRUE(action.instant || action.node) << action.type;
    EXPECT_FALSE(action.description.empty()) << action.type;
  }
}

TEST(Factsheet, declares_the_actions_of_orders_with_scopes_parameters_and_blocking_types) {
  const auto actions_with = [](const ActionCatalogue& catalogue) {
    return make_factsheet(test::lacet4(), {}, catalogue);
  };
  const wire::Factsheet drives_only = actions_with({});
  for (const auto& action : drives_only.actions) EXPECT_FALSE(action.node || action.edge) << action.type;
  EXPECT_TRUE(drives_only.load_positions.empty());

  ActionCatalogue catalogue{{action_named("startCharging"), action_named("polish")}, {"front", "back"}};
  catalogue.types[1].at_nodes = false;
  catalogue.types[1].on_edges = true;
  const wire::Factsheet sheet = actions_with(catalogue);
  ASSERT_EQ(sheet.actions.size(), drives_only.actions.size() + 2);
  const auto& charges = sheet.actions[drives_only.actions.size()];
  EXPECT_TRUE(charges.instant && charges.node && !charges.edge);
  const auto& polishes = sheet.actions.back();
  EXPECT_EQ(polishes.type, "polish");
  EXPECT_TRUE(!polishes.instant && !polishes.node && polishes.edge);
  EXPECT_EQ(polishes.blocking_types.size(), 3U);
  EXPECT_EQ(sheet.load_positions, catalogue.load_positions);
}

}  // namespace
}  // namespace cosiva::aiv
