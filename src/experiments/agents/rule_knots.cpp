#include "cosiva/experiments/agents/rule_knots.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

/// Knots of one variable stay apart by this part of its range.
constexpr double apart_ratio = 0.01;
constexpr std::array<std::string_view, 5> kept{"instruction", "priority", "charge", "go", "by_instruction"};

std::string_view trimmed(std::string_view text) {
  const std::size_t from = text.find_first_not_of(" \t\r");
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(" \t\r") - from + 1);
}

/// The text after "key:" on this line; nothing: another line.
std::optional<std::string_view> after(std::string_view line, std::string_view key) {
  const std::string_view text = trimmed(line.substr(0, line.find('#')));
  if (!text.starts_with(key) || text.size() <= key.size() || text[key.size()] != ':') return std::nullopt;
  return trimmed(text.substr(key.size() + 1));
}

struct Number {
  std::size_t offset;
  std::size_t length;
  double value;
};

/// The words of `text` that are numbers, at their offsets in `whole`, of which `text` is a part.
std::vector<Number> numbers_in(std::string_view whole, std::string_view text) {
  std::vector<Number> numbers;
  for (std::size_t at = 0; at < text.size();) {
    at = text.find_first_not_of(" \t", at);
    if (at == std::string_view::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t", at), text.size());
    double value = 0.0;
    const char* const stop = text.data() + end;
    const auto [parsed, error] = std::from_chars(text.data() + at, stop, value);
    if (error == std::errc{} && parsed == stop && std::isfinite(value))
      numbers.push_back({static_cast<std::size_t>(text.data() + at - whole.data()), end - at, value});
    at = end;
  }
  return numbers;
}

/// At least one decimal, as the rule files have them.
std::string written(double value) {
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  COSIVA_EXPECT(error == std::errc{});
  std::string written(text.data(), end);
  return written.find('.') == std::string::npos ? written + ".0" : written;
}

double rounded(double value) { return std::nearbyint(100.0 * value) / 100.0; }

}  // namespace

Result<RuleKnots> RuleKnots::read(std::string_view fll, std::string_view origin,
                                  const std::vector<std::string>& variables) {
  if (auto rules = aiv::AgentRules::read(fll, origin); !rules) return tl::unexpected<Error>(rules.error());
  RuleKnots read;
  read.text_ = std::string(fll);
  const std::string_view text = read.text_;
  std::string variable;
  double low = 0.0;
  double high = 0.0;
  std::vector<Number> numbers;
  const auto end_variable = [&] {
    std::vector<double> values;
    values.reserve(numbers.size());
    for (const Number& number : numbers) values.push_back(number.value);
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    const std::size_t first = read.knots_.size();
    for (const double value : values) read.knots_.push_back({variable, value, low, high});
    for (const Number& number : numbers) {
      const auto found = std::ranges::lower_bound(values, number.value);
      read.occurrences_.push_back(
          {number.offset, number.length, first + static_cast<std::size_t>(found - values.begin())});
    }
    numbers.clear();
    variable.clear();
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    for (const std::string_view key : {"InputVariable", "OutputVariable", "RuleBlock"}) {
      const auto name = after(line, key);
      if (!name) continue;
      end_variable();
      const bool wanted = variables.empty() || std::ranges::find(variables, *name) != variables.end();
      if (key != "RuleBlock" && wanted && std::ranges::find(kept, *name) == kept.end()) variable = *name;
    }
    if (variable.empty()) continue;
    if (const auto range = after(line, "range")) {
      const auto ends = numbers_in(text, *range);
      if (ends.size() == 2) {
        low = ends[0].value;
        high = ends[1].value;
      }
    } else if (const auto term = after(line, "term")) {
      const auto more = numbers_in(text, *term);
      numbers.insert(numbers.end(), more.begin(), more.end());
    }
  }
  end_variable();
  for (const std::string& wanted : variables)
    if (std::ranges::find(read.knots_, wanted, &Knot::variable) == read.knots_.end())
      return fail("agents.variable", "the rules have no variable '" + wanted + "' with numbers that may be changed",
                  std::string(origin));
  return read;
}

std::vector<double> RuleKnots::values() const {
  std::vector<double> values;
  for (const Knot& knot : knots_) values.push_back(knot.value);
  return values;
}

std::vector<double> RuleKnots::repaired(std::vector<double> values) const {
  COSIVA_EXPECT(values.size() == knots_.size());
  for (std::size_t from = 0; from < knots_.size();) {
    std::size_t to = from;
    while (to < knots_.size() && knots_[to].variable == knots_[from].variable) ++to;
    const double apart = std::max(0.01, apart_ratio * (knots_[from].high - knots_[from].low));
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(from);
    std::sort(first, values.begin() + static_cast<std::ptrdiff_t>(to));
    for (std::size_t i = from; i < to; ++i) {
      const double lowest = i == from ? knots_[i].low : values[i - 1] + apart;
      const double highest = knots_[i].high - apart * static_cast<double>(to - 1 - i);
      values[i] = rounded(std::clamp(values[i], lowest, std::max(lowest, highest)));
    }
    from = to;
  }
  return values;
}

std::string RuleKnots::text_with(std::span<const double> values) const {
  COSIVA_EXPECT(values.size() == knots_.size());
  std::string text;
  std::size_t copied = 0;
  for (const Occurrence& occurrence : occurrences_) {
    text.append(text_, copied, occurrence.offset - copied);
    const double value = values[occurrence.knot];
    // An unchanged number stays as it was written.
    if (value == knots_[occurrence.knot].value)
      text.append(text_, occurrence.offset, occurrence.length);
    else
      text += written(value);
    copied = occurrence.offset + occurrence.length;
  }
  return text.append(text_, copied, std::string::npos);
}

}  // namespace cosiva::experiments
