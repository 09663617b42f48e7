#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/base/workers.h"
#include "cosiva/experiments/agents/fleet_run.h"
#include "cosiva/experiments/agents/rule_knots.h"

namespace cosiva::experiments {

/// A search for better numbers in a rule file. The training seeds must not be those of a later measurement.
struct SearchPlan {
  std::shared_ptr<const zone::Rtm> rtm;  ///< not null (checked)
  std::string fll;
  std::string origin;  ///< of `fll`, for errors
  std::vector<std::uint32_t> vehicles{12, 24};
  std::vector<std::uint32_t> persons{0};
  std::uint64_t first_seed{1};
  std::uint64_t last_seed{2};
  SimDuration duration{std::chrono::minutes{3}};
  std::vector<std::string> variables{};  ///< whose numbers are changed; empty: all (RuleKnots)
  std::uint64_t seed{1};                 ///< of the search's own draws
  std::uint32_t budget{40};              ///< number of candidates, without the initial rules
  std::uint32_t offspring{4};            ///< candidates per generation, > 0 (checked)
};

/// The means of a candidate's training runs, relative to the crisp rules' with the same seeds.
struct TrainingCase {
  std::uint32_t vehicles{};
  std::uint32_t persons{};
  double laps_ratio{};
  double stops_ratio{};
  double energy_ratio{};  ///< per lap
};

struct RuleCandidate {
  std::uint32_t number{};      ///< 0: the initial rules
  std::vector<double> values;  ///< of the knots
  double cost{};               ///< lower is better
  bool accepted{false};        ///< better than all before
  std::vector<TrainingCase> cases;
};

struct SearchResult {
  std::vector<RuleKnots::Knot> knots;
  std::vector<RuleCandidate> candidates;  ///< in the order of the search
  std::size_t best{};                     ///< of candidates
  std::string fll;                        ///< the best candidate's rules
  std::uint32_t refused{};                ///< candidates that were not run, because they lacked the properties
};

/// What a candidate costs: the mean over its cases of the ratio of stops, half of the ratio of energy per lap, and a
/// penalty of twenty times the laps that are missing to half a percent more than with the crisp rules.
[[nodiscard]] double cost_of(const std::vector<TrainingCase>& cases);

/// Whether the choice is never slower with more room, base, release, margin or priority, with a faster
/// leader or with less closing speed, and two
/// vehicles with the same view of a crossing never both go first; checked in drawn situations.
[[nodiscard]] bool has_properties(const aiv::AgentRules& rules);

/// An evolution strategy (1 + offspring): each generation changes some knots of the best rules by normal draws; the
/// step grows after a success, and shrinks otherwise. The same plan gives the same result on any number of threads.
/// @param progress  called with the numbers of candidates run and of all, and the lowest cost
/// Fails as run_fleet() and AgentRules::read(), and ("agents.search") where the rules have no number to change.
[[nodiscard]] Result<SearchResult> search_rules(
    const SearchPlan& plan, Workers& workers,
    const std::function<void(std::size_t, std::size_t, double)>& progress = {});

}  // namespace cosiva::experiments
