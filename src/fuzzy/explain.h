#pragma once

#include <span>
#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/fuzzy/rule_base.h"

namespace cosiva::fuzzy {

struct Explanation {
  struct Degree {
    std::string text;  ///< "close", "gap is very close"
    double degree;     ///< 0…1
  };
  struct Input {
    std::string name;
    double value;               ///< as given
    double counted;             ///< as used by the rules, within its range if that is locked
    std::vector<Degree> terms;  ///< its degree in each term
  };
  struct Ratio {
    std::string output;
    std::string term;
    double consequent;  ///< the term's output for these inputs
    double ratio;       ///< of this output's value, 0…1: the rule's weight over those of all rules that fired
  };
  struct Rule {
    std::size_t line;
    std::string text;
    std::vector<Degree> conditions;  ///< the single ones, without 'and' and 'or'
    double degree;                   ///< of all conditions together, times the rule's weight
    bool fired;
    std::vector<Ratio> ratios;
  };
  struct Output {
    std::string name;
    double value;
    bool by_default;  ///< no rule fired
  };

  std::vector<Input> inputs;
  std::vector<Rule> rules;  ///< all, in the file's order
  std::vector<Output> outputs;
};

/// For readers: the inputs, the rules that fired, strongest first, and the outputs. @param every_rule  includes the
/// rules that did not fire
[[nodiscard]] std::string to_text(const Explanation& explanation, bool every_rule = false);
/// The same for programs, all rules in the file's order.
void write_json(JsonWriter& json, const Explanation& explanation);

}  // namespace cosiva::fuzzy
