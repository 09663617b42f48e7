#include "cosiva/experiments/positioning/moves/move_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cosiva/experiments/positioning/metrology/limit.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/moves/move_fixture.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::experiments {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MoveFixture;
using testing::rmse_m;
using ::testing::SizeIs;
using ::testing::StartsWith;

std::vector<std::string> lines(const std::vector<Call>& calls) {
  std::vector<std::string> text;
  for (const Call& call : calls) text.push_back(call.from + " -> " + call.to + ": " + call.text);
  return text;
}

// Figure 17, message by message.
TEST(MoveLoop, requests_the_next_position_then_commands_the_move_then_requests_the_actual_position) {
  MoveFixture fixture{{"dead_reckoning", "arc_kalman"}, 0.2};
  GroundTruthSource source;
  source.on_message(wire::gvs_connection_topic,
                    to_json(wire::GvsConnection{wire::ConnectionState::online, virtual_epoch, "a camera", ""}));
  MoveLoop loop{fixture.options, source};
  ASSERT_TRUE(fixture.run(loop)) << loop.fault();
  EXPECT_EQ(loop.phase(), MoveLoop::Phase::done) << loop.fault();
  const std::vector<std::string> text = lines(fixture.calls);
  ASSERT_THAT(text, SizeIs(1 + 2 * 7 + 3));
  EXPECT_EQ(text[0], "Simulator -> CoSiVA/AIV1: move(0.100 m)") << "the vehicle comes to rest first";
  for (const std::size_t at : {1U, 8U}) {
    EXPECT_EQ(text[at], "Simulator -> CoSiVA/AIV1: nextEstimatedPosition(dead_reckoning, arc_kalman)");
    EXPECT_THAT(text[at + 1], StartsWith("CoSiVA/AIV1 -> Simulator: PE1 = ("));
    EXPECT_THAT(text[at + 2], StartsWith("CoSiVA/AIV1 -> Simulator: PE2 = ("));
    EXPECT_EQ(text[at + 3], "Simulator -> CoSiVA/AIV1: move(0.100 m)");
    EXPECT_EQ(text[at + 4], "CoSiVA/AIV1 -> Simulator: moved");
    EXPECT_EQ(text[at + 5], "Simulator -> GVS: actualAIVposition(CoSiVA/AIV1)");
    EXPECT_THAT(text[at + 6], StartsWith("GVS -> Simulator: PA = ("));
  }
  EXPECT_THAT(loop.steps(), SizeIs(2));
  EXPECT_NEAR(loop.travelled_m(), 0.2, 1e-6) << "until TDTmax";
}

TEST(MoveLoop, of_exact_sensors_predicts_each_position_exactly) {
  MoveFixture fixture{{"dead_reckoning", "reset_rule", "arc_kalman"}, 8.0, 1, 0.0};
  const GroundTruthSource source;
  MoveLoop loop{fixture.options, source};
  ASSERT_TRUE(fixture.run(loop)) << loop.fault();
  ASSERT_THAT(loop.steps(), SizeIs(80));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT(rmse_m(loop.steps(), i), 1e-6) << i;
}

// The vehicle drives each move exactly, so a prediction's error is that of the estimate before the move: √(R + Q/2) of
// the article's rule, and of dead reckoning the start's error and q per metre, which grow without a bound.
TEST(MoveLoop, of_the_article_s_rule_has_the_error_of_its_closed_form) {
  double rule_m2 = 0.0;
  double reckoning_m2 = 0.0;
  constexpr int runs = 60;
  constexpr double distance_m = 20.0;
  for (int run = 1; run <= runs; ++run) {
    MoveFixture fixture{{"reset_rule", "dead_reckoning"}, distance_m, static_cast<std::uint64_t>(run)};
    const GroundTruthSource source;
    MoveLoop loop{fixture.options, source};
    ASSERT_TRUE(fixture.run(loop)) << loop.fault();
    rule_m2 += rmse_m(loop.steps(), 0) * rmse_m(loop.steps(), 0) / runs;
    reckoning_m2 += rmse_m(loop.steps(), 1) * rmse_m(loop.steps(), 1) / runs;
  }
  const double closed_m = reset_rule_m({1e-4, 0.537, 1e-4});
  EXPECT_NEAR(std::sqrt(rule_m2), closed_m, 0.05 * closed_m);
  // The variance grows from (1 cm)² by (1 cm)² per metre: its mean over the run. The chord is shorter than the arc.
  const double reckoning_m = std::sqrt(1e-4 + 1e-4 * distance_m / 2.0);
  EXPECT_NEAR(std::sqrt(reckoning_m2), reckoning_m, 0.2 * reckoning_m);
}

// A planted error: an algorithm that predicts 5 cm too far.
TEST(MoveLoop, shows_a_wrong_estimator) {
  MoveFixture fixture{{"dead_reckoning", "reset_rule"}, 4.0, 1, 0.0};
  fixture.plant = [](wire::EstimateResponse& response) {
    Pose2& next = *response.estimates[1].next;
    next = next * Pose2{0.05, 0.0, 0.0};
  };
  const GroundTruthSource source;
  MoveLoop loop{fixture.options, source};
  ASSERT_TRUE(fixture.run(loop));
  EXPECT_LT(rmse_m(loop.steps(), 0), 1e-6);
  EXPECT_NEAR(rmse_m(loop.steps(), 1), 0.05, 1e-6);
  auto run = loop.finish(testing::lacet4());
  ASSERT_TRUE(run) << to_string(run.error());
  const std::vector<std::shared_ptr<const LiveRun>> runs{std::make_shared<const LiveRun>(std::move(*run))};
  const auto all = qualify({on_board("dead_reckoning", "", runs), on_board("reset_rule", "", runs)}, 1,
                           [&](std::size_t, Trial&) -> Result<const Trial*> { return &runs[0]->trial; }, {});
  ASSERT_TRUE(all) << to_string(all.error());
  EXPECT_EQ(all->algorithms[0].iterations, 40U);
  EXPECT_DOUBLE_EQ(all->algorithms[0].precision.value, 1.0);
  EXPECT_DOUBLE_EQ(all->algorithms[1].precision.value, 0.0);
  EXPECT_NEAR(all->algorithms[1].mean_m.value, 0.05, 1e-6);
  EXPECT_NEAR(all->algorithms[1].variance_m2, 0.0, 1e-9);
  EXPECT_NEAR(all->algorithms[1].along_bias_m, 0.05, 1e-3);
  EXPECT_FALSE(all->algorithms[0].limit_m) << "the limit is that of estimates after the move";
}

TEST(MoveLoop, repeats_lost_messages_and_records_the_same_steps) {
  MoveFixture complete{{"arc_kalman"}, 3.0};
  const GroundTruthSource source;
  MoveLoop without_loss{complete.options, source};
  ASSERT_TRUE(complete.run(without_loss));
  MoveFixture fixture{{"arc_kalman"}, 3.0};
  int count = 0;
  fixture.lost = [&count](const std::string&) { return ++count % 3 == 0; };
  MoveLoop loop{fixture.options, source};
  ASSERT_TRUE(fixture.run(loop)) << loop.fault();
  EXPECT_GT(loop.repeated(), 10U);
  ASSERT_EQ(loop.steps().size(), without_loss.steps().size());
  for (std::size_t i = 0; i < loop.steps().size(); ++i) {
    EXPECT_EQ(loop.steps()[i].actual, without_loss.steps()[i].actual) << i;
    EXPECT_EQ(loop.steps()[i].estimated, without_loss.steps()[i].estimated) << i;
  }
}

// A move takes some seconds: it is not commanded again while the vehicle reports that it moves.
TEST(MoveLoop, commands_a_move_once_while_the_vehicle_reports_it_as_running) {
  const GroundTruthSource source;
  MoveFixture fixture{{"arc_kalman"}};
  MoveLoop loop{fixture.options, source};
  std::size_t commands = 0;
  for (SimTime now = virtual_epoch; now < virtual_epoch + std::chrono::seconds{10};
       now += std::chrono::milliseconds{50}) {
    for (const wire::Publish& message : loop.tick(now).messages)
      commands += message.topic.ends_with("instantActions") ? 1U : 0U;
    wire::State state;
    state.header = {1, now, "2.1.0", "CoSiVA", "AIV1"};
    state.action_states.push_back({"q/1/1", "move", wire::ActionStatus::running, ""});
    if (commands > 0)
      loop.on_message(now, wire::vda_topic(fixture.options.vehicle, "state"), wire::vda5050::encode(state));
  }
  EXPECT_EQ(commands, 1U);
  EXPECT_EQ(loop.phase(), MoveLoop::Phase::stopping);
}

TEST(MoveLoop, fails_with_the_reason_that_the_vehicle_gives) {
  const auto fault_with = [](const std::function<void(wire::EstimateResponse&)>& change) {
    MoveFixture fixture{{"arc_kalman"}};
    fixture.plant = change;
    const GroundTruthSource source;
    MoveLoop loop{fixture.options, source};
    EXPECT_TRUE(fixture.run(loop));
    EXPECT_EQ(loop.phase(), MoveLoop::Phase::failed);
    return loop.fault();
  };
  EXPECT_EQ(fault_with([](auto& response) { response.fault = "its zone was switched"; }), "its zone was switched");
  EXPECT_THAT(fault_with([](auto& response) { response.estimates[0].next.reset(); }), HasSubstr("another version"));
  EXPECT_THAT(fault_with([](auto& response) { response.estimates.clear(); }), HasSubstr("no estimate of arc_kalman"));
  EXPECT_THAT(fault_with([](auto& response) { response.estimates[0].fault = "diverged"; }), HasSubstr("diverged"));
}

// Without the GVS's response the loop neither records a step nor goes on.
TEST(MoveLoop, waits_for_the_actual_position) {
  MoveFixture fixture{{"arc_kalman"}};
  fixture.lost = [](const std::string& topic) { return topic.find("actual_position") != std::string::npos; };
  const GroundTruthSource source;
  MoveLoop loop{fixture.options, source};
  EXPECT_FALSE(fixture.run(loop));
  EXPECT_EQ(loop.phase(), MoveLoop::Phase::locating);
  EXPECT_THAT(loop.steps(), SizeIs(0));
  EXPECT_EQ(fixture.moved, 2U);
}

}  // namespace
}  // namespace cosiva::experiments
