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
    double counted;             ///< as the rules see it, within its range where that is locked
    std::vector<Degree> terms;  ///< how far it belongs to each
  };
  struct Ratio {
    std::string output;
    std::string term;
    double consequent;  ///< the term's number here
    double ratio;       ///< of this output's answer, 0…1: its weight over those of all rules that fired
  };
  struct Rule {
    std::size_t line;
    std::string text;
    std::vector<Degree> conditions;  ///< the single ones, without 'and' and 'or'
    double degree;                   ///< of all of them together, times the rule's weight
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

/// For people: what each input is, which rules fired, strongest first, and what came of it.
/// @param every_rule  also those that did not fire
[[nodiscard]] std::string to_text(const Explanation& explanation, bool every_rule = false);
/// The same for programs, all rules in the file's order.
void write_json(JsonWriter& json, const Explanation& explanation);

}  // namespace cosiva::fuzzy
