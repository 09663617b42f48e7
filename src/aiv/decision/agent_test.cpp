#include "cosiva/aiv/decision/agent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_senses.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::order;
using test::ranges_to;
using ::testing::ElementsAre;

/// An agent on wheels that obey its commands as the line-following board does, with exact odometry at 50 Hz.
struct AgentFixture {
  Agent agent{lacet4()};
  AivMotion ground_truth;
  double speed_mps{0.0};
  double travelled_m{0.0};
  double hardest_braking_mps2{0.0};
  double highest_speed_mps{0.0};
  std::vector<Point2> obstacles;
  std::vector<std::string> traversed;
  int tick{0};

  AgentFixture(std::string_view section, double s_m) : ground_truth{lacet4().circuit, at(lacet4(), section, s_m)} {
    agent.vehicle().estimator().position_at(ground_truth.track_position(lacet4().circuit));
    step();
  }

  AgentFixture& take(const wire::Order& text) {
    const auto verdict = agent.vehicle().take_order(text);
    EXPECT_TRUE(verdict) << verdict.error().message;
    return *this;
  }

  void step() {
    constexpr double dt = 0.02;
    const wire::Drive drive = agent.decide();
    const double wanted = 1e-3 * drive.speed_mmps;
    const double before = speed_mps;
    speed_mps = wanted > speed_mps ? std::min(wanted, speed_mps + 1e-3 * drive.acceleration_mmps2 * dt)
                                   : std::max(wanted, speed_mps - 1e-3 * drive.braking_mmps2 * dt);
    hardest_braking_mps2 = std::max(hardest_braking_mps2, (before - speed_mps) / dt);
    highest_speed_mps = std::max(highest_speed_mps, speed_mps);
    travelled_m += ground_truth.move(lacet4().circuit, 0.5 * (before + speed_mps) * dt);
    wire::Odometry odometry;
    odometry.distance_um = std::llround(travelled_m * 1e6);
    odometry.speed_mmps = static_cast<std::int16_t>(std::lround(speed_mps * 1e3));
    agent.on_odometry(odometry);
    if (++tick % 3 == 0) agent.vehicle().on_ranges(ranges_to(obstacles, ground_truth.pose(lacet4().circuit)));
    for (const auto& node : agent.vehicle().progress().take_traversed()) traversed.push_back(node.node_id);
  }

  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50.0); ++i) step();
  }
  bool run_until(const std::function<bool()>& done, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 50.0) && !done(); ++i) step();
    return done();
  }
  double s_m() const { return ground_truth.track_position(lacet4().circuit).s_m; }
};

constexpr double edge_m = 0.282743338823;
const auto to_565 = [] { return order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565"}); };

/// Chooses medium, and records the last choice that it is given.
class RecordingPolicy final : public SpeedPolicy {
 public:
  explicit RecordingPolicy(std::vector<std::optional<Profile>>& present) : present_{present} {}
  [[nodiscard]] SpeedChoice target(const Situation& situation) const override {
    present_.push_back(situation.present);
    return {Profile::medium};
  }

 private:
  std::vector<std::optional<Profile>>& present_;
};

TEST(Agent, gives_its_policy_the_last_choice_and_none_after_a_stop) {
  std::vector<std::optional<Profile>> present;
  Agent agent{lacet4(), std::make_unique<RecordingPolicy>(present)};
  agent.vehicle().estimator().position_at(at(lacet4(), "loop_se", 0.0));
  ASSERT_TRUE(agent.vehicle().take_order(to_565()));
  (void)agent.decide();
  (void)agent.decide();
  agent.vehicle().hold(Hold::paused, true);
  (void)agent.decide();
  agent.vehicle().hold(Hold::paused, false);
  (void)agent.decide();
  EXPECT_THAT(present, ElementsAre(std::nullopt, Profile::medium, std::nullopt));
}

TEST(Agent, does_not_drive_without_an_order) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.run(3.0);
  EXPECT_EQ(fixture.travelled_m, 0.0);
  EXPECT_TRUE(fixture.agent.vehicle().motion().stopped());
  EXPECT_EQ(fixture.agent.status(), Status::stopped);
}

TEST(Agent, follows_its_order_and_stops_on_the_last_node_of_its_base) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565().then({"loop_se@848"}));
  fixture.run(8.0);
  EXPECT_THAT(fixture.traversed, ElementsAre("loop_se@283", "loop_se@565"));
  EXPECT_TRUE(fixture.agent.vehicle().motion().stopped());
  EXPECT_NEAR(fixture.s_m(), 2.0 * edge_m, 0.01);
  EXPECT_NEAR(fixture.highest_speed_mps, lacet4().profiles.medium.speed_mps, 1e-9);
  EXPECT_LE(fixture.hardest_braking_mps2, lacet4().profiles.medium.braking_mps2 + 0.03) << "a smooth stop";
}

TEST(Agent, continues_without_a_stop_when_its_base_is_extended_in_time) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565().then({"loop_se@848"}));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.agent.decision().wants_base; }, 5.0));
  fixture.take(order("O-1", 1).from_sequence(4).through({"loop_se@565", "loop_se@848", "loop_se@1131"}));
  double slowest_mps = 1.0;
  ASSERT_TRUE(fixture.run_until(
      [&] {
        slowest_mps = std::min(slowest_mps, fixture.speed_mps);
        return fixture.traversed.size() == 3;
      },
      5.0));
  EXPECT_GT(slowest_mps, 0.25);
}

TEST(Agent, gives_the_motors_no_more_room_than_its_base) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565().then({"loop_se@848"}));
  int commanded = 0;
  for (int i = 0; i < 400; ++i) {
    const double to_end_m = 2.0 * edge_m - fixture.s_m();
    fixture.step();
    const wire::Drive& drive = fixture.agent.decision().drive;
    if (drive.speed_mmps == 0) continue;
    ++commanded;
    ASSERT_TRUE(drive.room_mm) << to_end_m;
    EXPECT_NEAR(*drive.room_mm, 1e3 * (to_end_m + stop_line_m), 10.0);
  }
  EXPECT_GT(commanded, 50);
}

TEST(Agent, requests_base_only_when_more_is_announced) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565());
  fixture.run(8.0);
  EXPECT_FALSE(fixture.agent.decision().wants_base);
}

TEST(Agent, is_stopped_during_any_hold_and_continues_by_itself) {
  for (const Hold reason : {Hold::paused, Hold::broker_lost, Hold::server_lost, Hold::board_lost, Hold::board_faulty}) {
    AgentFixture fixture{"loop_se", 0.0};
    fixture.take(order("O-1").through({"loop_se@0", "loop_se@565", "loop_se@1131", "loop_se@1696"}));
    fixture.run(1.0);
    EXPECT_GT(fixture.speed_mps, 0.2);
    fixture.agent.vehicle().hold(reason, true);
    fixture.run(1.0);
    EXPECT_EQ(fixture.speed_mps, 0.0) << to_string(reason);
    EXPECT_TRUE(fixture.agent.vehicle().order().active());
    fixture.agent.vehicle().hold(reason, false);
    fixture.run(1.0);
    EXPECT_GT(fixture.speed_mps, 0.2) << to_string(reason);
  }
}

TEST(Agent, stops_when_it_loses_the_line) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565());
  wire::Odometry lost;
  lost.line_lost = true;
  fixture.agent.on_odometry(lost);
  EXPECT_EQ(fixture.agent.decide().speed_mmps, 0);
}

TEST(Agent, without_a_known_position_does_not_drive_and_accepts_no_order) {
  Agent agent{lacet4()};
  EXPECT_EQ(agent.vehicle().take_order(to_565()).error().code, "noRouteError");
  EXPECT_EQ(agent.decide().speed_mmps, 0);
}

TEST(Agent, stops_before_an_obstacle_and_continues_when_it_is_removed) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1131"}));
  fixture.run(1.0);
  fixture.obstacles = {position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.9)))};
  fixture.run(4.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_TRUE(fixture.agent.decision().blocked);
  EXPECT_NEAR(0.9 - fixture.s_m() - 0.1, clearance_m, 0.03);
  EXPECT_LE(fixture.hardest_braking_mps2, lacet4().profiles.fast.braking_mps2 + 0.03);
  fixture.obstacles.clear();
  fixture.run(4.0);
  EXPECT_FALSE(fixture.agent.decision().blocked);
  EXPECT_NEAR(fixture.s_m(), 4.0 * edge_m, 0.01);
}

TEST(Agent, does_not_touch_an_obstacle_that_appears_half_a_metre_away_at_full_speed) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.agent.instructions().imposed = Profile::fast;
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1979"}));
  fixture.run(1.6);
  EXPECT_NEAR(fixture.speed_mps, 0.5, 0.01);
  const double obstacle_s_m = fixture.s_m() + 0.1 + 0.5;
  fixture.obstacles = {position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", obstacle_s_m)))};
  fixture.run(4.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_GT(obstacle_s_m - fixture.s_m() - 0.1, 0.08);
}

// --- virtual bodies -------------------------------------------------------------------------------------------------

TEST(Agent, stops_before_a_virtual_body_as_before_an_obstacle_and_continues_when_it_is_removed) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1131"}));
  fixture.run(1.0);
  const auto perceive = [&] { fixture.agent.perceive(0.9 - fixture.s_m() - 0.1); };
  for (int i = 0; i < 200; ++i) {
    perceive();
    fixture.step();
  }
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_TRUE(fixture.agent.decision().blocked);
  EXPECT_TRUE(fixture.agent.decision().braking_for_virtual);
  EXPECT_NEAR(0.9 - fixture.s_m() - 0.1, clearance_m, 0.02);
  EXPECT_LE(fixture.hardest_braking_mps2, lacet4().profiles.medium.braking_mps2 + 0.03) << "the body was known in time";
  fixture.agent.perceive(std::numeric_limits<double>::infinity());
  fixture.run(4.0);
  EXPECT_FALSE(fixture.agent.decision().blocked);
  EXPECT_FALSE(fixture.agent.decision().braking_for_virtual);
  EXPECT_NEAR(fixture.s_m(), 4.0 * edge_m, 0.01);
}

TEST(Agent, brakes_for_the_nearer_of_a_detected_and_a_virtual_body) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1131"}));
  fixture.obstacles = {position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.6)))};
  for (int i = 0; i < 250; ++i) {
    fixture.agent.perceive(0.9 - fixture.s_m() - 0.1);
    fixture.step();
    EXPECT_FALSE(fixture.agent.decision().braking_for_virtual && fixture.tick > 10) << fixture.tick;
  }
  EXPECT_NEAR(0.6 - fixture.s_m() - 0.1, clearance_m, 0.03) << "the obstacle";
  fixture.obstacles.clear();
  for (int i = 0; i < 250; ++i) {
    fixture.agent.perceive(0.9 - fixture.s_m() - 0.1);
    fixture.step();
  }
  EXPECT_NEAR(0.9 - fixture.s_m() - 0.1, clearance_m, 0.02) << "the virtual body";
  EXPECT_TRUE(fixture.agent.decision().braking_for_virtual);
}

TEST(Agent, does_not_brake_for_a_virtual_body_beyond_its_base_or_during_a_hold) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565());
  for (int i = 0; i < 400; ++i) {
    fixture.agent.perceive(1.1 - fixture.s_m() - 0.1);
    fixture.step();
    EXPECT_FALSE(fixture.agent.decision().braking_for_virtual) << fixture.s_m();
  }
  EXPECT_NEAR(fixture.s_m(), 2.0 * edge_m, 0.01);
  EXPECT_FALSE(fixture.agent.decision().blocked);

  AgentFixture paused{"loop_se", 0.0};
  paused.take(to_565());
  paused.agent.vehicle().hold(Hold::paused, true);
  paused.agent.perceive(0.0);
  paused.run(0.2);
  EXPECT_FALSE(paused.agent.decision().braking_for_virtual);
  paused.agent.vehicle().hold(Hold::paused, false);
  paused.run(0.2);
  EXPECT_TRUE(paused.agent.decision().braking_for_virtual);
  EXPECT_EQ(paused.travelled_m, 0.0);
}

TEST(Agent, does_not_stutter_behind_a_body_that_moves_back_and_forth_by_a_few_centimetres) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1131"}));
  int starts = 0;
  bool was_stopped = true;
  for (int i = 0; i < 1000; ++i) {
    const double sway_m = (i / 10) % 2 == 0 ? 0.015 : -0.015;
    fixture.agent.perceive(0.9 - fixture.s_m() - 0.1 + sway_m);
    fixture.step();
    starts += was_stopped && fixture.speed_mps > 0.0 ? 1 : 0;
    was_stopped = fixture.speed_mps == 0.0;
  }
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_LE(starts, 2);
}

TEST(Agent, drives_at_the_imposed_profile_and_no_faster_than_the_limit) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@2545"}));
  fixture.agent.instructions().imposed = Profile::slow;
  fixture.run(2.0);
  EXPECT_NEAR(fixture.speed_mps, 0.15, 1e-9);
  EXPECT_EQ(fixture.agent.status(), Status::slow_speed);
  fixture.agent.instructions().imposed = Profile::fast;
  fixture.run(1.5);
  EXPECT_NEAR(fixture.speed_mps, 0.5, 1e-9);
  EXPECT_EQ(fixture.agent.status(), Status::fast_speed);
  fixture.agent.instructions().speed_mps_max = 0.22;
  fixture.run(1.0);
  EXPECT_NEAR(fixture.speed_mps, 0.22, 1e-9);
}

TEST(Agent, stays_within_its_base_when_a_weaker_profile_is_imposed_at_speed) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.agent.instructions().imposed = Profile::fast;
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1131"}));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.agent.vehicle().order().distance_to_base_end_m() < 0.20; }, 5.0));
  fixture.agent.instructions().imposed = Profile::slow;
  fixture.run(3.0);
  EXPECT_LT(fixture.s_m(), 4.0 * edge_m + 0.01);
  EXPECT_GT(fixture.s_m(), 4.0 * edge_m - 0.01);
}

TEST(Agent, waits_at_the_stop_line_until_the_base_leads_through_the_crossing) {
  AgentFixture fixture{"east", 0.1};
  auto into = order("O-1").through({"east@0", "east@190", "centre"}).then({"east@1120"});
  into.node(2).position = wire::NodePosition{0.0, -0.15, {}, {}, {}, ""};
  fixture.take(into);
  fixture.run(5.0);
  EXPECT_TRUE(fixture.agent.vehicle().motion().stopped());
  EXPECT_LT(fixture.s_m(), 0.40);
  EXPECT_GT(fixture.s_m(), 0.37);
  EXPECT_LT(fixture.agent.decision().drive.room_mm, 20) << "the motors get no room beyond the line";
  fixture.take(order("O-1", 1).from_sequence(4).through({"centre", "east@1120"}));
  fixture.run(6.0);
  EXPECT_NEAR(fixture.s_m(), 1.12, 0.01);
}

TEST(Agent, cancelling_brakes_and_drops_the_order_at_standstill) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(order("O-1").through({"loop_se@0", "loop_se@1131"}));
  fixture.run(1.5);
  EXPECT_TRUE(fixture.agent.vehicle().progress().begin_cancel());
  EXPECT_TRUE(fixture.agent.vehicle().progress().cancelling());
  EXPECT_TRUE(fixture.agent.vehicle().order().active());
  EXPECT_EQ(fixture.agent.vehicle().take_order(order("O-2").through({"loop_se@283"})).error().code, "orderUpdateError");
  fixture.run(1.0);
  EXPECT_FALSE(fixture.agent.vehicle().progress().cancelling());
  EXPECT_FALSE(fixture.agent.vehicle().order().active());
  EXPECT_FALSE(fixture.agent.vehicle().progress().begin_cancel()) << "there is nothing to cancel any more";
}

TEST(Agent, tag_corrections_move_the_order_along) {
  AgentFixture fixture{"east", 1.30};
  fixture.take(order("O-1").through({"east@1310", "loop_se@0", "loop_se@283"}));
  const double before_m = fixture.agent.vehicle().order().distance_to_base_end_m();
  const auto fix = fixture.agent.vehicle().on_tag({0, 1, 0});
  ASSERT_EQ(fix.kind, FixKind::corrected);
  EXPECT_NEAR(fixture.agent.vehicle().order().distance_to_base_end_m(), before_m - fix.correction_m, 1e-12);
}

TEST(Agent, drops_an_order_that_a_tag_contradicts) {
  AgentFixture fixture{"east", 0.10};
  fixture.take(order("O-1").through({"east@0", "east@190", "east@380"}));
  fixture.agent.vehicle().on_tag({0, 7, 0});
  EXPECT_TRUE(fixture.agent.vehicle().progress().take_lost());
  EXPECT_FALSE(fixture.agent.vehicle().progress().take_lost());
  EXPECT_FALSE(fixture.agent.vehicle().order().active());
  EXPECT_EQ(fixture.agent.vehicle().position().track_position().section, 4U);
}

TEST(Agent, accepts_a_position_only_on_the_circuit_and_at_standstill_without_an_order) {
  AgentFixture fixture{"east", 0.10};
  EXPECT_EQ(fixture.agent.vehicle().initialise_position({5.0, 5.0, 0.0}, "").error().code, "position.off_circuit");
  EXPECT_TRUE(fixture.agent.vehicle().initialise_position({-0.5, -0.14, 0.05}, "dock"));
  EXPECT_NEAR(fixture.agent.vehicle().position().track_position().s_m, 0.25, 1e-9);
  EXPECT_EQ(fixture.agent.vehicle().order().last_node().node_id, "dock");
  fixture.take(order("O-1").through({"east@190", "east@380"}));
  EXPECT_EQ(fixture.agent.vehicle().initialise_position({-0.5, -0.14, 0.0}, "").error().code, "position.busy");
}

TEST(Agent, turns_as_the_circuit_does) {
  AgentFixture fixture{"loop_se", 0.0};
  fixture.take(to_565());
  fixture.run(1.0);
  EXPECT_NEAR(fixture.agent.vehicle().turn_rate_radps(), -fixture.agent.vehicle().motion().speed_mps() / 0.6, 1e-9);
}

/// Chooses medium, and records the situations.
class SituationPolicy final : public SpeedPolicy {
 public:
  explicit SituationPolicy(std::vector<Situation>& all) : all_{all} {}
  [[nodiscard]] SpeedChoice target(const Situation& situation) const override {
    all_.push_back(situation);
    return {Profile::medium};
  }

 private:
  std::vector<Situation>& all_;
};

/// An agent at standstill 0.1 m behind the start of the loop, with this order and a reading of its speed.
struct RestingAgent {
  std::vector<Situation> situations;
  Agent agent{lacet4(), std::make_unique<SituationPolicy>(situations)};

  explicit RestingAgent(const wire::Order& text, std::int16_t speed_mmps = 0, double s_m = 0.1) {
    agent.vehicle().estimator().position_at(at(lacet4(), "loop_se", s_m));
    wire::Odometry odometry;
    odometry.speed_mmps = speed_mmps;
    agent.on_odometry(odometry);
    agent.on_odometry(odometry);
    EXPECT_TRUE(agent.vehicle().take_order(text));
  }
  /// Of the next decision; the agent may also evaluate what it would do without virtual bodies.
  Situation situation() {
    situations.clear();
    static_cast<void>(agent.decide());
    return situations.front();
  }
};

TEST(Agent, gives_its_policy_the_whole_situation) {
  RestingAgent resting{order("O-1").through({"loop_se@0", "loop_se@1131"}), 200};
  resting.agent.on_charge(0.4);
  resting.agent.instructions().imposed = Profile::fast;
  resting.agent.perceive(0.5);
  for (const double off_m : {0.099, -0.099, 0.101, -0.101}) {
    // A vehicle that reports its pose is the perceived body up to 10 cm from it.
    resting.agent.heed(
        {.leader_gap_m = 0.5 + off_m, .leader_mps = 0.05, .crossing_margin_s = 1.5, .crossing_priority = -1.0});
    const Situation situation = resting.situation();
    EXPECT_EQ(situation.closing_mps.has_value(), std::fabs(off_m) < 0.1) << off_m;
    if (situation.closing_mps.has_value()) {
      EXPECT_NEAR(*situation.closing_mps, 0.15, 1e-12);
    }
    EXPECT_EQ(situation.crossing_margin_s, 1.5);
    EXPECT_EQ(situation.crossing_priority, -1.0);
  }
  resting.agent.perceive(std::numeric_limits<double>::infinity());
  const Situation situation = resting.situation();
  EXPECT_NEAR(situation.speed_mps, 0.2, 1e-12);
  EXPECT_EQ(situation.obstacle_ahead_m, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(situation.end_of_base_m, 4.0 * edge_m - 0.1, 1e-6);
  EXPECT_EQ(situation.charge, 0.4);
  EXPECT_EQ(situation.imposed, Profile::fast);
  EXPECT_EQ(situation.present, Profile::medium);
}

TEST(Agent, wants_base_30_centimetres_and_its_braking_distance_before_the_end) {
  // 0.4²/(2·0.8) = 0.1 m.
  for (const std::int16_t speed_mmps : {std::int16_t{0}, std::int16_t{400}}) {
    const double from_m = speed_mmps == 0 ? 0.30 : 0.40;
    for (const double more_m : {-0.001, 0.001}) {
      RestingAgent resting{order("O-1").through({"loop_se@0", "loop_se@565"}).then({"loop_se@848"}), speed_mmps,
                           2.0 * edge_m - from_m - more_m};
      static_cast<void>(resting.agent.decide());
      EXPECT_EQ(resting.agent.decision().wants_base, more_m < 0.0) << speed_mmps;
    }
  }
}

TEST(Agent, commands_the_kinematics_of_its_profile_in_thousandths) {
  RestingAgent resting{order("O-1").through({"loop_se@0", "loop_se@1131"})};
  const auto command = [&] {
    const wire::Drive drive = resting.agent.decide();
    EXPECT_FALSE(drive.seek);
    EXPECT_FALSE(drive.goal);
    return std::vector<int>{drive.speed_mmps, drive.acceleration_mmps2, drive.braking_mmps2, drive.branch};
  };
  EXPECT_THAT(command(), ElementsAre(400, 500, 800, 0));
  resting.agent.instructions().speed_mps_max = 0.1236;
  EXPECT_THAT(command(), ElementsAre(124, 500, 800, 0));
  resting.agent.vehicle().hold(Hold::paused, true);
  EXPECT_THAT(command(), ElementsAre(0, 500, 800, 0));
  EXPECT_FALSE(resting.agent.decision().profile);
}

TEST(Agent, that_stopped_for_an_obstacle_continues_with_five_centimetres_more) {
  RestingAgent resting{order("O-1").through({"loop_se@0", "loop_se@1131"})};
  const auto speed_mmps = [&](double gap_m) {
    resting.agent.perceive(gap_m);
    return resting.agent.decide().speed_mmps;
  };
  EXPECT_GT(speed_mmps(0.14), 0) << "2 cm beyond the clearance, before any stop";
  EXPECT_EQ(speed_mmps(0.12), 0);
  EXPECT_TRUE(resting.agent.decision().blocked);
  EXPECT_TRUE(resting.agent.decision().braking_for_virtual);
  EXPECT_EQ(speed_mmps(0.169), 0);
  EXPECT_GT(speed_mmps(0.171), 0);
  EXPECT_FALSE(resting.agent.decision().blocked);
  EXPECT_GT(speed_mmps(0.14), 0);
}

TEST(Agent, reports_braking_for_a_virtual_body_from_a_centimetre_per_second_on_to_two_millimetres) {
  RestingAgent resting{order("O-1").through({"loop_se@0", "loop_se@1131"})};
  // The gap at which the medium profile's 0.4 m/s is limited to that much less: d = v·0.15 s + v²/(2·0.8).
  const auto braking = [&](double less_mps) {
    const double v = 0.4 - less_mps;
    resting.agent.perceive(clearance_m + 0.15 * v + v * v / 1.6);
    static_cast<void>(resting.agent.decide());
    return resting.agent.decision().braking_for_virtual;
  };
  EXPECT_FALSE(braking(0.0095));
  EXPECT_TRUE(braking(0.0105));
  EXPECT_TRUE(braking(0.0025));
  EXPECT_FALSE(braking(0.0015));
  EXPECT_FALSE(braking(0.0095));
}

TEST(Agent, backs_up_slowly_and_not_during_a_hold) {
  Agent agent{lacet4()};
  agent.vehicle().estimator().position_at(at(lacet4(), "loop_se", 1.0));
  agent.on_odometry({});
  ASSERT_TRUE(agent.vehicle().begin_back_up(0.4));
  agent.perceive(0.0);
  wire::Drive drive = agent.decide();
  EXPECT_EQ(drive.speed_mmps, -100);
  EXPECT_EQ(drive.acceleration_mmps2, 300);
  EXPECT_EQ(drive.braking_mmps2, 600);
  EXPECT_FALSE(drive.seek);
  EXPECT_FALSE(agent.decision().blocked);
  EXPECT_FALSE(agent.decision().braking_for_virtual);
  EXPECT_FALSE(agent.decision().wants_base);
  agent.instructions().speed_mps_max = 0.05;
  EXPECT_EQ(agent.decide().speed_mmps, -50);
  agent.vehicle().hold(Hold::paused, true);
  EXPECT_EQ(agent.decide().speed_mmps, 0);
}

TEST(Agent, in_another_zone_keeps_its_charge_and_its_instructions) {
  Agent before{lacet4()};
  before.on_charge(0.3);
  before.instructions().imposed = Profile::slow;
  Agent after{lacet4()};
  after.take_over(before);
  EXPECT_EQ(after.charge(), 0.3);
  EXPECT_EQ(after.instructions().imposed, Profile::slow);
}

}  // namespace
}  // namespace cosiva::aiv
