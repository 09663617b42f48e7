#include "cosiva/aiv/onboard/state_reporter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;

struct StateReporterTest : ::testing::Test {
  OnboardOptions options;
  StateReporter reporter{options};
  BoardsLink boards{1};
  Supervision supervision{milliseconds{500}};
  ServerProxy server_proxy{options.id, options.interface_name};
  InstantActionBook actions;
  std::vector<wire::MapInfo> maps;
  std::string refusal;
  wire::Effects effects;

  StateReporterTest() { server_proxy.set_online(true); }
  /// How many states are published at this time.
  std::size_t states_at(int ms, bool starting_up = false) {
    effects.clear();
    const SimTime now{milliseconds{ms}};
    const ReportSources sources{
        now, nullptr, maps, refusal, boards, supervision, actions, reporter.warnings(), boards.power()};
    reporter.publish_state(sources, starting_up, server_proxy, effects);
    return effects.size();
  }
};

TEST_F(StateReporterTest, waits_with_the_first_state_for_the_boards) {
  EXPECT_EQ(states_at(0, true), 0U);
  EXPECT_EQ(states_at(10, false), 1U);
}

TEST_F(StateReporterTest, reports_every_second_and_on_request_after_50_ms_at_the_earliest) {
  EXPECT_EQ(states_at(0), 1U);
  EXPECT_EQ(states_at(999), 0U);
  EXPECT_EQ(states_at(1000), 1U);
  reporter.request_report();
  EXPECT_EQ(states_at(1049), 0U);
  EXPECT_EQ(states_at(1050), 1U);
  EXPECT_EQ(states_at(1100), 0U) << "the request is served";
}

TEST_F(StateReporterTest, publishes_nothing_without_the_broker) {
  server_proxy.set_online(false);
  EXPECT_EQ(states_at(0), 0U);
}

TEST_F(StateReporterTest, keeps_a_refusal_until_a_new_order_and_reports_it) {
  ASSERT_EQ(states_at(0), 1U);
  reporter.refuse("orderError", "order", "no such node", {}, effects);
  EXPECT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(states_at(60), 1U);
  reporter.on_new_order();
  EXPECT_TRUE(reporter.warnings().all().empty());
}

TEST_F(StateReporterTest, reports_a_changed_flag_once) {
  ASSERT_EQ(states_at(0), 1U);
  ReportFlags flags;
  flags.driving = true;
  reporter.compare_flags(flags);
  EXPECT_EQ(states_at(60), 1U);
  reporter.compare_flags(flags);
  EXPECT_EQ(states_at(120), 0U);
}

TEST_F(StateReporterTest, logs_each_refusal_and_names_the_topic_where_there_is_no_other_reference) {
  reporter.refuse("orderError", "order", "no such node", {}, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::Log>(effects[0]), (wire::Log{'w', "order refused, orderError: no such node"}));
  EXPECT_EQ(reporter.warnings().all().back(),
            (wire::VehicleError{"orderError", wire::ErrorLevel::warning, "no such node", {{"topic", "order"}}}));
  reporter.refuse("orderError", "order", "no such edge", {{"orderId", "O"}}, effects);
  EXPECT_EQ(reporter.warnings().all().back().references, (std::vector<wire::Reference>{{"orderId", "O"}}));
}

TEST_F(StateReporterTest, removes_warnings_about_updates_when_an_update_is_accepted) {
  reporter.refuse("orderUpdateError", "order", "late", {}, effects);
  reporter.refuse("orderError", "order", "wrong", {}, effects);
  reporter.on_order_update();
  EXPECT_EQ(reporter.warnings().all().size(), 1U);
}

TEST_F(StateReporterTest, publishes_a_state_at_once_where_the_clock_was_set_back) {
  ASSERT_EQ(states_at(100'000), 1U);
  EXPECT_EQ(states_at(99'000), 1U);
  EXPECT_EQ(states_at(99'999), 0U);
  EXPECT_EQ(states_at(100'000), 1U);
}

TEST_F(StateReporterTest, waits_for_the_boards_only_before_the_first_state) {
  ASSERT_EQ(states_at(0), 1U);
  EXPECT_EQ(states_at(1000, true), 1U);
}

TEST_F(StateReporterTest, publishes_the_boards_report_twice_a_second_with_the_counts_of_the_proxies) {
  FleetProxies fleet{options.id};
  fleet.deliver(SimTime{}, {"CoSiVA", "AIV2"});
  const auto reports_at = [&](int ms) {
    effects.clear();
    const SimTime now{milliseconds{ms}};
    reporter.publish_boards_report(
        {now, nullptr, maps, refusal, boards, supervision, actions, reporter.warnings(), boards.power()}, std::nullopt,
        fleet, server_proxy, effects);
    return effects.size();
  };
  EXPECT_EQ(reports_at(0), 1U);
  EXPECT_EQ(std::get<wire::Publish>(effects[0]).topic, server_proxy.topics().boards);
  const auto report = wire::boards_report_from_json(std::get<wire::Publish>(effects[0]).payload);
  ASSERT_TRUE(report);
  EXPECT_THAT(report->proxies,
              testing::ElementsAre(wire::ProxyCounts{"AIV_Server", 0, 0}, wire::ProxyCounts{"CoSiVA/AIV2", 0, 1}));
  EXPECT_EQ(reports_at(499), 0U);
  EXPECT_EQ(reports_at(500), 1U);
  EXPECT_EQ(reports_at(999), 0U);
  EXPECT_EQ(reports_at(1000), 1U);
}

TEST_F(StateReporterTest, publishes_the_visualization_in_its_period_once_the_pose_is_known) {
  DrivingContext context{test::lacet4(), {}};
  const auto published_at = [&](int ms) {
    effects.clear();
    reporter.publish_visualization(SimTime{milliseconds{ms}}, context, server_proxy, effects);
    return effects.size();
  };
  EXPECT_EQ(published_at(0), 0U);
  context.vehicle().estimator().position_at(test::at(test::lacet4(), "loop_se", 0.5));
  EXPECT_EQ(published_at(99), 0U);
  EXPECT_EQ(published_at(100), 1U);
  EXPECT_EQ(std::get<wire::Publish>(effects[0]).topic, server_proxy.topics().visualization);
  EXPECT_EQ(published_at(199), 0U);
  EXPECT_EQ(published_at(200), 1U);
}

TEST_F(StateReporterTest, publishes_a_factsheet_with_its_own_intervals) {
  reporter.publish_factsheet(SimTime{}, test::lacet4(), server_proxy, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_THAT(std::get<wire::Publish>(effects[0]).payload,
              testing::HasSubstr(R"("minStateInterval":0.05,"defaultStateInterval":1,"visualizationInterval":0.1})"));
}

TEST_F(StateReporterTest, updates_the_display_at_most_twice_a_second_and_only_where_the_text_changes) {
  Agent agent{test::lacet4()};
  boards.on_port(wire::Board::PRAV, true);
  const auto sent_at = [&](int ms) {
    effects.clear();
    reporter.update_display(SimTime{milliseconds{ms}}, agent, boards, effects);
    return effects.size();
  };
  EXPECT_EQ(sent_at(0), 1U);
  EXPECT_EQ(std::get<wire::SendBytes>(effects[0]).port, "1/PRAV");
  EXPECT_EQ(sent_at(500), 0U) << "the same text";
  wire::Odometry moving{};
  moving.speed_mmps = 400;
  agent.on_odometry(moving);
  EXPECT_EQ(sent_at(999), 0U);
  EXPECT_EQ(sent_at(1000), 1U);
}

}  // namespace
}  // namespace cosiva::aiv
