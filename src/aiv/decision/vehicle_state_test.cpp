#include "cosiva/aiv/decision/vehicle_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_senses.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::order;

zone::TrafficZone diamond_with(std::vector<zone::Tag> tags) {
  zone::TrafficZone made = diamond();
  made.tags = std::move(tags);
  return made;
}

/// A vehicle on the diamond, fed with readings of its board.
struct StateFixture {
  zone::TrafficZone zone;
  VehicleState state;
  wire::Odometry odometry;

  explicit StateFixture(std::vector<zone::Tag> tags = {}) : zone{diamond_with(std::move(tags))}, state{zone, false} {
    read();
    read();
  }
  StateFixture& placed(std::string_view section, double s_m) {
    state.estimator().position_at(at(zone, section, s_m));
    return *this;
  }
  void read(bool driving = false) { state.on_odometry(odometry, driving); }
  void move(double distance_m) {
    odometry.distance_um += std::llround(1e6 * distance_m);
    read();
  }
  void take(const wire::Order& text) { EXPECT_TRUE(state.take_order(text)); }
  std::string back_up(double distance_m) {
    const auto begun = state.begin_back_up(distance_m);
    return begun ? "" : begun.error().code;
  }
  std::string join(const Pose2& X_MG) {
    const auto joins = state.join_line(X_MG);
    return joins ? "" : joins.error().code + ": " + joins.error().message;
  }
  std::string initialise(const Pose2& X_MB) {
    const auto placed_at = state.initialise_position(X_MB, "N");
    return placed_at ? "" : placed_at.error().code;
  }
};

TEST(VehicleState, backs_up_by_half_a_metre_at_most_on_its_path_and_without_an_order) {
  StateFixture vehicle;
  EXPECT_EQ(vehicle.back_up(0.2), "back_up.off_path") << "the position is unknown";
  vehicle.placed("trunk", 1.0);
  EXPECT_EQ(vehicle.back_up(0.501), "back_up.distance");
  EXPECT_EQ(vehicle.back_up(-0.001), "back_up.distance");
  EXPECT_EQ(vehicle.back_up(std::numeric_limits<double>::quiet_NaN()), "back_up.distance");
  EXPECT_FALSE(vehicle.state.back_up().active());
  EXPECT_EQ(vehicle.back_up(0.5), "");
  EXPECT_TRUE(vehicle.state.back_up().active());
  EXPECT_EQ(vehicle.back_up(0.0), "") << "ends it";
  EXPECT_FALSE(vehicle.state.back_up().active());
  EXPECT_EQ(vehicle.back_up(0.1), "");
  vehicle.take(order("O-1").through({"T1", "F"}));
  EXPECT_FALSE(vehicle.state.back_up().active()) << "an order ends it";
  EXPECT_EQ(vehicle.back_up(0.1), "back_up.order");
  EXPECT_EQ(vehicle.back_up(0.0), "");
  const auto too_far = vehicle.state.begin_back_up(0.75);
  EXPECT_EQ(too_far.error().message, "a vehicle backs up at most 0.500000 m, not 0.750000 m");
}

TEST(VehicleState, completes_its_back_up_and_ignores_tags_meanwhile) {
  StateFixture vehicle{std::vector<zone::Tag>{{7, {0, 0.5}}}};
  vehicle.placed("trunk", 1.0);
  EXPECT_EQ(vehicle.back_up(0.2), "");
  vehicle.move(-0.1);
  EXPECT_TRUE(vehicle.state.back_up().active());
  EXPECT_EQ(vehicle.state.on_tag({0, 7, 0}).kind, FixKind::none);
  EXPECT_NEAR(vehicle.state.position().track_position().s_m, 0.9, 1e-9);
  vehicle.move(-0.1);
  EXPECT_FALSE(vehicle.state.back_up().active());
  EXPECT_TRUE(vehicle.state.back_up().completed());
  EXPECT_EQ(vehicle.state.on_tag({0, 7, 0}).kind, FixKind::corrected);
}

TEST(VehicleState, off_its_path_backs_up_only_where_a_path_is_under_it_by_chance) {
  struct Case {
    Pose2 X_MB;
    bool on_line;
  };
  for (const Case& one : {Case{{1.0, 0.0055, 0.0}, true},
                          {{1.0, 0.007, 0.0}, false},
                          {{1.0, 0.0, 0.49}, true},
                          {{1.0, 0.0, -0.49}, true},
                          {{1.0, 0.0, 0.51}, false},
                          {{1.0, 0.9, 0.0}, false}}) {
    StateFixture vehicle;
    vehicle.state.estimator().set_off_path(one.X_MB);
    EXPECT_EQ(vehicle.back_up(0.2), one.on_line ? "" : "back_up.off_path") << one.X_MB.y_m << one.X_MB.heading_rad;
  }
}

TEST(VehicleState, counts_the_distance_of_its_order_forwards_and_backwards_and_none_without_an_order) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0).take(order("O-1").through({"T1", "F"}));
  vehicle.move(0.3);
  EXPECT_NEAR(vehicle.state.order().travelled_m(), 0.3, 1e-9);
  vehicle.move(-0.1);
  EXPECT_NEAR(vehicle.state.order().travelled_m(), 0.2, 1e-9);
  vehicle.move(0.4);
  vehicle.move(0.39);
  EXPECT_FALSE(vehicle.state.order().active());
  EXPECT_NEAR(vehicle.state.order().travelled_m(), 0.99, 1e-9);
  vehicle.move(-0.2);
  EXPECT_NEAR(vehicle.state.order().travelled_m(), 0.99, 1e-9) << "backed up by hand";
  vehicle.move(0.1);
  EXPECT_NEAR(vehicle.state.order().travelled_m(), 1.09, 1e-9);
}

TEST(VehicleState, is_held_without_a_line_unless_it_is_off_path) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0);
  vehicle.odometry.line_lost = true;
  vehicle.read();
  EXPECT_TRUE(vehicle.state.holds().has(Hold::line_lost));
  vehicle.odometry.line_lost = false;
  vehicle.read();
  EXPECT_FALSE(vehicle.state.holds().has(Hold::line_lost));
  vehicle.state.estimator().set_off_path({1.0, 0.2, 0.0});
  vehicle.odometry.line_lost = true;
  vehicle.read();
  EXPECT_FALSE(vehicle.state.holds().has(Hold::line_lost));
}

TEST(VehicleState, that_waits_at_an_undecided_fork_corrects_position_and_order) {
  for (const bool line_lost : {false, true}) {
    StateFixture vehicle;
    vehicle.placed("trunk", 1.95).take(order("O-1").through({"F"}));
    vehicle.placed("trunk", 1.95);
    vehicle.odometry.line_lost = line_lost;
    for (int i = 0; i < 24; ++i) vehicle.read(true);
    EXPECT_NEAR(vehicle.state.position().track_position().s_m, 1.95, 1e-9);
    for (int i = 0; i < 3; ++i) vehicle.read(true);
    EXPECT_NEAR(vehicle.state.position().track_position().s_m, line_lost ? 1.95 : 2.0, 1e-5);
  }
}

TEST(VehicleState, takes_a_position_at_standstill_within_25_centimetres_of_a_path_in_its_direction) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0);
  EXPECT_EQ(vehicle.initialise({1.2, 0.249, 0.0}), "");
  EXPECT_NEAR(vehicle.state.position().track_position().s_m, 1.2, 1e-9);
  EXPECT_FALSE(vehicle.state.position().off_path());
  EXPECT_EQ(vehicle.state.order().last_node().node_id, "N");
  EXPECT_EQ(vehicle.initialise({1.2, 0.251, 0.0}), "position.off_circuit");
  EXPECT_EQ(vehicle.initialise({0.8, 0.0, 1.04}), "");
  EXPECT_EQ(vehicle.initialise({0.8, 0.0, 1.06}), "position.off_circuit");
  EXPECT_EQ(vehicle.state.initialise_position({0.8, 3.0, 0.0}, "N").error().message,
            "no path of 'diamond' passes within 0.25 m of the position in its direction");
  vehicle.odometry.speed_mmps = 50;
  vehicle.read();
  EXPECT_EQ(vehicle.initialise({0.8, 0.0, 0.0}), "position.busy");
  vehicle.odometry.speed_mmps = 0;
  vehicle.read();
  vehicle.read();
  EXPECT_EQ(vehicle.initialise({1.0, 0.0, 0.0}), "");
  vehicle.take(order("O-1").through({"T1", "F"}));
  EXPECT_EQ(vehicle.initialise({0.8, 0.0, 0.0}), "position.busy");
}

TEST(VehicleState, that_detects_no_line_is_off_path_at_the_position_it_is_given) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0);
  vehicle.odometry.line_lost = true;
  vehicle.read();
  EXPECT_EQ(vehicle.initialise({1.2, 0.2, 0.1}), "");
  EXPECT_TRUE(vehicle.state.position().off_path());
  EXPECT_EQ(vehicle.state.position().pose(), (Pose2{1.2, 0.2, 0.1}));
  vehicle.read();
  EXPECT_EQ(vehicle.initialise({1.3, 0.1, 0.1}), "");
  EXPECT_EQ(vehicle.state.position().pose(), (Pose2{1.3, 0.1, 0.1})) << "still off-path";
}

TEST(VehicleState, joins_a_path_within_70_centimetres_at_a_pose_on_it) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0);
  EXPECT_EQ(vehicle.join({1.0, 0.0, 0.0}), "join.on_line: the vehicle is not off-path");
  EXPECT_FALSE(vehicle.state.joining());
  vehicle.state.estimator().set_off_path({1.0, 0.2, 0.0});
  const double far_m = std::sqrt(0.7 * 0.7 - 0.2 * 0.2);
  EXPECT_EQ(vehicle.join({1.0 - far_m - 0.001, 0.0, 0.0}).substr(0, 13), "join.too_far:");
  EXPECT_EQ(vehicle.join({1.0, 1.2, 0.0}), "join.too_far: the pose is 1.000000 m away, further than 0.700000 m");
  EXPECT_EQ(vehicle.join({1.1, 0.021, 0.0}), "join.no_line: no path of 'diamond' passes there in that direction");
  EXPECT_EQ(vehicle.join({1.1, 0.0, 0.51}).substr(0, 12), "join.no_line");
  EXPECT_EQ(vehicle.join({1.1, 0.0, -0.51}).substr(0, 12), "join.no_line");
  EXPECT_FALSE(vehicle.state.joining());
  EXPECT_EQ(vehicle.join({1.1, 0.019, 0.49}), "");
  EXPECT_TRUE(vehicle.state.joining());
  EXPECT_NEAR(vehicle.state.position().track_position().s_m, 1.1, 1e-9);
  EXPECT_EQ(vehicle.join({1.0 - far_m + 0.001, 0.0, 0.0}), "");
  vehicle.read();
  EXPECT_TRUE(vehicle.state.joining());
  vehicle.odometry.manoeuvre = wire::Manoeuvre{0, 0, 10};
  vehicle.read();
  EXPECT_EQ(vehicle.join({1.1, 0.0, 0.0}), "join.busy: the vehicle is joining a path already");
  vehicle.odometry.manoeuvre.reset();
  vehicle.placed("trunk", 1.0).read();
  EXPECT_FALSE(vehicle.state.joining());
}

TEST(VehicleState, turns_with_its_path_or_its_manoeuvre) {
  StateFixture vehicle;
  vehicle.odometry.speed_mmps = 300;
  vehicle.read();
  EXPECT_EQ(vehicle.state.turn_rate_radps(), 0.0) << "the position is unknown";
  vehicle.placed("r_up", 0.1);
  EXPECT_NEAR(vehicle.state.turn_rate_radps(), -0.3, 1e-12);
  vehicle.placed("r_over", 0.1);
  EXPECT_NEAR(vehicle.state.turn_rate_radps(), 0.3, 1e-12);
  vehicle.placed("trunk", 0.1);
  EXPECT_EQ(vehicle.state.turn_rate_radps(), 0.0);
  vehicle.state.estimator().set_off_path(diamond().circuit.pose_at(at(diamond(), "r_up", 0.1)));
  EXPECT_EQ(vehicle.state.turn_rate_radps(), 0.0);
  vehicle.odometry.speed_mmps = 0;
  vehicle.odometry.manoeuvre = wire::Manoeuvre{0, 0, 10};
  vehicle.odometry.board_ms = 1000;
  vehicle.read();
  vehicle.odometry.manoeuvre = wire::Manoeuvre{0, 0, 40};
  vehicle.odometry.board_ms = 1020;
  vehicle.read();
  EXPECT_NEAR(vehicle.state.turn_rate_radps(), 1.5, 1e-12);
}

TEST(VehicleState, in_another_zone_keeps_its_pose_its_ids_and_its_holds_but_for_the_change_itself) {
  StateFixture before;
  before.placed("trunk", 1.0).take(order("O-1").through({"T1", "F"}));
  for (const Hold hold : {Hold::paused, Hold::zone_change, Hold::line_lost}) before.state.hold(hold, true);
  VehicleState after{before.zone, false};
  after.take_over(before.state);
  EXPECT_EQ(after.position().pose(), before.state.position().pose());
  EXPECT_EQ(after.order().ids().order_id, "O-1");
  EXPECT_FALSE(after.order().active());
  EXPECT_TRUE(after.holds().has(Hold::paused));
  EXPECT_FALSE(after.holds().has(Hold::zone_change));
  EXPECT_FALSE(after.holds().has(Hold::line_lost)) << "the vehicle is off-path there";
  EXPECT_TRUE(after.motion().stopped());

  StateFixture lost;
  lost.state.hold(Hold::line_lost, true);
  VehicleState nowhere{lost.zone, false};
  nowhere.take_over(lost.state);
  EXPECT_TRUE(nowhere.holds().has(Hold::line_lost));
}

TEST(VehicleState, drops_a_cancelled_order_and_refuses_others_until_then) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0).take(order("O-1").through({"T1", "F", "ro"}));
  EXPECT_TRUE(vehicle.state.progress().begin_cancel());
  vehicle.state.estimator().set_off_path({1.0, 3.0, 0.0});  // away from all paths, where an order has no route
  EXPECT_EQ(vehicle.state.take_order(order("O-2").through({"T1", "F"})).error().code, "orderUpdateError");
  vehicle.placed("trunk", 1.0);
  EXPECT_EQ(vehicle.back_up(0.1), "back_up.order");
  vehicle.state.end_cancel();
  EXPECT_FALSE(vehicle.state.order().active());
  EXPECT_FALSE(vehicle.state.progress().cancelling());
  EXPECT_TRUE(vehicle.state.position().on_path_estimator().path().course().remaining().empty());
  vehicle.take(order("O-2").through({"T1", "F", "lo"}));
  EXPECT_FALSE(vehicle.state.position().on_path_estimator().path().course().remaining().empty());
}

TEST(VehicleState, continues_its_order_after_a_jump_along_it) {
  StateFixture vehicle{std::vector<zone::Tag>{{7, {4, 0.3}}, {8, {2, 0.3}}}};
  vehicle.placed("trunk", 1.0).take(order("O-1").through({"T1", "F", "ro"}));
  EXPECT_EQ(vehicle.state.on_tag({0, 7, 0}).kind, FixKind::relocated);
  EXPECT_NEAR(vehicle.state.order().travelled_m(), 1.3, 0.05);
  ASSERT_EQ(vehicle.state.progress().take_traversed().size(), 1U) << "the fork";
  EXPECT_TRUE(vehicle.state.order().active());
  EXPECT_EQ(vehicle.state.on_tag({0, 8, 0}).kind, FixKind::relocated);
  EXPECT_FALSE(vehicle.state.order().active()) << "the other branch";
  EXPECT_TRUE(vehicle.state.progress().take_lost());
}

TEST(VehicleState, uses_ranges_only_where_its_position_is_known_and_forgets_them_when_it_is_placed) {
  StateFixture vehicle;
  const auto ranges = test::ranges_to({{0.5, 0.0}}, {});
  for (int i = 0; i < 3; ++i) vehicle.state.on_ranges(ranges);
  vehicle.placed("trunk", 1.0);
  EXPECT_EQ(vehicle.state.watch().ahead_m(vehicle.state.position()), std::numeric_limits<double>::infinity());
  for (int i = 0; i < 3; ++i) vehicle.state.on_ranges(ranges);
  EXPECT_NEAR(vehicle.state.watch().ahead_m(vehicle.state.position()), 0.4, 0.01);
  EXPECT_EQ(vehicle.initialise({1.2, 0.0, 0.0}), "");
  EXPECT_EQ(vehicle.state.watch().ahead_m(vehicle.state.position()), std::numeric_limits<double>::infinity());
}

TEST(VehicleStateDeathTest, ends_a_cancellation_only_at_standstill) {
  StateFixture vehicle;
  vehicle.placed("trunk", 1.0).take(order("O-1").through({"T1", "F"}));
  ASSERT_TRUE(vehicle.state.progress().begin_cancel());
  vehicle.odometry.speed_mmps = 50;
  vehicle.read();
  EXPECT_DEATH(vehicle.state.end_cancel(), "stopped");
}

}  // namespace
}  // namespace cosiva::aiv
