#include "cosiva/aiv/order/order_actions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/testing/test_actions.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/base/archive.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::act;
using test::hard;
using test::none;
using test::order;
using test::OrderText;
using test::soft;
using test::text_of;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using wire::ActionStatus;

/// Actions of ten seconds without preparation; picks and drops of five seconds, prepared for one.
ActionCatalogue catalogue() {
  ActionCatalogue all = usual_actions();
  ActionType ten = action_named("polish");
  ten.duration = seconds{10};
  ten.on_edges = true;
  all.types.push_back(ten);
  all.load_positions = {"front", "back"};
  return all;
}

/// A vehicle that stops and drives as the test has it.
struct OrderActionsTest : ::testing::Test {
  OrderActions actions{catalogue()};
  SimTime now{virtual_epoch};
  bool stopped{true};
  bool paused{false};
  double travelled_m{10.0};

  OrderActionsTest() { pass(0.0); }
  void pass(double s) {
    // The last cycle begins what the cycles before have made possible.
    const auto cycles = static_cast<int>(std::lround(s / 0.02)) + 1;
    for (int i = 0; i < cycles; ++i) {
      actions.update({now, stopped, paused, travelled_m});
      now += milliseconds{20};
    }
  }
  [[nodiscard]] std::string status(std::string_view id) const {
    for (const wire::ActionState& state : actions.states()) {
      if (state.action_id != id) continue;
      constexpr std::array names{"waiting", "initializing", "running", "paused", "finished", "failed"};
      return names.at(static_cast<std::size_t>(state.status));
    }
    return "absent";
  }
  [[nodiscard]] std::vector<std::string> all(const std::vector<std::string>& ids) const {
    std::vector<std::string> texts;
    for (const std::string& id : ids) texts.push_back(status(id));
    return texts;
  }
  [[nodiscard]] std::string result(std::string_view id) const {
    for (const wire::ActionState& state : actions.states())
      if (state.action_id == id) return state.result_description;
    return "absent";
  }
};

OrderText usual() { return order("O-1").through({"a", "b", "c"}).then({"d"}); }

// --- §6.11 action states, §6.10.2 triggering ----------------------------------------------------------------------

TEST_F(OrderActionsTest, par_6_11_represents_each_action_as_waiting_from_the_acceptance_on_horizon_included) {
  OrderText text = usual();
  text.node(1).actions = {act("pick", "1", hard)};
  text.edge(1).actions = {act("noop", "2", none)};
  text.node(3).actions = {act("drop", "3", hard)};
  actions.on_new_order(text);
  EXPECT_TRUE(actions.take_changed());
  EXPECT_THAT(actions.states(), ElementsAre(wire::ActionState{"1", "pick", ActionStatus::waiting, ""},
                                            wire::ActionState{"2", "noop", ActionStatus::waiting, ""},
                                            wire::ActionState{"3", "drop", ActionStatus::waiting, ""}));
  pass(60.0);
  EXPECT_THAT(all({"1", "2", "3"}), ElementsAre("waiting", "waiting", "waiting")) << "no node was reached";
  EXPECT_TRUE(actions.left());
  EXPECT_FALSE(actions.keep_here());
}

TEST_F(OrderActionsTest, par_6_11_an_action_is_initializing_then_running_then_finished) {
  OrderText text = usual();
  text.node(1).actions = {act("pick", "1", hard, {text_of("loadId", "L7")})};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(0.0);
  EXPECT_EQ(status("1"), "initializing");
  pass(0.9);
  EXPECT_EQ(status("1"), "initializing") << "its preparation takes one second";
  pass(0.1);
  EXPECT_EQ(status("1"), "running");
  pass(4.8);
  EXPECT_EQ(status("1"), "running") << "it takes five seconds";
  EXPECT_THAT(actions.loads().loads(), IsEmpty());
  pass(0.2);
  EXPECT_EQ(status("1"), "finished");
  EXPECT_EQ(result("1"), "L7");
  EXPECT_FALSE(actions.left());
}

TEST_F(OrderActionsTest, par_6_10_2_the_first_node_counts_as_traversed_when_the_order_is_accepted) {
  OrderText text = usual();
  text.node(0).actions = {act("polish", "1", soft)};
  actions.on_new_order(text);
  pass(0.0);
  EXPECT_EQ(status("1"), "running");
}

TEST_F(OrderActionsTest, par_6_10_2_an_edge_s_action_runs_from_entering_the_edge_until_leaving_it) {
  OrderText text = usual();
  text.edge(1).actions = {act("polish", "1", none)};
  actions.on_new_order(text);
  stopped = false;
  pass(1.0);
  EXPECT_EQ(status("1"), "waiting") << "the vehicle drives on the edge before";
  actions.on_traversed(2);
  pass(0.0);
  EXPECT_EQ(status("1"), "running");
  pass(3.0);
  actions.on_traversed(4);
  EXPECT_EQ(status("1"), "finished") << "ten seconds have not passed, but the vehicle has left the edge";
}

TEST_F(OrderActionsTest, par_6_10_2_an_edge_is_entered_only_after_the_node_s_blocking_actions) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "n", soft), act("polish", "second", none)};
  text.edge(1).actions = {act("polish", "e", none)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(9.9);
  EXPECT_THAT(all({"n", "second", "e"}), ElementsAre("running", "running", "waiting"));
  pass(0.1);
  EXPECT_THAT(all({"n", "e"}), ElementsAre("finished", "running"));
}

TEST_F(OrderActionsTest, par_6_10_2_an_edge_that_is_not_released_is_not_entered) {
  OrderText text = usual();
  text.edge(2).actions = {act("polish", "old", none)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  actions.on_traversed(4);
  pass(1.0);
  EXPECT_EQ(status("old"), "waiting");
  OrderText update = order("O-1", 1).from_sequence(4).through({"c", "d"});
  update.edge(0).actions = {act("polish", "new", none)};
  actions.on_update(update);
  pass(0.0);
  EXPECT_THAT(all({"old", "new"}), ElementsAre("absent", "running"));
}

TEST_F(OrderActionsTest, fails_what_the_vehicle_cannot_complete_on_its_edge) {
  OrderText text = usual();
  text.edge(0).actions = {act("pick", "p", none), act("detectObject", "d", none), act("noop", "n", hard)};
  actions.on_new_order(text);
  stopped = false;
  pass(0.5);
  EXPECT_THAT(all({"p", "d", "n"}), ElementsAre("initializing", "running", "waiting"));
  actions.on_traversed(2);
  EXPECT_THAT(all({"p", "d", "n"}), ElementsAre("failed", "failed", "failed"));
  EXPECT_EQ(result("p"), "the edge was left before the action was done");
  EXPECT_EQ(result("n"), "the edge was left before the action began");
  const auto failures = actions.take_failures();
  ASSERT_THAT(failures, SizeIs(3));
  EXPECT_EQ(failures[0].node_or_edge_id, "a-b");
  EXPECT_TRUE(failures[0].on_edge);
  EXPECT_THAT(actions.take_failures(), IsEmpty()) << "each failure is reported once";
}

// --- §6.12 blocking types and sequence ----------------------------------------------------------------------------

TEST_F(OrderActionsTest, par_6_12_none_runs_with_other_actions_and_while_the_vehicle_drives) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "1", none), act("polish", "2", none)};
  actions.on_new_order(text);
  stopped = false;
  actions.on_traversed(2);
  pass(0.0);
  EXPECT_THAT(all({"1", "2"}), ElementsAre("running", "running"));
  EXPECT_FALSE(actions.holds_vehicle());
  EXPECT_FALSE(actions.keep_here());
  actions.on_traversed(4);
  pass(5.0);
  EXPECT_THAT(all({"1", "2"}), ElementsAre("running", "running")) << "actions of nodes run as long as they need";
}

TEST_F(OrderActionsTest, par_6_12_soft_runs_with_other_actions_but_only_while_the_vehicle_is_stopped) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "1", soft), act("polish", "2", none), act("polish", "3", soft)};
  actions.on_new_order(text);
  stopped = false;
  actions.on_traversed(2);
  pass(1.0);
  EXPECT_THAT(all({"1", "2", "3"}), ElementsAre("waiting", "waiting", "waiting")) << "the vehicle still moves";
  EXPECT_TRUE(actions.keep_here());
  EXPECT_FALSE(actions.holds_vehicle()) << "it may drive up to the node";
  stopped = true;
  pass(0.0);
  EXPECT_THAT(all({"1", "2", "3"}), ElementsAre("running", "running", "running"));
  EXPECT_TRUE(actions.holds_vehicle());
  pass(10.0);
  EXPECT_FALSE(actions.keep_here());
  EXPECT_FALSE(actions.holds_vehicle());
}

TEST_F(OrderActionsTest, par_6_12_hard_runs_alone_in_the_sequence_of_the_list) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "1", none), act("polish", "2", soft), act("polish", "3", hard),
                          act("polish", "4", hard), act("polish", "5", none)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  const std::vector<std::string> ids{"1", "2", "3", "4", "5"};
  pass(5.0);
  EXPECT_THAT(all(ids), ElementsAre("running", "running", "waiting", "waiting", "waiting"));
  pass(5.0);
  EXPECT_THAT(all(ids), ElementsAre("finished", "finished", "running", "waiting", "waiting"));
  pass(10.0);
  EXPECT_THAT(all(ids), ElementsAre("finished", "finished", "finished", "running", "waiting"));
  EXPECT_TRUE(actions.keep_here());
  pass(10.0);
  EXPECT_EQ(status("5"), "running");
  EXPECT_FALSE(actions.keep_here()) << "the last one is of type NONE: the vehicle drives on";
}

TEST_F(OrderActionsTest, par_6_12_hard_waits_for_a_none_action_of_an_earlier_node) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "early", none)};
  text.node(2).actions = {act("noop", "late", hard)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(4.0);
  actions.on_traversed(4);
  pass(5.0);
  EXPECT_THAT(all({"early", "late"}), ElementsAre("running", "waiting"));
  EXPECT_TRUE(actions.keep_here());
  pass(1.1);
  EXPECT_THAT(all({"early", "late"}), ElementsAre("finished", "finished"));
}

TEST_F(OrderActionsTest, par_6_12_a_blocking_action_of_an_edge_keeps_the_vehicle_at_its_start) {
  OrderText text = usual();
  text.edge(1).actions = {act("polish", "1", soft), act("polish", "2", soft)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  EXPECT_TRUE(actions.keep_here());
  pass(0.0);
  EXPECT_THAT(all({"1", "2"}), ElementsAre("running", "running"));
  EXPECT_TRUE(actions.holds_vehicle());
  pass(10.0);
  EXPECT_THAT(all({"1", "2"}), ElementsAre("finished", "finished"));
}

// --- pause, cancellation, updates ---------------------------------------------------------------------------------

TEST_F(OrderActionsTest, par_6_8_2_start_pause_pauses_actions_and_stop_pause_resumes_them_where_they_were) {
  OrderText text = usual();
  text.node(1).actions = {act("pick", "1", soft), act("detectObject", "2", soft), act("polish", "3", hard)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(0.5);
  paused = true;
  pass(0.0);
  EXPECT_THAT(all({"1", "2"}), ElementsAre("paused", "running")) << "detectObject has no entry under PAUSED";
  EXPECT_TRUE(actions.holds_vehicle());
  pass(60.0);
  EXPECT_THAT(all({"1", "2", "3"}), ElementsAre("paused", "finished", "waiting"));
  paused = false;
  pass(0.0);
  EXPECT_EQ(status("1"), "initializing");
  pass(0.5);
  EXPECT_EQ(status("1"), "running");
  paused = true;
  pass(1.0);
  EXPECT_EQ(status("1"), "paused");
  paused = false;
  pass(0.0);
  EXPECT_EQ(status("1"), "running");
}

TEST_F(OrderActionsTest, par_6_8_2_begins_nothing_during_a_pause) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "1", none)};
  actions.on_new_order(text);
  paused = true;
  actions.on_traversed(2);
  pass(5.0);
  EXPECT_EQ(status("1"), "waiting");
}

TEST_F(OrderActionsTest, par_6_6_3_cancel_order_fails_scheduled_and_running_actions_and_keeps_their_states) {
  OrderText text = usual();
  text.node(1).actions = {act("pick", "done", soft), act("polish", "runs", none)};
  text.node(2).actions = {act("drop", "waits", hard)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(7.0);
  actions.cancel("the order was cancelled");
  EXPECT_THAT(all({"done", "runs", "waits"}), ElementsAre("finished", "failed", "failed"));
  EXPECT_EQ(result("waits"), "the order was cancelled");
  EXPECT_FALSE(actions.left());
  EXPECT_THAT(actions.loads().loads(), SizeIs(1)) << "what was picked stays on board";
  EXPECT_THAT(actions.take_failures(), IsEmpty()) << "a cancelled action is no fault of the vehicle";
  actions.on_traversed(4);
  pass(10.0);
  EXPECT_EQ(status("waits"), "failed");
}

TEST_F(OrderActionsTest, par_6_6_2_an_update_adds_actions_and_leaves_those_of_the_base_and_the_stitching_node) {
  OrderText text = usual();
  text.node(1).actions = {act("polish", "1", none)};
  text.node(2).actions = {act("pick", "stitch", hard)};
  text.node(3).actions = {act("drop", "horizon", hard)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(1.0);
  OrderText update = order("O-1", 1).from_sequence(4).through({"c", "e"});
  update.node(0).actions = {act("drop", "changed", hard)};
  update.node(1).actions = {act("noop", "new", soft)};
  actions.on_update(update);
  EXPECT_THAT(all({"1", "stitch", "horizon", "changed", "new"}),
              ElementsAre("running", "waiting", "absent", "absent", "waiting"));
}

TEST_F(OrderActionsTest, par_6_10_6_a_new_order_removes_the_states_of_the_one_before) {
  OrderText text = usual();
  text.node(0).actions = {act("noop", "1", none)};
  actions.on_new_order(text);
  pass(0.1);
  EXPECT_EQ(status("1"), "finished") << "it stays until the next order";
  actions.on_new_order(order("O-2").through({"a"}));
  EXPECT_THAT(actions.states(), IsEmpty());
}

TEST_F(OrderActionsTest, lists_a_bounded_number_of_ended_states_of_an_order_that_is_extended_for_ever) {
  actions.on_new_order(order("O-1").through({"n"}));
  for (std::uint32_t i = 0; i < 400; ++i) {
    OrderText update = order("O-1", i + 1).from_sequence(2 * i).through({"n", "n"});
    update.node(1).actions = {act("noop", std::to_string(i), none)};
    actions.on_update(update);
    actions.on_traversed(2 * i + 2);
    pass(0.04);
  }
  EXPECT_THAT(actions.states(), SizeIs(OrderActions::shown_max));
  EXPECT_THAT(all({"0", "399"}), ElementsAre("absent", "finished"));
}

// --- effects ------------------------------------------------------------------------------------------------------

TEST_F(OrderActionsTest, par_6_8_2_pick_and_drop_change_the_loads_when_they_end) {
  OrderText text = usual();
  text.node(0).actions = {act("pick", "1", hard, {text_of("loadId", "L1"), text_of("loadType", "EPAL")}),
                          act("pick", "2", hard, {text_of("loadId", "L2"), text_of("lhd", "back")}),
                          act("drop", "3", hard, {text_of("loadId", "L1")})};
  actions.on_new_order(text);
  pass(12.1);
  EXPECT_THAT(actions.loads().loads(),
              ElementsAre(wire::Load{"L1", "EPAL", "front", {}}, wire::Load{"L2", "", "back", {}}));
  pass(6.1);
  EXPECT_THAT(actions.loads().loads(), ElementsAre(wire::Load{"L2", "", "back", {}}));
}

TEST_F(OrderActionsTest, par_6_8_2_pick_fails_with_an_error_where_the_vehicle_is_loaded_to_capacity) {
  OrderText text = usual();
  text.node(1).actions = {act("pick", "1", hard), act("pick", "2", hard), act("pick", "3", hard),
                          act("noop", "4", hard)};
  actions.on_new_order(text);
  actions.on_traversed(2);
  pass(20.0);
  EXPECT_THAT(all({"1", "2", "3", "4"}), ElementsAre("finished", "finished", "failed", "finished"));
  EXPECT_EQ(result("3"), "the vehicle is loaded to its capacity");
  const auto failures = actions.take_failures();
  ASSERT_THAT(failures, SizeIs(1));
  EXPECT_EQ(failures[0].action.action_id, "3");
  EXPECT_EQ(failures[0].node_or_edge_id, "b");
  EXPECT_FALSE(failures[0].on_edge);
}

TEST_F(OrderActionsTest, par_6_8_2_drop_fails_with_an_error_without_a_load) {
  OrderText text = usual();
  text.node(0).actions = {act("drop", "1", hard)};
  actions.on_new_order(text);
  pass(2.0);
  EXPECT_EQ(status("1"), "failed");
  EXPECT_EQ(result("1"), "the vehicle carries no load");
  EXPECT_THAT(actions.take_failures(), SizeIs(1));
}

TEST_F(OrderActionsTest, of_two_parallel_picks_onto_one_device_the_second_fails) {
  OrderText text = usual();
  text.node(0).actions = {act("pick", "1", soft, {text_of("lhd", "back")}),
                          act("pick", "2", soft, {text_of("lhd", "back")})};
  actions.on_new_order(text);
  pass(7.0);
  EXPECT_THAT(all({"1", "2"}), ElementsAre("finished", "failed"));
  EXPECT_THAT(actions.loads().loads(), SizeIs(1));
}

TEST_F(OrderActionsTest, par_6_8_1_start_charging_charges_until_stop_charging) {
  OrderText text = usual();
  text.node(0).actions = {act("startCharging", "1", hard)};
  text.node(1).actions = {act("stopCharging", "2", hard)};
  actions.on_new_order(text);
  pass(0.9);
  EXPECT_EQ(status("1"), "initializing");
  EXPECT_FALSE(actions.charging());
  pass(0.2);
  EXPECT_EQ(status("1"), "finished");
  EXPECT_TRUE(actions.charging());
  pass(100.0);
  EXPECT_TRUE(actions.charging());
  actions.on_traversed(2);
  pass(1.1);
  EXPECT_FALSE(actions.charging());
}

TEST_F(OrderActionsTest, charging_ends_when_the_vehicle_drives_away) {
  actions.set_charging(true);
  pass(0.0);
  EXPECT_TRUE(actions.charging());
  travelled_m = 10.049;
  pass(0.0);
  EXPECT_TRUE(actions.charging()) << "the last millimetres to the node";
  travelled_m = 10.051;
  pass(0.0);
  EXPECT_FALSE(actions.charging());
  actions.set_charging(true);
  pass(0.0);
  EXPECT_TRUE(actions.charging()) << "another charger";
}

TEST_F(OrderActionsTest, par_6_8_2_wait_for_trigger_runs_until_a_trigger_of_its_type) {
  OrderText text = usual();
  text.node(0).actions = {act("waitForTrigger", "1", soft, {text_of("triggerType", "button")})};
  actions.on_new_order(text);
  EXPECT_FALSE(actions.trigger("")) << "it does not run yet";
  pass(3600.0);
  EXPECT_EQ(status("1"), "running");
  EXPECT_FALSE(actions.trigger("loaded"));
  EXPECT_EQ(status("1"), "running");
  EXPECT_TRUE(actions.trigger("button"));
  EXPECT_EQ(status("1"), "finished");
  EXPECT_FALSE(actions.trigger("button"));
}

TEST_F(OrderActionsTest, par_6_8_2_detect_object_has_its_result_when_its_time_has_passed) {
  OrderText text = usual();
  text.node(0).actions = {act("detectObject", "1", none, {text_of("objectType", "EPAL")})};
  actions.on_new_order(text);
  pass(0.9);
  EXPECT_EQ(result("1"), "");
  pass(0.2);
  EXPECT_EQ(status("1"), "finished");
  EXPECT_EQ(result("1"), "EPAL");
}

TEST_F(OrderActionsTest, takes_the_same_time_whatever_the_cycle) {
  OrderText text = usual();
  text.node(0).actions = {act("pick", "1", hard)};
  actions.on_new_order(text);
  actions.update({now, true, false, 0.0});
  now += milliseconds{1300};
  actions.update({now, true, false, 0.0});
  EXPECT_EQ(status("1"), "running");
  now += milliseconds{4699};
  actions.update({now, true, false, 0.0});
  EXPECT_EQ(status("1"), "running");
  now += milliseconds{1};
  actions.update({now, true, false, 0.0});
  EXPECT_EQ(status("1"), "finished") << "six seconds in all";
}

TEST_F(OrderActionsTest, is_not_disturbed_by_a_clock_that_is_set_back) {
  OrderText text = usual();
  text.node(0).actions = {act("polish", "1", hard)};
  actions.on_new_order(text);
  pass(5.0);
  now -= std::chrono::hours{1};
  pass(4.9);
  EXPECT_EQ(status("1"), "running");
  pass(0.1);
  EXPECT_EQ(status("1"), "finished");
}

TEST_F(OrderActionsTest, continue_from_a_snapshot_as_from_the_original) {
  OrderText text = usual();
  text.node(0).actions = {act("pick", "1", hard, {text_of("loadId", "L1")}), act("polish", "2", soft)};
  actions.on_new_order(text);
  pass(6.5);
  std::string bytes;
  Archive out{bytes};
  actions.archive(out);
  OrderActions copy{catalogue()};
  Archive in{std::string_view{bytes}};
  copy.archive(in);
  ASSERT_FALSE(in.failed());
  EXPECT_EQ(copy.states(), actions.states());
  EXPECT_EQ(copy.loads().loads(), actions.loads().loads());
  for (int i = 0; i < 600; ++i) {
    now += milliseconds{20};
    actions.update({now, true, false, 0.0});
    copy.update({now, true, false, 0.0});
    ASSERT_EQ(copy.states(), actions.states()) << i;
  }
  EXPECT_EQ(status("2"), "finished");
}

// --- any order ----------------------------------------------------------------------------------------------------

/// An order of up to six nodes with up to three actions at each node and on each edge.
OrderText any_order() {
  OrderText text = order("O-1").through({"a", "b", "c", "d", "e", "f"});
  int next_id = 0;
  const auto some = [&next_id](const std::vector<std::string>& types) {
    std::vector<wire::Action> actions;
    for (int left = *rc::gen::inRange(0, 4); left > 0; --left)
      actions.push_back(act(*rc::gen::elementOf(types), std::to_string(next_id++),
                            *rc::gen::elementOf(std::vector{none, soft, hard})));
    return actions;
  };
  for (std::size_t i = 0; i < text.order().nodes.size(); ++i) {
    text.node(i).actions = some({"pick", "drop", "noop", "polish", "waitForTrigger", "startCharging", "detectObject"});
    if (i < text.order().edges.size()) text.edge(i).actions = some({"pick", "noop", "polish", "detectObject"});
  }
  return text;
}

/// Drives the order: stops at nodes where the actions keep the vehicle, three cycles after its arrival.
struct AnyDrive {
  OrderText text;
  OrderActions actions{catalogue()};
  SimTime now{virtual_epoch};
  std::size_t node{0};    ///< traversed last
  int edge_cycles{0};     ///< left on the edge behind it; 0: at the node
  int braking_cycles{0};  ///< left until the vehicle has stopped
  bool paused{false};

  [[nodiscard]] bool stopped() const { return edge_cycles == 0 && braking_cycles == 0; }
  void cycle() {
    if (braking_cycles > 0) --braking_cycles;
    if (edge_cycles > 0 && --edge_cycles == 0) {
      braking_cycles = 3;
      actions.on_traversed(text.node(++node).sequence_id);
    }
    actions.update({now, stopped(), paused, 0.0});
    now += milliseconds{20};
    check();
    if (edge_cycles == 0 && !actions.keep_here() && node + 1 < text.order().nodes.size())
      edge_cycles = *rc::gen::inRange(1, 200);
  }

 private:
  static bool performed(ActionStatus status) {
    return status == ActionStatus::initializing || status == ActionStatus::running || status == ActionStatus::paused;
  }
  void check() {
    const auto states = actions.states();
    std::size_t at = 0;
    int performs = 0;
    bool performs_hard = false;
    const auto check_list = [&](const std::vector<wire::Action>& list, bool here) {
      bool waits = false;
      for (const wire::Action& each : list) {
        const ActionStatus status = states.at(at++).status;
        if (waits) RC_ASSERT(status == ActionStatus::waiting || status == ActionStatus::failed);
        waits = waits || status == ActionStatus::waiting;
        if (!performed(status)) continue;
        ++performs;
        performs_hard = performs_hard || each.blocking_type == hard;
        RC_ASSERT(here);
        if (each.blocking_type != none) RC_ASSERT(stopped() && actions.holds_vehicle());
      }
    };
    for (std::size_t i = 0; i < text.order().nodes.size(); ++i) {
      check_list(text.node(i).actions, i <= node);
      if (i < text.order().edges.size()) check_list(text.edge(i).actions, i == node);
    }
    if (performs_hard) RC_ASSERT(performs == 1);
  }
};

TEST(OrderActionsOfAnyOrder, par_6_12_keep_their_sequence_and_their_blocking_types_and_end) {
  EXPECT_TRUE(rc::check([] {
    AnyDrive drive{any_order()};
    drive.actions.on_new_order(drive.text);
    for (int i = 0; i < 30'000 && (drive.actions.left() || drive.node < 5); ++i) {
      if (i % 250 == 0) {
        (void)drive.actions.trigger("");
        drive.paused = *rc::gen::weightedElement<bool>({{3, false}, {1, true}});
      }
      drive.cycle();
    }
    RC_ASSERT(drive.node == 5U);
    RC_ASSERT(!drive.actions.left());
  }));
}

}  // namespace
}  // namespace cosiva::aiv
