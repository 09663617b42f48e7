#include "cosiva/experiments/positioning/metrology/live_runs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/zone/rtm/rtm.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

wire::VehicleId aiv(int number) { return {"CoSiVA", "AIV" + std::to_string(number)}; }

/// The whole platform in virtual time, with a live test on its bus.
class Fixture {
 public:
  explicit Fixture(LiveRunsOptions options, double loss = 0.0) : loss_{loss}, runs_{named(std::move(options))} {
    WorldOptions world;
    world.zone = zone::testing::configuration_file("lacet4.toml");
    world.aivs = 2;
    auto made = World::make(world);
    EXPECT_TRUE(made);
    world_ = std::move(*made);
    runs_.on_zone(zone::Rtm::initialise(world.zone)->shared_zone());
    world_->tap([this](SimTime at, const std::string&, const wire::Publish& message) {
      if (detections && message.topic == wire::ground_truth_topic)
        runs_.on_message(at, wire::gvs_detections_topic, to_json(detections(*JsonValue::parse(message.payload))));
      for (const std::string& filter : runs_.subscriptions()) {
        if (wire::topic_matches(filter, message.topic) && !(deaf && deaf(message.topic)) && !random_.chance(loss_))
          runs_.on_message(at, message.topic, message.payload);
      }
    });
    world_->run_for(seconds{3});
  }
  /// Runs until the test is done, or for this time.
  void run(SimDuration longest) {
    const SimTime end = world_->now() + longest;
    while (!runs_.done() && world_->now() < end) {
      LiveRuns::Responses responses = runs_.tick(world_->now());
      for (const wire::Publish& message : responses.messages)
        if (!random_.chance(loss_)) world_->faults().publish_from_outside(message);
      for (std::string& command : responses.commands) world_->command_server(std::move(command));
      for (std::string& one : responses.operator_messages) operator_messages += one + "\n";
      world_->run_for(milliseconds{5});
    }
  }
  World& world() { return *world_; }
  LiveRuns& runs() { return runs_; }

  std::function<bool(std::string_view topic)> deaf;                       ///< messages to drop
  std::function<wire::GvsDetections(const JsonValue& fixes)> detections;  ///< of a GVS, from the plant's ground truth
  std::string operator_messages;

 private:
  static LiveRunsOptions named(LiveRunsOptions options) {
    options.name = "test";
    options.timeout = seconds{3};
    return options;
  }
  double loss_;
  Random random_{7, "bench"};
  LiveRuns runs_;
  std::unique_ptr<World> world_;
};

LiveRunsOptions options_of(std::vector<wire::VehicleId> vehicles, std::size_t runs, double distance_m,
                           std::vector<std::string> algorithms) {
  LiveRunsOptions options;
  options.vehicles = std::move(vehicles);
  options.runs = runs;
  options.distance_m = distance_m;
  options.algorithms = std::move(algorithms);
  return options;
}

/// The responses of the same algorithm to the same inputs off board.
Trace off_board(const std::string& name, const Trial& trial) {
  Trace trace;
  const auto algorithm = estimation::Registry{}.make(name, trial.setting);
  EXPECT_TRUE(algorithm && apply(**algorithm, trial, trace));
  return trace;
}

Result<Qualification> evaluated(const std::vector<std::string>& names,
                                const std::vector<std::shared_ptr<const LiveRun>>& runs) {
  std::vector<Candidate> candidates;
  candidates.reserve(names.size());
  for (const std::string& name : names) candidates.push_back(on_board(name, "", runs));
  return qualify(candidates, runs.size(),
                 [&](std::size_t index, Trial&) -> Result<const Trial*> { return &runs[index]->trial; }, {});
}

TEST(LiveRuns, record_the_vehicles_estimates_with_their_actual_positions) {
  const std::vector<std::string> names{"dead_reckoning", "reset_rule", "arc_kalman", "ekf", "particles"};
  Fixture fixture{options_of({aiv(1), aiv(2)}, 3, 12.0, names)};
  fixture.run(seconds{200});
  EXPECT_THAT(fixture.runs().losses(), IsEmpty()) << fixture.operator_messages;
  EXPECT_EQ(fixture.runs().map_id(), "lacet4");
  EXPECT_EQ(fixture.runs().without_ground_truth(), 0U);
  const auto runs = fixture.runs().take_runs();
  ASSERT_THAT(runs, SizeIs(3));
  for (const auto& run : runs) {
    EXPECT_NEAR(run->trial.moments.back().travelled_m, 12.0, 0.05);
    // 12 m at up to 0.5 m/s, 20 requests per second.
    EXPECT_GT(run->trial.moments.size(), 400U);
  }
  const auto all = evaluated(names, runs);
  ASSERT_TRUE(all) << to_string(all.error());
  for (const Qualified& one : all->algorithms) EXPECT_FALSE(one.failed) << one.name;
  const Qualified& reckoning = all->algorithms[0];
  const Qualified& kalman = all->algorithms[2];
  // A tag every 1.44 m and beacons between them: 3 mm. Wheels with an error of 0.5 % alone: several times that.
  EXPECT_LT(kalman.rmse_m.value, 0.006);
  EXPECT_GT(reckoning.rmse_m.value, 2.0 * kalman.rmse_m.value);
  EXPECT_LT(std::fabs(kalman.along_bias_m), 0.003) << "the stamps of both sides agree";
}

/// A GVS over the zone, whose detections are 0.25 m to the left of the actual positions: a planted error.
void run_with_gvs(Fixture& fixture, bool connected) {
  const auto connection = [](wire::ConnectionState state) {
    return to_json(wire::GvsConnection{state, virtual_epoch, "a test's camera", ""});
  };
  fixture.runs().on_message(fixture.world().now(), wire::gvs_connection_topic,
                            connection(connected ? wire::ConnectionState::online : wire::ConnectionState::offline));
  fixture.detections = [](const JsonValue& fixes) {
    wire::GvsDetections image{1, *parse_iso8601(*fixes.text("timestamp")), 0.1, {}, {}};
    for (const JsonValue& one : *fixes.find("vehicles")->array()) {
      const Pose2 X_MB{*one.number("x"), *one.number("y"), *one.number("heading")};
      const auto number = std::to_string(static_cast<int>(*one.number("number")));
      image.detections.push_back({"CoSiVA/AIV" + number, 1, image.timestamp, X_MB * Pose2{0.0, 0.25, 0.0}, 0.001});
    }
    return image;
  };
  fixture.run(seconds{60});
}

TEST(LiveRuns, take_the_actual_positions_from_the_gvs_where_one_is_in_operation) {
  for (const bool connected : {true, false}) {
    Fixture fixture{options_of({aiv(1)}, 1, 3.0, {"arc_kalman"})};
    run_with_gvs(fixture, connected);
    const auto runs = fixture.runs().take_runs();
    ASSERT_THAT(runs, SizeIs(1)) << fixture.operator_messages;
    const auto all = evaluated({"arc_kalman"}, runs);
    ASSERT_TRUE(all);
    if (connected) {
      EXPECT_EQ(fixture.runs().source().name(), "GVS, a test's camera");
      EXPECT_NEAR(all->algorithms[0].rmse_m.value, 0.25, 0.01) << "the GVS's planted error, not the plant's";
    } else {
      EXPECT_THAT(fixture.runs().source().name(), HasSubstr("the plant's ground truth"));
      EXPECT_LT(all->algorithms[0].rmse_m.value, 0.006);
    }
  }
}

TEST(LiveRuns, give_on_board_bit_for_bit_the_estimates_of_the_same_algorithm_elsewhere) {
  const std::vector<std::string> names{"dead_reckoning", "arc_kalman_scale", "ukf", "particles", "ufir"};
  Fixture fixture{options_of({aiv(1)}, 1, 6.0, names), 0.2};
  fixture.run(seconds{200});
  EXPECT_GT(fixture.runs().repeated(), 10U) << "every fifth message is lost";
  const auto runs = fixture.runs().take_runs();
  ASSERT_THAT(runs, SizeIs(1)) << fixture.operator_messages;
  const Trial& trial = runs[0]->trial;
  EXPECT_GT(std::ranges::count_if(trial.events,
                                  [](const Event& e) { return std::holds_alternative<estimation::Reading>(e); }),
            5);
  for (const std::string& name : names) {
    const Candidate published = on_board(name, "", runs);
    Trace on;
    ASSERT_TRUE(apply(**published.make(trial.setting), trial, on));
    const Trace off = off_board(name, trial);
    EXPECT_EQ(on.error_m, off.error_m) << name;
    EXPECT_EQ(on.nees, off.nees) << name;
    EXPECT_EQ(on.nis, off.nis) << name;
    EXPECT_EQ(on.refused, off.refused) << name;
  }
}

TEST(LiveRuns, are_repeated_by_a_restarted_vehicle_and_left_to_others_by_a_lost_one) {
  Fixture fixture{options_of({aiv(1), aiv(2)}, 2, 6.0, {"arc_kalman"})};
  fixture.run(seconds{5});
  fixture.world().kill_aiv(1);
  fixture.world().start_aiv(1);
  fixture.run(seconds{4});
  EXPECT_THAT(fixture.operator_messages, HasSubstr("CoSiVA/AIV1 repeats run 1"));
  fixture.world().kill_aiv(1);
  fixture.run(seconds{8});
  ASSERT_THAT(fixture.runs().losses(), SizeIs(1));
  EXPECT_THAT(fixture.runs().losses()[0], HasSubstr("CoSiVA/AIV1: no response"));
  // The vehicle comes back, and does not block the other one, which drives its run by now.
  fixture.world().start_aiv(1);
  fixture.run(seconds{200});
  const auto runs = fixture.runs().take_runs();
  ASSERT_THAT(runs, SizeIs(2)) << fixture.operator_messages;
  for (const auto& run : runs) EXPECT_EQ(to_string(run->vehicle), "CoSiVA/AIV2");
}

TEST(LiveRuns, end_with_the_vehicle_s_own_message_where_no_vehicle_can_drive_them) {
  Fixture fixture{options_of({aiv(1)}, 2, 5.0, {"arc_kalman", "magic"})};
  fixture.run(seconds{30});
  EXPECT_TRUE(fixture.runs().done());
  ASSERT_THAT(fixture.runs().losses(), SizeIs(1));
  EXPECT_THAT(fixture.runs().losses()[0], AllOf(HasSubstr("magic"), HasSubstr("there are dead_reckoning")));
  EXPECT_THAT(fixture.runs().take_runs(), IsEmpty());
}

TEST(LiveRuns, need_a_source_of_actual_positions) {
  Fixture fixture{options_of({aiv(1)}, 1, 5.0, {"arc_kalman"})};
  fixture.deaf = [](std::string_view topic) { return topic == wire::ground_truth_topic; };
  fixture.run(seconds{30});
  ASSERT_THAT(fixture.runs().losses(), SizeIs(1));
  EXPECT_THAT(fixture.runs().losses()[0],
              HasSubstr("no actual position of the vehicle on cosiva/v1/plant/ground_truth"));
}

TEST(LiveRuns, use_the_detections_of_a_camera_over_the_zone_as_ground_truth) {
  LiveRunsOptions options = options_of({aiv(1)}, 1, 3.0, {"arc_kalman"});
  options.ground_truth_topic = "area/detections";
  Fixture fixture{std::move(options)};
  // As the GVS publishes: by name, and each vehicle with the time of its own rows.
  fixture.world().tap([&](SimTime at, const std::string&, const wire::Publish& message) {
    if (message.topic != wire::ground_truth_topic) return fixture.runs().on_message(at, message.topic, message.payload);
    const Pose2 ground_truth = fixture.world().plant().vehicles()[0].X_MB;
    JsonWriter json;
    json.begin_object().field("timestamp", "2000-01-01T00:00:00Z").key("detections").begin_array().begin_object();
    json.field("vehicle", "CoSiVA/AIV1")
        .field("at", to_iso8601(at))
        .field("x", ground_truth.x_m)
        .field("y", ground_truth.y_m);
    json.field("heading", ground_truth.heading_rad).end_object().end_array().end_object();
    fixture.runs().on_message(at, "area/detections", json.take());
  });
  fixture.run(seconds{30});
  const auto runs = fixture.runs().take_runs();
  ASSERT_THAT(runs, SizeIs(1)) << fixture.operator_messages;
  EXPECT_LT(evaluated({"arc_kalman"}, runs)->algorithms[0].rmse_m.value, 0.006);
}

TEST(LiveRuns, of_a_fleet_of_one_unknown_vehicle_end) {
  Fixture fixture{options_of({{"Other", "X9"}}, 1, 5.0, {"arc_kalman"})};
  fixture.run(seconds{30});
  ASSERT_THAT(fixture.runs().losses(), SizeIs(1));
  EXPECT_THAT(fixture.runs().losses()[0], HasSubstr("Other/X9: no response for 3 s"));
}

TEST(LiveRuns, that_are_ended_early_keep_complete_runs) {
  Fixture fixture{options_of({aiv(1)}, 5, 3.0, {"arc_kalman"})};
  fixture.run(seconds{12});
  const auto progress = fixture.runs().progress(fixture.world().now());
  EXPECT_GT(progress.complete, 0U);
  EXPECT_LT(progress.complete, 5U);
  ASSERT_TRUE(progress.left_s);
  EXPECT_NEAR(*progress.left_s, 12.0 * (1.0 - progress.ratio) / progress.ratio, 1.0);
  fixture.runs().give_up();
  EXPECT_TRUE(fixture.runs().done());
  EXPECT_THAT(fixture.runs().take_runs(), SizeIs(progress.complete));
}

TEST(TruePose, between_two_fixes_follows_the_bend_and_is_none_outside_of_them) {
  const auto on_circle = [](double t_s) {
    const double angle_rad = 0.5 * t_s / 0.6;  // 0.5 m/s along a radius of 0.6 m
    const SinCos at = sincos(angle_rad);
    return TrueFix{SimTime{from_seconds(t_s)}, {0.6 * at.sin, 0.6 - 0.6 * at.cos, angle_rad}};
  };
  const std::vector<TrueFix> fixes{on_circle(0.0), on_circle(0.1), on_circle(0.2), on_circle(1.2)};
  for (const double t_s : {0.03, 0.05, 0.1, 0.17}) {
    const auto pose = true_pose(fixes, SimTime{from_seconds(t_s)}, milliseconds{500});
    ASSERT_TRUE(pose);
    EXPECT_LT(distance(*pose, on_circle(t_s).X_MB), 1e-5) << t_s;
    EXPECT_NEAR(pose->heading_rad, on_circle(t_s).X_MB.heading_rad, 1e-9);
  }
  EXPECT_FALSE(true_pose(fixes, SimTime{from_seconds(0.7)}, milliseconds{500})) << "too long a gap";
  EXPECT_FALSE(true_pose(fixes, SimTime{from_seconds(1.3)}, milliseconds{500}));
  EXPECT_FALSE(true_pose({}, SimTime{}, milliseconds{500}));
}

TEST(LiveRun, reports_a_diverged_algorithm_and_keeps_the_results_of_the_others) {
  const auto zone = zone::Rtm::initialise(zone::testing::configuration_file("lacet4.toml"))->shared_zone();
  RunLog log{"run 1", aiv(1), 1, 500, 4};
  std::vector<TrueFix> ground_truth;
  wire::EstimateResponse response;
  response.map_id = "lacet4";
  response.start.emplace(wire::EstimateResponse::Start{});
  response.start->sensors.distance_variance_per_m = 1e-4;
  for (int i = 0; i < 40; ++i) {
    response.timestamp = SimTime{milliseconds{50 * i}};
    response.travelled_m = 0.02 * i;
    response.inputs.clear();
    if (i > 0) response.inputs.emplace_back(wire::EstimateResponse::Odometry{0.02, 0.0, 0.05});
    response.estimates = {{"good", "", {0.02 * i, 0.0, 0.0}, std::nullopt, std::nullopt, std::nullopt, {}},
                          {"bad",
                           i < 20 ? "" : "the estimate has diverged",
                           {0.0, 0.0, 0.0},
                           std::nullopt,
                           std::nullopt,
                           std::nullopt,
                           {}}};
    log.add(response);
    response.start.reset();
    ground_truth.push_back({response.timestamp, {0.02 * i, 0.003, 0.0}});
  }
  std::size_t without_ground_truth = 0;
  auto run = std::move(log).finish(zone, ground_truth, milliseconds{500}, without_ground_truth);
  ASSERT_TRUE(run) << to_string(run.error());
  const std::vector<std::shared_ptr<const LiveRun>> runs{std::make_shared<const LiveRun>(std::move(*run))};
  const auto all = evaluated({"good", "bad"}, runs);
  ASSERT_TRUE(all);
  EXPECT_NEAR(all->algorithms[0].rmse_m.value, 0.003, 1e-9);
  ASSERT_TRUE(all->algorithms[1].failed);
  EXPECT_THAT(all->algorithms[1].failed->message, HasSubstr("diverged"));
}

}  // namespace
}  // namespace cosiva::experiments
