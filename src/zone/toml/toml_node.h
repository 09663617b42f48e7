#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/zone/toml/toml_library.h"

namespace cosiva::zone {

/// Describes a value for a message: "0.5", "an array of 3".
[[nodiscard]] std::string describe(const toml::node& node);
/// A number, whether written 1 or 1.0.
[[nodiscard]] std::optional<double> number_of(const toml::node& node);
/// "a, b, c".
[[nodiscard]] std::string listed(const std::vector<std::string_view>& terms);
/// The term of `known` that was most likely meant; empty where none is near.
[[nodiscard]] std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known);
/// In quotes, short enough for one line.
[[nodiscard]] std::string in_quotes(std::string_view text);
/// The shortest text that reads back to the same number, and is a TOML number: "0.3".
[[nodiscard]] std::string toml_number(double value);

}  // namespace cosiva::zone
