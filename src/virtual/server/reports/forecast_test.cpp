#include "cosiva/virtual/server/reports/forecast.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

/// A vehicle on the oval, 0.5 m along "south", that another master control drives: the test writes its messages, and
/// the twin shows what the server expects of it.
class Forecasted : public testing::TestWithParam<const char*> {
 protected:
  static ServerOptions watching(bool anticipation = true) {
    ServerOptions options;
    options.drive = false;
    options.anticipation = anticipation;
    options.virtual_rules = {};
    return options;
  }
  struct Scene {
    explicit Scene(const std::string& manufacturer, bool anticipation = true)
        : fixture{oval(), watching(anticipation)}, vehicle{fixture.add("agv-7", {0, 0.5}, manufacturer)} {
      vehicle.alive = false;
    }
    ServerFixture fixture;
    FixtureVehicle& vehicle;
  };
  /// Reports the speed at 0.5 m, and 0.1 s later, where it is `then_mps`, at the position driven until then.
  static void report(Scene& scene, double first_mps, double then_mps, double base_m, bool paused = false) {
    const auto send = [&](double speed_mps, double s_m) {
      wire::State state = scene.vehicle.state(scene.fixture.now);
      state.driving = true;
      state.paused = paused;
      state.position->pose = scene.fixture.zone->circuit.pose_at({0, s_m});
      state.velocity = wire::Velocity{speed_mps, 0.0, 0.0};
      state.node_states = {{node_beyond(scene, 0.5 + base_m), 2, true, {}}};
      scene.fixture.send(scene.vehicle, "state", vda::encode(state));
    };
    send(first_mps, 0.5 - 0.05 * (first_mps + then_mps));
    scene.fixture.now += 100ms;
    send(then_mps, 0.5);
  }
  /// The first waypoint at or beyond this distance along "south".
  static std::string node_beyond(const Scene& scene, double s_m) {
    const zone::Waypoint* found = nullptr;
    for (const zone::Waypoint& waypoint : scene.fixture.zone->waypoints)
      if (waypoint.position.section == 0 && waypoint.position.s_m >= s_m &&
          (found == nullptr || waypoint.position.s_m < found->position.s_m))
        found = &waypoint;
    EXPECT_NE(found, nullptr);
    return found == nullptr ? "" : found->id;
  }
  /// How far the twin moves in this time after the last report.
  static double moved_m(Scene& scene, SimDuration after) {
    scene.fixture.now += after;
    scene.fixture.feed(wire::InputKind::tick, "", "");
    const std::string name = wire::to_string(scene.vehicle.id);
    return scene.fixture.aiv(name).number("s").value_or(0.0) - 0.5;
  }
};

TEST_F(Forecasted, vehicle_that_has_begun_to_accelerate_accelerates_up_to_the_speed_of_its_rules) {
  Scene scene{"CoSiVA"};
  report(scene, 0.1, 0.15, 1.2);
  // 0.5 m/s², as between the reports: 0.15 t + 0.25 t².
  EXPECT_NEAR(moved_m(scene, 200ms), 0.15 * 0.2 + 0.25 * 0.04, 0.003);
}

TEST_F(Forecasted, vehicle_that_keeps_its_speed_is_not_expected_to_accelerate) {
  Scene scene{"CoSiVA"};
  report(scene, 0.15, 0.15, 1.2);
  EXPECT_NEAR(moved_m(scene, 200ms), 0.15 * 0.2, 0.002) << "it may see what the server does not know";
}

TEST_F(Forecasted, vehicle_brakes_before_the_end_of_its_base) {
  Scene scene{"CoSiVA"};
  report(scene, 0.4, 0.4, 0.05);
  const double moved = moved_m(scene, 200ms);
  EXPECT_LT(moved, 0.4 * 0.2 - 0.005);
  EXPECT_GT(moved, 0.02);
}

TEST_F(Forecasted, paused_vehicle_brakes) {
  Scene scene{"CoSiVA"};
  report(scene, 0.4, 0.4, 1.2, true);
  EXPECT_LT(moved_m(scene, 300ms), 0.4 * 0.3 - 0.01);
}

TEST_F(Forecasted, vehicle_of_unknown_rules_moves_on_at_its_speed) {
  Scene scene{"Acme"};
  report(scene, 0.1, 0.15, 1.2);
  EXPECT_NEAR(moved_m(scene, 200ms), 0.15 * 0.2, 0.002);
}

TEST_F(Forecasted, vehicle_is_expected_to_move_as_before_after_an_edit_of_the_zone) {
  Scene scene{"CoSiVA"};
  const std::string edit = R"({"command":"edit","edit":{"priorities":{"CoSiVA/agv-7":5}}})";
  ASSERT_EQ(scene.fixture.refusal(edit), "");
  scene.fixture.send_command(edit);  // the zone before the edit exists no longer
  report(scene, 0.1, 0.15, 1.2);
  EXPECT_NEAR(moved_m(scene, 200ms), 0.15 * 0.2 + 0.25 * 0.04, 0.003);
}

TEST_F(Forecasted, nothing_is_expected_where_anticipation_is_switched_off) {
  Scene scene{"CoSiVA", false};
  report(scene, 0.1, 0.15, 1.2);
  EXPECT_NEAR(moved_m(scene, 200ms), 0.15 * 0.2, 0.002);
}

}  // namespace
}  // namespace cosiva::virtual_side
