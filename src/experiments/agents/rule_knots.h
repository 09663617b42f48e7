#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::experiments {

/// The numbers in the terms of an agent's rules, for a search that changes them: the corners of the inputs' terms, and
/// the constants of the outputs. Equal numbers of one variable are one knot, so that terms that meet at a corner still
/// meet there, and the conditions that add up to one still do.
///
/// Invariant: the knots of each variable are next to each other, in ascending order, and apart.
class RuleKnots {
 public:
  struct Knot {
    std::string variable;
    double value;
    double low;   ///< of the variable's range
    double high;  ///< likewise
  };

  /// Takes only variables that describe the surroundings; the operator's instruction, the priority, the battery and the
  /// output `go` have meanings of their own, and their numbers stay.
  /// @param variables  only of these, inputs or outputs; empty: of all
  /// Fails as AgentRules::read, and ("agents.variable") on a variable of `variables` without such numbers.
  [[nodiscard]] static Result<RuleKnots> read(std::string_view fll, std::string_view origin,
                                              const std::vector<std::string>& variables = {});

  [[nodiscard]] const std::vector<Knot>& knots() const { return knots_; }
  [[nodiscard]] std::vector<double> values() const;
  /// The values with each variable's in ascending order, apart by a hundredth of its range and within it, rounded to
  /// hundredths.
  /// @param values  one per knot (checked)
  [[nodiscard]] std::vector<double> repaired(std::vector<double> values) const;
  /// The rules with these values instead; all else, comments included, is unchanged.
  /// @param values  as repaired() returns them, one per knot (checked)
  [[nodiscard]] std::string text_with(std::span<const double> values) const;

 private:
  /// A number in the text.
  struct Occurrence {
    std::size_t offset;
    std::size_t length;
    std::size_t knot;
  };
  RuleKnots() = default;

  std::string text_;
  std::vector<Knot> knots_;
  std::vector<Occurrence> occurrences_;  ///< in the order of the text
};

}  // namespace cosiva::experiments
