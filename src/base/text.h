#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

/// Text of lines and fields, as in tables and trajectories. Views are valid as long as the text.
namespace cosiva {

/// Iterates over the lines of a text, without line ends and carriage returns. A UTF-8 BOM, which some programs write,
/// belongs to no line.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_{text} {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (rest_.starts_with(byte_order_mark)) rest_.remove_prefix(byte_order_mark.size());
  }
  [[nodiscard]] bool next(std::string_view& line);
  [[nodiscard]] std::size_t number() const { return number_; }  ///< of the last line, from 1

 private:
  std::string_view rest_;
  std::size_t number_{0};
};

/// Without `blanks` at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");
/// The fields between commas, trimmed; one field more than there are commas.
[[nodiscard]] std::vector<std::string_view> cut_at_commas(std::string_view line, std::string_view blanks = " \t");

/// The whole text as a number: nothing before or after it, no NaN and no infinity.
template <class Number>
[[nodiscard]] std::optional<Number> number_of(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace cosiva
