#include "cosiva/experiments/runs/scenario/toml_entry.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::experiments {

using zone::describe;
using zone::in_quotes;
using zone::listed;
using zone::nearest;
using zone::number_of;
using zone::NumberRange;
using zone::toml_number;

namespace {

constexpr double coordinate_max_m = 1e5;
constexpr std::string_view point_text = "two numbers of metres [x, y] within ±100000";

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

}  // namespace

std::optional<std::string> Entry::peek(std::string_view table, std::string_view key) const {
  const toml::node* inner = table_here().get(table);
  const auto* fields = inner == nullptr ? nullptr : inner->as_table();
  const toml::node* node = fields == nullptr ? nullptr : fields->get(key);
  const auto* text = node == nullptr ? nullptr : node->as_string();
  return text == nullptr ? std::nullopt : std::optional<std::string>(text->get());
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
  fault(key, faults().code("field"),
        "expected " + what + ", found " + describe(*node) +
            (near.empty() ? "" : "; did you mean " + in_quotes(near) + "?"));
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
  if (const auto* value = node->as_table()) return Entry{faults(), *value, path(key)};
  expected(key, what, *node);
  return std::nullopt;
}

std::vector<Entry> Entry::tables(std::string_view key, std::size_t count_max) const {
  const std::string what = "at most " + std::to_string(count_max) + " tables, each under [[" + path(key) + "]]";
  std::vector<Entry> entries;
  for (const toml::table* entry : list(key, what, count_max))
    entries.emplace_back(faults(), *entry, entry_path(key, entries.size() + 1));
  return entries;
}

std::vector<std::string> Entry::some_of(std::string_view key, const std::vector<std::string_view>& terms,
                                        const std::vector<std::string>& fallback) const {
  const toml::node* node = find(key, "", true);
  if (node == nullptr) return fallback;
  const auto* list = node->as_array();
  if (list == nullptr) return {one_of(key, terms)};
  if (list->empty())
    fault(key, faults().code("field"), "expected one or more of " + listed(terms) + ", found an empty list");
  std::vector<std::string> chosen;
  for (const toml::node& one : *list) {
    const auto* text = one.as_string();
    if (text == nullptr || std::ranges::find(terms, text->get()) == terms.end()) {
      const std::string_view near = text == nullptr ? std::string_view{} : nearest(text->get(), terms);
      fault(key, faults().code("field"),
            "expected some of " + listed(terms) + ", found " + describe(one) +
                (near.empty() ? "" : "; did you mean " + in_quotes(near) + "?"));
      return fallback;
    }
    if (std::ranges::find(chosen, text->get()) != chosen.end())
      fault(key, faults().code("field"), in_quotes(text->get()) + " is given twice");
    chosen.push_back(text->get());
  }
  return chosen;
}

std::vector<double> Entry::spread(const Entry& fields, const NumberRange& range, std::size_t count_max) const {
  fields.expect_only({"from", "to", "steps", "log"});
  const double from = fields.number("from", range);
  const double to = fields.number("to", range);
  const auto steps = static_cast<std::size_t>(fields.whole("steps", 2, static_cast<std::int64_t>(count_max)));
  const bool log = fields.flag("log", false);
  if (faults().any()) return {};
  if (!(from < to)) {
    fields.fault("to", faults().code("field"),
                 "expected more than from = " + toml_number(from) + ", found " + toml_number(to));
    return {};
  }
  if (log && !(from > 0.0)) {
    fields.fault("from", faults().code("field"),
                 "expected a number over 0 with log = true, found " + toml_number(from));
    return {};
  }
  // With larger ratios logarithms are inexact, and with a denormal number they overflow.
  if (constexpr double decades_max = 1e15; log && !(to / from <= decades_max)) {
    fields.fault("to", faults().code("field"),
                 "expected at most 1e15 times from with log = true, found " + toml_number(to));
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

std::vector<double> Entry::sweep(std::string_view key, const NumberRange& range, std::size_t count_max,
                                 double fallback) const {
  const std::string what =
      std::string(range.what) + ", a list of such, or { from = 0.1, to = 4.0, steps = 6, log = true }";
  const toml::node* node = find(key, what, true);
  if (node == nullptr) return {fallback};
  std::vector<double> values;
  if (const auto* fields = node->as_table()) {
    values = spread(Entry{faults(), *fields, path(key)}, range, count_max);
  } else if (const auto* list = node->as_array()) {
    if (list->empty()) fault(key, faults().code("field"), "expected " + what + ", found an empty list");
    if (list->size() > count_max)
      fault(key, faults().code("field"), "a list has at most " + std::to_string(count_max) + " values");
    for (const toml::node& one : *list) {
      const auto value = number_of(one);
      if (!value || !range.contains(*value)) {
        expected(key, range.what, one);
        return {fallback};
      }
      values.push_back(*value);
    }
  } else if (const auto value = number_of(*node); value && range.contains(*value)) {
    values = {*value};
  } else {
    expected(key, what, *node);
  }
  if (values.empty()) return {fallback};
  std::ranges::sort(values);
  if (const auto twin = std::ranges::adjacent_find(values); twin != values.end())
    fault(key, faults().code("field"), toml_number(*twin) + " is in it twice");
  return values;
}

}  // namespace cosiva::experiments
