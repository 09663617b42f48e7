#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cosiva/base/digest.h"

namespace cosiva {

/// Equal for equal texts, on every machine; a text need not be copied to be found.
struct TextHash {
  using is_transparent = void;
  [[nodiscard]] std::size_t operator()(std::string_view text) const noexcept {
    Digest digest;
    digest.add(text);
    return static_cast<std::size_t>(digest.value());
  }
};

/// A table in which texts are found: nothing may depend on the order of its entries.
template <typename Value>
using TextTable = std::unordered_map<std::string, Value, TextHash, std::equal_to<>>;

}  // namespace cosiva
