#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/fll_tokens.h"

/// Limits and name searches that the reader's files have in common; only they include this.
namespace cosiva::fuzzy {

/// What a person could still read, and what the kernel's workspace holds.
inline constexpr std::size_t text_bytes_max = 1U << 20U;
inline constexpr std::size_t variables_max = 64;
inline constexpr std::size_t terms_max = 64;
inline constexpr std::size_t rules_max = 512;
inline constexpr std::size_t conditions_max = 64;

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
