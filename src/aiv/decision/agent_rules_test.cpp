#include "cosiva/aiv/decision/agent_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::aiv {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
// As zones/lacet4.toml has them.
constexpr zone::SpeedProfiles profiles{{0.15, 0.3, 0.6}, {0.40, 0.5, 0.8}, {0.50, 0.8, 1.0}};

Situation free_path() {
  return {.speed_mps = 0.3,
          .obstacle_ahead_m = nothing,
          .end_of_base_m = 1.2,
          .crossing_ahead_m = nothing,
          .charge = 1.0,
          .imposed = std::nullopt};
}

AgentDecision decision(const Situation& situation) {
  return FuzzySpeedPolicy{AgentRules::built_in(), profiles}.decide(situation);
}
Profile choice(const Situation& situation) { return decision(situation).profile; }

/// Any situation of an agent.
Situation any_situation() {
  const auto number = [](double low, double high) { return low + (high - low) * 1e-4 * *rc::gen::inRange(0, 10'001); };
  Situation situation = free_path();
  situation.speed_mps = number(0.0, 0.5);
  if (*rc::gen::arbitrary<bool>()) situation.obstacle_ahead_m = number(0.0, 2.0);
  situation.end_of_base_m = number(-0.1, 3.0);
  if (*rc::gen::arbitrary<bool>()) situation.crossing_ahead_m = number(0.0, 3.0);
  situation.charge = number(0.0, 1.0);
  if (*rc::gen::arbitrary<bool>()) situation.closing_mps = number(-0.5, 0.5);
  if (*rc::gen::arbitrary<bool>()) situation.crossing_margin_s = number(-12.0, 12.0);
  situation.crossing_priority = number(-1.0, 1.0);
  if (*rc::gen::arbitrary<bool>()) situation.release_distance_m = situation.end_of_base_m;
  if (*rc::gen::arbitrary<bool>()) situation.passed_m = number(0.0, 2.0);
  if (*rc::gen::arbitrary<bool>()) situation.imposed = static_cast<Profile>(*rc::gen::inRange(0, 4));
  if (*rc::gen::arbitrary<bool>()) situation.present = static_cast<Profile>(*rc::gen::inRange(0, 4));
  return situation;
}

TEST(FuzzyChoice, is_medium_on_a_free_path) { EXPECT_EQ(choice(free_path()), Profile::medium); }

TEST(FuzzyChoice, an_AIV_close_behind_a_slower_one_slows_down) {
  Situation situation = free_path();
  situation.obstacle_ahead_m = 0.25;
  situation.closing_mps = 0.1;
  EXPECT_EQ(choice(situation), Profile::slow);
}

TEST(FuzzyChoice, an_AIV_close_behind_one_that_pulls_away_keeps_its_speed) {
  Situation situation = free_path();
  situation.obstacle_ahead_m = 0.25;
  situation.closing_mps = -0.2;
  EXPECT_EQ(choice(situation), Profile::medium);
}

TEST(FuzzyChoice, an_obstacle_of_unknown_motion_counts_as_stopped) {
  Situation situation = free_path();
  situation.obstacle_ahead_m = 0.25;
  EXPECT_EQ(choice(situation), Profile::slow);
}

TEST(FuzzyChoice, obeys_the_operator_where_no_concern_is_lower) {
  Situation situation = free_path();
  for (const Profile imposed : {Profile::stop, Profile::slow, Profile::medium, Profile::fast}) {
    situation.imposed = imposed;
    EXPECT_EQ(choice(situation), imposed);
  }
}

TEST(FuzzyChoice, does_not_hurry_into_a_vehicle_or_the_end_of_its_base_for_an_operator) {
  Situation situation = free_path();
  situation.imposed = Profile::fast;
  situation.obstacle_ahead_m = 0.2;
  EXPECT_EQ(choice(situation), Profile::slow);
  situation = free_path();
  situation.imposed = Profile::fast;
  situation.end_of_base_m = 0.15;
  EXPECT_EQ(choice(situation), Profile::medium);
}

TEST(FuzzyChoice, is_slow_with_a_low_battery) {
  Situation situation = free_path();
  situation.charge = 0.05;
  EXPECT_EQ(choice(situation), Profile::slow);
}

TEST(FuzzyChoice, stops_without_a_base_in_any_situation) {
  EXPECT_TRUE(rc::check([] {
    Situation situation = any_situation();
    situation.end_of_base_m = -0.01 * *rc::gen::inRange(0, 100);
    RC_ASSERT(choice(situation) == Profile::stop);
  }));
}

TEST(FuzzyChoice, is_never_faster_than_the_instruction) {
  EXPECT_TRUE(rc::check([] {
    Situation situation = any_situation();
    situation.imposed = static_cast<Profile>(*rc::gen::inRange(0, 4));
    RC_ASSERT(choice(situation) <= *situation.imposed);
  }));
}

TEST(FuzzyChoice, is_never_slower_with_more_room_in_front) {
  EXPECT_TRUE(rc::check([] {
    const Situation nearer = any_situation();
    Situation farther = nearer;
    farther.obstacle_ahead_m += 0.01 * *rc::gen::inRange(0, 300);
    // On a free path nothing closes in: that is more room as well.
    RC_ASSERT(choice(farther) >= choice(nearer));
  }));
}

TEST(FuzzyChoice, is_never_slower_with_more_is_never_slower_with_more_base_charge_time_or_priority_or_less_closing) {
  EXPECT_TRUE(rc::check([] {
    const Situation worse = any_situation();
    Situation better = worse;
    switch (*rc::gen::inRange(0, 5)) {
      case 0:
        better.end_of_base_m += 0.5;
        better.release_distance_m += 0.5;
        break;
      case 1: better.charge = std::fmin(1.0, better.charge + 0.1); break;
      case 2: better.crossing_margin_s += 1.0; break;
      case 3: better.crossing_priority += 0.5; break;
      default: better.closing_mps = worse.closing_mps.value_or(worse.speed_mps) - 0.1;
    }
    RC_ASSERT(choice(better) >= choice(worse));
    RC_ASSERT(decision(better).go >= decision(worse).go - 1e-12);
  }));
}

TEST(FuzzyChoice, without_an_instruction_a_rival_and_a_wait_for_release_is_never_slower_than_the_crisp_one) {
  EXPECT_TRUE(rc::check([] {
    Situation situation = any_situation();
    situation.imposed.reset();
    situation.crossing_margin_s = nothing;
    situation.release_distance_m = nothing;
    // From standstill, or continuing from the choice of the crisp policy.
    if (situation.present) situation.present = CrispSpeedPolicy{}.choose(situation);
    RC_ASSERT(choice(situation) >= CrispSpeedPolicy{}.choose(situation));
  }));
}

TEST(FuzzyChoice, creeps_up_to_the_end_of_its_base_where_more_is_announced) {
  const FuzzySpeedPolicy policy{AgentRules::built_in(), profiles};
  Situation situation = free_path();
  situation.present = Profile::medium;
  double before_mps = 0.15;
  for (const double left_m : {0.15, 0.10, 0.05, 0.01}) {
    situation.end_of_base_m = situation.release_distance_m = left_m;
    const SpeedChoice choice = policy.target(situation);
    EXPECT_EQ(choice.profile, Profile::slow) << left_m;
    EXPECT_LT(choice.ratio * profiles.slow.speed_mps, before_mps) << left_m;
    // Still moving by the definition of the article's state "stopped", 1 cm/s.
    EXPECT_GE(choice.ratio * profiles.slow.speed_mps, stopped_mps) << left_m;
    before_mps = choice.ratio * profiles.slow.speed_mps;
    situation.present = choice.profile;
  }
  situation.end_of_base_m = situation.release_distance_m = 0.0;
  EXPECT_EQ(policy.target(situation).profile, Profile::stop);
}

TEST(FuzzyChoice, does_not_creep_before_a_crossing_nor_where_its_order_ends) {
  const FuzzySpeedPolicy policy{AgentRules::built_in(), profiles};
  Situation situation = free_path();
  situation.end_of_base_m = 0.10;
  EXPECT_EQ(policy.target(situation).profile, Profile::medium);
  situation.release_distance_m = 0.10;
  EXPECT_EQ(policy.target(situation).profile, Profile::slow);
  Situation before_crossing{0.3, nothing, 0.10, 0.11, 1.0, std::nullopt};
  before_crossing.release_distance_m = 0.10;
  EXPECT_EQ(policy.target(before_crossing).profile, Profile::medium);
  EXPECT_EQ(policy.target(before_crossing).ratio, 1.0);
}

/// Within a queue: further from both crossings than its head and its tail, with a base up to the next slot.
Situation in_queue(double leader_mps, double crossing_m = nothing, double passed_m = nothing, double body_m = 0.60) {
  Situation situation{0.3, body_m, 0.40, crossing_m, 1.0, std::nullopt};
  situation.release_distance_m = situation.end_of_base_m;
  situation.closing_mps = situation.speed_mps - leader_mps;
  situation.passed_m = passed_m;
  situation.present = Profile::medium;
  return situation;
}

TEST(FuzzyChoice, within_a_queue_creeps_while_its_leader_is_slow_and_moves_up_when_that_drives_off) {
  const FuzzySpeedPolicy policy{AgentRules::built_in(), profiles};
  for (const double leader_mps : {0.0, 0.05}) {
    const SpeedChoice choice = policy.target(in_queue(leader_mps));
    EXPECT_EQ(choice.profile, Profile::slow) << leader_mps;
    EXPECT_LT(choice.ratio, 1.0) << leader_mps;
    // Faster than what counts as creeping in measurements: most of the time saved at standstill is driven.
    EXPECT_GE(choice.ratio * profiles.slow.speed_mps, 0.05) << leader_mps;
  }
  EXPECT_EQ(policy.target(in_queue(0.35)).profile, Profile::medium);
}

TEST(FuzzyChoice, at_the_head_and_the_tail_of_a_queue_does_not_creep) {
  const FuzzySpeedPolicy policy{AgentRules::built_in(), profiles};
  // From there on a crossing is requested (TrafficRules::request_within_m).
  EXPECT_EQ(policy.target(in_queue(0.0, 0.70)).profile, Profile::medium);
  // Up to there it takes room that a vehicle before the crossing needs (TrafficRules::room_m, and a length).
  EXPECT_EQ(policy.target(in_queue(0.0, nothing, 0.35)).profile, Profile::medium);
  EXPECT_EQ(policy.target(in_queue(0.0, 1.50, 1.00)).profile, Profile::slow);
}

TEST(FuzzyChoice, does_not_creep_without_a_leader_nor_with_more_base) {
  const FuzzySpeedPolicy policy{AgentRules::built_in(), profiles};
  EXPECT_EQ(policy.target(in_queue(0.0, nothing, nothing, nothing)).profile, Profile::medium);
  Situation room = in_queue(0.0);
  room.end_of_base_m = room.release_distance_m = 1.0;
  EXPECT_EQ(policy.target(room).profile, Profile::medium);
}

TEST(FuzzyChoice, does_not_creep_behind_a_body_that_no_vehicle_reports) {
  const FuzzySpeedPolicy policy{AgentRules::built_in(), profiles};
  Situation unreported = in_queue(0.0);
  unreported.closing_mps.reset();
  EXPECT_EQ(policy.target(unreported).profile, Profile::medium);
  EXPECT_EQ(policy.target(unreported).ratio, 1.0);
}

TEST(FuzzyChoice, approaches_a_body_that_does_not_move_slowly_as_early_as_the_crisp_policy) {
  // The crisp policy slows down at 0.35 m.
  Situation body{0.4, 0.345, nothing, nothing, 1.0, std::nullopt};
  body.present = Profile::medium;
  EXPECT_EQ(choice(body), Profile::slow);
  body.closing_mps = 0.3;  // it moves
  EXPECT_EQ(choice(body), Profile::medium);
  Situation further{0.4, 0.36, nothing, nothing, 1.0, std::nullopt};
  further.present = Profile::medium;
  EXPECT_EQ(choice(further), Profile::medium);
}

TEST(FuzzyChoice, does_not_change_its_choice_with_every_echo) {
  Situation situation = free_path();
  situation.obstacle_ahead_m = 0.28;  // between slow and medium
  situation.present = choice(situation);
  for (int i = 0; i < 100; ++i) {
    situation.obstacle_ahead_m = 0.28 + (i % 2 == 0 ? 0.02 : -0.02);
    EXPECT_EQ(choice(situation), *situation.present);
  }
}

TEST(FuzzyChoice, at_a_crossing_goes_with_ample_time_and_yields_when_late) {
  Situation situation = free_path();
  situation.crossing_ahead_m = 0.2;
  EXPECT_TRUE(decision(situation).goes());
  situation.crossing_margin_s = 5.0;
  EXPECT_TRUE(decision(situation).goes());
  situation.crossing_margin_s = -5.0;
  EXPECT_FALSE(decision(situation).goes());
  EXPECT_EQ(choice(situation), Profile::slow);
}

TEST(FuzzyChoice, at_a_crossing_lets_priority_decide_when_the_margin_is_small) {
  Situation situation = free_path();
  situation.crossing_ahead_m = 0.2;
  situation.crossing_margin_s = 0.0;
  situation.crossing_priority = 1.0;
  EXPECT_TRUE(decision(situation).goes());
  situation.crossing_priority = 0.0;
  EXPECT_FALSE(decision(situation).goes());
  situation.crossing_priority = -1.0;
  EXPECT_FALSE(decision(situation).goes());
}

TEST(FuzzyChoice, never_lets_two_vehicles_with_the_same_view_both_go_first) {
  EXPECT_TRUE(rc::check([] {
    Situation mine = free_path();
    mine.crossing_ahead_m = 0.01 * *rc::gen::inRange(0, 30);
    mine.crossing_margin_s = 0.01 * *rc::gen::inRange(-300, 301);
    mine.crossing_priority = *rc::gen::element(-1.0, 0.0, 1.0);
    Situation theirs = mine;
    theirs.crossing_margin_s = -mine.crossing_margin_s;
    theirs.crossing_priority = -mine.crossing_priority;
    RC_ASSERT(!(decision(mine).goes() && decision(theirs).goes()));
  }));
}

// ---- approach to a stopped body, and behind a slower one ----------------------------------------------------------

struct Drive {
  double distance_m{};
  int changes{};  ///< of profile
  double nearest_m{1e9};
};

/// 20 s towards a body that starts 3 m ahead and moves at `body_mps`, by the speed policy under the envelope's law.
Drive drive(const SpeedPolicy& speed_policy, double body_mps) {
  constexpr double dt_s = 0.02;
  Drive drive;
  double speed_mps = 0.0;
  double body_m = 3.0;
  std::optional<Profile> present;
  for (int i = 0; i < 1000; ++i) {
    Situation situation = free_path();
    situation.speed_mps = speed_mps;
    situation.obstacle_ahead_m = body_m - drive.distance_m;
    situation.closing_mps = speed_mps - body_mps;
    situation.present = present;
    const Profile profile = speed_policy.choose(situation);
    drive.changes += present && *present != profile ? 1 : 0;
    present = profile;
    const zone::SpeedProfile target_speed = kinematics(profiles, profile);
    const double wanted_mps = std::min(target_speed.speed_mps, stoppable_speed(situation.obstacle_ahead_m - clearance_m,
                                                                               target_speed.braking_mps2, 0.15));
    speed_mps = std::clamp(wanted_mps, speed_mps - 0.8 * dt_s, speed_mps + target_speed.acceleration_mps2 * dt_s);
    drive.distance_m += speed_mps * dt_s;
    body_m += body_mps * dt_s;
    drive.nearest_m = std::min(drive.nearest_m, body_m - drive.distance_m);
  }
  return drive;
}

TEST(FuzzyDrive, advances_as_far_as_the_crisp_policy_with_no_more_changes_of_profile) {
  const FuzzySpeedPolicy fuzzy{AgentRules::built_in(), profiles};
  for (const double body_mps : {0.0, 0.05, 0.1, 0.2, 0.3}) {
    const Drive own = drive(fuzzy, body_mps);
    const Drive crisp = drive(CrispSpeedPolicy{}, body_mps);
    EXPECT_GE(own.distance_m, crisp.distance_m - 1e-3) << body_mps;
    EXPECT_LE(own.changes, crisp.changes) << body_mps;
    EXPECT_GE(own.nearest_m, 0.5 * clearance_m) << body_mps;
  }
}

// ---- rule files ----------------------------------------------------------------------------------------------------

std::string fault(const std::string& fll) {
  const auto rules = AgentRules::read(fll, "my.fll");
  return rules ? "nothing" : to_string(rules.error());
}

TEST(AgentRules, that_are_built_in_equal_the_rule_file) {
  std::ostringstream text;
  text << std::ifstream(source_dir() + "/rules/agent.fll").rdbuf();
  EXPECT_EQ(built_in_rules_text(), text.str());
  EXPECT_EQ(fault(text.str()), "nothing");
}

TEST(AgentRules, may_omit_inputs) {
  const auto rules = AgentRules::read(
      "InputVariable: gap\n  range: 0 10\n  term: near Ramp 2 1\n  term: far Ramp 1 2\nOutputVariable: pace\n"
      "  default: 1\n  defuzzifier: WeightedAverage\n  term: slow Constant 1\n  term: fast Constant 3\nRuleBlock:\n"
      "  rule: if gap is near then pace is slow\n  rule: if gap is far then pace is fast\n",
      "my.fll");
  ASSERT_TRUE(rules) << to_string(rules.error());
  EXPECT_EQ((*rules)->decide(free_path_inputs()).profile, Profile::fast);
  EXPECT_TRUE((*rules)->decide(free_path_inputs()).goes());
  // Rules without the input `instruction` do not cancel an instruction.
  Situation situation = free_path();
  situation.imposed = Profile::slow;
  EXPECT_EQ(FuzzySpeedPolicy(*rules, profiles).choose(situation), Profile::slow);
}

TEST(AgentRules, with_an_unknown_variable_are_refused_with_its_line) {
  std::string text(built_in_rules_text());
  for (std::size_t at = 0; (at = text.find("charge", at)) != std::string::npos; at += 7) text.replace(at, 6, "voltage");
  EXPECT_THAT(fault(text), testing::MatchesRegex(
                               "my.fll:[0-9]+: an agent has no input 'voltage'; its inputs are instruction, gap.*"));
}

TEST(AgentRules, without_a_speed_output_or_without_a_default_are_refused) {
  const std::string head = "InputVariable: gap\n  range: 0 10\n  term: near Ramp 2 1\nOutputVariable: ";
  const std::string tail =
      "\n  defuzzifier: WeightedAverage\n  term: a Constant 1\nRuleBlock:\n  rule: if gap is near then ";
  EXPECT_EQ(fault(head + "go\n  default: 0" + tail + "go is a\n"),
            "my.fll:4: an output other than 'go' has to limit the speed");
  EXPECT_EQ(fault(head + "pace" + tail + "pace is a\n"),
            "my.fll:4: 'pace' needs a 'default': its value where no rule fires");
}

TEST(AgentInputs, are_distances_in_braking_distances_and_rates_in_percent) {
  // 0.4²/(2·0.8) + 0.4·0.15 = 0.16 m.
  EXPECT_NEAR(braking_distance_m(profiles), 0.16, 1e-12);
  Situation situation{.speed_mps = 0.3,
                      .obstacle_ahead_m = 0.28,
                      .end_of_base_m = 0.48,
                      .crossing_ahead_m = 0.8,
                      .charge = 0.25,
                      .imposed = Profile::slow,
                      .closing_mps = 0.1,
                      .crossing_margin_s = 2.5,
                      .crossing_priority = -1.0,
                      .release_distance_m = 0.32,
                      .passed_m = 0.16};
  const AgentInputs inputs = inputs_of(situation, profiles);
  const AgentInputs expected{1.0, 1.0, 25.0, 3.0, 5.0, 2.5, -1.0, 25.0, 2.0, 50.0, 1.0};
  for (std::size_t i = 0; i < agent_input_count; ++i) EXPECT_NEAR(inputs[i], expected[i], 1e-9) << i;
  situation.closing_mps.reset();
  situation.imposed.reset();
  EXPECT_NEAR(inputs_of(situation, profiles)[2], 75.0, 1e-9) << "an obstacle of unknown motion counts as stopped";
  EXPECT_EQ(inputs_of(situation, profiles)[0], 4.0);
  situation.obstacle_ahead_m = nothing;
  situation.closing_mps = 0.1;
  EXPECT_EQ(inputs_of(situation, profiles)[2], 0.0);
  EXPECT_EQ(free_path_inputs(), (AgentInputs{4.0, 10.0, 0.0, 10.0, 10.0, 10.0, 0.0, 100.0, 10.0, 100.0, 10.0}));
}

TEST(AgentInputs, have_names_and_units) {
  std::string names;
  for (std::size_t i = 0; i < agent_input_count; ++i) {
    const AgentInputInfo& one = metadata_of(static_cast<AgentInput>(i));
    names += std::string(one.name) + "/" + std::string(one.unit) + " ";
    EXPECT_FALSE(one.meaning.empty());
  }
  EXPECT_EQ(names,
            "instruction/ gap/braking distances closing/% of the medium speed base/braking distances "
            "crossing/braking distances margin/s priority/ charge/% release/braking distances "
            "leader/% of the medium speed passed/braking distances ");
}

TEST(AgentRules, decide_by_the_lowest_concern_and_yield_by_go) {
  const auto rules = AgentRules::read(
      "InputVariable: charge\n  range: 0 100\n  term: low Ramp 100 0\n  term: high Ramp 0 100\n"
      "InputVariable: gap\n  range: 0 10\n  term: near Ramp 10 0\n  term: far Ramp 0 10\n"
      "OutputVariable: go\n  default: 1\n  defuzzifier: WeightedAverage\n  term: no Constant 0\n  term: yes Constant "
      "1\n"
      "OutputVariable: room\n  default: 3\n  defuzzifier: WeightedAverage\n  term: none Constant 0\n"
      "  term: much Constant 3\n"
      "OutputVariable: energy\n  default: 3\n  defuzzifier: WeightedAverage\n  term: none Constant 0\n"
      "  term: much Constant 3\n"
      "RuleBlock:\n  rule: if gap is near then room is none\n  rule: if gap is far then room is much\n"
      "  rule: if charge is low then energy is none\n  rule: if charge is high then energy is much\n"
      "  rule: if gap is near then go is no\n  rule: if gap is far then go is yes\n",
      "my.fll");
  ASSERT_TRUE(rules) << to_string(rules.error());
  AgentInputs inputs = free_path_inputs();
  inputs[static_cast<std::size_t>(AgentInput::gap)] = 4.0;
  inputs[static_cast<std::size_t>(AgentInput::charge)] = 80.0;
  const AgentDecision by_gap = (*rules)->decide(inputs);
  EXPECT_NEAR(by_gap.speed, 1.2, 1e-9);
  EXPECT_EQ(by_gap.decided_by, 1U);
  EXPECT_NEAR(by_gap.go, 0.4, 1e-9);
  EXPECT_FALSE(by_gap.goes());
  EXPECT_EQ(by_gap.profile, Profile::slow);
  EXPECT_EQ((*rules)->decide(inputs, Profile::medium).profile, Profile::slow) << "0.8 away from the present one";
  inputs[static_cast<std::size_t>(AgentInput::charge)] = 20.0;
  const AgentDecision by_charge = (*rules)->decide(inputs);
  EXPECT_NEAR(by_charge.speed, 0.6, 1e-9);
  EXPECT_EQ(by_charge.decided_by, 2U);
  EXPECT_EQ((*rules)->decide(inputs, Profile::stop).profile, Profile::stop) << "0.6 away";
  const auto explained = (*rules)->explain(inputs);
  ASSERT_EQ(explained.inputs.size(), 2U);
  EXPECT_EQ(explained.inputs[0].value, 20.0);
  EXPECT_EQ(explained.inputs[1].value, 4.0);
  EXPECT_EQ((*rules)->decide(free_path_inputs()).decided_by, 1U) << "of equal concerns the first";
}

TEST(FuzzyChoice, stops_at_the_end_of_its_base_and_is_no_faster_than_instructed) {
  Situation situation = free_path();
  situation.end_of_base_m = 0.0;
  EXPECT_EQ(choice(situation), Profile::stop);
  situation.end_of_base_m = 100.0;
  situation.imposed = Profile::stop;
  EXPECT_EQ(choice(situation), Profile::stop);
}

TEST(SpeedRules, survive_a_json_round_trip) {
  for (const SpeedRules& rules : {SpeedRules{}, SpeedRules{SpeedRules::Kind::fuzzy, {}, {}},
                                  SpeedRules{SpeedRules::Kind::custom, "my.fll", std::string(built_in_rules_text())}}) {
    JsonWriter json;
    write_json(json, rules);
    const auto back = speed_rules_from_json(*JsonValue::parse(json.text()));
    ASSERT_TRUE(back) << to_string(back.error());
    EXPECT_EQ(*back, rules);
    EXPECT_TRUE(make_speed_policy(*back, profiles));
  }
  EXPECT_FALSE(speed_rules_from_json(*JsonValue::parse("\"vague\"")));
  EXPECT_THAT(to_string(speed_rules_from_json(*JsonValue::parse(R"({"origin":"x.fll","fll":"hello"})")).error()),
              testing::StartsWith("x.fll:1:1: "));
}

std::string written(const SpeedRules& rules) {
  JsonWriter json;
  write_json(json, rules);
  return std::string(json.text());
}

TEST(SpeedRules, are_a_word_or_an_object_with_origin_and_text) {
  EXPECT_EQ(written({}), "\"crisp\"");
  EXPECT_EQ(written({SpeedRules::Kind::fuzzy, {}, {}}), "\"fuzzy\"");
  EXPECT_EQ(written({SpeedRules::Kind::custom, "my.fll", "text"}), R"({"origin":"my.fll","fll":"text"})");
  JsonWriter json;
  json.begin_object().field("fll", built_in_rules_text()).end_object();
  const auto without_origin = speed_rules_from_json(*JsonValue::parse(json.text()));
  ASSERT_TRUE(without_origin);
  EXPECT_EQ(without_origin->kind, SpeedRules::Kind::custom);
  EXPECT_EQ(without_origin->origin, "rules");
}

TEST(SpeedRules, that_are_neither_are_refused) {
  for (const char* text : {"\"vague\"", "\"\"", "null", "7", "true", "[]", "{}", R"({"origin":"x"})", R"({"fll":7})"}) {
    const auto refused = speed_rules_from_json(*JsonValue::parse(text));
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error(),
              (Error{"options.rules", "expected 'crisp', 'fuzzy' or an object with origin and fll", "rules"}))
        << text;
  }
}

TEST(SpeedRules, make_the_policy_of_their_kind) {
  const auto is_fuzzy = [](const SpeedRules& rules) {
    const auto policy = make_speed_policy(rules, profiles);
    return dynamic_cast<const FuzzySpeedPolicy*>(policy->get()) != nullptr;
  };
  EXPECT_FALSE(is_fuzzy({}));
  EXPECT_TRUE(is_fuzzy({SpeedRules::Kind::fuzzy, {}, {}}));
  EXPECT_TRUE(is_fuzzy({SpeedRules::Kind::custom, "my.fll", std::string(built_in_rules_text())}));
  EXPECT_EQ(make_speed_policy({SpeedRules::Kind::custom, "x.fll", "hello"}, profiles).error().location.substr(0, 6),
            "x.fll:");
}

TEST(NearestProfile, keeps_the_present_one_within_seven_tenths) {
  struct Case {
    double speed;
    std::optional<Profile> present;
    Profile expected;
  };
  for (const Case& one : {Case{0.49, {}, Profile::stop},
                          {0.5, {}, Profile::slow},
                          {1.49, {}, Profile::slow},
                          {1.5, {}, Profile::medium},
                          {2.49, {}, Profile::medium},
                          {2.5, {}, Profile::fast},
                          {0.69, Profile::stop, Profile::stop},
                          {0.71, Profile::stop, Profile::slow},
                          {1.31, Profile::medium, Profile::medium},
                          {1.29, Profile::medium, Profile::slow},
                          {2.31, Profile::fast, Profile::fast}})
    EXPECT_EQ(nearest_profile(one.speed, one.present), one.expected) << one.speed;
}

}  // namespace
}  // namespace cosiva::aiv
