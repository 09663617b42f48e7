// The agent on graphs: forks, bends on the spot, and paths that it has yet to join.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <tuple>

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_line_world.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_senses.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::LineWorld;
using test::order;
using test::square;
using ::testing::ElementsAre;

struct GraphFixture {
  const zone::TrafficZone& zone;
  Agent agent{zone};
  LineWorld world;
  std::vector<Point2> obstacles;
  std::vector<std::string> traversed;
  wire::Drive drive;
  double pose_error_m{0.0};    ///< the largest since it was reset
  double bend_speed_mps{0.0};  ///< the highest just before a turn
  int turns{0};
  int tick{0};

  GraphFixture(const zone::TrafficZone& z, std::string_view section, double s_m, double estimated_ahead_m = 0.0)
      : zone{z}, world{z.circuit, at(z, section, s_m)} {
    agent.vehicle().estimator().position_at(at(z, section, s_m + estimated_ahead_m));
    step();
  }
  GraphFixture& take(const wire::Order& text) {
    const auto verdict = agent.vehicle().take_order(text);
    EXPECT_TRUE(verdict) << verdict.error().message;
    return *this;
  }
  void step() {
    drive = agent.decide();
    const bool turned = world.manoeuvring();
    const double before_mps = world.speed_mps;
    world.step(&drive, 0.02);
    if (world.manoeuvring() && !turned) {
      ++turns;
      bend_speed_mps = std::max(bend_speed_mps, before_mps);
    }
    wire::Odometry odometry = world.odometry();
    odometry.board_ms = static_cast<std::uint32_t>(20 * tick);
    agent.on_odometry(odometry);
    if (++tick % 3 == 0) agent.vehicle().on_ranges(test::ranges_to(obstacles, world.pose()));
    for (const auto& node : agent.vehicle().progress().take_traversed()) traversed.push_back(node.node_id);
    if (agent.vehicle().position().pose_known())
      pose_error_m = std::max(pose_error_m, distance(agent.vehicle().position().pose(), world.pose()));
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50.0); ++i) step();
  }
  bool run_until(const std::function<bool()>& done, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50.0) && !done(); ++i) step();
    return done();
  }
  std::string section() const { return zone.circuit.part(world.track_position().section).name; }
  double heading_error_rad() const {
    return std::fabs(wrap_angle(agent.vehicle().position().pose().heading_rad - world.pose().heading_rad));
  }
};

// --- forks ----------------------------------------------------------------------------------------------------------

TEST(AgentAtAFork, takes_either_branch_as_its_order_requires) {
  for (const auto& [node, over] : {std::pair{"ro", "r_over"}, std::pair{"lo", "l_over"}}) {
    GraphFixture fixture{diamond(), "trunk", 1.0};
    fixture.take(order("O-1").through({"T1", "F", node}));
    fixture.run(12.0);
    EXPECT_THAT(fixture.traversed, ElementsAre("F", node));
    EXPECT_EQ(fixture.zone.circuit.part(fixture.agent.vehicle().position().track_position().section).name.substr(0, 1),
              std::string(over).substr(0, 1));
    EXPECT_NEAR(distance(fixture.world.pose(), fixture.zone.circuit.pose_at(at(fixture.zone, over, 0.0))), 0.0, 0.015);
    EXPECT_LT(fixture.pose_error_m, 0.005);
  }
}

TEST(AgentAtAFork, commands_the_branch_only_when_its_base_leads_over_it) {
  GraphFixture fixture{diamond(), "trunk", 1.0};
  EXPECT_EQ(fixture.drive.branch, wire::no_branch);
  fixture.take(order("O-1").through({"T1", "F"}).then({"ro"}));
  fixture.run(8.0);
  EXPECT_EQ(fixture.drive.branch, wire::no_branch);
  EXPECT_EQ(fixture.section(), "trunk");
  EXPECT_NEAR(fixture.world.track_position().s_m, 2.0, 0.015);
  EXPECT_TRUE(fixture.agent.vehicle().motion().stopped());
  fixture.take(order("O-1", 1).from_sequence(2).through({"F", "ro"}));
  fixture.step();
  EXPECT_EQ(fixture.drive.branch, 1);
  fixture.run(6.0);
  EXPECT_LT(distance(fixture.world.pose(), fixture.zone.circuit.pose_at(at(fixture.zone, "r_over", 0.0))), 0.015);
}

TEST(AgentAtAFork, keeps_its_branch_until_its_body_has_passed_the_fork) {
  // The estimate is 6 cm too far: at the fork the body is not there yet.
  GraphFixture fixture{diamond(), "trunk", 1.0, 0.06};
  fixture.take(order("O-1").through({"T1", "F", "ro", "rd"}));
  fixture.run(15.0);
  EXPECT_EQ(fixture.section().substr(0, 1), "r");
}

TEST(AgentAtAFork, corrects_its_position_when_its_wheels_stop_at_the_fork) {
  // The estimate is 4 cm short: PILS stops at the fork, and the base ends there.
  GraphFixture fixture{diamond(), "trunk", 1.0, -0.04};
  fixture.take(order("O-1").through({"T1", "F"}));
  fixture.run(10.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("F"));
  EXPECT_LT(distance(fixture.agent.vehicle().position().pose(), fixture.world.pose()), 0.002);
}

TEST(AgentAtAFork, accepts_an_order_along_the_other_branch_despite_a_small_overestimate) {
  Agent agent{diamond()};
  agent.vehicle().estimator().position_at(at(diamond(), "l_up", 0.005));
  const auto verdict = agent.vehicle().take_order(order("O-1").through({"T1", "F", "ro"}));
  ASSERT_TRUE(verdict) << verdict.error().message;
  EXPECT_EQ(diamond().circuit.part(agent.vehicle().position().track_position().section).name.substr(0, 1), "t");
  EXPECT_EQ(agent.decide().branch, 1);

  Agent beyond{diamond()};
  beyond.vehicle().estimator().position_at(at(diamond(), "l_up", 0.3));
  EXPECT_FALSE(beyond.vehicle().take_order(order("O-1").through({"T1", "F", "ro"})));
}

TEST(AgentOnTwoSections, that_coincide_accepts_an_order_along_either) {
  for (const auto& [estimated, node, edge] : {std::tuple{"there", "tt", "there_too"}, {"there_too", "t", "there"}}) {
    Agent agent{test::there_and_back()};
    agent.vehicle().estimator().position_at(at(test::there_and_back(), estimated, 0.2));
    auto text = order("O-1").through({"W", node});
    const auto verdict = agent.vehicle().take_order(text);
    ASSERT_TRUE(verdict) << verdict.error().message;
    EXPECT_EQ(test::there_and_back().circuit.part(agent.vehicle().position().track_position().section).name, edge);
    EXPECT_NEAR(agent.vehicle().position().track_position().s_m, 0.2, 1e-9);
  }
}

TEST(AgentAtTheEnd, of_a_path_without_forks_corrects_its_position_when_its_wheels_stop) {
  const zone::TrafficZone zone = test::graph("line", {{"only", {}, 2.0, 0.0, {}}}, {{"O", {0, 0.0}}, {"X", {0, 2.0}}});
  GraphFixture fixture{zone, "only", 1.0, -0.06};
  fixture.take(order("O-1").through({"O", "X"}));
  fixture.run(10.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("X"));
  EXPECT_NEAR(fixture.agent.vehicle().position().track_position().s_m, 2.0, 0.015);
}

TEST(AgentOnALoop, commands_the_first_branch_and_has_no_course) {
  Agent agent{test::lacet4()};
  agent.vehicle().estimator().position_at(at(test::lacet4(), "loop_se", 0.0));
  EXPECT_EQ(agent.decide().branch, 0);
  ASSERT_TRUE(agent.vehicle().take_order(order("O-1").through({"loop_se@0", "loop_se@283"})));
  EXPECT_EQ(agent.decide().branch, 0);
  EXPECT_TRUE(agent.vehicle().position().on_path_estimator().path().course().empty());
}

// --- bends on the spot ----------------------------------------------------------------------------------------------

/// One lap, from a corner.
wire::Order round() {
  auto text = order("O-1").through({"A", "B", "C", "D", "A"});
  text.edge(0).edge_id = "south";
  return text;
}

TEST(AgentAtABend, drives_round_a_square) {
  GraphFixture fixture{square(), "south", 0.0};
  fixture.take(round());
  fixture.run(60.0);
  EXPECT_EQ(fixture.turns, 3) << "the base ends before the fourth";
  EXPECT_THAT(fixture.traversed, ElementsAre("B", "C", "D", "A"));
  EXPECT_LT(fixture.pose_error_m, 0.005);
  EXPECT_LT(fixture.heading_error_rad(), 0.01);
  EXPECT_LT(distance(fixture.world.pose(), Pose2{0.0, 0.0, 0.0}), 0.015);
  EXPECT_LE(fixture.bend_speed_mps, bend_creep_mps + 0.005);
}

TEST(AgentAtABend, is_driving_while_it_turns_and_measures_its_turn) {
  GraphFixture fixture{square(), "south", 0.5};
  auto text = order("O-1").through({"A", "B", "C"});
  text.edge(0).edge_id = "south";
  fixture.take(text);
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.manoeuvring(); }, 10.0));
  double turned_rad = 0.0;
  while (fixture.world.manoeuvring()) {
    EXPECT_FALSE(fixture.agent.vehicle().motion().stopped());
    EXPECT_EQ(fixture.agent.vehicle().motion().speed_mps(), 0.0);
    EXPECT_LT(fixture.heading_error_rad(), 0.002);
    turned_rad = std::max(turned_rad, fixture.agent.vehicle().turn_rate_radps());
    fixture.step();
  }
  EXPECT_NEAR(turned_rad, 1.5, 0.1);
  EXPECT_EQ(fixture.agent.vehicle().position().track_position(), at(square(), "east", 0.0))
      << "the end of a turn is a certain position";
}

TEST(AgentAtABend, drives_straight_on_where_its_order_does) {
  GraphFixture fixture{square(), "south", 0.5};
  auto text = order("O-1").through({"A", "B", "S"});
  text.edge(0).edge_id = "south";
  text.edge(1).edge_id = "spur";
  fixture.take(text);
  fixture.run(15.0);
  EXPECT_EQ(fixture.turns, 0);
  EXPECT_EQ(fixture.section(), "spur");
}

TEST(AgentAtABend, is_rectified_by_the_turn) {
  for (const double estimated_ahead_m : {-0.08, 0.08}) {
    GraphFixture fixture{square(), "south", 0.5, estimated_ahead_m};
    auto text = order("O-1").through({"A", "B", "C"});
    text.edge(0).edge_id = "south";
    fixture.take(text);
    ASSERT_TRUE(fixture.run_until([&] { return fixture.turns == 1 && fixture.section() == "east"; }, 20.0));
    fixture.run(1.0);
    EXPECT_LT(distance(fixture.agent.vehicle().position().pose(), fixture.world.pose()), 0.01) << estimated_ahead_m;
    fixture.run(20.0);
    EXPECT_THAT(fixture.traversed, ElementsAre("B", "C"));
  }
}

TEST(AgentAtABend, that_is_paused_during_the_turn_continues_it_later) {
  GraphFixture fixture{square(), "south", 0.8};
  fixture.take(round());
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.pose().heading_rad > 0.5; }, 10.0));
  fixture.agent.vehicle().hold(Hold::paused, true);
  fixture.run(2.0);
  EXPECT_TRUE(fixture.agent.vehicle().motion().stopped());
  EXPECT_TRUE(fixture.world.manoeuvring());
  EXPECT_LT(fixture.heading_error_rad(), 0.002);
  fixture.agent.vehicle().hold(Hold::paused, false);
  ASSERT_TRUE(fixture.run_until([&] { return !fixture.world.manoeuvring(); }, 5.0));
  EXPECT_EQ(fixture.section(), "east");
}

TEST(AgentAtABend, that_loses_its_order_during_the_turn_accepts_another_from_there) {
  GraphFixture fixture{square(), "south", 0.8};
  fixture.take(round());
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.pose().heading_rad > 0.5; }, 10.0));
  ASSERT_TRUE(fixture.agent.vehicle().progress().begin_cancel());
  fixture.run(1.0);
  EXPECT_FALSE(fixture.agent.vehicle().progress().cancelling());
  EXPECT_FALSE(fixture.agent.vehicle().order().active());
  fixture.traversed.clear();
  fixture.take(order("O-2").through({"B", "C"}));
  fixture.run(15.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("C"));
}

TEST(AgentAtABend, does_not_sweep_over_an_adjacent_obstacle) {
  GraphFixture fixture{square(), "south", 0.5};
  auto text = order("O-1").through({"A", "B", "C"});
  text.edge(0).edge_id = "south";
  fixture.take(text);
  fixture.obstacles = {{1.135, -0.02}};  // beyond the corner, not on the path round it
  fixture.run(10.0);
  EXPECT_EQ(fixture.turns, 0);
  EXPECT_TRUE(fixture.agent.decision().blocked);
  fixture.obstacles.clear();
  fixture.run(15.0);
  EXPECT_EQ(fixture.turns, 1);
}

// --- off the path ---------------------------------------------------------------------------------------------------

/// On the diamond's floor, at a pose 0.14 m off the trunk and across it.
struct OffPathFixture : GraphFixture {
  OffPathFixture() : GraphFixture{diamond(), "trunk", 0.0} {
    const auto aslant = test::graph("aslant", {{"way", {0.5, 0.14, 1.0}, 1.0, 0.0, {}}}, {});
    world = LineWorld{aslant.circuit, {0, 0.0}};
    world.set_zone(diamond().circuit);
    agent.vehicle().estimator().set_off_path(world.pose());
  }
};

TEST(AgentOffPath, joins_the_path_when_it_has_base_and_not_before) {
  OffPathFixture fixture;
  ASSERT_TRUE(fixture.agent.vehicle().position().near_path());
  fixture.run(1.0);
  EXPECT_FALSE(fixture.drive.seek);
  EXPECT_FALSE(fixture.agent.vehicle().holds().has(Hold::line_lost)) << "the vehicle is known to be off-path";
  fixture.take(order("O-1").through({"T", "T1", "F", "ro"}));
  fixture.step();
  EXPECT_TRUE(fixture.drive.seek);
  EXPECT_LE(fixture.drive.speed_mmps, 150) << "slowly";
  fixture.run(25.0);
  EXPECT_TRUE(fixture.world.on_line());
  EXPECT_FALSE(fixture.drive.seek);
  EXPECT_LT(fixture.pose_error_m, 0.01);
  EXPECT_THAT(fixture.traversed, ElementsAre("T1", "F", "ro"));
}

TEST(AgentOffPath, waits_for_an_obstacle_between_vehicle_and_path) {
  OffPathFixture fixture;
  fixture.obstacles = {{0.559, 0.233}};  // 0.11 m before the body origin: a corner passes there during the turn
  fixture.run(0.5);
  fixture.take(order("O-1").through({"T", "T1"}));
  fixture.run(3.0);
  EXPECT_FALSE(fixture.world.manoeuvring());
  EXPECT_TRUE(fixture.agent.decision().blocked);
  fixture.obstacles.clear();
  fixture.run(15.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("T1"));
}

TEST(AgentOffPath, considers_only_obstacles_that_its_body_would_touch) {
  OffPathFixture fixture;
  fixture.obstacles = {{0.567, 0.245}};  // 0.125 m before the body origin, where no corner passes
  fixture.take(order("O-1").through({"T", "T1"}));
  fixture.run(15.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("T1"));
}

TEST(AgentOffPath, stops_during_the_manoeuvre_for_an_obstacle_detected_only_then) {
  OffPathFixture fixture;
  fixture.obstacles = {{0.5, -0.05}};  // across the path, which lies behind the vehicle at first
  fixture.take(order("O-1").through({"T", "T1"}));
  fixture.run(6.0);
  EXPECT_TRUE(fixture.world.manoeuvring());
  EXPECT_TRUE(fixture.agent.decision().blocked);
  const Pose2 is_stopped = fixture.world.pose();
  EXPECT_GT(is_stopped.y_m - 0.1, -0.05);
  fixture.run(2.0);
  EXPECT_EQ(fixture.world.pose(), is_stopped);
  fixture.obstacles.clear();
  fixture.run(15.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("T1"));
}

TEST(AgentOffPath, joins_the_path_at_a_commanded_pose_without_an_order) {
  OffPathFixture fixture;
  fixture.step();
  ASSERT_TRUE(fixture.agent.vehicle().join_line({0.7, 0.0, 0.0}));
  EXPECT_TRUE(fixture.agent.vehicle().joining());
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.on_line(); }, 10.0));
  fixture.run(0.5);
  EXPECT_FALSE(fixture.agent.vehicle().joining());
  EXPECT_NEAR(fixture.world.track_position().s_m, 0.7, 0.002);
  EXPECT_LT(fixture.pose_error_m, 0.01);
  EXPECT_EQ(fixture.drive.speed_mmps, 0) << "the vehicle waits there";
  fixture.take(order("O-1").through({"T", "T1"}));
  fixture.run(10.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("T1"));
}

TEST(AgentOffPath, joins_no_path_that_is_not_at_the_commanded_pose) {
  OffPathFixture fixture;
  const auto code = [&](const Pose2& X_MG) {
    const auto joins = fixture.agent.vehicle().join_line(X_MG);
    return joins ? std::string("none") : joins.error().code;
  };
  fixture.step();
  EXPECT_EQ(code({0.7, 0.05, 0.0}), "join.no_line");
  EXPECT_EQ(code({0.7, 0.0, 2.0}), "join.no_line") << "the path has another direction there";
  EXPECT_EQ(code({0.5, -0.6, 0.0}), "join.too_far");
  EXPECT_EQ(code({std::nan(""), 0.0, 0.0}), "join.too_far");
  EXPECT_FALSE(fixture.agent.vehicle().joining());
  EXPECT_EQ(code({0.6, 0.0, 0.0}), "none");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.manoeuvring(); }, 2.0));
  EXPECT_EQ(code({0.7, 0.0, 0.0}), "join.busy");
  fixture.run(10.0);
  EXPECT_NEAR(fixture.world.track_position().s_m, 0.6, 0.002);
  EXPECT_EQ(code({0.7, 0.0, 0.0}), "join.on_line");
}

TEST(AgentOffPath, stays_where_an_abandoned_manoeuvre_left_it) {
  OffPathFixture fixture;
  fixture.take(order("O-1").through({"T", "T1"}));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.pose().heading_rad < 0.5; }, 5.0));
  const Pose2 there = fixture.world.pose();
  wire::Odometry given_up = fixture.world.odometry();
  given_up.manoeuvre.reset();
  given_up.line_lost = true;
  fixture.agent.on_odometry(given_up);
  EXPECT_TRUE(fixture.agent.vehicle().position().near_path());
  EXPECT_LT(distance(fixture.agent.vehicle().position().pose(), there), 0.002);
  EXPECT_NEAR(fixture.agent.vehicle().position().pose().heading_rad, there.heading_rad, 0.002);
  EXPECT_TRUE(fixture.agent.vehicle().order().active()) << "its route still passes here";
}

TEST(AgentOffPath, completes_on_joinLine_a_manoeuvre_that_was_abandoned_with_its_order) {
  OffPathFixture fixture;
  fixture.take(order("O-1").through({"T", "T1"}));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.pose().heading_rad < 0.5; }, 5.0));
  ASSERT_TRUE(fixture.agent.vehicle().progress().begin_cancel());
  fixture.run(1.0);
  ASSERT_TRUE(fixture.world.manoeuvring());
  ASSERT_FALSE(fixture.agent.vehicle().order().active());
  const Pose2 there = fixture.world.pose();
  fixture.run(1.0);
  EXPECT_EQ(fixture.world.pose(), there);
  ASSERT_TRUE(fixture.agent.vehicle().join_line({0.7, 0.0, 0.0}));
  EXPECT_EQ(fixture.agent.vehicle().join_line({0.7, 0.0, 0.0}).error().code, "join.busy");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.on_line(); }, 10.0));
  fixture.run(0.5);
  EXPECT_FALSE(fixture.agent.vehicle().joining());
  EXPECT_FALSE(fixture.agent.vehicle().position().off_path());
  fixture.take(order("O-2").through({"T", "T1"}));
  fixture.run(10.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("T1"));
}

TEST(AgentOffPath, that_is_too_far_away_refuses_an_order_with_the_distance) {
  Agent agent{square()};
  agent.vehicle().estimator().set_off_path({0.5, 0.5, 0.0});
  EXPECT_FALSE(agent.vehicle().position().known());
  EXPECT_TRUE(agent.vehicle().position().pose_known());
  EXPECT_NEAR(agent.vehicle().position().off_path_estimator().off_by_m(), 0.5, 1e-9);
  const auto verdict = agent.vehicle().take_order(order("O-1").through({"A", "B"}));
  ASSERT_FALSE(verdict);
  EXPECT_EQ(verdict.error().code, "noRouteError");
  EXPECT_THAT(verdict.error().message, ::testing::HasSubstr("0.500000 m"));
  EXPECT_EQ(agent.decide().speed_mmps, 0);
}

}  // namespace
}  // namespace cosiva::aiv
