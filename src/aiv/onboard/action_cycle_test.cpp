#include "cosiva/aiv/onboard/action_cycle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/aiv/onboard/onboard_fixture.h"
#include "cosiva/aiv/testing/test_actions.h"

namespace cosiva::aiv {
namespace {

using test::act;
using test::hard;
using test::none;
using test::OnboardFixture;
using test::order;
using test::soft;
using test::text_of;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using wire::ActionStatus;

/// Five nodes of the loop in the south-east, 0.2827 m apart.
test::OrderText usual() {
  return order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"});
}

/// A vehicle that the test gives orders with actions.
struct OrderActionsOnBoard : ::testing::Test {
  OnboardFixture vehicle;

  OrderActionsOnBoard() { vehicle.run(0.7); }
  [[nodiscard]] ActionStatus status(std::string_view id) const {
    return vehicle.action(id).value_or(wire::ActionState{}).status;
  }
  bool reaches(std::string_view id, ActionStatus wanted, double seconds) {
    return vehicle.run_until([&] { return vehicle.action(id) && status(id) == wanted; }, seconds);
  }
  [[nodiscard]] double along_m() const { return vehicle.world.odometer_m; }
  /// The states that the vehicle reported while this action had this status.
  [[nodiscard]] std::vector<wire::State> states_during(std::string_view id, ActionStatus wanted) const {
    std::vector<wire::State> all;
    std::ranges::copy_if(vehicle.states, std::back_inserter(all), [&](const wire::State& state) {
      return std::ranges::any_of(state.action_states, [&](const wire::ActionState& each) {
        return each.action_id == id && each.status == wanted;
      });
    });
    return all;
  }
};

TEST_F(OrderActionsOnBoard, a_hard_pick_stops_the_vehicle_at_its_node_until_the_load_is_on_board) {
  test::OrderText text = usual();
  text.node(2).actions = {act("pick", "p", hard, {text_of("loadId", "L1"), text_of("loadType", "EPAL")})};
  vehicle.order(text);
  vehicle.run(0.1);
  EXPECT_EQ(status("p"), ActionStatus::waiting);
  EXPECT_EQ(vehicle.state().loads, (std::vector<wire::Load>{}));
  ASSERT_TRUE(reaches("p", ActionStatus::initializing, 8.0));
  EXPECT_EQ(vehicle.state().last_node_id, "loop_se@565");
  EXPECT_FALSE(vehicle.state().driving);
  const double stopped_m = along_m();
  EXPECT_NEAR(stopped_m, 0.565, 0.02);
  ASSERT_TRUE(reaches("p", ActionStatus::running, 1.1));
  vehicle.run(4.9);
  EXPECT_EQ(status("p"), ActionStatus::running);
  EXPECT_NEAR(along_m(), stopped_m, 0.001);
  ASSERT_TRUE(reaches("p", ActionStatus::finished, 0.3));
  EXPECT_EQ(vehicle.state().loads, (std::vector<wire::Load>{{"L1", "EPAL", "deck", {}}}));
  ASSERT_TRUE(vehicle.run_until([&] { return vehicle.state().node_states.empty(); }, 8.0));
  EXPECT_THAT(vehicle.error_types(), IsEmpty());
  EXPECT_THAT(vehicle.undecodable, IsEmpty());
}

TEST_F(OrderActionsOnBoard, a_none_action_runs_while_the_vehicle_drives_on) {
  test::OrderText text = usual();
  text.node(1).actions = {act("detectObject", "d", none)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("d", ActionStatus::running, 8.0));
  const double begins_m = along_m();
  ASSERT_TRUE(reaches("d", ActionStatus::finished, 1.2));
  EXPECT_GT(along_m(), begins_m + 0.2);
  for (const wire::State& state : states_during("d", ActionStatus::running)) EXPECT_TRUE(state.driving);
}

TEST_F(OrderActionsOnBoard, soft_actions_of_a_node_run_together_while_the_vehicle_is_stopped) {
  test::OrderText text = usual();
  text.node(1).actions = {act("pick", "1", soft), act("finePositioning", "2", soft)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("2", ActionStatus::running, 8.0));
  EXPECT_EQ(status("1"), ActionStatus::initializing);
  ASSERT_TRUE(reaches("1", ActionStatus::finished, 6.2));
  for (const auto wanted : {ActionStatus::initializing, ActionStatus::running})
    for (const wire::State& state : states_during("1", wanted)) EXPECT_FALSE(state.driving);
}

TEST_F(OrderActionsOnBoard, stop_the_vehicle_where_its_order_starts_before_it_drives_at_all) {
  test::OrderText text = usual();
  text.node(0).actions = {act("finePositioning", "first", hard)};
  text.edge(0).actions = {act("finePositioning", "edge", hard)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("first", ActionStatus::running, 0.1));
  ASSERT_TRUE(reaches("edge", ActionStatus::running, 2.1));
  EXPECT_LT(along_m(), 0.001);
  ASSERT_TRUE(reaches("edge", ActionStatus::finished, 2.1));
  ASSERT_TRUE(vehicle.run_until([&] { return vehicle.state().node_states.empty(); }, 8.0));
}

TEST_F(OrderActionsOnBoard, of_an_update_keep_a_vehicle_that_waits_at_the_end_of_its_base) {
  vehicle.order(order("O-1").through({"loop_se@0", "loop_se@283"}).then({"loop_se@565"}));
  ASSERT_TRUE(vehicle.run_until([&] { return vehicle.state().node_states.size() == 1; }, 8.0));
  vehicle.run(1.0);
  const double waits_m = along_m();
  test::OrderText update = order("O-1", 1).from_sequence(2).through({"loop_se@283", "loop_se@565"});
  update.edge(0).actions = {act("finePositioning", "edge", soft)};
  vehicle.order(update);
  ASSERT_TRUE(reaches("edge", ActionStatus::finished, 2.3));
  EXPECT_NEAR(along_m(), waits_m, 0.002);
  ASSERT_TRUE(vehicle.run_until([&] { return vehicle.state().node_states.empty(); }, 8.0));
}

TEST_F(OrderActionsOnBoard, par_6_6_2_a_new_order_is_refused_until_the_actions_of_the_last_node_have_ended) {
  test::OrderText text = order("O-1").through({"loop_se@0"});
  text.node(0).actions = {act("finePositioning", "1", none)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("1", ActionStatus::running, 0.2));
  EXPECT_THAT(vehicle.state().node_states, IsEmpty());
  vehicle.order(order("O-2").through({"loop_se@0", "loop_se@283"}));
  vehicle.run(0.1);
  EXPECT_THAT(vehicle.error_types(), ElementsAre("orderUpdateError"));
  EXPECT_EQ(vehicle.state().order_id, "O-1");
  ASSERT_TRUE(reaches("1", ActionStatus::finished, 2.1));
  vehicle.order(order("O-2").through({"loop_se@0", "loop_se@283"}));
  vehicle.run(0.1);
  EXPECT_EQ(vehicle.state().order_id, "O-2");
  EXPECT_THAT(vehicle.state().action_states, IsEmpty());
}

TEST_F(OrderActionsOnBoard, par_6_6_4_3_a_repeated_order_changes_nothing) {
  test::OrderText text = usual();
  text.node(0).actions = {act("finePositioning", "1", hard)};
  vehicle.order(text);
  vehicle.run(1.5);
  vehicle.order(text);
  ASSERT_TRUE(reaches("1", ActionStatus::finished, 0.7)) << "two seconds since it began";
  vehicle.order(text);
  vehicle.run(0.1);
  EXPECT_EQ(status("1"), ActionStatus::finished);
  EXPECT_THAT(vehicle.state().action_states, testing::SizeIs(1));
}

TEST_F(OrderActionsOnBoard, par_6_6_4_2_what_the_vehicle_cannot_perform_refuses_the_order_as_a_whole) {
  test::OrderText text = usual();
  text.edge(1).actions = {act("startCharging", "1", none)};
  vehicle.order(text);
  vehicle.run(0.5);
  EXPECT_THAT(vehicle.error_types(), ElementsAre("orderError"));
  EXPECT_EQ(vehicle.state().errors[0].description,
            "edges[1].actions: action 'startCharging' (1) is not supported on edges");
  EXPECT_THAT(vehicle.state().action_states, IsEmpty());
  EXPECT_LT(along_m(), 0.001);
}

TEST_F(OrderActionsOnBoard, par_6_8_2_start_pause_pauses_a_pick_and_stop_pause_resumes_it) {
  test::OrderText text = usual();
  text.node(0).actions = {act("pick", "1", hard)};
  vehicle.order(text);
  vehicle.run(2.0);
  EXPECT_EQ(status("1"), ActionStatus::running);
  vehicle.act("startPause", "stop");
  ASSERT_TRUE(reaches("1", ActionStatus::paused, 0.1));
  EXPECT_TRUE(vehicle.state().paused);
  vehicle.run(20.0);
  EXPECT_EQ(status("1"), ActionStatus::paused);
  vehicle.act("stopPause", "go");
  ASSERT_TRUE(reaches("1", ActionStatus::running, 0.1));
  ASSERT_TRUE(reaches("1", ActionStatus::finished, 4.1));
}

TEST_F(OrderActionsOnBoard, par_6_6_3_cancel_order_fails_actions_and_finishes_when_all_have_stopped) {
  test::OrderText text = usual();
  text.node(1).actions = {act("finePositioning", "runs", none)};
  text.node(3).actions = {act("pick", "waits", hard)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("runs", ActionStatus::running, 8.0));
  vehicle.act("cancelOrder", "cancel");
  ASSERT_TRUE(reaches("cancel", ActionStatus::finished, 2.0));
  EXPECT_EQ(status("runs"), ActionStatus::failed);
  EXPECT_EQ(status("waits"), ActionStatus::failed);
  EXPECT_EQ(vehicle.action("waits")->result_description, "the order was cancelled");
  EXPECT_THAT(vehicle.state().node_states, IsEmpty());
  EXPECT_EQ(vehicle.state().order_id, "O-1") << "orderId and orderUpdateId stay";
}

TEST_F(OrderActionsOnBoard, par_6_6_3_cancel_order_ends_an_order_of_which_only_actions_are_left) {
  test::OrderText text = order("O-1").through({"loop_se@0"});
  text.node(0).actions = {act("waitForTrigger", "1", hard)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("1", ActionStatus::running, 0.2));
  vehicle.act("cancelOrder", "cancel");
  ASSERT_TRUE(reaches("cancel", ActionStatus::finished, 0.2));
  EXPECT_EQ(status("1"), ActionStatus::failed);
  vehicle.act("cancelOrder", "again");
  vehicle.run(0.1);
  EXPECT_EQ(status("again"), ActionStatus::failed);
  EXPECT_THAT(vehicle.error_types(), ElementsAre("noOrderToCancel"));
}

TEST_F(OrderActionsOnBoard, par_6_8_2_a_failed_drop_is_an_error_that_names_action_and_node) {
  test::OrderText text = usual();
  text.node(1).actions = {act("drop", "d", hard)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("d", ActionStatus::failed, 10.0));
  EXPECT_EQ(vehicle.action("d")->result_description, "the vehicle carries no load");
  EXPECT_THAT(vehicle.state().errors,
              ElementsAre(wire::VehicleError{"orderActionError",
                                             wire::ErrorLevel::warning,
                                             "the vehicle carries no load",
                                             {{"actionId", "d"}, {"actionType", "drop"}, {"nodeId", "loop_se@283"}}}));
  EXPECT_TRUE(vehicle.run_until([&] { return vehicle.state().node_states.empty(); }, 8.0)) << "the order goes on";
}

TEST_F(OrderActionsOnBoard, start_charging_reports_charging_until_the_vehicle_drives_away) {
  test::OrderText text = usual();
  text.node(1).actions = {act("startCharging", "c", hard), act("waitForTrigger", "w", hard)};
  vehicle.order(text);
  ASSERT_TRUE(reaches("c", ActionStatus::finished, 10.0));
  EXPECT_TRUE(vehicle.state().battery.charging);
  vehicle.run(5.0);
  EXPECT_TRUE(vehicle.state().battery.charging);
  vehicle.act("trigger", "t");
  ASSERT_TRUE(reaches("w", ActionStatus::finished, 0.1));
  EXPECT_EQ(status("t"), ActionStatus::finished);
  const double charges_m = along_m();
  ASSERT_TRUE(vehicle.run_until([&] { return !vehicle.state().battery.charging; }, 2.0));
  EXPECT_NEAR(along_m() - charges_m, 0.05, 0.05);
}

TEST_F(OrderActionsOnBoard, charging_is_an_instant_action_of_a_stopped_vehicle) {
  vehicle.act("startCharging", "on");
  vehicle.run(0.1);
  EXPECT_EQ(status("on"), ActionStatus::finished);
  EXPECT_TRUE(vehicle.state().battery.charging);
  vehicle.act("stopCharging", "off");
  vehicle.run(0.1);
  EXPECT_FALSE(vehicle.state().battery.charging);
  vehicle.order(usual());
  vehicle.run(1.0);
  vehicle.act("startCharging", "late");
  vehicle.run(0.1);
  EXPECT_EQ(status("late"), ActionStatus::failed);
  EXPECT_EQ(vehicle.action("late")->result_description, "the vehicle drives");
}

TEST_F(OrderActionsOnBoard, a_trigger_for_which_no_action_waits_fails) {
  vehicle.act("trigger", "t");
  vehicle.run(0.1);
  EXPECT_EQ(vehicle.action("t")->result_description, "no action waits for this trigger");
}

TEST_F(OrderActionsOnBoard, loads_stay_on_board_when_the_program_restarts) {
  test::OrderText text = order("O-1").through({"loop_se@0"});
  text.node(0).actions = {act("pick", "1", hard, {text_of("loadId", "L1")})};
  vehicle.order(text);
  ASSERT_TRUE(reaches("1", ActionStatus::finished, 7.0));
  vehicle.run(0.1);
  EXPECT_THAT(vehicle.persisted, HasSubstr("L1"));
  OnboardFixture again{vehicle.reborn()};
  again.run(0.7);
  EXPECT_EQ(again.state().loads, (std::vector<wire::Load>{{"L1", "", "deck", {}}}));
}

TEST_F(OrderActionsOnBoard, are_declared_in_the_factsheet) {
  const wire::Factsheet& sheet = vehicle.factsheets.back();
  const auto pick = std::ranges::find(sheet.actions, "pick", &wire::Factsheet::SupportedAction::type);
  ASSERT_NE(pick, sheet.actions.end());
  EXPECT_EQ(std::tuple(pick->instant, pick->node, pick->edge), std::tuple(false, true, true));
  EXPECT_THAT(pick->blocking_types, ElementsAre(none, soft, hard));
  EXPECT_THAT(pick->optional_parameters, Contains(wire::Parameter{"loadId", std::string("STRING")}));
  EXPECT_THAT(sheet.load_positions, ElementsAre("deck"));
}

}  // namespace
}  // namespace cosiva::aiv
