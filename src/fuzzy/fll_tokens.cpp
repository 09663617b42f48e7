#include "cosiva/fuzzy/fll_tokens.h"

#include <charconv>
#include <limits>
#include <utility>

namespace cosiva::fuzzy {
namespace {

constexpr std::string_view blanks = " \t\r\v\f";

/// Without blanks at both ends; adjusts the column.
Word trimmed(Word word) {
  const std::size_t from = word.text.find_first_not_of(blanks);
  if (from == std::string_view::npos) return {word.text.substr(0, 0), word.line, word.column};
  const std::size_t to = word.text.find_last_not_of(blanks);
  return {word.text.substr(from, to - from + 1), word.line, word.column + from};
}

}  // namespace

std::string location_of(std::string_view origin, const Word& word) {
  return std::string(origin) + ":" + std::to_string(word.line) + ":" + std::to_string(word.column);
}

tl::unexpected<Error> refuse(std::string_view origin, const Word& word, std::string message) {
  return fail("rules.syntax", std::move(message), location_of(origin, word));
}

Result<std::vector<Line>> split_lines(std::string_view text, std::string_view origin) {
  std::vector<Line> lines;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    line = line.substr(0, line.find('#'));
    const Word whole = trimmed({line, number, 1});
    if (whole.text.empty()) continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) {
      return refuse(origin, whole,
                    "expected 'key: value', such as 'range: 0.0 10.0', but found " + in_quotes(whole.text) +
                        "; a comment begins with #");
    }
    lines.push_back(
        {trimmed({line.substr(0, colon), number, 1}), trimmed({line.substr(colon + 1), number, colon + 2})});
  }
  return lines;
}

std::vector<Word> split_tokens(const Word& value) {
  std::vector<Word> tokens;
  const std::string_view text = value.text;
  for (std::size_t i = 0; i < text.size();) {
    if (blanks.find(text[i]) != std::string_view::npos) {
      ++i;
      continue;
    }
    std::size_t end = i + 1;
    const auto is_bracket = [](char c) { return c == '(' || c == ')'; };
    if (!is_bracket(text[i])) {
      while (end < text.size() && blanks.find(text[end]) == std::string_view::npos && !is_bracket(text[end])) ++end;
    }
    tokens.push_back({text.substr(i, end - i), value.line, value.column + i});
    i = end;
  }
  return tokens;
}

Word end_of(const Word& value) {
  return {value.text.substr(value.text.size()), value.line, value.column + value.text.size()};
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || stop != text.data() + text.size() || text.empty()) return std::nullopt;
  // One bit pattern for all NaNs: "-nan" and "nan(7)" would each have their own.
  return number == number ? number : std::numeric_limits<double>::quiet_NaN();  // NOLINT(misc-redundant-expression)
}

std::string listed(const std::vector<std::string_view>& names, std::string_view last_joint) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) {
      text += i + 1 < names.size() ? std::string(", ") : " " + std::string(last_joint) + " ";
    }
    text.append(names[i]);
  }
  return text;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t length_max = 60;
  std::string out = "'";
  for (const char c : text.substr(0, length_max)) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  if (text.size() > length_max) out += "…";
  return out + "'";
}

}  // namespace cosiva::fuzzy
