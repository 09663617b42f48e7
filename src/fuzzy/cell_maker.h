#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/fuzzy/cells.h"
#include "cosiva/fuzzy/steps.h"

namespace cosiva::fuzzy {

/// How an output is computed from its rules, whose degrees are values made by steps.
struct Weighing {
  struct Rule {
    Value degree{};
    double weight{};
  };
  struct Term {
    std::vector<Rule> rules;
    double consequent{};
    std::optional<Value> consequent_value;  ///< the term's output if it is not a constant
  };
  std::vector<Term> terms;
  bool is_average{};
  double otherwise{};
  double low{};  ///< infinite: no lock-range
  double high{};
};

/// Makes the cells; none (see Cells::pay) if the steps by themselves need less work.
[[nodiscard]] Cells make_cells(const Steps& steps, const std::vector<Weighing>& outputs);

}  // namespace cosiva::fuzzy
