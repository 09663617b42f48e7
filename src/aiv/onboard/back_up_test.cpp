// backUp, an instant action of ours: a vehicle lets others out of a deadlock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_bench.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::OnboardBench;
using test::order;

/// Stands a little beyond the start of a section, so that backing up may lead over the joint.
struct BackUpBench : OnboardBench {
  BackUpBench() : BackUpBench{0.30} {}
  explicit BackUpBench(double s_m)
      : OnboardBench{{.start = OnboardOptions::Start{"loop_se", s_m}, .ground_truth = at(lacet4(), "loop_se", s_m)}} {
    run(0.5);
  }
  wire::ActionStatus back_up(const char* id, double distance_m, double for_s = 0.3) {
    act("backUp", id, {{"distance", distance_m}});
    run(for_s);
    return action(id)->status;
  }
  [[nodiscard]] double s_m() const { return world.place().s_m; }
};

TEST(BackUp, rolls_back_slowly_as_far_as_it_is_told_and_knows_where_it_is) {
  BackUpBench bench;
  EXPECT_EQ(bench.back_up("b1", 0.20), wire::ActionStatus::running);
  double fastest_mps = 0.0;
  for (int i = 0; i < 500; ++i) {
    bench.step();
    fastest_mps = std::max(fastest_mps, -bench.speed_mps);
  }
  EXPECT_EQ(bench.action("b1")->status, wire::ActionStatus::finished);
  EXPECT_NEAR(bench.s_m(), 0.10, 0.01);
  EXPECT_LE(fastest_mps, 0.10 + 1e-9);
  EXPECT_EQ(bench.speed_mps, 0.0);
  ASSERT_TRUE(bench.state().position);
  EXPECT_LT(distance(bench.state().position->pose, bench.world.pose()), 0.005);
}

TEST(BackUp, leads_over_a_joint) {
  BackUpBench bench{0.05};
  EXPECT_EQ(bench.back_up("b1", 0.20, 6.0), wire::ActionStatus::finished);
  EXPECT_NE(bench.world.place().section, at(lacet4(), "loop_se", 0.0).section);
  ASSERT_TRUE(bench.state().position);
  EXPECT_LT(distance(bench.state().position->pose, bench.world.pose()), 0.005);
}

TEST(BackUp, is_refused_with_an_order_and_when_it_makes_no_sense) {
  BackUpBench bench;
  EXPECT_EQ(bench.back_up("far", 0.6), wire::ActionStatus::failed);
  EXPECT_EQ(bench.back_up("forwards", -0.1), wire::ActionStatus::failed);
  bench.act("backUp", "nothing", {{"distance", std::string("a bit")}});
  bench.run(0.1);
  EXPECT_EQ(bench.action("nothing")->status, wire::ActionStatus::failed);
  EXPECT_EQ(bench.s_m(), 0.30);
  bench.order(order("O-1").through({"loop_se@283", "loop_se@565"}));
  bench.run(0.2);
  EXPECT_EQ(bench.back_up("order", 0.1), wire::ActionStatus::failed);
  EXPECT_GT(bench.s_m(), 0.30);
}

TEST(BackUp, is_ended_by_zero_by_an_order_and_by_another) {
  BackUpBench bench;
  EXPECT_EQ(bench.back_up("b1", 0.25, 1.0), wire::ActionStatus::running);
  EXPECT_EQ(bench.back_up("stop", 0.0), wire::ActionStatus::finished);
  EXPECT_EQ(bench.action("b1")->status, wire::ActionStatus::failed);
  const double stopped_m = bench.s_m();
  EXPECT_GT(stopped_m, 0.15);
  bench.run(2.0);
  EXPECT_EQ(bench.s_m(), stopped_m);
  EXPECT_EQ(bench.back_up("b2", 0.10, 0.5), wire::ActionStatus::running);
  bench.order(order("O-1").through({"loop_se@0", "loop_se@283"}));
  bench.run(8.0);
  EXPECT_EQ(bench.state().last_node_id, "loop_se@283");
}

TEST(BackUp, waits_while_it_is_paused_and_gives_up_in_the_end) {
  BackUpBench bench;
  EXPECT_EQ(bench.back_up("b1", 0.20), wire::ActionStatus::running);
  bench.act("startPause", "p1");
  bench.run(2.0);
  const double paused_m = bench.s_m();
  bench.run(1.0);
  EXPECT_EQ(bench.s_m(), paused_m);
  bench.run(15.0);
  EXPECT_EQ(bench.action("b1")->status, wire::ActionStatus::failed);
  bench.act("stopPause", "p2");
  bench.run(2.0);
  EXPECT_EQ(bench.s_m(), paused_m);
}

TEST(BackUp, stands_in_the_factsheet) {
  BackUpBench bench;
  bench.act("factsheetRequest", "f1");
  bench.run(0.2);
  ASSERT_FALSE(bench.factsheets.empty());
  EXPECT_TRUE(std::ranges::any_of(bench.factsheets.back().actions,
                                  [](const auto& action) { return action.type == "backUp" && action.instant; }));
}

}  // namespace
}  // namespace cosiva::aiv
