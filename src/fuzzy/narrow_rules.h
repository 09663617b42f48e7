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

/// A rule base for one kind of question, asked very often: what some inputs are is known, and only some outputs are
/// asked for. Answers equal those of the whole rule base; only the work for what never changes is gone. Questions and
/// answers stand in the caller's own rows, `lanes` decisions side by side, so that nothing is copied.
class NarrowRules {
 public:
  /// Fails ("rules.size") as RuleBase::read.
  /// @param known    by input of the rule base: what it will always be; nothing: it is asked each time
  /// @param outputs  of the rule base, those asked for
  [[nodiscard]] static Result<NarrowRules> make(const RuleBase& rules, std::vector<std::optional<double>> known,
                                                std::vector<std::size_t> outputs);

  /// How many rows of `lanes` numbers it works in. Row i takes input i; known ones are not read. Inputs do not outlast
  /// a run.
  [[nodiscard]] std::size_t rows() const { return narrowed_.program.values; }
  void run(double (*rows)[lanes]) const { run_lanes(narrowed_.program, rows); }
  /// The k-th output asked for is this number, whatever the inputs; nothing: its answers stand in row(k) after a run.
  [[nodiscard]] const std::optional<double>& known(std::size_t k) const { return narrowed_.known[k]; }
  [[nodiscard]] std::size_t row(std::size_t k) const { return narrowed_.program.outputs[k]; }

 private:
  explicit NarrowRules(Narrowed narrowed) : narrowed_{std::move(narrowed)} {}
  Narrowed narrowed_;
};

}  // namespace cosiva::fuzzy
