// backUp, an instant action of CoSiVA: a vehicle lets others out of a deadlock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_fixture.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::OnboardFixture;
using test::order;

/// Is stopped a little beyond the start of a section, so that backing up may lead over the joint.
struct BackUpFixture : OnboardFixture {
  BackUpFixture() : BackUpFixture{0.30} {}
  explicit BackUpFixture(double s_m)
      : OnboardFixture{{.start = OnboardOptions::Start{"loop_se", s_m}, .ground_truth = at(lacet4(), "loop_se", s_m)}} {
    run(0.5);
  }
  wire::ActionStatus back_up(const char* id, double distance_m, double for_s = 0.3) {
    act("backUp", id, {{"distance", distance_m}});
    run(for_s);
    return action(id)->status;
  }
  [[nodiscard]] double s_m() const { return world.track_position().s_m; }
};

TEST(BackUp, moves_slowly_by_the_commanded_distance_and_updates_the_position) {
  BackUpFixture fixture;
  EXPECT_EQ(fixture.back_up("b1", 0.20), wire::ActionStatus::running);
  double fastest_mps = 0.0;
  for (int i = 0; i < 500; ++i) {
    fixture.step();
    fastest_mps = std::max(fastest_mps, -fixture.speed_mps);
  }
  EXPECT_EQ(fixture.action("b1")->status, wire::ActionStatus::finished);
  EXPECT_NEAR(fixture.s_m(), 0.10, 0.01);
  EXPECT_LE(fastest_mps, 0.10 + 1e-9);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  ASSERT_TRUE(fixture.state().position);
  EXPECT_LT(distance(fixture.state().position->pose, fixture.world.pose()), 0.005);
}

TEST(BackUp, leads_over_a_joint) {
  BackUpFixture fixture{0.05};
  EXPECT_EQ(fixture.back_up("b1", 0.20, 6.0), wire::ActionStatus::finished);
  EXPECT_NE(fixture.world.track_position().section, at(lacet4(), "loop_se", 0.0).section);
  ASSERT_TRUE(fixture.state().position);
  EXPECT_LT(distance(fixture.state().position->pose, fixture.world.pose()), 0.005);
}

TEST(BackUp, is_refused_with_an_order_and_with_invalid_parameters) {
  BackUpFixture fixture;
  EXPECT_EQ(fixture.back_up("far", 0.6), wire::ActionStatus::failed);
  EXPECT_EQ(fixture.back_up("forwards", -0.1), wire::ActionStatus::failed);
  fixture.act("backUp", "nothing", {{"distance", std::string("a bit")}});
  fixture.run(0.1);
  EXPECT_EQ(fixture.action("nothing")->status, wire::ActionStatus::failed);
  EXPECT_EQ(fixture.s_m(), 0.30);
  fixture.order(order("O-1").through({"loop_se@283", "loop_se@565"}));
  fixture.run(0.2);
  EXPECT_EQ(fixture.back_up("order", 0.1), wire::ActionStatus::failed);
  EXPECT_GT(fixture.s_m(), 0.30);
}

TEST(BackUp, is_ended_by_zero_by_an_order_and_by_another) {
  BackUpFixture fixture;
  EXPECT_EQ(fixture.back_up("b1", 0.25, 1.0), wire::ActionStatus::running);
  EXPECT_EQ(fixture.back_up("stop", 0.0), wire::ActionStatus::finished);
  EXPECT_EQ(fixture.action("b1")->status, wire::ActionStatus::failed);
  const double stopped_m = fixture.s_m();
  EXPECT_GT(stopped_m, 0.15);
  fixture.run(2.0);
  EXPECT_EQ(fixture.s_m(), stopped_m);
  EXPECT_EQ(fixture.back_up("b2", 0.10, 0.5), wire::ActionStatus::running);
  fixture.order(order("O-1").through({"loop_se@0", "loop_se@283"}));
  fixture.run(8.0);
  EXPECT_EQ(fixture.state().last_node_id, "loop_se@283");
}

TEST(BackUp, waits_during_a_pause_and_is_abandoned_in_the_end) {
  BackUpFixture fixture;
  EXPECT_EQ(fixture.back_up("b1", 0.20), wire::ActionStatus::running);
  fixture.act("startPause", "p1");
  fixture.run(2.0);
  const double paused_m = fixture.s_m();
  fixture.run(1.0);
  EXPECT_EQ(fixture.s_m(), paused_m);
  fixture.run(15.0);
  EXPECT_EQ(fixture.action("b1")->status, wire::ActionStatus::failed);
  fixture.act("stopPause", "p2");
  fixture.run(2.0);
  EXPECT_EQ(fixture.s_m(), paused_m);
}

TEST(BackUp, is_listed_in_the_factsheet) {
  BackUpFixture fixture;
  fixture.act("factsheetRequest", "f1");
  fixture.run(0.2);
  ASSERT_FALSE(fixture.factsheets.empty());
  EXPECT_TRUE(std::ranges::any_of(fixture.factsheets.back().actions,
                                  [](const auto& action) { return action.type == "backUp" && action.instant; }));
}

}  // namespace
}  // namespace cosiva::aiv
