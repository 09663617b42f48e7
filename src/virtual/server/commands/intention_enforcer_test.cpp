#include "cosiva/virtual/server/commands/intention_enforcer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

class EnforcedIntentions : public testing::Test {
 protected:
  EnforcedIntentions() { fixture.run_for(3s); }
  /// The vehicle is switched on again, without the commands that it had received.
  void start_again(FixtureVehicle& vehicle) {
    vehicle.alive = true;
    vehicle.paused = false;
    vehicle.profile = "normal";
    vehicle.action_states.clear();
    vehicle.state_due = true;
    fixture.connection(vehicle, wire::ConnectionState::online);
  }
  ServerFixture fixture;
  FixtureVehicle& aiv1{fixture.add("AIV1", {0, 0.5})};
  FixtureVehicle& aiv2{fixture.add("AIV2", {2, 0.5})};
};

TEST_F(EnforcedIntentions, stop_a_vehicle_that_was_dead_at_the_stop_when_it_returns) {
  fixture.kill(aiv2);
  fixture.run_for(2s);
  fixture.command("stop", "*", "c1");
  fixture.run_for(10s);
  EXPECT_EQ(fixture.command_entry("c1.AIV1").text("state"), "materialised");
  EXPECT_EQ(fixture.command_entry("c1.AIV2").text("state"), "issued") << "no time limit ends a Stop";
  const double driven_m = aiv2.driven_m;
  start_again(aiv2);
  fixture.run_for(3s);
  EXPECT_TRUE(aiv2.paused);
  EXPECT_EQ(fixture.command_entry("c1.AIV2").text("state"), "materialised");
  EXPECT_NEAR(aiv2.driven_m, driven_m, 0.1) << "on its own order, until the first startPause arrived";
}

TEST_F(EnforcedIntentions, stop_a_vehicle_again_that_was_restarted) {
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(2s);
  fixture.kill(aiv1);
  fixture.run_for(2s);
  const double driven_m = aiv1.driven_m;
  start_again(aiv1);
  fixture.run_for(3s);
  EXPECT_TRUE(aiv1.paused);
  EXPECT_NEAR(aiv1.driven_m, driven_m, 0.1) << "until the first startPause arrived";
}

TEST_F(EnforcedIntentions, stop_a_vehicle_again_that_an_older_restart_has_released_while_it_braked) {
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  for (int i = 0; i < 100 && !aiv1.paused; ++i) fixture.run_for(10ms);
  ASSERT_TRUE(aiv1.paused);
  ASSERT_GT(aiv1.speed_mps, 0.1) << "it brakes, so that the Stop is not confirmed yet";
  aiv1.paused = false;  // a stopPause that was delayed; the vehicle has performed the Stop, and does not repeat it
  aiv1.state_due = true;
  const double driven_m = aiv1.driven_m;
  fixture.run_for(2s);
  EXPECT_TRUE(aiv1.paused);
  EXPECT_EQ(aiv1.speed_mps, 0.0);
  EXPECT_LT(aiv1.driven_m, driven_m + 0.5);
}

TEST_F(EnforcedIntentions, stop_a_vehicle_again_although_another_command_is_open) {
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(2s);
  aiv1.deaf_to.insert("setSpeedLimit");
  fixture.command("slow", "CoSiVA/AIV1", "c2");
  fixture.run_for(200ms);
  aiv1.paused = false;
  aiv1.state_due = true;
  fixture.run_for(1s);
  EXPECT_EQ(fixture.command_entry("c2").text("state"), "issued");
  EXPECT_TRUE(aiv1.paused);
}

TEST_F(EnforcedIntentions, hold_over_a_restart_of_the_server) {
  fixture.kill(aiv2);
  fixture.run_for(1s);
  fixture.command("stop", "*");
  fixture.restart_server(true);
  fixture.run_for(1s);
  start_again(aiv2);
  fixture.run_for(3s);
  EXPECT_TRUE(aiv1.paused);
  EXPECT_TRUE(aiv2.paused);
}

TEST_F(EnforcedIntentions, hold_for_a_vehicle_that_was_unknown) {
  fixture.command("stop", "*");
  FixtureVehicle& newcomer = fixture.add("AIV3", {0, 1.5});
  fixture.run_for(3s);
  EXPECT_TRUE(newcomer.paused);
  EXPECT_EQ(newcomer.driven_m, 0.0);
}

TEST_F(EnforcedIntentions, end_with_a_restart_that_may_be_given_while_the_vehicle_is_away) {
  fixture.command("stop", "*");
  fixture.run_for(2s);
  fixture.kill(aiv2);
  fixture.run_for(1s);
  fixture.command("restart", "*");
  start_again(aiv2);
  const double driven_m = aiv2.driven_m;
  fixture.run_for(8s);
  EXPECT_FALSE(aiv1.paused);
  EXPECT_FALSE(aiv2.paused);
  EXPECT_GT(aiv2.driven_m, driven_m + 0.5);
}

TEST_F(EnforcedIntentions, limit_the_speed_again_of_a_vehicle_that_lost_its_limit) {
  fixture.send_command(R"({"command":"limit","speed":0.12,"vehicle":"CoSiVA/AIV1","id":"c1"})");
  fixture.run_for(3s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").number("speedLimit"), 0.12);
  fixture.kill(aiv1);
  fixture.run_for(1s);
  start_again(aiv1);
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").find("speedLimit")->is_null()) << "only what the vehicle confirmed is shown";
  fixture.run_for(4s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").number("speedLimit"), 0.12);
  EXPECT_LE(aiv1.speed_mps, 0.12 + 1e-9);
}

TEST_F(EnforcedIntentions, impose_a_profile_again_after_a_restart_of_the_server) {
  fixture.command("slow", "CoSiVA/AIV1");
  fixture.run_for(2s);
  fixture.restart_server(true);
  aiv1.profile = "normal";
  aiv1.action_states.clear();
  aiv1.state_due = true;
  fixture.run_for(4s);
  EXPECT_EQ(aiv1.profile, "slow");
}

TEST_F(EnforcedIntentions, give_no_order_to_a_cancelled_vehicle_after_a_restart_of_the_server) {
  fixture.command("cancel", "CoSiVA/AIV1");
  fixture.run_for(5s);
  fixture.restart_server(true);
  const double driven_m = aiv1.driven_m;
  fixture.run_for(10s);
  EXPECT_EQ(aiv1.driven_m, driven_m);
}

TEST_F(EnforcedIntentions, of_cancelling_end_with_a_mission) {
  fixture.command("cancel", "CoSiVA/AIV1");
  fixture.run_for(5s);
  fixture.send_command(R"({"command":"circulate","vehicle":"CoSiVA/AIV1"})");
  const double driven_m = aiv1.driven_m;
  fixture.run_for(10s);
  EXPECT_GT(aiv1.driven_m, driven_m + 0.5);
}

}  // namespace
}  // namespace cosiva::virtual_side
