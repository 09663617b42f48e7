#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/compiler.h"
#include "cosiva/fuzzy/kernel.h"
#include "cosiva/fuzzy/rule_base.h"

namespace cosiva::fuzzy {

/// A rule base for one kind of frequent query: some inputs are known, and only some outputs are requested. The outputs
/// equal those of the whole rule base; only the computation of what never changes is omitted. Inputs and outputs are in
/// the caller's own rows, `lanes` decisions side by side, so that nothing is copied.
class NarrowRules {
 public:
  /// Fails ("rules.size") as RuleBase::read. @param known    by input of the rule base: its constant value; nothing:
  /// given with each query
  /// @param outputs  of the rule base, those requested
  [[nodiscard]] static Result<NarrowRules> make(const RuleBase& rules, std::vector<std::optional<double>> known,
                                                std::vector<std::size_t> outputs);

  /// Number of rows of `lanes` numbers that a run works in. Row i receives input i; rows of known inputs are not read.
  /// A run overwrites the inputs.
  [[nodiscard]] std::size_t rows() const { return narrowed_.program.values; }
  void run(double (*rows)[lanes]) const { run_lanes(narrowed_.program, rows); }
  /// The k-th requested output is this number, whatever the inputs; nothing: its values are in row(k) after a run.
  [[nodiscard]] const std::optional<double>& known(std::size_t k) const { return narrowed_.known[k]; }
  [[nodiscard]] std::size_t row(std::size_t k) const { return narrowed_.program.outputs[k]; }

 private:
  explicit NarrowRules(Narrowed narrowed) : narrowed_{std::move(narrowed)} {}
  Narrowed narrowed_;
};

}  // namespace cosiva::fuzzy
