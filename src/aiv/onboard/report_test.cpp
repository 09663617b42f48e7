#include "cosiva/aiv/onboard/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::lacet4;
using testing::ElementsAre;
using testing::IsEmpty;
using wire::Board;

/// A vehicle at the start of a loop whose boards all respond.
struct ReportTest : ::testing::Test {
  SimTime now{std::chrono::seconds{100}};
  Agent agent{lacet4()};
  std::vector<wire::MapInfo> maps{{"lacet4", "1", "", true}};
  std::string refused;
  BoardsLink boards{1};
  Supervision supervision{milliseconds{500}};
  InstantActionBook actions;
  Warnings warnings;
  std::optional<wire::Power> power{wire::Power{7412, 300, 250, 789}};

  ReportTest() {
    agent.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.0));
    for (const Board board : wire::all_boards) supervision.on_board_message(now, board);
  }
  [[nodiscard]] ReportSources sources(bool with_agent = true) const {
    return {now, with_agent ? &agent : nullptr, maps, refused, boards, supervision, actions, warnings, power};
  }
  [[nodiscard]] wire::State state() const { return compose_state(sources()); }
  [[nodiscard]] std::vector<std::string> errors(bool with_agent = true) const {
    std::vector<std::string> types;
    for (const wire::VehicleError& error : compose_state(sources(with_agent)).errors) types.push_back(error.type);
    return types;
  }
  void self_test(Board board, std::uint8_t code) {
    (void)boards.on_bytes(board, wire::module_link::encode(wire::Heartbeat{1234, 2, 3, code}, 0));
  }
};

TEST_F(ReportTest, of_a_vehicle_in_order_has_no_errors) {
  EXPECT_THAT(errors(), IsEmpty());
  const wire::State reported = state();
  EXPECT_EQ(reported.maps, maps);
  EXPECT_FALSE(reported.driving);
  EXPECT_FALSE(reported.paused);
  EXPECT_FALSE(reported.new_base_request);
  EXPECT_FALSE(reported.field_violation);
  EXPECT_EQ(reported.distance_since_last_node_m, std::nullopt) << "there is no last node";
  ASSERT_TRUE(reported.position);
  EXPECT_EQ(reported.position->pose, agent.vehicle().position().pose());
  EXPECT_EQ(reported.position->map_id, "lacet4");
  EXPECT_TRUE(reported.position->position_initialized);
  EXPECT_DOUBLE_EQ(*reported.position->deviation_range_m,
                   2.0 * agent.vehicle().position().on_path_estimator().sigma_m());
  EXPECT_EQ(reported.velocity, wire::Velocity{});
  EXPECT_NEAR(reported.battery.charge_percent, 78.9, 1e-9);
  EXPECT_DOUBLE_EQ(*reported.battery.voltage_v, 7.412);
  EXPECT_THAT(
      reported.information,
      ElementsAre(wire::Information{"boards", "", {{"PILS", "ok"}, {"PRAV", "ok"}, {"DOBS", "ok"}, {"RALI", "ok"}}}));
}

TEST_F(ReportTest, names_each_condition_that_keeps_the_vehicle_from_driving) {
  agent.vehicle().hold(Hold::server_lost, true);
  EXPECT_THAT(errors(), ElementsAre("serverLost"));
  agent.vehicle().hold(Hold::line_lost, true);
  EXPECT_THAT(errors(), ElementsAre("serverLost", "lineLost"));
  agent.vehicle().hold(Hold::server_lost, false);
  EXPECT_THAT(errors(), ElementsAre("lineLost"));
  agent.vehicle().hold(Hold::line_lost, false);
  refused = "a zone was announced";
  EXPECT_THAT(errors(), ElementsAre("zoneError"));
  EXPECT_EQ(state().errors[0].description, "a zone was announced");
  EXPECT_THAT(errors(false), ElementsAre("zoneError", "zoneUnknown"));
  warnings.add("orderError", "why");
  EXPECT_THAT(errors(), ElementsAre("orderError", "zoneError")) << "refusals first";
}

TEST_F(ReportTest, distinguishes_an_unknown_position_from_one_away_from_all_paths) {
  Agent lost{lacet4()};
  const auto types = [&] {
    std::vector<std::string> all;
    const ReportSources from{now, &lost, maps, refused, boards, supervision, actions, warnings, power};
    for (const wire::VehicleError& error : compose_state(from).errors) all.push_back(error.type);
    return all;
  };
  EXPECT_THAT(types(), ElementsAre("positionUnknown"));
  lost.vehicle().estimator().set_off_path({9.0, 9.0, 0.0});
  EXPECT_THAT(types(), ElementsAre("offCircuit"));
}

TEST_F(ReportTest, warns_of_less_than_a_tenth_of_the_charge) {
  agent.on_charge(0.10);
  EXPECT_THAT(errors(), IsEmpty());
  agent.on_charge(0.0999);
  EXPECT_THAT(errors(), ElementsAre("batteryLowError"));
}

TEST_F(ReportTest, names_each_board_that_is_lost_or_faulty) {
  self_test(Board::DOBS, 3);
  const wire::State faulty = state();
  EXPECT_THAT(faulty.errors,
              ElementsAre(wire::VehicleError{
                  "boardFaulty", wire::ErrorLevel::warning, "DOBS reports fault 3", {{"board", "DOBS"}}}));
  EXPECT_EQ(faulty.information.back().references[2], (wire::Reference{"DOBS", "faulty"}));
  supervision.forget_board(Board::DOBS);
  const wire::State lost = state();
  EXPECT_THAT(lost.errors, ElementsAre(wire::VehicleError{
                               "boardLost", wire::ErrorLevel::warning, "DOBS does not respond", {{"board", "DOBS"}}}));
  EXPECT_EQ(lost.information.back().references[2], (wire::Reference{"DOBS", "lost"}));
}

TEST_F(ReportTest, without_a_zone_has_no_position_and_without_power_no_charge) {
  power.reset();
  const wire::State nothing = compose_state(sources(false));
  EXPECT_FALSE(nothing.position);
  EXPECT_FALSE(nothing.velocity);
  EXPECT_EQ(nothing.battery, wire::BatteryState{});
}

TEST_F(ReportTest, states_the_uncertainty_of_a_gauge_and_whether_only_a_full_charge_helps) {
  const auto of_gauge = [&](std::uint16_t sd) {
    power->gauge = wire::Power::Gauge{871'234, sd};
    return state();
  };
  EXPECT_NEAR(of_gauge(135).battery.charge_percent, 87.1234, 1e-9);
  EXPECT_EQ(of_gauge(135).information.back(),
            (wire::Information{"battery", "", {{"chargeStdDev_percent", "1.350"}, {"needsFullCharge", "false"}}}));
  EXPECT_EQ(of_gauge(500).information.back().references[1].value, "false");
  EXPECT_EQ(of_gauge(501).information.back().references[1].value, "true") << "more than 5 %";
}

TEST_F(ReportTest, describes_the_order_and_the_action_states) {
  ASSERT_TRUE(
      agent.vehicle().take_order(test::order("O-1", 0).through({"loop_se@0", "loop_se@283"}).then({"loop_se@565"})));
  ASSERT_TRUE(actions.begin({"stateRequest", "a", "", wire::BlockingType::none, {}}));
  const wire::State reported = state();
  EXPECT_EQ(reported.order_id, "O-1");
  EXPECT_EQ(reported.order_update_id, 0U);
  EXPECT_EQ(reported.last_node_id, "loop_se@0");
  EXPECT_EQ(reported.node_states.size(), 2U);
  EXPECT_EQ(reported.edge_states.size(), 2U);
  EXPECT_EQ(reported.distance_since_last_node_m, 0.0);
  EXPECT_THAT(reported.action_states,
              ElementsAre(wire::ActionState{"a", "stateRequest", wire::ActionStatus::waiting, ""}));
  agent.vehicle().hold(Hold::paused, true);
  EXPECT_TRUE(state().paused);
}

TEST_F(ReportTest, of_the_boards_has_a_line_for_each) {
  (void)boards.on_bytes(Board::PILS, wire::module_link::encode(wire::Hello{Board::PILS, 1, 0xF00D, 5}, 0));
  (void)boards.on_bytes(Board::PILS, wire::module_link::encode(wire::Heartbeat{1234, 2, 3, 4}, 1));
  supervision.forget_board(Board::RALI);
  const wire::Ranges ranges{1, -50, 10, {500}};
  const wire::BoardsReport report = compose_boards_report(sources(), ranges);
  EXPECT_THAT(report.boards, ElementsAre(wire::BoardsReport::Line{Board::PILS, "faulty", 0xF00D, 1234, 2, 2, 3, 4},
                                         wire::BoardsReport::Line{Board::PRAV, "ok", 0, 0, 0, 0, 0, 0},
                                         wire::BoardsReport::Line{Board::DOBS, "ok", 0, 0, 0, 0, 0, 0},
                                         wire::BoardsReport::Line{Board::RALI, "lost", 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(report.power, power);
  EXPECT_EQ(report.ranges, ranges);
}

TEST_F(ReportTest, of_a_visualization_has_a_position_only_where_it_is_known) {
  EXPECT_EQ(compose_visualization(agent, "m").position->map_id, "m");
  EXPECT_TRUE(compose_visualization(agent, "m").velocity);
  EXPECT_FALSE(compose_visualization(Agent{lacet4()}, "m").position);
}

TEST_F(ReportTest, on_the_display_has_twelve_bytes_of_the_name_the_status_and_the_speed) {
  EXPECT_EQ(display_text("AIV1", agent), "AIV1 stopped 0.0");
  EXPECT_EQ(display_text("123456789012", agent), "123456789012 stopped 0.0");
  EXPECT_EQ(display_text("1234567890123", agent), "123456789012 stopped 0.0");
  wire::Odometry backwards{};
  backwards.speed_mmps = -340;
  agent.on_odometry(backwards);
  EXPECT_EQ(display_text("AIV1", agent), "AIV1 Normal 0.3");
}

TEST_F(ReportTest, flags_change_with_what_the_server_has_to_know_at_once) {
  const ReportFlags before = flags_of(sources());
  EXPECT_EQ(before.charge_percent, 78);
  EXPECT_EQ(before.boards_lost, 0U);
  EXPECT_TRUE(before.position_known);
  EXPECT_FALSE(before.driving);
  EXPECT_FALSE(before.near_path);
  EXPECT_EQ(before, flags_of(sources()));

  power->charge_permille = 780;
  EXPECT_EQ(flags_of(sources()), before) << "the same whole percent";
  power->charge_permille = 779;
  EXPECT_EQ(flags_of(sources()).charge_percent, 77);
  power->charge_permille = 789;

  agent.vehicle().hold(Hold::paused, true);
  EXPECT_NE(flags_of(sources()).holds, before.holds);
  agent.vehicle().hold(Hold::paused, false);

  wire::Odometry moving{};
  moving.speed_mmps = 400;
  agent.on_odometry(moving);
  EXPECT_TRUE(flags_of(sources()).driving);
}

TEST_F(ReportTest, flags_have_a_bit_for_each_board_lost_and_for_each_board_faulty) {
  EXPECT_EQ(flags_of(sources()).boards_lost, 0U);
  unsigned bit = 1;
  for (const Board board : wire::all_boards) {
    supervision.forget_board(board);
    EXPECT_EQ(flags_of(sources()).boards_lost, bit) << to_string(board);
    supervision.on_board_message(now, board);
    self_test(board, 1);
    EXPECT_EQ(flags_of(sources()).boards_lost, 2 * bit) << to_string(board);
    boards.on_port(board, true);
    bit *= 4;
  }
}

TEST_F(ReportTest, flags_without_a_zone_concern_the_boards_alone) {
  power.reset();
  supervision.forget_board(Board::PILS);
  ReportFlags expected;
  expected.boards_lost = 1;
  EXPECT_EQ(flags_of(sources(false)), expected);
}

}  // namespace
}  // namespace cosiva::aiv
