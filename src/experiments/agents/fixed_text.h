#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace cosiva::experiments {

/// @param digits  after the decimal point
[[nodiscard]] inline std::string fixed_text(double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

}  // namespace cosiva::experiments
