#include "cosiva/aiv/onboard/action_executor.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "cosiva/aiv/onboard/factsheet.h"
#include "cosiva/aiv/onboard/test_instructions.h"
#include "cosiva/aiv/testing/test_orders.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;
using wire::ActionStatus;

using testing::HasSubstr;

struct ActionExecutorTest : test::InstructionTest {
  ActionExecutorTest() { server_proxy.set_online(true); }
  [[nodiscard]] const std::string& last_result() const { return actions.book().states().back().result_description; }
  [[nodiscard]] const wire::ActionState& state_of(std::string_view id) const {
    return *std::ranges::find(actions.book().states(), id, &wire::ActionState::action_id);
  }
  /// The action fails for this reason, and a warning to the server names the action.
  void expect_failure(std::string_view type, std::vector<wire::Parameter> parameters, const std::string& why) {
    const std::string id = "failure " + std::to_string(++failures);
    act(type, id, &context, std::move(parameters));
    EXPECT_EQ(last_status(), ActionStatus::failed) << why;
    EXPECT_EQ(last_result(), why);
    ASSERT_FALSE(reporter.warnings().all().empty()) << why;
    EXPECT_EQ(reporter.warnings().all().back(),
              (wire::VehicleError{"instantActionError",
                                  wire::ErrorLevel::warning,
                                  why,
                                  {{"actionId", id}, {"actionType", std::string(type)}}}));
  }
  /// Whether a state would be published now although none is due.
  bool report_requested() {
    effects.clear();
    const SimTime now{std::chrono::milliseconds{60 * ++reports}};
    const ReportSources sources{now,           &context.agent(), maps,           zones.refusal(),
                                boards,        supervision,      actions.book(), reporter.warnings(),
                                boards.power()};
    reporter.publish_state(sources, false, server_proxy, effects);
    return !effects.empty();
  }

  std::vector<wire::MapInfo> maps{{"lacet4", "1", "", true}};
  int failures{0};
  int reports{0};
};

TEST_F(ActionExecutorTest, performs_what_arrives_before_a_zone_is_known_in_the_same_order_once_it_is) {
  act(action::state_request, "a", nullptr);
  EXPECT_EQ(last_status(), ActionStatus::finished) << "it needs no zone";
  act("fly", "b", nullptr);
  EXPECT_EQ(last_status(), ActionStatus::failed) << "no zone would help";
  act(action::start_pause, "c", nullptr);
  EXPECT_EQ(last_status(), ActionStatus::waiting);
  act(action::set_speed_limit, "d", nullptr, {{"profile", std::string("slow")}});
  act(action::stop_pause, "e", nullptr);
  act(action::stop_pause, "e", nullptr);
  context.vehicle().hold(Hold::paused, true);  // restored from before the restart of the program
  actions.on_first_zone(SimTime{}, context, effects);
  EXPECT_FALSE(context.vehicle().holds().has(Hold::paused)) << "restarted last";
  EXPECT_EQ(context.agent().instructions().imposed, Profile::slow);
  for (const char* id : {"c", "d", "e"}) EXPECT_EQ(state_of(id).status, ActionStatus::finished) << id;
  act(action::start_pause, "f", &context);
  actions.on_first_zone(SimTime{}, context, effects);
  EXPECT_TRUE(context.vehicle().holds().has(Hold::paused)) << "nothing is performed twice";
}

TEST_F(ActionExecutorTest, has_a_limited_number_of_actions_wait_for_a_zone) {
  for (std::size_t i = 0; i < InstantActionBook::shown_max; ++i) {
    act(action::start_pause, "p" + std::to_string(i), nullptr);
    EXPECT_EQ(last_status(), ActionStatus::waiting) << i;
  }
  act(action::stop_pause, "one too many", nullptr);
  EXPECT_EQ(last_status(), ActionStatus::failed);
  EXPECT_EQ(last_result(), "no zone is known yet, and too many actions wait for one");
}

TEST_F(ActionExecutorTest, performs_each_instant_type_of_the_factsheet) {
  for (const auto& supported : make_factsheet(lacet4(), {}, usual_actions()).actions) {
    if (!supported.instant) continue;
    effects.clear();
    act(supported.type, "of " + supported.type, &context);
    const std::string& result = actions.book().states().back().result_description;
    EXPECT_EQ(result.find("not supported"), std::string::npos) << supported.type;
  }
}

TEST_F(ActionExecutorTest, fails_unsupported_actions_with_a_warning) {
  act("fly", "a", &context);
  EXPECT_EQ(last_status(), ActionStatus::failed);
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].type, "instantActionError");
}

TEST_F(ActionExecutorTest, finishes_a_pause_of_a_vehicle_that_is_stopped_at_once) {
  act(action::start_pause, "a", &context);
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_TRUE(context.vehicle().holds().has(Hold::paused));
  act(action::stop_pause, "b", &context);
  EXPECT_FALSE(context.vehicle().holds().has(Hold::paused));
}

TEST_F(ActionExecutorTest, stays_stopped_when_a_restart_arrives_that_was_sent_before_the_stop) {
  using std::chrono::milliseconds;
  const SimTime stop{std::chrono::hours{1}};
  const auto paused_after_restart = [&](SimTime sent) {
    const std::string id = std::to_string(sent.time_since_epoch().count());
    act(action::start_pause, "stop before " + id, &context, {}, stop);
    act(action::stop_pause, "restart at " + id, &context, {}, sent);
    return context.vehicle().holds().has(Hold::paused);
  };
  EXPECT_TRUE(paused_after_restart(stop - milliseconds{1}));
  EXPECT_EQ(last_status(), ActionStatus::failed);
  EXPECT_EQ(last_result(), "stopPause was sent before the last startPause; repeat it where that is safe");
  EXPECT_TRUE(paused_after_restart(stop - ActionExecutor::delay_max));
  // Not delayed: the sender's clock has stepped back.
  EXPECT_FALSE(paused_after_restart(stop - ActionExecutor::delay_max - milliseconds{1}));
  EXPECT_FALSE(paused_after_restart(stop));
}

TEST_F(ActionExecutorTest, compares_a_restart_with_the_latest_stop_whatever_the_order_of_the_stops) {
  const SimTime late{std::chrono::hours{1}};
  const SimTime early = late - std::chrono::seconds{2};
  act(action::start_pause, "the later one", &context, {}, late);
  act(action::start_pause, "the earlier one", &context, {}, early);
  act(action::stop_pause, "between both", &context, {}, early + std::chrono::seconds{1});
  EXPECT_TRUE(context.vehicle().holds().has(Hold::paused));
}

TEST_F(ActionExecutorTest, performs_no_action_twice) {
  act(action::start_pause, "a", &context);
  act(action::stop_pause, "b", &context);
  act(action::start_pause, "a", &context);
  EXPECT_FALSE(context.vehicle().holds().has(Hold::paused));
  EXPECT_EQ(actions.book().states().size(), 2U);
}

TEST_F(ActionExecutorTest, refuses_a_message_that_it_cannot_read_or_that_is_for_another_vehicle) {
  actions.on_message(SimTime{}, "{", &context, effects);
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].type, "validationError");
  EXPECT_EQ(reporter.warnings().all()[0].references, (std::vector<wire::Reference>{{"topic", "instantActions"}}));

  wire::InstantActions other{header(), {{"startPause", "p", "", wire::BlockingType::none, {}}}};
  other.header.header_id = 9;
  other.header.serial_number = "AIV2";
  actions.on_message(SimTime{}, wire::vda5050::encode(other), &context, effects);
  ASSERT_EQ(reporter.warnings().all().size(), 2U);
  EXPECT_EQ(reporter.warnings().all()[1].type, "validationError");
  EXPECT_EQ(reporter.warnings().all()[1].references,
            (std::vector<wire::Reference>{{"topic", "instantActions"}, {"headerId", "9"}}));
  EXPECT_TRUE(actions.book().states().empty());
  EXPECT_FALSE(context.vehicle().holds().has(Hold::paused));
}

TEST_F(ActionExecutorTest, performs_all_actions_of_a_message) {
  const wire::InstantActions both{
      header(),
      {{"startPause", "p", "", wire::BlockingType::none, {}}, {"stateRequest", "q", "", wire::BlockingType::none, {}}}};
  actions.on_message(SimTime{}, wire::vda5050::encode(both), &context, effects);
  EXPECT_EQ(state_of("p").status, ActionStatus::finished);
  EXPECT_EQ(state_of("q").status, ActionStatus::finished);
}

TEST_F(ActionExecutorTest, requests_a_report_for_each_action_even_a_repeated_one) {
  EXPECT_TRUE(report_requested()) << "the first state";
  EXPECT_FALSE(report_requested());
  act(action::state_request, "q", &context);
  EXPECT_TRUE(report_requested());
  act(action::state_request, "q", &context);
  EXPECT_TRUE(report_requested());
}

TEST_F(ActionExecutorTest, gives_the_reason_for_which_an_action_fails) {
  expect_failure("fly", {}, "action 'fly' is not supported");
  expect_failure(action::set_speed_limit, {}, "setSpeedLimit needs profile or maxSpeed");
  expect_failure(action::set_speed_limit, {{"profile", std::string("warp")}},
                 "profile 'warp', expected slow, medium, fast or normal");
  expect_failure(action::set_speed_limit, {{"profile", std::string("stop")}},
                 "profile 'stop', expected slow, medium, fast or normal");
  expect_failure(action::set_speed_limit, {{"maxSpeed", 0.0}}, "maxSpeed is a positive number of m/s");
  expect_failure(action::set_speed_limit, {{"maxSpeed", -0.1}}, "maxSpeed is a positive number of m/s");
  expect_failure(action::back_up, {}, "backUp needs the number distance");
  expect_failure(action::enable_map, {}, "enableMap needs a mapId");
  expect_failure(action::enable_map, {{"mapId", std::string()}}, "enableMap needs a mapId");
  expect_failure(action::download_map, {}, "downloadMap needs a mapId");
  expect_failure(action::enable_map, {{"mapId", std::string("moon")}},
                 "map 'moon' is not available; maps arrive with a message on cosiva/v1/zone/");
  expect_failure(action::join_line, {{"x", 0.0}, {"y", 0.0}, {"theta", 0.0}}, "the vehicle is not off-path");
}

TEST_F(ActionExecutorTest, reports_that_there_is_no_order_to_cancel_by_the_standard_s_error) {
  act(action::cancel_order, "c", &context);
  EXPECT_EQ(last_status(), ActionStatus::failed);
  EXPECT_EQ(reporter.warnings().all().back().type, "noOrderToCancel");
}

TEST_F(ActionExecutorTest, needs_all_three_numbers_of_a_pose) {
  for (const std::string missing : {"x", "y", "theta"}) {
    for (const std::string_view type : {action::init_position, action::join_line}) {
      std::vector<wire::Parameter> parameters{{"x", -0.5}, {"y", -0.15}, {"theta", 0.0}};
      std::erase_if(parameters, [&](const wire::Parameter& parameter) { return parameter.key == missing; });
      expect_failure(type, parameters, std::string(type) + " needs the numbers x, y and theta");
    }
  }
}

TEST_F(ActionExecutorTest, takes_the_position_that_the_operator_gives) {
  const std::vector<wire::Parameter> pose{{"x", -0.5}, {"y", -0.15}, {"theta", 0.0}};
  const auto with_map = [&](const std::string& map_id) {
    std::vector<wire::Parameter> parameters = pose;
    parameters.push_back({"mapId", map_id});
    return parameters;
  };
  expect_failure(action::init_position, with_map("attic"), "map 'attic' is not 'lacet4'");
  act(action::init_position, "any map", &context, with_map(""));
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_NEAR(context.vehicle().position().pose().x_m, -0.5, 1e-9);
  EXPECT_EQ(context.vehicle().order().last_node().node_id, "");
  auto parameters = with_map("lacet4");
  parameters.push_back({"lastNodeId", std::string("east@190")});
  act(action::init_position, "this map", &context, parameters);
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_EQ(context.vehicle().order().last_node().node_id, "east@190");
  act(action::init_position, "off the circuit", &context, {{"x", 9.0}, {"y", 9.0}, {"theta", 0.0}});
  EXPECT_THAT(last_result(), HasSubstr("no path of 'lacet4' passes within 0.25 m"));
}

TEST_F(ActionExecutorTest, imposes_a_profile_or_a_speed_and_lifts_both) {
  const auto& instructions = context.agent().instructions();
  act(action::set_speed_limit, "a", &context, {{"profile", std::string("slow")}, {"maxSpeed", 0.125}});
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_EQ(last_result(), "slow");
  EXPECT_EQ(instructions.imposed, Profile::slow);
  EXPECT_EQ(instructions.speed_mps_max, 0.125);
  act(action::set_speed_limit, "b", &context, {{"maxSpeed", 0.25}});
  EXPECT_EQ(last_result(), "slow") << "the profile stays";
  EXPECT_EQ(instructions.imposed, Profile::slow);
  EXPECT_EQ(instructions.speed_mps_max, 0.25);
  act(action::set_speed_limit, "c", &context, {{"profile", std::string("fast")}});
  EXPECT_EQ(instructions.imposed, Profile::fast);
  EXPECT_EQ(instructions.speed_mps_max, std::nullopt);
  act(action::set_speed_limit, "d", &context, {{"profile", std::string("normal")}});
  EXPECT_EQ(last_result(), "normal");
  EXPECT_EQ(instructions.imposed, std::nullopt);
}

TEST_F(ActionExecutorTest, saves_at_once_what_has_to_outlast_a_crash) {
  context.agent().on_odometry({});
  EXPECT_FALSE(positions.on_pils_hello(7));
  int tick = 0;
  const auto saved = [&] {
    effects.clear();
    positions.on_tick(SimTime{std::chrono::milliseconds{++tick}}, context, effects);  // far more often than due
    return effects.size() == 1;
  };
  EXPECT_TRUE(saved());
  EXPECT_FALSE(saved());
  act(action::start_pause, "a", &context);
  EXPECT_TRUE(saved());
  act(action::stop_pause, "b", &context);
  EXPECT_TRUE(saved());
  act(action::set_speed_limit, "c", &context, {{"profile", std::string("slow")}});
  EXPECT_TRUE(saved());
  act(action::init_position, "d", &context, {{"x", -0.5}, {"y", -0.15}, {"theta", 0.0}});
  EXPECT_TRUE(saved());
  act(action::state_request, "e", &context);
  EXPECT_FALSE(saved());
}

TEST_F(ActionExecutorTest, enables_a_map_that_is_in_force_at_once_and_a_pending_one_with_the_switch) {
  const auto in_force = zones.on_announced(test::lacet4_configuration(), nullptr, nullptr, effects);
  zones.enforce(*in_force.rtm);
  zone::ZoneConfiguration other = test::lacet4_configuration();
  other.text.replace(other.text.find("name = \"lacet4\""), 15, "name = \"other\"");
  EXPECT_EQ(zones.on_announced(other, nullptr, &lacet4(), effects).verdict, ZoneSelection::Verdict::pending);
  const std::string version = zones.maps().at(0).map_version;
  const auto parameters = [](const std::string& map_id, const std::string& map_version) {
    return std::vector<wire::Parameter>{{"mapId", map_id}, {"mapVersion", map_version}};
  };
  act(action::enable_map, "in force", &context, {{"mapId", std::string("lacet4")}});
  EXPECT_EQ(last_status(), ActionStatus::finished);
  act(action::enable_map, "any version", &context, parameters("lacet4", ""));
  EXPECT_EQ(last_status(), ActionStatus::finished);
  act(action::enable_map, "this version", &context, parameters("lacet4", version));
  EXPECT_EQ(last_status(), ActionStatus::finished);
  expect_failure(action::enable_map, parameters("lacet4", "another version"),
                 "map 'lacet4' is not available; maps arrive with a message on cosiva/v1/zone/");
  act(action::download_map, "download", &context, {{"mapId", std::string("other")}});
  EXPECT_EQ(last_status(), ActionStatus::finished);
  act(action::enable_map, "pending", &context, {{"mapId", std::string("other")}});
  EXPECT_EQ(last_status(), ActionStatus::running);
  actions.on_zone_switched();
  EXPECT_EQ(last_status(), ActionStatus::finished);
}

TEST_F(ActionExecutorTest, publishes_the_factsheet_on_request) {
  act(action::factsheet_request, "f", &context);
  EXPECT_EQ(last_status(), ActionStatus::finished);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::Publish>(effects[0]).topic, server_proxy.topics().factsheet);
}

TEST_F(ActionExecutorTest, backs_up_and_stops_backing_up) {
  act(action::back_up, "a", &context, {{"distance", 0.25}});
  EXPECT_EQ(last_status(), ActionStatus::running);
  act(action::back_up, "b", &context, {{"distance", 0.125}});
  EXPECT_EQ(last_status(), ActionStatus::running);
  EXPECT_EQ(state_of("a").status, ActionStatus::failed);
  EXPECT_EQ(state_of("a").result_description, "overtaken by another backUp");
  act(action::back_up, "c", &context, {{"distance", 0.0}});
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_EQ(state_of("b").status, ActionStatus::failed);
  act(action::back_up, "d", &context, {{"distance", 0.6}});
  EXPECT_THAT(last_result(), HasSubstr("backs up at most"));
}

TEST_F(ActionExecutorTest, ends_what_runs_as_soon_as_the_vehicle_no_longer_performs_it) {
  act(action::back_up, "back", &context, {{"distance", 0.25}});
  actions.end_waits(context.vehicle());
  EXPECT_EQ(state_of("back").status, ActionStatus::running);
  ASSERT_TRUE(context.vehicle().begin_back_up(0.0));
  actions.end_waits(context.vehicle());
  EXPECT_EQ(state_of("back").status, ActionStatus::failed);
  EXPECT_EQ(state_of("back").result_description, "ended before the commanded distance");

  ASSERT_TRUE(context.vehicle().take_order(test::order("O-1").through({"loop_se@0", "loop_se@283"})));
  act(action::cancel_order, "cancel", &context);
  EXPECT_EQ(state_of("cancel").status, ActionStatus::running);
  actions.end_waits(context.vehicle());
  EXPECT_EQ(state_of("cancel").status, ActionStatus::running);
  (void)context.agent().decide();  // the vehicle is stopped
  actions.end_waits(context.vehicle());
  EXPECT_EQ(state_of("cancel").status, ActionStatus::finished);
  EXPECT_EQ(state_of("cancel").result_description, "");
}

TEST_F(ActionExecutorTest, ends_at_a_zone_switch_all_that_runs) {
  ASSERT_TRUE(context.vehicle().take_order(test::order("O-1").through({"loop_se@0", "loop_se@283"})));
  act(action::cancel_order, "cancel", &context);
  ASSERT_EQ(last_status(), ActionStatus::running);
  DrivingContext idle{lacet4(), {}};
  idle.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.5));
  act(action::back_up, "back", &idle, {{"distance", 0.25}});
  ASSERT_EQ(last_status(), ActionStatus::running);
  actions.on_zone_switched();
  EXPECT_EQ(state_of("cancel").status, ActionStatus::finished);
  EXPECT_EQ(state_of("back").status, ActionStatus::failed);
  EXPECT_EQ(state_of("back").result_description, "the zone was switched");
}

TEST_F(ActionExecutorTest, lets_a_resume_overtake_a_pause_that_still_waits) {
  for (const wire::Board board : wire::all_boards) supervision.on_board_message(SimTime{}, board);
  wire::Odometry moving{};
  moving.speed_mmps = 400;
  context.agent().on_odometry(moving);
  act(action::start_pause, "p", &context);
  EXPECT_EQ(last_status(), ActionStatus::running);
  act(action::stop_pause, "r", &context);
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_EQ(state_of("p").status, ActionStatus::failed);
  EXPECT_EQ(state_of("p").result_description, "overtaken by stopPause");
}

}  // namespace
}  // namespace cosiva::aiv
