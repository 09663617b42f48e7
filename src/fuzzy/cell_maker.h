#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/fuzzy/cells.h"
#include "cosiva/fuzzy/steps.h"

namespace cosiva::fuzzy {

/// How an output comes from its rules: their degrees are values that steps make.
struct Weighing {
  struct Rule {
    Value degree{};
    double weight{};
  };
  struct Term {
    std::vector<Rule> rules;
    double consequent{};
    std::optional<Value> consequent_value;  ///< what it says where that is no number
  };
  std::vector<Term> terms;
  bool is_average{};
  double otherwise{};
  double low{};  ///< infinite: not locked
  double high{};
};

/// None (see Cells::pay) where the steps by themselves are less to do.
[[nodiscard]] Cells make_cells(const Steps& steps, const std::vector<Weighing>& outputs);

}  // namespace cosiva::fuzzy
