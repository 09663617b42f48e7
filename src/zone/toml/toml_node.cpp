#define TOML_IMPLEMENTATION
#include "cosiva/zone/toml/toml_node.h"

#include <algorithm>
#include <charconv>

#include "cosiva/base/likeness.h"

namespace cosiva::zone {

std::string describe(const toml::node& node) {
  if (const auto* text = node.as_string()) return in_quotes(text->get());
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* number = node.as_floating_point()) return toml_number(number->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (const auto* array = node.as_array()) return "an array of " + std::to_string(array->size());
  return "a date or time";
}

std::optional<double> number_of(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  return std::nullopt;
}

std::string listed(const std::vector<std::string_view>& terms) {
  std::string text;
  for (const std::string_view word : terms) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known) {
  word = word.substr(0, 64);
  std::string_view best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 2) + 1;
  for (const std::string_view candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = candidate;
  }
  return best;
}

std::string in_quotes(std::string_view text) {
  // Long enough to recognise, short enough for one line of a terminal; control characters would garble the line.
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return out + (text.size() > 40 ? "…\"" : "\"");
}

std::string toml_number(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

}  // namespace cosiva::zone
