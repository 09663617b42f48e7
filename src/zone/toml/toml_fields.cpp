#include "cosiva/zone/toml/toml_fields.h"

#include <algorithm>
#include <cmath>

#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::zone {
namespace {

constexpr std::size_t name_bytes_max = 256;
constexpr std::string_view name_text = "a name of 1 to 256 bytes without control characters";

}  // namespace

bool is_toml_name(std::string_view text) {
  return !text.empty() && text.size() <= name_bytes_max && std::none_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
  });
}

std::string toml_quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

bool TomlFields::is_list(std::string_view key) const {
  const toml::node* node = table_here().get(key);
  return node != nullptr && node->is_array();
}

std::string TomlFields::name(std::string_view key) const {
  const toml::node* node = find(key, name_text, false);
  if (node == nullptr) return {};
  const auto* value = node->as_string();
  if (value != nullptr && is_toml_name(value->get())) return value->get();
  expected(key, name_text, *node);
  return {};
}

std::optional<std::string> TomlFields::optional_name(std::string_view key) const {
  return has(key) ? std::optional{name(key)} : std::nullopt;
}

double TomlFields::angle(std::string_view key, double within_deg, std::optional<double> fallback_rad) const {
  const std::string degrees = std::string(key) + "_deg";
  const std::string radians = std::string(key) + "_rad";
  const std::string what = "degrees within ±" + toml_number(within_deg);
  if (has(radians) && !has(degrees)) {
    const double within_rad = within_deg * rad_per_deg;
    const std::string what_rad = "radians within ±" + toml_number(within_rad);
    return number(radians, {what_rad, -within_rad, within_rad});
  }
  if (has(radians))
    fault(radians, faults().code("field"), "give this angle either in degrees or in radians, not in both");
  std::optional<double> fallback_deg;
  if (fallback_rad) fallback_deg = 0.0;
  const double value_deg = number(degrees, {what, -within_deg, within_deg}, fallback_deg);
  return has(degrees) || !fallback_rad ? value_deg * rad_per_deg : *fallback_rad;
}

std::string TomlFields::one_of(std::string_view key, const std::vector<std::string_view>& terms) const {
  std::string what;
  for (const std::string_view word : terms) what.append(what.empty() ? "" : " or ").append(in_quotes(word));
  const toml::node* node = find(key, what, false);
  if (node == nullptr) return {};
  const auto* value = node->as_string();
  if (value != nullptr && std::find(terms.begin(), terms.end(), value->get()) != terms.end()) return value->get();
  expected(key, what, *node);
  return {};
}

std::optional<TomlFields> TomlFields::table(std::string_view key) const {
  const toml::node* node = find(key, "a table", true);
  if (node == nullptr) return std::nullopt;
  if (const auto* value = node->as_table()) return TomlFields{faults(), *value, path(key)};
  expected(key, "a table", *node);
  return std::nullopt;
}

std::vector<TomlFields> TomlFields::tables(std::string_view key) const {
  const std::string what = "tables, each under [[" + path(key) + "]]";
  std::vector<TomlFields> entries;
  for (const toml::table* entry : list(key, what))
    entries.emplace_back(faults(), *entry, entry_path(key, entries.size() + 1));
  return entries;
}

std::optional<std::vector<std::string>> TomlFields::names(std::string_view key) const {
  constexpr std::string_view what = "an array of names, such as [\"east\"]";
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return std::nullopt;
  std::vector<std::string> names;
  const auto* array = node->as_array();
  if (array == nullptr) {
    expected(key, what, *node);
    return names;
  }
  for (const toml::node& entry : *array) {
    if (const auto* value = entry.as_string())
      names.push_back(value->get());
    else
      expected(key, what, entry);
  }
  return names;
}

std::optional<Point2> TomlFields::point(std::string_view key) const {
  constexpr std::string_view what = "two numbers of metres [x, y] within ±1000000";
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return std::nullopt;
  const auto* array = node->as_array();
  if (array == nullptr || array->size() != 2) {
    expected(key, what, *node);
    return Point2{};
  }
  double xy[2] = {0.0, 0.0};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto value = number_of(*array->get(i));
    if (value && std::fabs(*value) <= coordinate_max_m)
      xy[i] = *value;
    else
      expected(key, what, *array->get(i));
  }
  return Point2{xy[0], xy[1]};
}

}  // namespace cosiva::zone
