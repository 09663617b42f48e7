#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/zone/toml/toml_library.h"

namespace cosiva::experiments {

/// Describes a value for a message: "0.5", "an array of 3".
[[nodiscard]] std::string describe(const toml::node& node);
[[nodiscard]] std::optional<double> number_of(const toml::node& node);
/// "a, b, c".
[[nodiscard]] std::string listed(const std::vector<std::string_view>& terms);

}  // namespace cosiva::experiments
