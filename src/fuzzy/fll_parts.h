#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "cosiva/fuzzy/engine.h"
#include "cosiva/fuzzy/fll_tokens.h"

/// Limits and name searches common to the reader's files; only they include this header.
namespace cosiva::fuzzy {

/// Limits of readability, and of the kernel's workspace.
inline constexpr std::size_t text_bytes_max = 1U << 20U;
inline constexpr std::size_t variables_max = 64;
inline constexpr std::size_t terms_max = 64;
inline constexpr std::size_t rules_max = 512;
inline constexpr std::size_t conditions_max = 64;

/// Index of the name, if it exists.
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
