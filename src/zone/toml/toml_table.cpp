#include "cosiva/zone/toml/toml_table.h"

#include <algorithm>
#include <cmath>

#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::zone {
namespace {

constexpr std::size_t faults_max = 100;

}  // namespace

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

std::string TomlFaults::code(std::string_view kind) const { return family_ + "." + std::string(kind); }

bool NumberRange::contains(double value) const {
  return std::isfinite(value) && value <= high && (low_allowed ? value >= low : value > low);
}

std::uint32_t TomlTable::line(std::string_view key) const {
  const toml::node* node = key.empty() ? nullptr : table_->get(key);
  const auto line = (node == nullptr ? table_->source() : node->source()).begin.line;
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(line), 1U);
}

std::string TomlTable::path(std::string_view key) const {
  if (key.empty()) return path_;
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

std::string TomlTable::entry_path(std::string_view key, std::size_t number) const {
  return path(key) + "[" + std::to_string(number) + "]";
}

void TomlTable::fault(std::string_view key, std::string code, std::string message) const {
  faults_->add(std::move(code), line(key), path(key), std::move(message));
}

void TomlTable::expected(std::string_view key, std::string_view what, const toml::node& found) const {
  fault(key, faults_->code("field"), "expected " + std::string(what) + ", found " + describe(found));
}

const toml::node* TomlTable::find(std::string_view key, std::string_view what, bool optional) const {
  const toml::node* node = table_->get(key);
  if (node == nullptr && !optional)
    fault(key, faults_->code("missing"), "expected " + std::string(what) + ", found nothing");
  return node;
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, node] : *table_) keys.emplace_back(key.str());
  return keys;
}

void TomlTable::expect_only(std::initializer_list<std::string_view> keys) const {
  expect_among({keys.begin(), keys.size()});
}

void TomlTable::expect_only(const std::vector<std::string_view>& keys) const { expect_among(keys); }

void TomlTable::expect_among(std::span<const std::string_view> keys) const {
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (std::ranges::find(keys, name) != keys.end()) continue;
    const std::vector<std::string_view> known{keys.begin(), keys.end()};
    const std::string_view near = nearest(name, known);
    const auto at = static_cast<std::uint32_t>(key.source().begin.line);
    std::string shown;
    for (const char c : name.substr(0, 64)) shown += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
    faults_->add(faults_->code("unknown_key"), at == 0 ? line() : at, path(shown),
                 "unknown key; " + (near.empty() ? "" : "did you mean " + in_quotes(near) + "? ") +
                     "Known here: " + listed(known));
  }
}

double TomlTable::number(std::string_view key, const NumberRange& range, std::optional<double> fallback) const {
  const toml::node* node = find(key, range.what, fallback.has_value());
  if (node == nullptr) return fallback.value_or(range.high);
  if (const auto value = number_of(*node); value && range.contains(*value)) return *value;
  expected(key, range.what, *node);
  return range.high;
}

std::int64_t TomlTable::whole(std::string_view key, std::int64_t low, std::int64_t high,
                              std::optional<std::int64_t> fallback) const {
  const std::string what = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const toml::node* node = find(key, what, fallback.has_value());
  if (node == nullptr) return fallback.value_or(low);
  const auto* value = node->as_integer();
  if (value != nullptr && value->get() >= low && value->get() <= high) return value->get();
  expected(key, what, *node);
  return low;
}

bool TomlTable::flag(std::string_view key, bool fallback) const {
  const toml::node* node = find(key, "true or false", true);
  if (node == nullptr) return fallback;
  if (const auto* value = node->as_boolean()) return value->get();
  expected(key, "true or false", *node);
  return fallback;
}

std::vector<const toml::table*> TomlTable::list(std::string_view key, std::string_view what,
                                                std::size_t count_max) const {
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return {};
  const auto* array = node->as_array();
  if (array == nullptr || array->size() > count_max) {
    expected(key, what, *node);
    return {};
  }
  std::vector<const toml::table*> tables;
  tables.reserve(array->size());
  for (const toml::node& entry : *array) {
    const auto* table = entry.as_table();
    if (table == nullptr) {
      expected(key, what, entry);
      return {};
    }
    tables.push_back(table);
  }
  return tables;
}

}  // namespace cosiva::zone
