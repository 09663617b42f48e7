// Fields that hold several values: what a campaign sweeps over.
#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"
#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/experiments/runs/scenario/toml_node.h"

namespace cosiva::experiments {
namespace {

bool within(double value, const Range& range) {
  return std::isfinite(value) && value <= range.high && (range.low_allowed ? value >= range.low : value > range.low);
}

}  // namespace

std::vector<std::string> Entry::some_of(std::string_view key, const std::vector<std::string_view>& words,
                                        const std::vector<std::string>& fallback) const {
  const toml::node* node = find(key, "", true);
  if (node == nullptr) return fallback;
  const auto* list = node->as_array();
  if (list == nullptr) return {one_of(key, words)};
  if (list->empty()) fault(key, "scenario.field", "expected one or more of " + listed(words) + ", found an empty list");
  std::vector<std::string> chosen;
  for (const toml::node& one : *list) {
    const auto* text = one.as_string();
    if (text == nullptr || std::ranges::find(words, text->get()) == words.end()) {
      const std::string_view near = text == nullptr ? std::string_view{} : nearest(text->get(), words);
      fault(key, "scenario.field",
            "expected some of " + listed(words) + ", found " + describe(one) +
                (near.empty() ? "" : "; did you mean " + quoted(near) + "?"));
      return fallback;
    }
    if (std::ranges::find(chosen, text->get()) != chosen.end())
      fault(key, "scenario.field", quoted(text->get()) + " is named twice");
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
  // Beyond that logarithms leave what is exact, and from a denormal number they leave the numbers.
  if (constexpr double decades_max = 1e15; log && !(to / from <= decades_max)) {
    fields.fault("to", "scenario.field", "expected at most 1e15 times from with log = true, found " + shortest(to));
    return {};
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < steps; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(steps - 1);
    values.push_back(log ? from * det_exp(share * det_log(to / from)) : from + share * (to - from));
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
