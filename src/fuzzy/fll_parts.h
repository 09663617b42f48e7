#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/fll_words.h"

/// What the reader is made of; only its own files include this.
namespace cosiva::fuzzy {

/// What a person could still read, and what the kernel's workspace holds.
inline constexpr std::size_t text_bytes_max = 1U << 20U;
inline constexpr std::size_t variables_max = 64;
inline constexpr std::size_t terms_max = 64;
inline constexpr std::size_t rules_max = 512;
inline constexpr std::size_t conditions_max = 64;

/// "name Shape numbers… [height]".
[[nodiscard]] Result<Term> read_input_term(const Word& value, std::string_view origin);
/// "name Constant number" or "name Linear coefficients… [constant]".
[[nodiscard]] Result<Term> read_output_term(const Word& value, std::string_view origin, std::size_t inputs);

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
[[nodiscard]] std::optional<Hedge> parse_hedge(std::string_view text);

/// Where the name stands among them, if it does.
template <typename T>
[[nodiscard]] std::optional<std::size_t> find_name(const std::vector<T>& all, std::string_view name) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == name) return i;
  }
  return std::nullopt;
}

template <typename T>
[[nodiscard]] std::string names_of(const std::vector<T>& all) {
  std::vector<std::string_view> names;
  names.reserve(all.size());
  for (const T& one : all) names.push_back(one.name);
  return listed(names, "or");
}

}  // namespace cosiva::fuzzy
