#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::fuzzy {

/// A piece of an FLL text with its position: line and column count from 1.
struct Word {
  std::string_view text;
  std::size_t line{};
  std::size_t column{};
};

/// `key: value` with the value's words, without comments.
struct Line {
  Word key;
  Word value;  ///< trimmed; empty if nothing follows the colon
};

/// "file:line:column".
[[nodiscard]] std::string location_of(std::string_view origin, const Word& word);
[[nodiscard]] tl::unexpected<Error> refuse(std::string_view origin, const Word& word, std::string message);

/// All non-empty lines. Fails on the first line without a colon.
[[nodiscard]] Result<std::vector<Line>> split_lines(std::string_view text, std::string_view origin);
/// The words of a value; ( and ) are words of their own.
[[nodiscard]] std::vector<Word> split_tokens(const Word& value);
/// The position just behind a value, where something is missing.
[[nodiscard]] Word end_of(const Word& value);

/// A number as FLL writes it, "inf" and "nan" among them.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);
/// "'a', 'b' or 'c'", for messages.
[[nodiscard]] std::string listed(const std::vector<std::string_view>& names, std::string_view last_joint);
/// The text found, in quotes, truncated if long, and printable.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace cosiva::fuzzy
