#pragma once

#include <optional>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/fll_tokens.h"

namespace cosiva::fuzzy {

/// The norms that a block of rules names.
struct Norms {
  std::optional<Norm> conjunction;
  std::optional<Norm> disjunction;
};
/// "if … then …". The engine knows all its variables by now.
[[nodiscard]] Result<Rule> read_rule(const Word& value, const Norms& norms, const Engine& engine,
                                     std::string_view origin);

/// Letters, digits, _ and .; what fuzzylite leaves as it is.
[[nodiscard]] bool is_name(std::string_view text);
/// A word that the rules' grammar uses itself.
[[nodiscard]] bool is_keyword(std::string_view text);
/// The hedge of this word; nothing where the word is none.
[[nodiscard]] std::optional<Hedge> parse_hedge(std::string_view text);

}  // namespace cosiva::fuzzy
