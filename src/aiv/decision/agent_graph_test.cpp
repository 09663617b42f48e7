// The agent on graphs: forks, bends on the spot, and lines that it has yet to come onto.
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

struct GraphBench {
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

  GraphBench(const zone::TrafficZone& z, std::string_view section, double s_m, double estimated_ahead_m = 0.0)
      : zone{z}, world{z.circuit, at(z, section, s_m)} {
    agent.estimator().place_at(at(z, section, s_m + estimated_ahead_m));
    step();
  }
  GraphBench& take(const wire::Order& text) {
    const auto verdict = agent.take_order(text);
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
    if (++tick % 3 == 0) agent.on_ranges(test::ranges_to(obstacles, world.pose()));
    for (const auto& node : agent.progress().take_traversed()) traversed.push_back(node.node_id);
    if (agent.position().pose_known())
      pose_error_m = std::max(pose_error_m, distance(agent.position().pose(), world.pose()));
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50.0); ++i) step();
  }
  bool run_until(const std::function<bool()>& done, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50.0) && !done(); ++i) step();
    return done();
  }
  std::string section() const { return zone.circuit.part(world.place().section).name; }
  double heading_error_rad() const {
    return std::fabs(wrap_angle(agent.position().pose().heading_rad - world.pose().heading_rad));
  }
};

// --- forks ----------------------------------------------------------------------------------------------------------

TEST(AgentAtAFork, takes_the_way_of_its_order_whichever_it_is) {
  for (const auto& [node, over] : {std::pair{"ro", "r_over"}, std::pair{"lo", "l_over"}}) {
    GraphBench bench{diamond(), "trunk", 1.0};
    bench.take(order("O-1").through({"T1", "F", node}));
    bench.run(12.0);
    EXPECT_THAT(bench.traversed, ElementsAre("F", node));
    EXPECT_EQ(bench.zone.circuit.part(bench.agent.position().place().section).name.substr(0, 1),
              std::string(over).substr(0, 1));
    EXPECT_NEAR(distance(bench.world.pose(), bench.zone.circuit.pose_at(at(bench.zone, over, 0.0))), 0.0, 0.015);
    EXPECT_LT(bench.pose_error_m, 0.005);
  }
}

TEST(AgentAtAFork, says_the_branch_only_when_its_base_leads_over_it) {
  GraphBench bench{diamond(), "trunk", 1.0};
  EXPECT_EQ(bench.drive.branch, wire::no_branch);
  bench.take(order("O-1").through({"T1", "F"}).then({"ro"}));
  bench.run(8.0);
  EXPECT_EQ(bench.drive.branch, wire::no_branch);
  EXPECT_EQ(bench.section(), "trunk");
  EXPECT_NEAR(bench.world.place().s_m, 2.0, 0.015);
  EXPECT_TRUE(bench.agent.motion().stopped());
  bench.take(order("O-1", 1).from_sequence(2).through({"F", "ro"}));
  bench.step();
  EXPECT_EQ(bench.drive.branch, 1);
  bench.run(6.0);
  EXPECT_LT(distance(bench.world.pose(), bench.zone.circuit.pose_at(at(bench.zone, "r_over", 0.0))), 0.015);
}

TEST(AgentAtAFork, keeps_its_branch_until_its_body_is_over_it_too) {
  // It believes 6 cm more than is true: at the fork it is not there yet.
  GraphBench bench{diamond(), "trunk", 1.0, 0.06};
  bench.take(order("O-1").through({"T1", "F", "ro", "rd"}));
  bench.run(15.0);
  EXPECT_EQ(bench.section().substr(0, 1), "r");
}

TEST(AgentAtAFork, finds_that_it_is_there_when_its_wheels_stop) {
  // It believes 4 cm less than is true: PILS stops at the fork, and the base ends there.
  GraphBench bench{diamond(), "trunk", 1.0, -0.04};
  bench.take(order("O-1").through({"T1", "F"}));
  bench.run(10.0);
  EXPECT_THAT(bench.traversed, ElementsAre("F"));
  EXPECT_LT(distance(bench.agent.position().pose(), bench.world.pose()), 0.002);
}

TEST(AgentAtAFork, believes_a_little_more_than_it_has_driven_and_still_takes_an_order_along_the_other_way) {
  Agent agent{diamond()};
  agent.estimator().place_at(at(diamond(), "l_up", 0.005));
  const auto verdict = agent.take_order(order("O-1").through({"T1", "F", "ro"}));
  ASSERT_TRUE(verdict) << verdict.error().message;
  EXPECT_EQ(diamond().circuit.part(agent.position().place().section).name.substr(0, 1), "t");
  EXPECT_EQ(agent.decide().branch, 1);

  Agent beyond{diamond()};
  beyond.estimator().place_at(at(diamond(), "l_up", 0.3));
  EXPECT_FALSE(beyond.take_order(order("O-1").through({"T1", "F", "ro"})));
}

TEST(AgentOnTwoSections, of_the_same_line_takes_an_order_along_either) {
  for (const auto& [estimated, node, edge] : {std::tuple{"there", "tt", "there_too"}, {"there_too", "t", "there"}}) {
    Agent agent{test::there_and_back()};
    agent.estimator().place_at(at(test::there_and_back(), estimated, 0.2));
    auto text = order("O-1").through({"W", node});
    const auto verdict = agent.take_order(text);
    ASSERT_TRUE(verdict) << verdict.error().message;
    EXPECT_EQ(test::there_and_back().circuit.part(agent.position().place().section).name, edge);
    EXPECT_NEAR(agent.position().place().s_m, 0.2, 1e-9);
  }
}

TEST(AgentAtTheEnd, of_a_way_without_any_fork_finds_that_it_is_there_when_its_wheels_stop) {
  const zone::TrafficZone zone = test::graph("line", {{"only", {}, 2.0, 0.0, {}}}, {{"O", {0, 0.0}}, {"X", {0, 2.0}}});
  GraphBench bench{zone, "only", 1.0, -0.06};
  bench.take(order("O-1").through({"O", "X"}));
  bench.run(10.0);
  EXPECT_THAT(bench.traversed, ElementsAre("X"));
  EXPECT_NEAR(bench.agent.position().place().s_m, 2.0, 0.015);
}

TEST(AgentOnARing, says_the_first_branch_and_carries_no_course) {
  Agent agent{test::lacet4()};
  agent.estimator().place_at(at(test::lacet4(), "loop_se", 0.0));
  EXPECT_EQ(agent.decide().branch, 0);
  ASSERT_TRUE(agent.take_order(order("O-1").through({"loop_se@0", "loop_se@283"})));
  EXPECT_EQ(agent.decide().branch, 0);
  EXPECT_TRUE(agent.position().course().empty());
}

// --- bends on the spot ----------------------------------------------------------------------------------------------

/// Once round, from a corner.
wire::Order round() {
  auto text = order("O-1").through({"A", "B", "C", "D", "A"});
  text.edge(0).edge_id = "south";
  return text;
}

TEST(AgentAtABend, goes_round_a_square) {
  GraphBench bench{square(), "south", 0.0};
  bench.take(round());
  bench.run(60.0);
  EXPECT_EQ(bench.turns, 3) << "the base ends before the fourth";
  EXPECT_THAT(bench.traversed, ElementsAre("B", "C", "D", "A"));
  EXPECT_LT(bench.pose_error_m, 0.005);
  EXPECT_LT(bench.heading_error_rad(), 0.01);
  EXPECT_LT(distance(bench.world.pose(), Pose2{0.0, 0.0, 0.0}), 0.015);
  EXPECT_LE(bench.bend_speed_mps, bend_creep_mps + 0.005);
}

TEST(AgentAtABend, is_driving_while_it_turns_and_knows_how_far_it_has_turned) {
  GraphBench bench{square(), "south", 0.5};
  auto text = order("O-1").through({"A", "B", "C"});
  text.edge(0).edge_id = "south";
  bench.take(text);
  ASSERT_TRUE(bench.run_until([&] { return bench.world.manoeuvring(); }, 10.0));
  double turned_rad = 0.0;
  while (bench.world.manoeuvring()) {
    EXPECT_FALSE(bench.agent.motion().stopped());
    EXPECT_EQ(bench.agent.motion().speed_mps(), 0.0);
    EXPECT_LT(bench.heading_error_rad(), 0.002);
    turned_rad = std::max(turned_rad, bench.agent.turn_rate_radps());
    bench.step();
  }
  EXPECT_NEAR(turned_rad, 1.5, 0.1);
  EXPECT_EQ(bench.agent.position().place(), at(square(), "east", 0.0)) << "a turn's end is a sure place";
}

TEST(AgentAtABend, goes_straight_on_where_its_order_does) {
  GraphBench bench{square(), "south", 0.5};
  auto text = order("O-1").through({"A", "B", "S"});
  text.edge(0).edge_id = "south";
  text.edge(1).edge_id = "spur";
  bench.take(text);
  bench.run(15.0);
  EXPECT_EQ(bench.turns, 0);
  EXPECT_EQ(bench.section(), "spur");
}

TEST(AgentAtABend, is_put_right_by_it) {
  for (const double estimated_ahead_m : {-0.08, 0.08}) {
    GraphBench bench{square(), "south", 0.5, estimated_ahead_m};
    auto text = order("O-1").through({"A", "B", "C"});
    text.edge(0).edge_id = "south";
    bench.take(text);
    ASSERT_TRUE(bench.run_until([&] { return bench.turns == 1 && bench.section() == "east"; }, 20.0));
    bench.run(1.0);
    EXPECT_LT(distance(bench.agent.position().pose(), bench.world.pose()), 0.01) << estimated_ahead_m;
    bench.run(20.0);
    EXPECT_THAT(bench.traversed, ElementsAre("B", "C"));
  }
}

TEST(AgentAtABend, that_is_paused_in_it_goes_on_turning_later) {
  GraphBench bench{square(), "south", 0.8};
  bench.take(round());
  ASSERT_TRUE(bench.run_until([&] { return bench.world.pose().heading_rad > 0.5; }, 10.0));
  bench.agent.hold(Hold::paused, true);
  bench.run(2.0);
  EXPECT_TRUE(bench.agent.motion().stopped());
  EXPECT_TRUE(bench.world.manoeuvring());
  EXPECT_LT(bench.heading_error_rad(), 0.002);
  bench.agent.hold(Hold::paused, false);
  ASSERT_TRUE(bench.run_until([&] { return !bench.world.manoeuvring(); }, 5.0));
  EXPECT_EQ(bench.section(), "east");
}

TEST(AgentAtABend, that_loses_its_order_in_it_takes_another_from_there) {
  GraphBench bench{square(), "south", 0.8};
  bench.take(round());
  ASSERT_TRUE(bench.run_until([&] { return bench.world.pose().heading_rad > 0.5; }, 10.0));
  ASSERT_TRUE(bench.agent.progress().begin_cancel());
  bench.run(1.0);
  EXPECT_FALSE(bench.agent.progress().cancelling());
  EXPECT_FALSE(bench.agent.order().active());
  bench.traversed.clear();
  bench.take(order("O-2").through({"B", "C"}));
  bench.run(15.0);
  EXPECT_THAT(bench.traversed, ElementsAre("C"));
}

TEST(AgentAtABend, does_not_sweep_over_what_stands_beside_it) {
  GraphBench bench{square(), "south", 0.5};
  auto text = order("O-1").through({"A", "B", "C"});
  text.edge(0).edge_id = "south";
  bench.take(text);
  bench.obstacles = {{1.135, -0.02}};  // beyond the corner, not in the way round it
  bench.run(10.0);
  EXPECT_EQ(bench.turns, 0);
  EXPECT_TRUE(bench.agent.decision().blocked);
  bench.obstacles.clear();
  bench.run(15.0);
  EXPECT_EQ(bench.turns, 1);
}

// --- beside the line ------------------------------------------------------------------------------------------------

/// On the diamond's floor, at a pose 0.14 m beside the trunk and across it.
struct BesideBench : GraphBench {
  BesideBench() : GraphBench{diamond(), "trunk", 0.0} {
    const auto aslant = test::graph("aslant", {{"way", {0.5, 0.14, 1.0}, 1.0, 0.0, {}}}, {});
    world = LineWorld{aslant.circuit, {0, 0.0}};
    world.stand_on(diamond().circuit);
    agent.estimator().stand_off(world.pose());
  }
};

TEST(AgentBesideTheLine, goes_to_it_when_it_has_base_and_not_before) {
  BesideBench bench;
  ASSERT_TRUE(bench.agent.position().beside());
  bench.run(1.0);
  EXPECT_FALSE(bench.drive.seek);
  EXPECT_FALSE(bench.agent.holds().has(Hold::line_lost)) << "it is beside the line, and knows it";
  bench.take(order("O-1").through({"T", "T1", "F", "ro"}));
  bench.step();
  EXPECT_TRUE(bench.drive.seek);
  EXPECT_LE(bench.drive.speed_mmps, 150) << "slowly";
  bench.run(25.0);
  EXPECT_TRUE(bench.world.on_line());
  EXPECT_FALSE(bench.drive.seek);
  EXPECT_LT(bench.pose_error_m, 0.01);
  EXPECT_THAT(bench.traversed, ElementsAre("T1", "F", "ro"));
}

TEST(AgentBesideTheLine, waits_for_whatever_stands_between) {
  BesideBench bench;
  bench.obstacles = {{0.559, 0.233}};  // 0.11 m before its middle: a corner comes by as it turns
  bench.run(0.5);
  bench.take(order("O-1").through({"T", "T1"}));
  bench.run(3.0);
  EXPECT_FALSE(bench.world.manoeuvring());
  EXPECT_TRUE(bench.agent.decision().blocked);
  bench.obstacles.clear();
  bench.run(15.0);
  EXPECT_THAT(bench.traversed, ElementsAre("T1"));
}

TEST(AgentBesideTheLine, looks_only_at_what_its_body_would_touch) {
  BesideBench bench;
  bench.obstacles = {{0.567, 0.245}};  // 0.125 m before its middle, where no corner comes
  bench.take(order("O-1").through({"T", "T1"}));
  bench.run(15.0);
  EXPECT_THAT(bench.traversed, ElementsAre("T1"));
}

TEST(AgentBesideTheLine, stops_half_way_for_what_it_sees_only_then) {
  BesideBench bench;
  bench.obstacles = {{0.5, -0.05}};  // across the line, which lies behind it at first
  bench.take(order("O-1").through({"T", "T1"}));
  bench.run(6.0);
  EXPECT_TRUE(bench.world.manoeuvring());
  EXPECT_TRUE(bench.agent.decision().blocked);
  const Pose2 stands = bench.world.pose();
  EXPECT_GT(stands.y_m - 0.1, -0.05);
  bench.run(2.0);
  EXPECT_EQ(bench.world.pose(), stands);
  bench.obstacles.clear();
  bench.run(15.0);
  EXPECT_THAT(bench.traversed, ElementsAre("T1"));
}

TEST(AgentBesideTheLine, joins_it_where_it_is_told_to_without_an_order) {
  BesideBench bench;
  bench.step();
  ASSERT_TRUE(bench.agent.join_line({0.7, 0.0, 0.0}));
  EXPECT_TRUE(bench.agent.joining());
  ASSERT_TRUE(bench.run_until([&] { return bench.world.on_line(); }, 10.0));
  bench.run(0.5);
  EXPECT_FALSE(bench.agent.joining());
  EXPECT_NEAR(bench.world.place().s_m, 0.7, 0.002);
  EXPECT_LT(bench.pose_error_m, 0.01);
  EXPECT_EQ(bench.drive.speed_mmps, 0) << "and waits there";
  bench.take(order("O-1").through({"T", "T1"}));
  bench.run(10.0);
  EXPECT_THAT(bench.traversed, ElementsAre("T1"));
}

TEST(AgentBesideTheLine, joins_no_line_that_is_not_where_it_is_told) {
  BesideBench bench;
  const auto code = [&](const Pose2& X_MG) {
    const auto joins = bench.agent.join_line(X_MG);
    return joins ? std::string("none") : joins.error().code;
  };
  bench.step();
  EXPECT_EQ(code({0.7, 0.05, 0.0}), "join.no_line");
  EXPECT_EQ(code({0.7, 0.0, 2.0}), "join.no_line") << "the line leads another way there";
  EXPECT_EQ(code({0.5, -0.6, 0.0}), "join.too_far");
  EXPECT_EQ(code({std::nan(""), 0.0, 0.0}), "join.too_far");
  EXPECT_FALSE(bench.agent.joining());
  EXPECT_EQ(code({0.6, 0.0, 0.0}), "none");
  ASSERT_TRUE(bench.run_until([&] { return bench.world.manoeuvring(); }, 2.0));
  EXPECT_EQ(code({0.7, 0.0, 0.0}), "join.busy");
  bench.run(10.0);
  EXPECT_NEAR(bench.world.place().s_m, 0.6, 0.002);
  EXPECT_EQ(code({0.7, 0.0, 0.0}), "join.on_line");
}

TEST(AgentBesideTheLine, stands_where_a_manoeuvre_left_it_that_was_given_up) {
  BesideBench bench;
  bench.take(order("O-1").through({"T", "T1"}));
  ASSERT_TRUE(bench.run_until([&] { return bench.world.pose().heading_rad < 0.5; }, 5.0));
  const Pose2 there = bench.world.pose();
  wire::Odometry given_up = bench.world.odometry();
  given_up.manoeuvre.reset();
  given_up.line_lost = true;
  bench.agent.on_odometry(given_up);
  EXPECT_TRUE(bench.agent.position().beside());
  EXPECT_LT(distance(bench.agent.position().pose(), there), 0.002);
  EXPECT_NEAR(bench.agent.position().pose().heading_rad, there.heading_rad, 0.002);
  EXPECT_TRUE(bench.agent.order().active()) << "its way still comes by here";
}

TEST(AgentBesideTheLine, that_is_too_far_away_says_how_far_and_takes_no_order) {
  Agent agent{square()};
  agent.estimator().stand_off({0.5, 0.5, 0.0});
  EXPECT_TRUE(agent.position().away());
  EXPECT_TRUE(agent.position().pose_known());
  EXPECT_NEAR(agent.position().off_by_m(), 0.5, 1e-9);
  const auto verdict = agent.take_order(order("O-1").through({"A", "B"}));
  ASSERT_FALSE(verdict);
  EXPECT_EQ(verdict.error().code, "noRouteError");
  EXPECT_THAT(verdict.error().message, ::testing::HasSubstr("0.500000 m"));
  EXPECT_EQ(agent.decide().speed_mmps, 0);
}

}  // namespace
}  // namespace cosiva::aiv
