// move, an instant action of CoSiVA (A33): the vehicle drives a distance along its order, and stops there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_fixture.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::OnboardFixture;
using test::order;

/// On a straight part, with an order of some metres.
struct MoveFixture : OnboardFixture {
  MoveFixture()
      : OnboardFixture{{.start = OnboardOptions::Start{"loop_se", 0.0}, .ground_truth = at(lacet4(), "loop_se", 0.0)}} {
    run(0.5);
    // Before the first order the vehicle is stopped; the move begins with it.
    move("first", 0.10);
    OnboardFixture::order(
        test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"}));
  }
  void move(const char* id, double distance_m) { act("move", id, {{"distance", distance_m}}); }
  [[nodiscard]] wire::ActionStatus status(const char* id) { return action(id)->status; }
  [[nodiscard]] double s_m() const { return world.track_position().s_m; }
};

TEST(Move, drives_the_commanded_distance_and_stops_there_until_the_next_move) {
  MoveFixture fixture;
  fixture.run(3.0);
  EXPECT_EQ(fixture.status("first"), wire::ActionStatus::finished);
  EXPECT_NEAR(fixture.s_m(), 0.10, 0.005);
  fixture.run(3.0);
  EXPECT_NEAR(fixture.s_m(), 0.10, 0.005) << "stays, although its order leads further";
  fixture.move("second", 0.25);
  fixture.run(0.2);
  EXPECT_EQ(fixture.status("second"), wire::ActionStatus::running);
  fixture.run(3.0);
  EXPECT_EQ(fixture.status("second"), wire::ActionStatus::finished);
  EXPECT_NEAR(fixture.s_m(), 0.35, 0.01);
}

TEST(Move, yields_to_a_stop_and_ends_with_its_end) {
  MoveFixture fixture;
  fixture.run(3.0);
  fixture.move("second", 0.30);
  fixture.run(0.3);
  fixture.act("startPause", "stop");
  fixture.run(2.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_EQ(fixture.status("second"), wire::ActionStatus::running) << "not there yet";
  fixture.act("stopPause", "restart");
  fixture.run(8.0);
  EXPECT_EQ(fixture.status("second"), wire::ActionStatus::failed);
  EXPECT_NEAR(fixture.s_m(), 1.131, 0.03) << "drives on, to the end of its order";
}

TEST(Move, of_no_distance_ends_the_limit) {
  MoveFixture fixture;
  fixture.run(3.0);
  fixture.move("on", 0.0);
  fixture.run(8.0);
  EXPECT_EQ(fixture.status("on"), wire::ActionStatus::finished);
  EXPECT_NEAR(fixture.s_m(), 1.131, 0.03);
}

TEST(Move, is_refused_without_a_distance_or_beyond_ten_metres) {
  MoveFixture fixture;
  fixture.act("move", "nothing");
  fixture.move("backwards", -0.1);
  fixture.move("far", 10.1);
  fixture.run(0.1);
  for (const char* id : {"nothing", "backwards", "far"})
    EXPECT_EQ(fixture.status(id), wire::ActionStatus::failed) << id;
  fixture.run(3.0);
  EXPECT_EQ(fixture.status("first"), wire::ActionStatus::finished) << "the move before is still in force";
}

}  // namespace
}  // namespace cosiva::aiv
