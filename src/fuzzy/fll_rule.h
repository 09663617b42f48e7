#pragma once

#include <optional>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/fll_tokens.h"

namespace cosiva::fuzzy {

/// The norms named by a block of rules.
struct Norms {
  std::optional<Norm> conjunction;
  std::optional<Norm> disjunction;
};
/// Reads "if … then …". The engine already contains all variables.
[[nodiscard]] Result<Rule> read_rule(const Word& value, const Norms& norms, const Engine& engine,
                                     std::string_view origin);

/// Letters, digits, _ and .; the characters that fuzzylite accepts unchanged.
[[nodiscard]] bool is_name(std::string_view text);
/// A word of the rules' grammar.
[[nodiscard]] bool is_keyword(std::string_view text);
/// The hedge with this name; nothing if there is none.
[[nodiscard]] std::optional<Hedge> parse_hedge(std::string_view text);

}  // namespace cosiva::fuzzy
