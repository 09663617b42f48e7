#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::app {

inline constexpr int exit_done = 0;
inline constexpr int exit_check_failed = 1;
inline constexpr int exit_bad_input = 2;

/// Messages go to standard error, data to standard output.
void print_info(std::string_view text);
void print(std::string_view data);
/// "    12.0 s  person P1 walks …": a step of a scenario.
[[nodiscard]] std::string step_line(double t_s, std::string_view what);
/// Prints "cosiva: location: message"; returns exit_bad_input.
int report_error(const Error& error);

/// The candidate nearest to a mistyped word, or an empty text when none is near enough.
[[nodiscard]] std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

/// "0.123": few digits, for display.
[[nodiscard]] std::string decimals(double number, int digits);

}  // namespace cosiva::app
