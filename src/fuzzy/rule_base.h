#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/cells.h"
#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/program.h"

namespace cosiva::fuzzy {

/// The reasons for the outputs of the rules.
struct Explanation;

/// Fuzzy rules, read and compiled once, immutable. An evaluation allocates nothing, makes no virtual calls, and gives
/// the same bits on every machine, for single decisions and for many at a time. Several threads may use one rule base.
class RuleBase {
 public:
  /// Reads FLL (fuzzylite 6, Takagi–Sugeno outputs). Fails as read_fll does, with file, line and column, and
  /// ("rules.size") on too many rules. @param origin  of the text, for the errors: a file's name
  [[nodiscard]] static Result<RuleBase> read(std::string_view fll, std::string_view origin);

  /// One decision: `inputs` and `outputs` in the order of the variables in the file, one for each (checked). Beyond its
  /// range an input with lock-range is limited to the range's end; NaN counts as its minimum. If no rule fires an
  /// output is its `default`, which may be NaN.
  void evaluate(std::span<const double> inputs, std::span<double> outputs) const;

  /// Many decisions, with the same bits as single ones. Decision k uses inputs[i][k] and gives outputs[o][k]; all
  /// columns have one length (checked), and an output's column must not be an input's.
  void evaluate(std::span<const std::span<const double>> inputs, std::span<const std::span<double>> outputs) const;

  [[nodiscard]] Explanation explain(std::span<const double> inputs) const;

  [[nodiscard]] const Engine& engine() const { return engine_; }
  /// Index of the variable with this name; nothing if there is none.
  [[nodiscard]] std::optional<std::size_t> find_input(std::string_view name) const;
  [[nodiscard]] std::optional<std::size_t> find_output(std::string_view name) const;

 private:
  RuleBase(Engine engine, Program program, Cells cells);

  Engine engine_;
  Program program_;
  Cells cells_;  ///< of the program, for single decisions
};

}  // namespace cosiva::fuzzy
