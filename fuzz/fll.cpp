#include <cmath>
#include <vector>

#include "cosiva/fuzzy/explain.h"
#include "cosiva/fuzzy/rule_base.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto base = fuzzy::RuleBase::read(fuzz::as_text(data, size), "fuzz.fll");
  if (!base) {
    COSIVA_EXPECT(base.error().code.starts_with("rules.") && !base.error().message.empty());
    COSIVA_EXPECT(base.error().location.starts_with("fuzz.fll"));
    return 0;
  }
  // An accepted rule base can be evaluated, singly and in batches, and explains its result.
  const fuzzy::Engine& engine = base->engine();
  std::vector<double> question;
  for (const fuzzy::Variable& input : engine.inputs)
    question.push_back(0.3 * std::fmax(-1e3, input.minimum) + 0.7 * std::fmin(1e3, input.maximum));
  std::vector<double> alone(engine.outputs.size());
  base->evaluate(question, alone);
  std::vector<std::span<const double>> inputs;
  inputs.reserve(question.size());
  for (const double& x : question) inputs.emplace_back(&x, 1);
  std::vector<double> together(alone.size());
  std::vector<std::span<double>> outputs;
  outputs.reserve(together.size());
  for (double& x : together) outputs.emplace_back(&x, 1);
  base->evaluate(inputs, outputs);
  for (std::size_t o = 0; o < alone.size(); ++o) {
    COSIVA_EXPECT(alone[o] == together[o] || (std::isnan(alone[o]) && std::isnan(together[o])));
    COSIVA_EXPECT(!std::isnan(alone[o]) || std::isnan(engine.outputs[o].otherwise));
  }
  for (const auto& rule : base->explain(question).rules) COSIVA_EXPECT(rule.degree >= 0.0 && rule.degree <= 1.0);
  return 0;
}
