// What makes a vehicle stop and continue: instant actions, obstacles, and the loss of links.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_fixture.h"
#include "cosiva/aiv/onboard/supervision.h"
#include "cosiva/aiv/onboard/warnings.h"
#include "cosiva/aiv/order/instant_actions.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::at;
using test::lacet4;
using test::OnboardFixture;
using test::order;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using wire::ActionStatus;

constexpr double medium_mps = 0.4;  // of lacet4's medium profile

/// Drives along the loop in the south-east, at medium speed.
struct Driving : OnboardFixture {
  explicit Driving(bool with_server = false) {
    server_heartbeats = with_server;
    run(0.5);
    order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@2545"}));
    run(1.0);
    EXPECT_NEAR(speed_mps, medium_mps, 0.01);
  }
};

// --- instant actions ----------------------------------------------------------------------------------------------

TEST(InstantActions, pause_and_resume) {
  Driving fixture;
  fixture.act("startPause", "p1");
  EXPECT_EQ(fixture.action("p1")->status, ActionStatus::running);
  EXPECT_TRUE(fixture.state().paused);
  fixture.run(1.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_EQ(fixture.action("p1")->status, ActionStatus::finished);
  EXPECT_FALSE(fixture.state().driving);
  fixture.act("startPause", "p2");
  fixture.run(0.1);
  EXPECT_EQ(fixture.action("p2")->status, ActionStatus::finished) << "pausing twice is no fault";
  fixture.act("stopPause", "r1");
  fixture.run(1.0);
  EXPECT_EQ(fixture.action("r1")->status, ActionStatus::finished);
  EXPECT_FALSE(fixture.state().paused);
  EXPECT_NEAR(fixture.speed_mps, medium_mps, 0.01);
}

TEST(InstantActions, a_pause_commands_the_motors_at_once) {
  Driving fixture;
  const int drives = fixture.drives;
  ASSERT_GT(fixture.last_drive().speed_mmps, 0);
  fixture.act("startPause", "p");
  EXPECT_EQ(fixture.drives, drives + 1);
  EXPECT_EQ(fixture.last_drive().speed_mmps, 0);
}

TEST(InstantActions, a_resume_overtakes_a_pause_before_the_standstill) {
  Driving fixture;
  fixture.act("startPause", "p");
  fixture.act("stopPause", "r");
  fixture.run(0.1);
  EXPECT_EQ(fixture.action("p")->status, ActionStatus::failed);
  EXPECT_EQ(fixture.action("r")->status, ActionStatus::finished);
}

TEST(InstantActions, cancelOrder_finishes_when_the_vehicle_has_stopped) {
  Driving fixture;
  fixture.act("cancelOrder", "c");
  fixture.run(0.1);
  EXPECT_EQ(fixture.action("c")->status, ActionStatus::running);
  EXPECT_THAT(fixture.state().node_states, Not(IsEmpty()));
  fixture.run(1.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_EQ(fixture.action("c")->status, ActionStatus::finished);
  EXPECT_THAT(fixture.state().node_states, IsEmpty());
  EXPECT_THAT(fixture.state().edge_states, IsEmpty());
  EXPECT_EQ(fixture.state().order_id, "O-1") << "ids stay";
  fixture.order(test::order("O-2").through({"loop_se@283", "loop_se@565"}));
  fixture.run(0.1);
  EXPECT_EQ(fixture.state().order_id, "O-2");
}

TEST(InstantActions, cancelOrder_without_an_order_fails) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.act("cancelOrder", "c");
  fixture.run(0.1);
  EXPECT_EQ(fixture.action("c")->status, ActionStatus::failed);
  EXPECT_THAT(fixture.error_types(), ElementsAre("noOrderToCancel"));
}

TEST(InstantActions, set_a_speed_limit_and_lift_it) {
  Driving fixture;
  fixture.act("setSpeedLimit", "s1", {{"profile", std::string("slow")}});
  fixture.run(1.0);
  EXPECT_NEAR(fixture.speed_mps, 0.15, 1e-6);
  EXPECT_EQ(fixture.action("s1")->status, ActionStatus::finished);
  EXPECT_EQ(fixture.action("s1")->result_description, "slow");
  fixture.act("setSpeedLimit", "s2", {{"maxSpeed", 0.1}});
  fixture.run(1.0);
  EXPECT_NEAR(fixture.speed_mps, 0.1, 1e-6);
  fixture.act("setSpeedLimit", "s3", {{"profile", std::string("normal")}});
  fixture.run(1.5);
  EXPECT_NEAR(fixture.speed_mps, medium_mps, 1e-6);
  EXPECT_EQ(fixture.action("s3")->result_description, "normal");
}

TEST(InstantActions, that_are_invalid_fail_with_a_reason) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.act("setSpeedLimit", "a", {{"profile", std::string("warp")}});
  fixture.act("setSpeedLimit", "b", {{"profile", std::string("stop")}});
  fixture.act("setSpeedLimit", "c", {{"maxSpeed", -1.0}});
  fixture.act("setSpeedLimit", "d");
  fixture.act("pick", "e");
  fixture.run(0.1);
  for (const char* id : {"a", "b", "c", "d", "e"}) {
    ASSERT_TRUE(fixture.action(id)) << id;
    EXPECT_EQ(fixture.action(id)->status, ActionStatus::failed) << id;
    EXPECT_FALSE(fixture.action(id)->result_description.empty()) << id;
  }
  EXPECT_THAT(fixture.error_types(), Contains("instantActionError"));
}

TEST(InstantActions, that_are_repeated_are_not_performed_again) {
  Driving fixture;
  fixture.act("startPause", "p");
  fixture.run(0.5);
  fixture.act("stopPause", "r");
  fixture.run(0.1);
  fixture.act("startPause", "p");
  fixture.run(1.0);
  EXPECT_FALSE(fixture.state().paused);
  EXPECT_NEAR(fixture.speed_mps, medium_mps, 0.01);
}

TEST(InstantActions, are_removed_at_a_new_order_except_for_the_speed_limit_in_force) {
  OnboardFixture fixture;
  fixture.run(0.5);
  fixture.act("setSpeedLimit", "s1", {{"profile", std::string("fast")}});
  fixture.act("setSpeedLimit", "s2", {{"profile", std::string("slow")}});
  fixture.act("stateRequest", "q");
  fixture.run(0.1);
  EXPECT_THAT(fixture.state().action_states, SizeIs(3));
  fixture.order(test::order("O-1").through({"loop_se@0", "loop_se@283"}));
  fixture.run(0.1);
  ASSERT_THAT(fixture.state().action_states, SizeIs(1));
  EXPECT_EQ(fixture.state().action_states[0].action_id, "s2");
}

TEST(InstantActions, states_are_bounded_and_running_ones_stay) {
  InstantActionBook book;
  ASSERT_TRUE(book.begin({"cancelOrder", "running", "", wire::BlockingType::none, {}}));
  book.set("running", ActionStatus::running);
  for (int i = 0; i < 500; ++i) {
    const std::string id = "a" + std::to_string(i);
    ASSERT_TRUE(book.begin({"stateRequest", id, "", wire::BlockingType::none, {}}));
    book.set(id, ActionStatus::finished);
  }
  EXPECT_EQ(book.states().size(), InstantActionBook::shown_max);
  EXPECT_TRUE(book.running("cancelOrder"));
  EXPECT_FALSE(book.begin({"stateRequest", "a499", "", wire::BlockingType::none, {}}));
  book.set("of no action", ActionStatus::failed);
}

TEST(Warnings, do_not_pile_up) {
  Warnings warnings;
  for (int i = 0; i < 100; ++i) warnings.add("orderError", "the same");
  EXPECT_THAT(warnings.all(), SizeIs(1));
  for (int i = 0; i < 100; ++i) warnings.add("orderError", std::to_string(i));
  EXPECT_THAT(warnings.all(), SizeIs(Warnings::count_max));
  EXPECT_EQ(warnings.all().back().description, "99");
}

// --- obstacles ----------------------------------------------------------------------------------------------------

TEST(Obstacle, on_the_path_stops_the_vehicle_and_shows_in_its_state_until_it_is_removed) {
  Driving fixture;
  fixture.obstacles = {position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", 1.0)))};
  fixture.run(5.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_LT(fixture.ground_truth.track_position(lacet4().circuit).s_m, 0.8);
  EXPECT_TRUE(fixture.state().field_violation);
  fixture.obstacles.clear();
  fixture.run(1.5);
  EXPECT_FALSE(fixture.state().field_violation);
  EXPECT_GT(fixture.speed_mps, 0.25);
}

// --- loss of links ------------------------------------------------------------------------------------------------

TEST(Silence, of_the_broker_stops_the_vehicle_after_half_a_second) {
  Driving fixture{true};
  fixture.link(false);
  fixture.run(0.45);
  EXPECT_GT(fixture.speed_mps, 0.25);
  fixture.run(0.6);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  fixture.link(true);
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.25) << "the vehicle continues by itself";
}

TEST(Silence, of_a_known_server_stops_the_vehicle_until_it_is_back) {
  Driving fixture;
  fixture.server_heartbeats = true;
  fixture.run(0.5);
  fixture.server_heartbeats = false;
  fixture.run(0.4);
  EXPECT_GT(fixture.speed_mps, 0.25);
  fixture.run(0.8);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.error_types(), Contains("serverLost"));
  fixture.server_heartbeats = true;
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.25);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
}

TEST(Silence, of_a_server_that_never_published_a_heartbeat_has_no_effect) {
  Driving fixture;
  fixture.receive(wire::server_heartbeat_topic, "{}", true);  // a retained heartbeat does not count
  fixture.run(0.7);
  EXPECT_GT(fixture.speed_mps, 0.25);
}

TEST(Silence, of_a_server_whose_connection_broke_still_counts) {
  Driving fixture;
  fixture.server_heartbeats = true;
  fixture.run(0.5);
  fixture.server_heartbeats = false;
  fixture.receive(wire::server_connection_topic, R"({"connectionState":"CONNECTIONBROKEN"})", true);
  fixture.run(1.2);
  EXPECT_EQ(fixture.speed_mps, 0.0);
}

TEST(Silence, of_any_board_stops_the_vehicle_until_it_is_back) {
  for (const wire::Board board : wire::all_boards) {
    Driving fixture;
    fixture.silence(board);
    fixture.run(1.5);
    EXPECT_EQ(fixture.speed_mps, 0.0) << to_string(board);
    EXPECT_FALSE(fixture.state().driving) << to_string(board);
    EXPECT_THAT(fixture.error_types(), ElementsAre("boardLost")) << to_string(board);
    EXPECT_THAT(fixture.state().information.back().references,
                Contains(wire::Reference{std::string(to_string(board)), "lost"}));
    fixture.plug(board);
    fixture.run(1.5);
    EXPECT_GT(fixture.speed_mps, 0.25) << to_string(board);
    EXPECT_THAT(fixture.error_types(), IsEmpty()) << to_string(board);
  }
}

TEST(Silence, of_a_cable_pulled_out_counts_at_once) {
  Driving fixture;
  fixture.silence(wire::Board::DOBS);
  fixture.feed(wire::InputKind::port, "1/DOBS", "down");
  fixture.run(0.05);
  EXPECT_THAT(fixture.error_types(), ElementsAre("boardLost"));
}

TEST(Fault, of_wheels_or_obstacle_sensor_stops_the_vehicle_but_not_of_the_power_gauge) {
  Driving fixture;
  fixture.self_test[wire::Board::RALI] = 3;
  fixture.run(0.5);
  EXPECT_GT(fixture.speed_mps, 0.25);
  EXPECT_THAT(fixture.error_types(), ElementsAre("boardFaulty"));
  fixture.self_test[wire::Board::DOBS] = 1;
  fixture.run(1.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.state().information.back().references, Contains(wire::Reference{"DOBS", "faulty"}));
}

TEST(Boards, that_have_not_identified_themselves_receive_a_request) {
  OnboardFixture fixture{{.boards_up = false}};
  fixture.feed(wire::InputKind::port, "1/PILS", "up");
  fixture.run(0.25);
  EXPECT_GE(fixture.requests, 2);
  fixture.plug(wire::Board::PILS);
  const int requests = fixture.requests;
  fixture.run(0.5);
  EXPECT_EQ(fixture.requests, requests);
}

TEST(Boards, are_driven_at_least_every_100_ms) {
  OnboardFixture fixture;
  const int before = fixture.drives;
  fixture.run(1.0);
  EXPECT_GE(fixture.drives - before, 49);
}

TEST(Boards, that_restart_do_not_change_the_position) {
  Driving fixture;
  fixture.act("startPause", "p");
  fixture.run(1.0);
  const auto before = *fixture.core->estimated_pose();
  fixture.send_from_board(wire::Board::PILS, wire::Hello{wire::Board::PILS, 1, 0, 1234});
  fixture.send_from_board(wire::Board::PILS, wire::Odometry{});
  EXPECT_EQ(*fixture.core->estimated_pose(), before);
}

// --- supervision alone --------------------------------------------------------------------------------------------

TEST(Supervision, reports_every_link_but_the_server_as_lost_at_first) {
  const Supervision supervision{milliseconds{500}};
  const SimTime now = virtual_epoch;
  EXPECT_TRUE(supervision.broker_lost(now));
  EXPECT_TRUE(supervision.any_board_lost(now));
  EXPECT_FALSE(supervision.server_lost(now));
}

TEST(Supervision, counts_from_the_last_message) {
  Supervision supervision{milliseconds{500}};
  const SimTime now = virtual_epoch;
  supervision.on_broker_message(now);
  EXPECT_FALSE(supervision.broker_lost(now + milliseconds{500}));
  EXPECT_TRUE(supervision.broker_lost(now + milliseconds{501}));
  supervision.on_board_message(now, wire::Board::RALI);
  EXPECT_FALSE(supervision.board_lost(now + milliseconds{500}, wire::Board::RALI));
  EXPECT_TRUE(supervision.board_lost(now + milliseconds{501}, wire::Board::RALI));
}

}  // namespace
}  // namespace cosiva::aiv
