#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/result.h"
#include "cosiva/fuzzy/explain.h"
#include "cosiva/fuzzy/rule_base.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The inputs of an agent's rules. rules/agent.fll and docs/guide/agents.md define their numbers.
enum class AgentInput { instruction, gap, closing, base, crossing, margin, priority, charge, release, leader, passed };
inline constexpr std::size_t agent_input_count = 11;
struct AgentInputInfo {
  std::string_view name;     ///< in the rules
  std::string_view unit;     ///< of the rules' number; empty: none
  std::string_view meaning;  ///< for people
  double free;               ///< value on a free path, and where the input is not known
};
[[nodiscard]] const AgentInputInfo& metadata_of(AgentInput input);

/// One number per AgentInput, in the unit of the rules.
using AgentInputs = std::array<double, agent_input_count>;
/// A free path, fully charged, no instruction, no other vehicle near.
[[nodiscard]] AgentInputs free_path_inputs();
/// The inputs of the rules in this situation. Distances count in braking distances of the medium profile, a unit that
/// does not change with the choice.
[[nodiscard]] AgentInputs inputs_of(const Situation& situation, const zone::SpeedProfiles& profiles);
/// The distance in which the medium profile stops, reaction included [m].
[[nodiscard]] double braking_distance_m(const zone::SpeedProfiles& profiles);

struct AgentDecision {
  Profile profile;                        ///< stop only where a concern's speed is 0: above, a part of the slow speed
  double speed;                           ///< 0 stop … 3 fast, before rounding: the lowest concern's
  std::optional<std::size_t> decided_by;  ///< that concern, an output of the rules
  double go;                              ///< the rules' output for the next crossing, 0 yield … 1 go
  [[nodiscard]] bool goes() const { return go > 0.5; }
};

/// Fuzzy rules that an agent can decide by (A10): each output but `go` is a concern with an upper limit of the speed;
/// the lowest limit decides. Immutable; any number of agents may use the same rules.
class AgentRules {
 public:
  /// Fails as fuzzy::RuleBase::read, and ("rules.agent") with file and line on a variable that is no AgentInput, on an
  /// output without a finite default, and where no output limits the speed.
  [[nodiscard]] static Result<std::shared_ptr<const AgentRules>> read(std::string_view fll, std::string_view origin);
  /// The rules that come with the platform.
  [[nodiscard]] static std::shared_ptr<const AgentRules> built_in();

  /// @param present  the present profile, which is left only where another profile is clearly meant, so that a result
  ///                 on the border of two profiles does not alternate with every echo. Nothing: the nearest profile
  [[nodiscard]] AgentDecision decide(const AgentInputs& inputs, std::optional<Profile> present = std::nullopt) const;
  [[nodiscard]] fuzzy::Explanation explain(const AgentInputs& inputs) const;

  [[nodiscard]] const fuzzy::RuleBase& base() const { return base_; }
  /// The rule base's inputs, in its order.
  [[nodiscard]] std::span<const AgentInput> inputs() const { return inputs_; }
  /// The output that decides whether to go first, and is no concern; nothing: there is none.
  [[nodiscard]] std::optional<std::size_t> go() const { return go_; }

 private:
  AgentRules(fuzzy::RuleBase base, std::vector<AgentInput> inputs, std::optional<std::size_t> go)
      : base_{std::move(base)}, inputs_{std::move(inputs)}, go_{go} {}

  fuzzy::RuleBase base_;
  std::vector<AgentInput> inputs_;
  std::optional<std::size_t> go_;
};

/// The profile nearest to a speed of 0 (stop) to 3 (fast); the present one stays within 0.7 of it.
[[nodiscard]] Profile nearest_profile(double speed, std::optional<Profile> present);

/// rules/agent.fll.
[[nodiscard]] std::string_view built_in_rules_text();

/// Chooses by fuzzy rules. Two limits are crisp: at the end of its base the vehicle stops, and it is never faster than
/// the operator's instruction.
class FuzzySpeedPolicy final : public SpeedPolicy {
 public:
  FuzzySpeedPolicy(std::shared_ptr<const AgentRules> rules, const zone::SpeedProfiles& profiles);

  [[nodiscard]] SpeedChoice target(const Situation& situation) const override;
  /// The same, with the rules' output for the next crossing.
  [[nodiscard]] AgentDecision decide(const Situation& situation) const;

 private:
  std::shared_ptr<const AgentRules> rules_;
  zone::SpeedProfiles profiles_;
};

}  // namespace cosiva::aiv
