#pragma once

#include <string>
#include <string_view>

namespace cosiva::fuzzy {

/// A whole rule file around the part under test.
struct RuleText {
  std::string input_terms{"  term: low Ramp 10.0 0.0\n  term: high Ramp 0.0 10.0\n"};
  std::string output{"  defuzzifier: WeightedAverage TakagiSugeno\n  default: -1.0\n"};
  std::string output_terms{"  term: none Constant 0.0\n  term: full Constant 1.0\n"};
  std::string norms{"  conjunction: AlgebraicProduct\n  disjunction: Maximum\n"};
  std::string rules{"  rule: if x is low then out is none\n  rule: if x is high then out is full\n"};

  [[nodiscard]] std::string text() const {
    return "Engine: test\nInputVariable: x\n  range: 0.0 10.0\n  lock-range: true\n" + input_terms +
           "InputVariable: y\n  range: 0.0 10.0\n  term: low Ramp 10.0 0.0\n  term: high Ramp 0.0 10.0\n" +
           "OutputVariable: out\n  range: 0.0 1.0\n" + output + output_terms + "RuleBlock: rules\n" + norms + rules;
  }
};

}  // namespace cosiva::fuzzy
