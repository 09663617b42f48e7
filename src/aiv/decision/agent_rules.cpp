#include "cosiva/aiv/decision/agent_rules.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Without a body nothing keeps the vehicle back.
constexpr double no_leader = 100.0;
/// No vehicle reports the body: it counts as stationary, and not as the leader in a queue.
constexpr double unreported_leader = -100.0;

constexpr std::array<AgentInputInfo, agent_input_count> all_metadata{{
    {"instruction", "", "the operator's instruction: 0 stop, 1 slow, 2 medium, 3 fast, 4 none", no_instruction},
    {"gap", "braking distances", "free distance up to the stopping point before the next body", 10.0},
    {"closing", "% of the medium speed", "rate at which that distance shrinks; below 0 it grows", 0.0},
    {"base", "braking distances", "distance to the end of the base", 10.0},
    {"crossing", "braking distances", "distance to the next crossing that the vehicle may not enter yet", 10.0},
    {"margin", "s", "time by which the vehicle is at that crossing before the other vehicle", 10.0},
    {"priority", "", "own priority against the other vehicle's: -1 lower, 0 the same, 1 higher", 0.0},
    {"charge", "%", "state of charge of the battery", 100.0},
    {"release", "braking distances", "distance to the end of the base, if more of the order is announced", 10.0},
    {"leader", "% of the medium speed", "speed of the next body, -100 if no vehicle reports it", no_leader},
    {"passed", "braking distances", "distance from the exit of the last crossing", 10.0},
}};
constexpr std::string_view go_name = "go";
/// The slowest speed of a vehicle that is not to stop, relative to the slow profile: slower than that, standstill
/// saves energy.
constexpr double creep_ratio_min = 0.2;

std::optional<AgentInput> parse_input(std::string_view name) {
  for (std::size_t i = 0; i < agent_input_count; ++i) {
    if (all_metadata[i].name == name) return static_cast<AgentInput>(i);
  }
  return std::nullopt;
}

tl::unexpected<Error> refuse(std::string_view origin, const fuzzy::Variable& variable, std::string message) {
  return fail("rules.agent", std::move(message), std::string(origin) + ":" + std::to_string(variable.line));
}

Result<std::vector<AgentInput>> known_inputs(const fuzzy::Engine& engine, std::string_view origin) {
  std::vector<AgentInput> inputs;
  for (const fuzzy::Variable& variable : engine.inputs) {
    const auto input = parse_input(variable.name);
    if (!input) {
      std::string names;
      for (const AgentInputInfo& metadata : all_metadata)
        names += (names.empty() ? "" : ", ") + std::string(metadata.name);
      return refuse(origin, variable, "an agent has no input '" + variable.name + "'; its inputs are " + names);
    }
    inputs.push_back(*input);
  }
  return inputs;
}

}  // namespace

const AgentInputInfo& metadata_of(AgentInput input) { return all_metadata[static_cast<std::size_t>(input)]; }

AgentInputs free_path_inputs() {
  AgentInputs inputs{};
  for (std::size_t i = 0; i < agent_input_count; ++i) inputs[i] = all_metadata[i].free;
  return inputs;
}

double braking_distance_m(const zone::SpeedProfiles& profiles) {
  const zone::SpeedProfile& medium = profiles.medium;
  return medium.speed_mps * medium.speed_mps / (2.0 * medium.braking_mps2) + medium.speed_mps * obstacle_reaction_s;
}

AgentInputs inputs_of(const Situation& situation, const zone::SpeedProfiles& profiles) {
  const double braking_m = braking_distance_m(profiles);
  // Without an obstacle there is no closing speed; an obstacle of unknown motion counts as stopped.
  const bool is_free = std::isinf(situation.obstacle_ahead_m);
  const double closing_mps = is_free ? 0.0 : situation.closing_mps.value_or(situation.speed_mps);
  return {situation.imposed ? static_cast<double>(*situation.imposed) : no_instruction,
          plain::gap_input(situation.obstacle_ahead_m, braking_m),
          plain::closing_input(closing_mps, profiles.medium.speed_mps),
          plain::path_input(situation.end_of_base_m, braking_m),
          plain::path_input(situation.crossing_ahead_m, braking_m),
          situation.crossing_margin_s,
          situation.crossing_priority,
          100.0 * situation.charge,
          plain::path_input(situation.release_distance_m, braking_m),
          is_free                 ? no_leader
          : situation.closing_mps ? plain::closing_input(situation.speed_mps - closing_mps, profiles.medium.speed_mps)
                                  : unreported_leader,
          plain::path_input(situation.passed_m, braking_m)};
}

Profile nearest_profile(double speed, std::optional<Profile> present) {
  const double chosen = plain::nearest_profile(speed, present ? static_cast<double>(*present) : -1.0);
  return static_cast<Profile>(static_cast<int>(chosen));
}

Result<std::shared_ptr<const AgentRules>> AgentRules::read(std::string_view fll, std::string_view origin) {
  auto base = fuzzy::RuleBase::read(fll, origin);
  if (!base) return tl::unexpected(base.error());
  auto inputs = known_inputs(base->engine(), origin);
  if (!inputs) return tl::unexpected(inputs.error());
  for (const fuzzy::Variable& output : base->engine().outputs) {
    if (!std::isfinite(output.otherwise))
      return refuse(origin, output, "'" + output.name + "' needs a 'default': its value where no rule fires");
  }
  const auto go = base->find_output(go_name);
  if (base->engine().outputs.size() == (go ? 1U : 0U))
    return refuse(origin, base->engine().outputs.front(), "an output other than 'go' has to limit the speed");
  return std::shared_ptr<const AgentRules>(new AgentRules{std::move(*base), std::move(*inputs), go});
}

std::shared_ptr<const AgentRules> AgentRules::built_in() {
  static const std::shared_ptr<const AgentRules> rules = [] {
    auto read = AgentRules::read(built_in_rules_text(), "rules/agent.fll");
    COSIVA_EXPECT(read);  // also read by a test
    return *read;
  }();
  return rules;
}

AgentDecision AgentRules::decide(const AgentInputs& inputs, std::optional<Profile> present) const {
  // An agent has eleven inputs, each of them once; FLL has at most 64 variables.
  std::array<double, agent_input_count> question{};
  for (std::size_t i = 0; i < inputs_.size(); ++i) question[i] = inputs[static_cast<std::size_t>(inputs_[i])];
  std::array<double, 64> responses{};
  const std::size_t outputs = base_.engine().outputs.size();
  base_.evaluate(std::span(question).first(inputs_.size()), std::span(responses).first(outputs));

  AgentDecision decision{Profile::stop, std::numeric_limits<double>::infinity(), std::nullopt, 1.0};
  for (std::size_t o = 0; o < outputs; ++o) {
    if (o == go_) {
      decision.go = responses[o];
    } else if (responses[o] < decision.speed) {
      decision.speed = responses[o];
      decision.decided_by = o;
    }
  }
  decision.profile = nearest_profile(decision.speed, present);
  // Only a concern of 0 stops a vehicle that drives; less than slow is a part of the slow speed (SpeedChoice).
  if (decision.profile == Profile::stop && decision.speed > 0.0 && present != Profile::stop)
    decision.profile = Profile::slow;
  return decision;
}

fuzzy::Explanation AgentRules::explain(const AgentInputs& inputs) const {
  std::vector<double> question;
  question.reserve(inputs_.size());
  for (const AgentInput input : inputs_) question.push_back(inputs[static_cast<std::size_t>(input)]);
  return base_.explain(question);
}

FuzzySpeedPolicy::FuzzySpeedPolicy(std::shared_ptr<const AgentRules> rules, const zone::SpeedProfiles& profiles)
    : rules_{std::move(rules)}, profiles_{profiles} {}

SpeedChoice FuzzySpeedPolicy::target(const Situation& situation) const {
  const AgentDecision decision = decide(situation);
  if (decision.profile != Profile::slow) return {decision.profile};
  return {decision.profile, std::clamp(decision.speed, creep_ratio_min, 1.0)};
}

AgentDecision FuzzySpeedPolicy::decide(const Situation& situation) const {
  AgentDecision decision = rules_->decide(inputs_of(situation, profiles_), situation.present);
  if (situation.end_of_base_m <= 0.0) decision.profile = Profile::stop;
  if (situation.imposed) decision.profile = std::min(decision.profile, *situation.imposed);
  return decision;
}

}  // namespace cosiva::aiv
