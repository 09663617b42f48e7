#define TOML_IMPLEMENTATION
#include "cosiva/zone/toml/toml_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cosiva/base/likeness.h"

namespace cosiva::zone {
namespace {

std::string quoted(std::string_view text) {
  // Long enough to recognise, short enough for one line of terminal; control characters would garble it.
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return out + (text.size() > 40 ? "…\"" : "\"");
}

std::string describe(const toml::node& node) {
  if (const auto* text = node.as_string()) return quoted(text->get());
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* number = node.as_floating_point()) return toml_number(number->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (node.is_array()) return "an array";
  return "a date or time";
}

/// A number, whether written 1 or 1.0.
std::optional<double> number_of(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return number->get();
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  return std::nullopt;
}

constexpr std::size_t name_bytes_max = 256;
constexpr std::string_view name_text = "a name of 1 to 256 bytes without control characters";
constexpr std::size_t faults_max = 100;

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

std::string toml_number(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

void TomlFaults::add(std::string code, std::uint32_t line, std::string_view path, std::string message) {
  add({std::move(code), std::move(message), location(line, path)});
}

void TomlFaults::add(Error error) {
  if (all_.size() < faults_max) all_.push_back(std::move(error));
}

std::string TomlFaults::location(std::uint32_t line, std::string_view path) const {
  std::string text = origin_ + ":" + std::to_string(line);
  if (!path.empty()) text.append(": ").append(path);
  return text;
}

std::uint32_t TomlFields::line(std::string_view key) const {
  const toml::node* node = key.empty() ? nullptr : table_->get(key);
  const auto line = (node == nullptr ? table_->source() : node->source()).begin.line;
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(line), 1U);
}

std::string TomlFields::path(std::string_view key) const {
  if (key.empty()) return path_;
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void TomlFields::fault(std::string_view key, std::string code, std::string message) const {
  faults_->add(std::move(code), line(key), path(key), std::move(message));
}

void TomlFields::expected(std::string_view key, std::string_view what, const toml::node& found) const {
  fault(key, "zone.field", "expected " + std::string(what) + ", found " + describe(found));
}

const toml::node* TomlFields::find(std::string_view key, std::string_view what, bool optional) const {
  const toml::node* node = table_->get(key);
  if (node == nullptr && !optional) fault(key, "zone.missing", "expected " + std::string(what) + ", found nothing");
  return node;
}

bool TomlFields::is_list(std::string_view key) const {
  const toml::node* node = table_->get(key);
  return node != nullptr && node->is_array();
}

std::vector<std::string> TomlFields::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, node] : *table_) keys.emplace_back(key.str());
  return keys;
}

void TomlFields::expect_only(std::initializer_list<std::string_view> keys) const {
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
    const auto nearest = *std::min_element(keys.begin(), keys.end(), [&](std::string_view a, std::string_view b) {
      return edit_distance(a, name.substr(0, 64)) < edit_distance(b, name.substr(0, 64));
    });
    std::string known;
    for (const std::string_view k : keys) known.append(known.empty() ? "" : ", ").append(k);
    const auto at = static_cast<std::uint32_t>(key.source().begin.line);
    faults_->add("zone.unknown_key", at == 0 ? line() : at, path(name.substr(0, 64)),
                 "unknown key; did you mean " + quoted(nearest) + "? Known here: " + known);
  }
}

double TomlFields::number(std::string_view key, const NumberRange& range, std::optional<double> fallback) const {
  const toml::node* node = find(key, range.what, fallback.has_value());
  if (node == nullptr) return fallback.value_or(range.high);
  const auto value = number_of(*node);
  const bool good = value && std::isfinite(*value) && *value <= range.high &&
                    (range.low_allowed ? *value >= range.low : *value > range.low);
  if (good) return *value;
  expected(key, range.what, *node);
  return range.high;
}

std::uint32_t TomlFields::whole(std::string_view key, std::uint32_t low, std::uint32_t high,
                                std::optional<std::uint32_t> fallback) const {
  const std::string what = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const toml::node* node = find(key, what, fallback.has_value());
  if (node == nullptr) return fallback.value_or(low);
  const auto* value = node->as_integer();
  if (value != nullptr && value->get() >= std::int64_t{low} && value->get() <= std::int64_t{high})
    return static_cast<std::uint32_t>(value->get());
  expected(key, what, *node);
  return low;
}

bool TomlFields::flag(std::string_view key, bool fallback) const {
  const toml::node* node = find(key, "true or false", true);
  if (node == nullptr) return fallback;
  if (const auto* value = node->as_boolean()) return value->get();
  expected(key, "true or false", *node);
  return fallback;
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
  if (has(radians)) fault(radians, "zone.field", "give this angle either in degrees or in radians, not in both");
  std::optional<double> fallback_deg;
  if (fallback_rad) fallback_deg = 0.0;
  const double value_deg = number(degrees, {what, -within_deg, within_deg}, fallback_deg);
  return has(degrees) || !fallback_rad ? value_deg * rad_per_deg : *fallback_rad;
}

std::string TomlFields::one_of(std::string_view key, std::initializer_list<std::string_view> terms) const {
  std::string what;
  for (const std::string_view word : terms) what.append(what.empty() ? "" : " or ").append(quoted(word));
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
  if (const auto* value = node->as_table()) return TomlFields{*faults_, *value, path(key)};
  expected(key, "a table", *node);
  return std::nullopt;
}

std::vector<TomlFields> TomlFields::tables(std::string_view key) const {
  const std::string what = "tables, each under [[" + path(key) + "]]";
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return {};
  const auto* array = node->as_array();
  if (array == nullptr) {
    expected(key, what, *node);
    return {};
  }
  std::vector<TomlFields> entries;
  entries.reserve(array->size());
  for (const toml::node& entry : *array) {
    if (const auto* value = entry.as_table()) {
      entries.emplace_back(*faults_, *value, path(key) + "[" + std::to_string(entries.size() + 1) + "]");
    } else {
      expected(key, what, entry);
      return {};
    }
  }
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
