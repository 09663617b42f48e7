#include "cosiva/experiments/positioning/moves/predict_then_move.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cosiva/experiments/positioning/moves/move_fixture.h"
#include "cosiva/experiments/positioning/moves/world_session.h"

namespace cosiva::experiments {
namespace {

using std::chrono::minutes;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::rmse_m;
using ::testing::SizeIs;

std::unique_ptr<World> world_of(std::uint32_t aivs, bool as_values = true) {
  WorldOptions options;
  options.zone = zone::testing::configuration_file("lacet4.toml");
  options.aivs = aivs;
  options.as_values = as_values;
  auto made = World::make(options);
  EXPECT_TRUE(made);
  return std::move(*made);
}

PredictThenMoveOptions options_of(std::vector<std::string> algorithms, std::size_t runs = 1) {
  PredictThenMoveOptions options;
  options.vehicles = {{"CoSiVA", "AIV1"}};
  options.runs = runs;
  options.distance_m = 3.0;
  options.step_m = 0.15;
  options.algorithms = std::move(algorithms);
  options.name = "test";
  return options;
}

/// A vehicle's program with a wrong estimator: the responses of a test's vehicle, changed in transit.
class Changed final : public PlatformTest {
 public:
  Changed(PlatformTest& test, std::string algorithm, double error_m)
      : test_{test}, algorithm_{std::move(algorithm)}, error_m_{error_m} {}
  std::vector<std::string> subscriptions() const override { return test_.subscriptions(); }
  void on_zone(std::shared_ptr<const zone::TrafficZone> zone) override { test_.on_zone(std::move(zone)); }
  void on_message(SimTime now, std::string_view topic, std::string_view payload) override {
    if (!topic.starts_with(wire::estimate_response_topic_prefix)) return test_.on_message(now, topic, payload);
    auto response = wire::estimate_response_from_json(payload);
    for (auto& estimate : response->estimates)
      if (estimate.algorithm == algorithm_ && estimate.next)
        *estimate.next = *estimate.next * Pose2{error_m_, 0.0, 0.0};
    test_.on_message(now, topic, to_json(*response));
  }
  Responses tick(SimTime now) override { return test_.tick(now); }
  void give_up() override { test_.give_up(); }
  bool done() const override { return test_.done(); }
  std::vector<std::shared_ptr<const LiveRun>> take_runs() override { return test_.take_runs(); }
  const std::vector<std::string>& losses() const override { return test_.losses(); }
  std::size_t without_ground_truth() const override { return test_.without_ground_truth(); }
  std::size_t repeated() const override { return test_.repeated(); }
  const std::string& map_id() const override { return test_.map_id(); }
  const GroundTruthSource& source() const override { return test_.source(); }
  Progress progress(SimTime now) const override { return test_.progress(now); }

 private:
  PlatformTest& test_;
  std::string algorithm_;
  double error_m_;
};

// The vehicle's own program estimates and moves; the plant responds, as no GVS runs.
TEST(PredictThenMove, qualifies_the_algorithms_on_board_of_a_vehicle_in_virtual_time) {
  const auto world = world_of(1);
  PredictThenMove test{options_of({"dead_reckoning", "arc_kalman"})};
  test.on_zone(testing::lacet4());
  ASSERT_TRUE(drive_in_world(test, *world, 1, minutes{10}));
  EXPECT_THAT(test.losses(), IsEmpty());
  ASSERT_THAT(test.steps(), SizeIs(1));
  const std::vector<MoveStep>& steps = test.steps().begin()->second;
  // 3 m in moves of 0.15 m, each within the vehicle's stopping accuracy.
  ASSERT_GE(steps.size(), 19U);
  EXPECT_LE(steps.size(), 22U);
  for (std::size_t i = 1; i < steps.size(); ++i)
    EXPECT_NEAR(distance(steps[i].actual, steps[i - 1].actual), 0.15, 0.02) << i;
  EXPECT_NEAR(steps.back().travelled_m, 3.0, 0.16);
  // Each prediction was made one move before: far from the position then, near to the position after.
  for (const MoveStep& step : steps)
    for (const Pose2& estimated : step.estimated) EXPECT_LT(distance(estimated, step.actual), 0.03);
  EXPECT_LT(rmse_m(steps, 1), 0.015);
  EXPECT_THAT(calls_text(test.calls()), HasSubstr("Simulator -> plant: actualAIVposition(CoSiVA/AIV1)"));
  const auto csv = steps_csv(test.steps(), {"dead_reckoning", "arc_kalman"});
  EXPECT_THAT(csv, HasSubstr("actual_heading_rad,dead_reckoning_x_m"));
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(csv, '\n')), steps.size() + 1);
  EXPECT_EQ(test.take_runs().front()->trial.moments.size(), steps.size());
  const double before_m = world->plant().vehicles()[0].distance_m;
  world->run_for(std::chrono::seconds{10});
  EXPECT_GT(world->plant().vehicles()[0].distance_m, before_m + 1.0) << "afterwards the vehicle drives on";
}

TEST(PredictThenMove, shows_a_wrong_estimator_on_board) {
  const auto world = world_of(1);
  PredictThenMove test{options_of({"dead_reckoning", "arc_kalman"})};
  test.on_zone(testing::lacet4());
  Changed changed{test, "arc_kalman", 0.10};
  ASSERT_TRUE(drive_in_world(changed, *world, 1, minutes{10}));
  const std::vector<MoveStep>& steps = test.steps().begin()->second;
  EXPECT_GT(rmse_m(steps, 1), 0.08);
  EXPECT_LT(rmse_m(steps, 0), 0.03);
}

TEST(PredictThenMove, gives_the_same_steps_as_values_and_as_texts) {
  std::vector<std::string> results;
  for (const bool as_values : {true, false}) {
    const auto world = world_of(1, as_values);
    PredictThenMove test{options_of({"arc_kalman"})};
    test.on_zone(testing::lacet4());
    ASSERT_TRUE(drive_in_world(test, *world, 1, minutes{10}));
    results.push_back(steps_csv(test.steps(), {"arc_kalman"}));
  }
  EXPECT_EQ(results[0], results[1]);
}

TEST(PredictThenMove, loses_a_vehicle_that_does_not_respond_and_leaves_its_runs_to_the_others) {
  const auto world = world_of(2);
  PredictThenMoveOptions options = options_of({"arc_kalman"}, 2);
  options.vehicles = {{"CoSiVA", "AIV9"}, {"CoSiVA", "AIV1"}};
  options.distance_m = 0.5;
  options.stopped_max = std::chrono::seconds{10};
  PredictThenMove test{options};
  test.on_zone(testing::lacet4());
  ASSERT_TRUE(drive_in_world(test, *world, 2, minutes{10}));
  ASSERT_THAT(test.losses(), SizeIs(1));
  EXPECT_THAT(test.losses()[0], HasSubstr("CoSiVA/AIV9: the commanded move has not ended for 10 s"));
  EXPECT_THAT(test.steps(), SizeIs(2));
}

}  // namespace
}  // namespace cosiva::experiments
