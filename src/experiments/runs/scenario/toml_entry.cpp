#include "cosiva/experiments/runs/scenario/toml_entry.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cosiva/base/likeness.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/runs/scenario/toml_node.h"

namespace cosiva::experiments {
namespace {

constexpr double coordinate_max_m = 1e5;
constexpr std::string_view point_text = "two numbers of metres [x, y] within ±100000";

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

}  // namespace

std::string describe(const toml::node& node) {
  if (const auto* text = node.as_string()) return quoted(text->get());
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* number = node.as_floating_point()) return shortest(number->get());
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

std::string quoted(std::string_view text) {
  // Long enough to recognise, short enough for one line of a terminal; control characters would garble the line.
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += is_control(c) ? '?' : c;
  return out + (text.size() > 40 ? "…\"" : "\"");
}

std::string shortest(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
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

void Faults::add(std::string code, std::uint32_t line, std::string_view path, std::string message) {
  if (first_) return;
  std::string location = origin_ + ":" + std::to_string(line);
  if (!path.empty()) location.append(": ").append(path);
  first_ = Error{std::move(code), std::move(message), std::move(location)};
}

std::uint32_t Entry::line(std::string_view key) const {
  const toml::node* node = key.empty() ? nullptr : table_->get(key);
  const auto line = (node == nullptr ? table_->source() : node->source()).begin.line;
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(line), 1U);
}

std::string Entry::path(std::string_view key) const {
  if (key.empty()) return path_;
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void Entry::fault(std::string_view key, std::string code, std::string message) const {
  faults_->add(std::move(code), line(key), path(key), std::move(message));
}

void Entry::expected(std::string_view key, std::string_view what, const toml::node& found) const {
  fault(key, "scenario.field", "expected " + std::string(what) + ", found " + describe(found));
}

const toml::node* Entry::find(std::string_view key, std::string_view what, bool optional) const {
  const toml::node* node = table_->get(key);
  if (node == nullptr && !optional) fault(key, "scenario.missing", "expected " + std::string(what) + ", found nothing");
  return node;
}

void Entry::expect_only(const std::vector<std::string_view>& keys) const {
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (std::ranges::find(keys, name) != keys.end()) continue;
    const std::string_view near = nearest(name, keys);
    const auto at = static_cast<std::uint32_t>(key.source().begin.line);
    std::string shown;
    for (const char c : name.substr(0, 64)) shown += is_control(c) ? '?' : c;
    faults_->add(
        "scenario.unknown_key", at == 0 ? line() : at, path(shown),
        "unknown key; " + (near.empty() ? "" : "did you mean " + quoted(near) + "? ") + "Known here: " + listed(keys));
  }
}

std::vector<std::string> Entry::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, node] : *table_) names.emplace_back(key.str());
  return names;
}

std::optional<std::string> Entry::peek(std::string_view table, std::string_view key) const {
  const toml::node* inner = table_->get(table);
  const auto* fields = inner == nullptr ? nullptr : inner->as_table();
  const toml::node* node = fields == nullptr ? nullptr : fields->get(key);
  const auto* text = node == nullptr ? nullptr : node->as_string();
  return text == nullptr ? std::nullopt : std::optional<std::string>(text->get());
}

double Entry::number(std::string_view key, const Range& range, std::optional<double> fallback) const {
  const toml::node* node = find(key, range.what, fallback.has_value());
  if (node == nullptr) return fallback.value_or(range.high);
  const auto value = number_of(*node);
  const bool good = value && std::isfinite(*value) && *value <= range.high &&
                    (range.low_allowed ? *value >= range.low : *value > range.low);
  if (good) return *value;
  expected(key, range.what, *node);
  return range.high;
}

std::int64_t Entry::whole(std::string_view key, std::int64_t low, std::int64_t high,
                          std::optional<std::int64_t> fallback) const {
  const std::string what = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const toml::node* node = find(key, what, fallback.has_value());
  if (node == nullptr) return fallback.value_or(low);
  const auto* value = node->as_integer();
  if (value != nullptr && value->get() >= low && value->get() <= high) return value->get();
  expected(key, what, *node);
  return low;
}

std::string Entry::text(std::string_view key, std::size_t bytes_max, const std::optional<std::string>& fallback) const {
  const std::string what = "a text of 1 to " + std::to_string(bytes_max) + " bytes";
  const toml::node* node = find(key, what, fallback.has_value());
  if (node == nullptr) return fallback.value_or("");
  const auto* value = node->as_string();
  const auto bad = [](char c) { return is_control(c) && c != '\n'; };
  if (value != nullptr && !value->get().empty() && value->get().size() <= bytes_max &&
      std::ranges::none_of(value->get(), bad))
    return value->get();
  expected(key, what, *node);
  return {};
}

std::string Entry::one_of(std::string_view key, const std::vector<std::string_view>& terms,
                          const std::optional<std::string>& fallback) const {
  const std::string what = "one of " + listed(terms);
  const toml::node* node = find(key, what, fallback.has_value());
  if (node == nullptr) return fallback.value_or("");
  const auto* value = node->as_string();
  if (value != nullptr && std::ranges::find(terms, value->get()) != terms.end()) return value->get();
  const std::string_view near = value == nullptr ? std::string_view{} : nearest(value->get(), terms);
  fault(
      key, "scenario.field",
      "expected " + what + ", found " + describe(*node) + (near.empty() ? "" : "; did you mean " + quoted(near) + "?"));
  return std::string(terms.front());
}

std::vector<std::string> Entry::texts(std::string_view key, std::size_t count_max) const {
  const std::string what = "an array of 1 to " + std::to_string(count_max) + " names, such as [\"AIV1\", \"AIV2\"]";
  const toml::node* node = find(key, what, false);
  const auto* array = node == nullptr ? nullptr : node->as_array();
  if (array == nullptr || array->empty() || array->size() > count_max) {
    if (node != nullptr) expected(key, what, *node);
    return {};
  }
  std::vector<std::string> names;
  for (const toml::node& entry : *array) {
    if (const auto* value = entry.as_string()) {
      names.push_back(value->get());
    } else {
      expected(key, what, entry);
      return {};
    }
  }
  return names;
}

std::optional<Point2> Entry::point_of(const toml::node& node) const {
  const auto* array = node.as_array();
  if (array == nullptr || array->size() != 2) return std::nullopt;
  const auto x = number_of(*array->get(0));
  const auto y = number_of(*array->get(1));
  if (!x || !y || !(std::fabs(*x) <= coordinate_max_m) || !(std::fabs(*y) <= coordinate_max_m)) return std::nullopt;
  return Point2{*x, *y};
}

Point2 Entry::point(std::string_view key) const {
  const toml::node* node = find(key, point_text, false);
  if (node == nullptr) return {};
  if (const auto point = point_of(*node)) return *point;
  expected(key, point_text, *node);
  return {};
}

std::vector<Point2> Entry::points(std::string_view key, std::size_t count_max) const {
  const std::string what = "2 to " + std::to_string(count_max) + " points [[x, y], [x, y]] in metres";
  const toml::node* node = find(key, what, false);
  const auto* array = node == nullptr ? nullptr : node->as_array();
  if (array == nullptr || array->size() < 2 || array->size() > count_max) {
    if (node != nullptr) expected(key, what, *node);
    return {};
  }
  std::vector<Point2> points;
  for (const toml::node& entry : *array) {
    const auto point = point_of(entry);
    if (!point) {
      expected(key, point_text, entry);
      return {};
    }
    points.push_back(*point);
  }
  return points;
}

std::optional<Entry> Entry::table(std::string_view key) const {
  constexpr std::string_view what = "a table, such as { id = \"P1\", at = [0.4, 0.1] }";
  const toml::node* node = find(key, what, false);
  if (node == nullptr) return std::nullopt;
  if (const auto* value = node->as_table()) return Entry{*faults_, *value, path(key)};
  expected(key, what, *node);
  return std::nullopt;
}

std::vector<Entry> Entry::tables(std::string_view key, std::size_t count_max) const {
  const std::string what = "at most " + std::to_string(count_max) + " tables, each under [[" + path(key) + "]]";
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return {};
  const auto* array = node->as_array();
  if (array == nullptr || array->size() > count_max) {
    expected(key, what, *node);
    return {};
  }
  std::vector<Entry> entries;
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

namespace {

bool within(double value, const Range& range) {
  return std::isfinite(value) && value <= range.high && (range.low_allowed ? value >= range.low : value > range.low);
}

}  // namespace

std::vector<std::string> Entry::some_of(std::string_view key, const std::vector<std::string_view>& terms,
                                        const std::vector<std::string>& fallback) const {
  const toml::node* node = find(key, "", true);
  if (node == nullptr) return fallback;
  const auto* list = node->as_array();
  if (list == nullptr) return {one_of(key, terms)};
  if (list->empty()) fault(key, "scenario.field", "expected one or more of " + listed(terms) + ", found an empty list");
  std::vector<std::string> chosen;
  for (const toml::node& one : *list) {
    const auto* text = one.as_string();
    if (text == nullptr || std::ranges::find(terms, text->get()) == terms.end()) {
      const std::string_view near = text == nullptr ? std::string_view{} : nearest(text->get(), terms);
      fault(key, "scenario.field",
            "expected some of " + listed(terms) + ", found " + describe(one) +
                (near.empty() ? "" : "; did you mean " + quoted(near) + "?"));
      return fallback;
    }
    if (std::ranges::find(chosen, text->get()) != chosen.end())
      fault(key, "scenario.field", quoted(text->get()) + " is given twice");
    chosen.push_back(text->get());
  }
  return chosen;
}

std::vector<double> Entry::spread(const Entry& fields, const Range& range, std::size_t count_max) const {
  fields.expect_only({"from", "to", "steps", "log"});
  const double from = fields.number("from", range);
  const double to = fields.number("to", range);
  const auto steps = static_cast<std::size_t>(fields.whole("steps", 2, static_cast<std::int64_t>(count_max)));
  const bool log = fields.flag("log", false);
  if (faults_->first()) return {};
  if (!(from < to)) {
    fields.fault("to", "scenario.field", "expected more than from = " + shortest(from) + ", found " + shortest(to));
    return {};
  }
  if (log && !(from > 0.0)) {
    fields.fault("from", "scenario.field", "expected a number over 0 with log = true, found " + shortest(from));
    return {};
  }
  // With larger ratios logarithms are inexact, and with a denormal number they overflow.
  if (constexpr double decades_max = 1e15; log && !(to / from <= decades_max)) {
    fields.fault("to", "scenario.field", "expected at most 1e15 times from with log = true, found " + shortest(to));
    return {};
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < steps; ++i) {
    const double ratio = static_cast<double>(i) / static_cast<double>(steps - 1);
    values.push_back(log ? from * det_exp(ratio * det_log(to / from)) : from + ratio * (to - from));
  }
  values.back() = to;
  return values;
}

std::vector<double> Entry::sweep(std::string_view key, const Range& range, std::size_t count_max,
                                 double fallback) const {
  const std::string what =
      std::string(range.what) + ", a list of such, or { from = 0.1, to = 4.0, steps = 6, log = true }";
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return {fallback};
  std::vector<double> values;
  if (const auto* fields = node->as_table()) {
    values = spread(Entry{*faults_, *fields, path(key)}, range, count_max);
  } else if (const auto* list = node->as_array()) {
    if (list->empty()) fault(key, "scenario.field", "expected " + what + ", found an empty list");
    if (list->size() > count_max)
      fault(key, "scenario.field", "a list has at most " + std::to_string(count_max) + " values");
    for (const toml::node& one : *list) {
      const auto value = number_of(one);
      if (!value || !within(*value, range)) {
        expected(key, range.what, one);
        return {fallback};
      }
      values.push_back(*value);
    }
  } else if (const auto value = number_of(*node); value && within(*value, range)) {
    values = {*value};
  } else {
    expected(key, what, *node);
  }
  if (values.empty()) return {fallback};
  std::ranges::sort(values);
  if (const auto twin = std::ranges::adjacent_find(values); twin != values.end())
    fault(key, "scenario.field", shortest(*twin) + " is in it twice");
  return values;
}

bool Entry::flag(std::string_view key, bool fallback) const {
  const toml::node* node = find(key, "true or false", true);
  if (node == nullptr) return fallback;
  if (const auto* value = node->as_boolean()) return value->get();
  expected(key, "true or false", *node);
  return fallback;
}

}  // namespace cosiva::experiments
