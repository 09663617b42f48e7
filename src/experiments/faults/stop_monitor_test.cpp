#include "cosiva/experiments/faults/stop_monitor.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

/// A vehicle that drives although its monitor has received that it is stopped.
class StopMonitorOfADrivingVehicle : public testing::Test {
 protected:
  StopMonitorOfADrivingVehicle() {
    WorldOptions options;
    options.zone = zone::testing::configuration_file("lacet4.toml");
    options.aivs = 1;
    world = *World::make(std::move(options));
    monitor = std::make_unique<StopMonitor>(*world, 1);
    operators.take(R"({"command":"stop","vehicle":"*"})");
  }
  Finding server_sends(const std::string& type, const std::string& id) {
    wire::InstantActions actions{{1, SimTime{}, "2.1.0", "CoSiVA", "AIV1"},
                                 {{type, id, "", wire::BlockingType::none, {}}}};
    return monitor->on_server_message({"uagv/v2/CoSiVA/AIV1/instantActions", wire::vda5050::encode(actions)},
                                      operators);
  }
  void vehicle_reports(bool paused, const std::string& id) {
    wire::State state;
    state.header = {1, SimTime{}, "2.1.0", "CoSiVA", "AIV1"};
    state.paused = paused;
    state.action_states = {{id, "startPause", wire::ActionStatus::finished, ""}};
    monitor->on_effect(1, {"uagv/v2/CoSiVA/AIV1/state", wire::vda5050::encode(state)});
  }
  /// What the monitor finds until the vehicle has driven for some seconds.
  Finding found() {
    for (int i = 0; i < 100; ++i) {
      if (auto finding = monitor->step(operators, world->faults())) return finding;
      world->run_for(100ms);
    }
    return std::nullopt;
  }

  std::unique_ptr<World> world;
  std::unique_ptr<StopMonitor> monitor;
  OperatorState operators;
};

TEST_F(StopMonitorOfADrivingVehicle, finds_that_it_moves_although_it_has_confirmed_the_stop) {
  EXPECT_FALSE(server_sends("startPause", "A-1"));
  vehicle_reports(true, "A-1");
  const auto finding = found();
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->invariant, "I6");
}

TEST_F(StopMonitorOfADrivingVehicle, takes_a_state_of_an_earlier_stop_for_no_confirmation) {
  EXPECT_FALSE(server_sends("startPause", "A-2"));
  vehicle_reports(true, "A-1");
  EXPECT_FALSE(found());
}

TEST_F(StopMonitorOfADrivingVehicle, takes_a_state_without_pause_for_no_confirmation) {
  EXPECT_FALSE(server_sends("startPause", "A-1"));
  vehicle_reports(false, "A-1");
  EXPECT_FALSE(found());
}

TEST_F(StopMonitorOfADrivingVehicle, forgets_a_confirmation_with_the_restart_also_where_another_stop_follows_at_once) {
  EXPECT_FALSE(server_sends("startPause", "A-1"));
  vehicle_reports(true, "A-1");
  operators.take(R"({"command":"restart","vehicle":"*"})");
  EXPECT_FALSE(server_sends("stopPause", "A-2"));
  operators.take(R"({"command":"stop","vehicle":"*"})");
  EXPECT_FALSE(found());
}

TEST_F(StopMonitorOfADrivingVehicle, finds_a_restart_that_the_server_sends_although_a_stop_holds) {
  const auto finding = server_sends("stopPause", "A-1");
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->invariant, "I6");
}

}  // namespace
}  // namespace cosiva::experiments
