#include "cosiva/aiv/onboard/state_reporter.h"

#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;

struct StateReporterTest : ::testing::Test {
  OnboardOptions options;
  StateReporter reporter{options};
  BoardsLink boards{1};
  Supervision supervision{milliseconds{500}};
  Session session{options.id, options.interface_name};
  InstantActionBook actions;
  std::vector<wire::MapInfo> maps;
  std::string refusal;
  wire::Effects effects;

  StateReporterTest() { session.set_online(true); }
  /// How many states are published at this time.
  std::size_t states_at(int ms, bool starting_up = false) {
    effects.clear();
    const SimTime now{milliseconds{ms}};
    const ReportSources sources{
        now, nullptr, maps, refusal, boards, supervision, actions, reporter.warnings(), boards.power()};
    reporter.publish_state(sources, starting_up, session, effects);
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
  session.set_online(false);
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

}  // namespace
}  // namespace cosiva::aiv
