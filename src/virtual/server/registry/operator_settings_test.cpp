#include "cosiva/virtual/server/registry/operator_settings.h"

#include <gtest/gtest.h>

#include <limits>

namespace cosiva::virtual_side {
namespace {

TEST(OperatorSettings, begin_without_any_restriction) {
  const OperatorSettings settings;
  EXPECT_EQ(settings.priority(), 0);
  EXPECT_FALSE(settings.speed_mps_max());
  EXPECT_FALSE(settings.no_orders());
  EXPECT_FALSE(settings.paused_for_body());
}

TEST(OperatorSettings, accept_the_priorities_of_a_zone_only) {
  OperatorSettings settings;
  settings.set_priority(999);
  EXPECT_EQ(settings.priority(), 999);
  settings.set_priority(0);
  EXPECT_EQ(settings.priority(), 0);
  EXPECT_DEATH(settings.set_priority(-1), "priority");
  EXPECT_DEATH(settings.set_priority(1000), "priority");
}

TEST(OperatorSettings, keep_a_vehicle_without_orders_until_it_is_restarted_or_given_a_mission) {
  OperatorSettings settings;
  settings.on_cancel();
  settings.on_stop();
  EXPECT_TRUE(settings.no_orders());
  settings.on_restart();
  EXPECT_FALSE(settings.no_orders());
  settings.on_cancel();
  settings.on_mission();
  EXPECT_FALSE(settings.no_orders());
}

TEST(OperatorSettings, await_that_a_vehicle_confirms_a_stop_from_the_command_on) {
  OperatorSettings settings;
  settings.on_stop();
  EXPECT_TRUE(settings.stop_awaited());
  EXPECT_TRUE(settings.no_orders());
  settings.await_stop(false);
  EXPECT_FALSE(settings.no_orders());
}

TEST(OperatorSettings, keep_a_limit_until_a_profile_or_a_restart_replaces_it) {
  OperatorSettings settings;
  settings.on_limit(0.2);
  settings.on_stop();
  EXPECT_EQ(settings.speed_mps_max(), 0.2);
  settings.on_profile();
  EXPECT_FALSE(settings.speed_mps_max());
  settings.on_limit(0.3);
  settings.on_restart();
  EXPECT_FALSE(settings.speed_mps_max());
}

TEST(OperatorSettings, refuse_a_limit_that_is_no_speed) {
  OperatorSettings settings;
  EXPECT_DEATH(settings.on_limit(0.0), "speed_mps > 0.0");
  EXPECT_DEATH(settings.on_limit(-0.1), "speed_mps > 0.0");
  EXPECT_DEATH(settings.on_limit(std::numeric_limits<double>::infinity()), "isfinite");
}

TEST(OperatorSettings, pause_for_a_body_until_it_has_left_or_an_operator_decides) {
  OperatorSettings settings;
  settings.on_body_in_path();
  EXPECT_TRUE(settings.paused_for_body());
  settings.on_body_left();
  EXPECT_FALSE(settings.paused_for_body());
  for (void (OperatorSettings::*decide)() :
       {&OperatorSettings::on_stop, &OperatorSettings::on_restart, &OperatorSettings::on_retired}) {
    settings.on_body_in_path();
    (settings.*decide)();
    EXPECT_FALSE(settings.paused_for_body());
  }
  settings.on_body_in_path();
  EXPECT_DEATH(settings.on_body_in_path(), "!paused_for_body_");
  settings.on_body_left();
  EXPECT_DEATH(settings.on_body_left(), "paused_for_body_");
}

}  // namespace
}  // namespace cosiva::virtual_side
