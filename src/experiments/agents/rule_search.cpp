#include "cosiva/experiments/agents/rule_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/random.h"

namespace cosiva::experiments {
namespace {

/// Laps are sought that exceed those of the crisp rules by this much: training is not the measurement.
constexpr double laps_margin = 0.005;
constexpr double laps_weight = 20.0;
constexpr double energy_weight = 0.5;
/// So near to a crossing, in braking distances, the rules must have decided which of two vehicles goes first.
constexpr double decided_within = 1.9;
/// Candidates that are drawn for one that has the properties.
constexpr std::uint32_t draws_max = 20;

double& at(aiv::AgentInputs& inputs, aiv::AgentInput input) { return inputs[static_cast<std::size_t>(input)]; }

aiv::AgentInputs drawn_inputs(Random& random) {
  using enum aiv::AgentInput;
  aiv::AgentInputs inputs = aiv::free_path_inputs();
  // Without an instruction the medium speed hides what is faster.
  if (random.chance(0.5)) at(inputs, instruction) = static_cast<double>(aiv::Profile::fast);
  if (random.chance(0.7)) at(inputs, gap) = random.uniform(-0.5, 6.0);
  at(inputs, closing) = random.uniform(-100.0, 100.0);
  if (random.chance(0.7)) at(inputs, base) = random.uniform(0.0, 8.0);
  if (random.chance(0.7)) at(inputs, crossing) = random.uniform(0.0, 8.0);
  if (random.chance(0.7)) at(inputs, margin) = random.uniform(-6.0, 6.0);
  at(inputs, priority) = random.uniform(-1.0, 1.0);
  at(inputs, charge) = random.uniform(0.0, 100.0);
  if (random.chance(0.5)) at(inputs, release) = random.uniform(0.0, 6.0);
  if (random.chance(0.7)) at(inputs, leader) = random.uniform(-20.0, 100.0);
  if (random.chance(0.5)) at(inputs, passed) = random.uniform(0.0, 8.0);
  return inputs;
}

/// One input a little better for the vehicle than in `inputs`.
aiv::AgentInputs bettered(aiv::AgentInputs inputs, Random& random) {
  using enum aiv::AgentInput;
  switch (random.below(8)) {
    case 0: at(inputs, gap) += random.uniform(0.0, 2.0); break;
    case 1: at(inputs, base) += random.uniform(0.0, 2.0); break;
    case 2: at(inputs, margin) += random.uniform(0.0, 2.0); break;
    case 3: at(inputs, priority) = std::min(1.0, at(inputs, priority) + random.uniform(0.0, 1.0)); break;
    case 4: at(inputs, charge) = std::min(100.0, at(inputs, charge) + random.uniform(0.0, 10.0)); break;
    case 5: at(inputs, release) += random.uniform(0.0, 2.0); break;
    case 6: at(inputs, leader) += random.uniform(0.0, 30.0); break;
    default: at(inputs, closing) -= random.uniform(0.0, 50.0);
  }
  return inputs;
}

bool both_go(const aiv::AgentRules& rules, aiv::AgentInputs inputs) {
  using enum aiv::AgentInput;
  const bool one = rules.decide(inputs).goes();
  at(inputs, margin) = -at(inputs, margin);
  at(inputs, priority) = -at(inputs, priority);
  return one && rules.decide(inputs).goes();
}

/// The training runs of a list of rules.
///
/// Invariant: for each case there are the crisp runs of all training seeds.
class Training {
 public:
  Training(const SearchPlan& plan, Workers& workers) : plan_{plan}, workers_{workers} {}

  /// Fails as run_fleet().
  [[nodiscard]] Result<void> run_crisp() {
    auto runs = run({aiv::SpeedRules{}});
    if (!runs) return tl::unexpected<Error>(runs.error());
    crisp_ = std::move(runs->front());
    return {};
  }

  /// The cases of each text. Fails as run_fleet().
  [[nodiscard]] Result<std::vector<std::vector<TrainingCase>>> evaluate(const std::vector<std::string>& texts) {
    std::vector<aiv::SpeedRules> all;
    all.reserve(texts.size());
    for (const std::string& text : texts) all.push_back({aiv::SpeedRules::Kind::custom, plan_.origin, text});
    const auto runs = run(all);
    if (!runs) return tl::unexpected<Error>(runs.error());
    std::vector<std::vector<TrainingCase>> cases;
    for (const auto& of_rules : *runs) {
      cases.emplace_back();
      COSIVA_EXPECT(of_rules.size() == crisp_.size());
      for (std::size_t c = 0; c < of_rules.size(); ++c) cases.back().push_back(compared(of_rules[c], crisp_[c]));
    }
    return cases;
  }

 private:
  /// The sums over the seeds of a case.
  struct Sum {
    std::uint32_t vehicles{};
    std::uint32_t persons{};
    double laps{};
    double stops{};
    double energy_kj{};
  };

  static TrainingCase compared(const Sum& rules, const Sum& crisp) {
    // Few stops of a small fleet are chance: one for each vehicle is added to both sides.
    const double slack = rules.vehicles;
    const double energy = rules.energy_kj / std::max(rules.laps, 1e-3) / (crisp.energy_kj / std::max(crisp.laps, 1e-3));
    return {rules.vehicles, rules.persons, rules.laps / std::max(crisp.laps, 1e-3),
            (rules.stops + slack) / (crisp.stops + slack), energy};
  }

  [[nodiscard]] Result<std::vector<std::vector<Sum>>> run(const std::vector<aiv::SpeedRules>& rules) {
    std::vector<FleetRunOptions> all;
    for (const aiv::SpeedRules& one : rules)
      for (const std::uint32_t persons : plan_.persons)
        for (const std::uint32_t vehicles : plan_.vehicles)
          for (std::uint64_t seed = plan_.first_seed; seed <= plan_.last_seed; ++seed)
            all.push_back({plan_.rtm, one, vehicles, persons, seed, plan_.duration});
    std::vector<Result<FleetRun>> runs(all.size());
    workers_.for_each(all.size(), [&](std::size_t i) { runs[i] = run_fleet(all[i]); });
    const std::size_t cases = plan_.persons.size() * plan_.vehicles.size();
    const std::size_t seeds = plan_.last_seed - plan_.first_seed + 1;
    std::vector<std::vector<Sum>> sums(rules.size(), std::vector<Sum>(cases));
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (!runs[i]) return tl::unexpected<Error>(runs[i].error());
      Sum& sum = sums[i / seeds / cases][i / seeds % cases];
      sum.vehicles = all[i].vehicles;
      sum.persons = all[i].persons;
      sum.laps += runs[i]->laps;
      sum.stops += static_cast<double>(runs[i]->stops);
      sum.energy_kj += runs[i]->energy_kj;
    }
    return sums;
  }

  const SearchPlan& plan_;
  Workers& workers_;
  std::vector<Sum> crisp_;
};

/// Draws candidates around the best one.
///
/// Invariant: there is a scale for each knot; what draw() returns has the properties.
class Mutation {
 public:
  Mutation(const RuleKnots& knots, const SearchPlan& plan) : knots_{knots}, plan_{plan}, random_{plan.seed, "search"} {
    // The step of a knot is a part of the spread of its variable's knots.
    for (const RuleKnots::Knot& knot : knots_.knots()) {
      double low = knot.value;
      double high = knot.value;
      for (const RuleKnots::Knot& other : knots_.knots()) {
        if (other.variable != knot.variable) continue;
        low = std::min(low, other.value);
        high = std::max(high, other.value);
      }
      scales_.push_back(std::max(high - low, 0.1 * (knot.high - knot.low)));
    }
  }

  /// Nothing: none of many draws has the properties, or differs.
  [[nodiscard]] std::optional<std::vector<double>> draw(const std::vector<double>& best) {
    COSIVA_EXPECT(best.size() == scales_.size());
    for (std::uint32_t i = 0; i < draws_max; ++i) {
      std::vector<double> values = best;
      // A few knots at a time: most have no effect on this zone, and a change of all hides what helped.
      const double chance = std::min(1.0, 2.0 / static_cast<double>(values.size()));
      for (std::size_t k = 0; k < values.size(); ++k)
        if (random_.chance(chance)) values[k] += step_ * scales_[k] * random_.gaussian(0.0, 1.0);
      values = knots_.repaired(std::move(values));
      if (values == best) continue;
      const auto rules = aiv::AgentRules::read(knots_.text_with(values), plan_.origin);
      if (rules && has_properties(**rules)) return values;
      ++refused_;
    }
    return std::nullopt;
  }
  void adapt(bool success) { step_ = std::clamp(step_ * (success ? 1.3 : 0.9), 0.01, 0.5); }
  [[nodiscard]] std::uint32_t refused() const { return refused_; }

 private:
  const RuleKnots& knots_;
  const SearchPlan& plan_;
  Random random_;
  std::vector<double> scales_;  ///< by knot
  double step_{0.06};
  std::uint32_t refused_{0};
};

}  // namespace

double cost_of(const std::vector<TrainingCase>& cases) {
  COSIVA_EXPECT(!cases.empty());
  double sum = 0.0;
  for (const TrainingCase& one : cases)
    sum += one.stops_ratio + energy_weight * one.energy_ratio +
           laps_weight * std::max(0.0, 1.0 + laps_margin - one.laps_ratio);
  return sum / static_cast<double>(cases.size());
}

bool has_properties(const aiv::AgentRules& rules) {
  constexpr int draws = 2000;
  Random random{1, "properties"};
  for (int i = 0; i < draws; ++i) {
    const aiv::AgentInputs worse = drawn_inputs(random);
    const aiv::AgentInputs better = bettered(worse, random);
    const aiv::AgentDecision before = rules.decide(worse);
    const aiv::AgentDecision after = rules.decide(better);
    if (after.speed < before.speed - 1e-9 || after.go < before.go - 1e-9) return false;
    aiv::AgentInputs before_crossing = worse;
    at(before_crossing, aiv::AgentInput::crossing) = random.uniform(0.0, decided_within);
    if (both_go(rules, before_crossing)) return false;
  }
  return true;
}

Result<SearchResult> search_rules(const SearchPlan& plan, Workers& workers,
                                  const std::function<void(std::size_t, std::size_t, double)>& progress) {
  COSIVA_EXPECT(plan.rtm && plan.offspring > 0 && plan.last_seed >= plan.first_seed);
  const auto knots = RuleKnots::read(plan.fll, plan.origin, plan.variables);
  if (!knots) return tl::unexpected<Error>(knots.error());
  if (knots->knots().empty()) return fail("agents.search", "the rules have no number that may be changed", plan.origin);
  Training training{plan, workers};
  if (auto ran = training.run_crisp(); !ran) return tl::unexpected<Error>(ran.error());

  SearchResult result;
  result.knots = knots->knots();
  Mutation mutation{*knots, plan};
  std::vector<std::vector<double>> drawn{knots->values()};
  while (!drawn.empty()) {
    std::vector<std::string> texts;
    texts.reserve(drawn.size());
    for (const auto& values : drawn) texts.push_back(knots->text_with(values));
    auto cases = training.evaluate(texts);
    if (!cases) return tl::unexpected<Error>(cases.error());
    bool success = false;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      RuleCandidate candidate{static_cast<std::uint32_t>(result.candidates.size()), drawn[i], cost_of((*cases)[i]),
                              false, std::move((*cases)[i])};
      candidate.accepted = result.candidates.empty() || candidate.cost < result.candidates[result.best].cost;
      if (candidate.accepted) result.best = result.candidates.size();
      success |= candidate.accepted;
      result.candidates.push_back(std::move(candidate));
    }
    if (result.candidates.size() > 1) mutation.adapt(success);
    if (progress) progress(result.candidates.size() - 1, plan.budget, result.candidates[result.best].cost);
    drawn.clear();
    while (drawn.size() < plan.offspring && result.candidates.size() - 1 + drawn.size() < plan.budget) {
      auto values = mutation.draw(result.candidates[result.best].values);
      if (!values) break;
      drawn.push_back(std::move(*values));
    }
  }
  result.refused = mutation.refused();
  result.fll = knots->text_with(result.candidates[result.best].values);
  return result;
}

}  // namespace cosiva::experiments
