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

/// Why the rules say what they say.
struct Explanation;

/// Fuzzy rules, read and compiled once, that never change. Evaluating them allocates nothing, calls nothing virtual,
/// and gives the same bits on every machine, whether decisions are taken one by one or many at a time. Several threads
/// may use one rule base.
class RuleBase {
 public:
  /// Reads FLL (fuzzylite 6, Takagi–Sugeno outputs). Fails as read_fll does, with file, line and column, and
  /// ("rules.size") on more rules than can be worked with.
  /// @param origin  of the text, for the errors: a file's name
  [[nodiscard]] static Result<RuleBase> read(std::string_view fll, std::string_view origin);

  /// One decision: `inputs` and `outputs` in the order in which the file has the variables, as many as it has
  /// (checked). Beyond its range an input with lock-range counts as the range's end; what is no number counts as its
  /// lowest. Where no rule fires an output is its `default`, which may be no number.
  void evaluate(std::span<const double> inputs, std::span<double> outputs) const;

  /// Many decisions, the same bits as one by one. Decision k takes inputs[i][k] and gives outputs[o][k]; all columns
  /// have one length (checked), and an output's column may be no input's.
  void evaluate(std::span<const std::span<const double>> inputs, std::span<const std::span<double>> outputs) const;

  [[nodiscard]] Explanation explain(std::span<const double> inputs) const;

  [[nodiscard]] const Engine& engine() const { return engine_; }
  /// Where a variable of this name stands among them; nothing: there is none.
  [[nodiscard]] std::optional<std::size_t> find_input(std::string_view name) const;
  [[nodiscard]] std::optional<std::size_t> find_output(std::string_view name) const;

 private:
  RuleBase(Engine engine, Program program, Cells cells);

  Engine engine_;
  Program program_;
  Cells cells_;  ///< of the program, for decisions taken alone
};

}  // namespace cosiva::fuzzy
