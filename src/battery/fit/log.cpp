#include "battery/fit/log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>

#include "base/text.h"
#include "battery/fit/log_checks.h"

namespace cosiva::battery {
namespace {

constexpr std::size_t samples_min = 10;
constexpr std::size_t series_max = 1000;
/// Around fields, and quotes.
constexpr std::string_view blanks = " \t\r\"";

/// A quantity, its column's machine-readable name, and what other files call it.
struct Column {
  std::string_view name;
  std::string_view label;
  std::string_view stem;  ///< what names the quantity, whatever its unit
};
constexpr std::array columns{Column{"test_time_second", "Test Time / s", "test_time"},
                             Column{"voltage_volt", "Voltage / V", "voltage"},
                             Column{"current_ampere", "Current / A", "current"}};
constexpr std::array temperatures{Column{"temperature_t1_celsius", "Temperature T1 / degC", "temperature_t1"},
                                  Column{"ambient_temperature_celsius", "Ambient Temperature / degC", "ambient"}};

/// The words of a column's name: "cell_id" has "cell" and "id".
bool has_word(std::string_view name, std::initializer_list<std::string_view> words) {
  while (!name.empty()) {
    const std::size_t end = std::min(name.find_first_of("_ -"), name.size());
    if (std::ranges::find(words, name.substr(0, end)) != words.end()) return true;
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return false;
}
bool belongs_to_samples(std::string_view name) {
  return has_word(name, {"step", "record", "data", "point", "sample", "row", "cycle", "index"});
}
/// Columns that say which battery or test a sample is of: each of their values is a series.
bool names_a_series(std::string_view name) {
  return !belongs_to_samples(name) && has_word(name, {"id", "cell", "series", "battery", "file", "channel"});
}
/// Columns that count, or that may: where one of these has changed when the time starts anew, another series begins.
bool may_name_a_series(std::string_view name) {
  return has_word(name, {"rate", "number", "name", "run", "cycle", "id"});
}

class Reader {
 public:
  Reader(std::string_view csv, const std::string& origin) : lines_{csv}, origin_{origin} {}

  Result<std::vector<Log>> read() {
    if (!lines_.next(line_)) return fail("log.column", "is empty", origin_);
    if (auto header = read_header(); !header) return tl::unexpected(header.error());
    while (lines_.next(line_)) {
      if (trimmed(line_, blanks).empty()) continue;
      if (auto row = read_row(); !row) return tl::unexpected(row.error());
    }
    if (auto percent = check_percent(); !percent) return tl::unexpected(percent.error());
    std::vector<Log> logs = finished();
    for (Log& log : logs) {
      if (log.time_s.size() < samples_min)
        return fail("log.short", "has " + std::to_string(log.time_s.size()) + " samples, too few to say anything",
                    log.name);
      if (auto good = check_log(log); !good) return tl::unexpected(good.error());
      tell_when_loads_came(log);
    }
    if (logs.empty()) return fail("log.short", "has no samples", origin_);
    return logs;
  }

 private:
  [[nodiscard]] std::string here() const { return origin_ + ":" + std::to_string(lines_.number()); }

  Result<void> read_header() {
    if (line_.starts_with("\xEF\xBB\xBF")) line_.remove_prefix(3);  // a spreadsheet's mark
    for (const std::string_view name : cut_at_commas(line_, blanks)) header_.emplace_back(name);
    for (const char c : line_)
      if (static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r')
        return fail("log.column", "is no table of text", here());
    const auto find = [&](const Column& column) -> std::optional<std::size_t> {
      for (std::size_t i = 0; i < header_.size(); ++i)
        if (header_[i] == column.name || header_[i] == column.label) return i;
      return std::nullopt;
    };
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto at = find(columns[k]);
      if (!at) return missing(columns[k]);
      places_[k] = *at;
    }
    for (const Column& column : temperatures)
      if (!temperature_at_) temperature_at_ = find(column);
    for (std::size_t i = 0; i < header_.size(); ++i) {
      if (std::ranges::find(places_, i) != places_.end()) continue;
      if (names_a_series(header_[i]))
        series_at_.push_back(i);
      else if (may_name_a_series(header_[i]))
        counters_at_.push_back(i);
    }
    ranges_.assign(header_.size(), {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
    return {};
  }

  [[nodiscard]] tl::unexpected<Error> missing(const Column& column) const {
    for (const std::string& name : header_) {
      if (name.starts_with(column.stem))
        return fail("log.column",
                    "column '" + name + "' lacks its unit or has another: expected '" + std::string(column.name) + "'",
                    here());
    }
    std::string there;
    for (const std::string& name : header_) there += (there.empty() ? "" : ", ") + name;
    return fail("log.column", "column '" + std::string(column.name) + "' is missing; there are " + there, here());
  }

  Result<void> read_row() {
    const std::vector<std::string_view> fields = cut_at_commas(line_, blanks);
    if (fields.size() != header_.size())
      return fail("log.number",
                  "has " + std::to_string(fields.size()) + " fields, the header " + std::to_string(header_.size()),
                  here());
    std::array<double, columns.size()> values{};
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto value = number_of<double>(fields[places_[k]]);
      if (!value)
        return fail("log.number",
                    std::string(columns[k].name) + " is '" + std::string(fields[places_[k]]) + "', no number", here());
      values[k] = *value;
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (const auto value = number_of<double>(fields[i])) {
        ranges_[i].first = std::min(ranges_[i].first, *value);
        ranges_[i].second = std::max(ranges_[i].second, *value);
      }
    }
    return book(fields, values);
  }

  /// A series as it grows, and what its counting columns said first and last.
  struct Growing {
    Log log;
    std::string key;
    std::vector<std::string> first;
    std::vector<std::string> last;
    std::vector<bool> is_steady;
  };

  Result<void> book(const std::vector<std::string_view>& fields, const std::array<double, columns.size()>& values) {
    std::string key;
    for (const std::size_t i : series_at_) key += ", " + header_[i] + "=" + std::string(fields[i]);
    std::vector<std::string> counters;
    counters.reserve(counters_at_.size());
    for (const std::size_t i : counters_at_) counters.emplace_back(fields[i]);
    // The latest of this key: rows of several batteries may be mixed.
    const auto found = std::ranges::find(growing_.rbegin(), growing_.rend(), key, &Growing::key);
    Growing* own = found == growing_.rend() ? nullptr : &*found;
    if (own != nullptr && values[0] < own->log.time_s.back()) {
      const double began_s = own->log.time_s.front();
      const bool is_anew = values[0] <= began_s + 0.05 * (own->log.time_s.back() - began_s);
      if (!is_anew || counters == own->last)
        return fail("log.time",
                    "the time goes back from " + short_number(own->log.time_s.back()) + " s to " +
                        short_number(values[0]) + " s",
                    here());
      own = nullptr;
    }
    if (own == nullptr) {
      if (growing_.size() == series_max)
        return fail("log.column", "columns that name a battery say more than " + std::to_string(series_max) + " names",
                    here());
      growing_.push_back({{origin_ + key, {}, {}, {}, {}, origin_, {}},
                          key,
                          counters,
                          counters,
                          std::vector<bool>(counters.size(), true)});
      own = &growing_.back();
    }
    for (std::size_t i = 0; i < counters.size(); ++i)
      own->is_steady[i] = own->is_steady[i] && counters[i] == own->first[i];
    own->last = std::move(counters);
    Log& log = own->log;
    // Two samples of one instant are the two sides of a step; the time between them is nothing.
    log.time_s.push_back(values[0]);
    log.voltage_v.push_back(values[1]);
    log.current_a.push_back(-values[2]);
    log.line.push_back(lines_.number());
    if (temperature_at_) {
      const auto celsius = number_of<double>(fields[*temperature_at_]);
      log.temperature_c.push_back(celsius ? *celsius : log.temperature_c.empty() ? 25.0 : log.temperature_c.back());
    }
    return {};
  }

  /// "rates.csv, cell_id=B1, rate=1C": also what its counting columns say where they never changed.
  [[nodiscard]] std::vector<Log> finished() {
    std::vector<Log> logs;
    logs.reserve(growing_.size());
    for (Growing& one : growing_) {
      const auto logs_of_key = std::ranges::count(growing_, one.key, &Growing::key);
      for (std::size_t i = 0; i < counters_at_.size(); ++i)
        if (one.is_steady[i] && (!belongs_to_samples(header_[counters_at_[i]]) || logs_of_key > 1))
          one.log.name += ", " + header_[counters_at_[i]] + "=" + one.first[i];
      logs.push_back(std::move(one.log));
    }
    return logs;
  }

  /// Names promise a range: a percentage that never comes above 1 is a fraction, and the figures would be a hundredth.
  Result<void> check_percent() const {
    for (std::size_t i = 0; i < header_.size(); ++i) {
      const auto [low, high] = ranges_[i];
      if (!(high >= low)) continue;
      const std::string range = short_number(low) + " to " + short_number(high);
      const bool is_percent = header_[i].find("percent") != std::string::npos || header_[i].ends_with('%');
      if (is_percent && high <= 1.0 && high > 0.0 && low >= 0.0 && low < high)
        return fail("log.percent", "column '" + header_[i] + "' goes from " + range + ": fractions, not percent",
                    origin_ + ":1");
      if (header_[i].find("fraction") != std::string::npos && high > 1.5)
        return fail("log.percent", "column '" + header_[i] + "' goes from " + range + ": percent, not fractions",
                    origin_ + ":1");
    }
    return {};
  }

  /// A rest is logged seldom. Where its last sample lies further back than the load's samples lie apart, it is written
  /// once more just before the load, so that the load's first sample does not count for the rest's time as well.
  static void tell_when_loads_came(Log& log) {
    double largest_a = 0.0;
    for (const double current : log.current_a) largest_a = std::max(largest_a, std::fabs(current));
    Log whole{log.name, {}, {}, {}, {}, log.origin, {}};
    const std::size_t size = log.time_s.size();
    const auto copy = [&](std::size_t i, double time_s) {
      whole.time_s.push_back(time_s);
      whole.voltage_v.push_back(log.voltage_v[i]);
      whole.current_a.push_back(log.current_a[i]);
      whole.line.push_back(log.line[i]);
      if (!log.temperature_c.empty()) whole.temperature_c.push_back(log.temperature_c[i]);
    };
    for (std::size_t i = 0; i < size; ++i) {
      const bool load_comes =
          i > 0 && std::fabs(log.current_a[i - 1]) < 0.01 * largest_a && std::fabs(log.current_a[i]) > 0.05 * largest_a;
      if (load_comes && i + 1 < size) {
        const double usual_s = log.time_s[i + 1] - log.time_s[i];
        if (log.time_s[i] - log.time_s[i - 1] > 2.0 * usual_s) copy(i - 1, log.time_s[i] - usual_s);
      }
      copy(i, log.time_s[i]);
    }
    log = std::move(whole);
  }

  Lines lines_;
  const std::string& origin_;
  std::string_view line_;
  std::vector<std::string> header_;
  std::array<std::size_t, columns.size()> places_{};
  std::optional<std::size_t> temperature_at_;
  std::vector<std::size_t> series_at_;
  std::vector<std::pair<double, double>> ranges_;
  std::vector<std::size_t> counters_at_;
  std::vector<Growing> growing_;
};

}  // namespace

Result<std::vector<Log>> read_logs(std::string_view csv, const std::string& origin) {
  return Reader{csv, origin}.read();
}

std::vector<Discharge> discharges_from_full(const Log& log, double full_v, double full_ohm) {
  const std::size_t size = log.time_s.size();
  double largest_a = 0.0;
  for (const double current : log.current_a) largest_a = std::max(largest_a, std::fabs(current));
  const double load_a = 0.005 * largest_a;
  const auto is_full = [&](std::size_t i) { return log.voltage_v[i] >= 0.99 * full_v; };

  std::vector<Discharge> all;
  // At the log's begin it is full where a rest or the first sample under load says so, and it is not being charged.
  const double rested_v = log.voltage_v.front() + std::max(0.0, log.current_a.front()) * full_ohm;
  bool full = log.current_a.front() >= -load_a && (is_full(0) || rested_v >= 0.96 * full_v);
  for (std::size_t i = 0; i < size; ++i) {
    if (log.current_a[i] < -load_a) {
      full = is_full(i);
      continue;
    }
    if (!full || log.current_a[i] <= load_a) continue;
    Discharge one{&log, i, i, {}};
    double used_ah = 0.0;
    double most_ah = 0.0;
    for (; one.last < size; ++one.last) {
      const std::size_t k = one.last;
      const double since_s = k == i ? load_on_s(one) : log.time_s[k - 1];
      used_ah += log.current_a[k] * (log.time_s[k] - since_s) / 3600.0;
      most_ah = std::max(most_ah, used_ah);
      // A full charge of a pulse test's regeneration gives a little back; a recharge ends the discharge.
      if (most_ah - used_ah > 0.05 * most_ah && most_ah - used_ah > 1.0 / 3600.0 * 30.0 * largest_a &&
          log.current_a[k] < -load_a)
        break;
      one.used_ah.push_back(used_ah);
    }
    full = false;
    i = one.last - 1;
    all.push_back(std::move(one));
  }
  return all;
}

double highest_voltage_v(const std::vector<Log>& logs) {
  double volt = 0.0;
  for (const Log& log : logs) volt = std::max(volt, *std::ranges::max_element(log.voltage_v));
  return volt;
}

double lowest_under_load_v(const Discharge& discharge) {
  double volt = std::numeric_limits<double>::infinity();
  for (std::size_t i = discharge.first; i < discharge.last; ++i)
    if (discharge.log->current_a[i] > 0.0) volt = std::min(volt, discharge.log->voltage_v[i]);
  return volt;
}

double load_on_s(const Discharge& discharge) {
  const std::vector<double>& time_s = discharge.log->time_s;
  const std::size_t first = discharge.first;
  const double usual_s = first + 1 < time_s.size() ? time_s[first + 1] - time_s[first] : 0.0;
  if (first == 0) return std::max(std::min(0.0, time_s[0]), time_s[0] - usual_s);
  // A rest is logged more seldom than a load, and its last sample may lie far back.
  return std::max(time_s[first - 1], time_s[first] - usual_s);
}

double seconds_to_voltage(const Discharge& discharge, double voltage_v) {
  const Log& log = *discharge.log;
  const double start_s = load_on_s(discharge);
  for (std::size_t i = discharge.first; i < discharge.last; ++i) {
    if (log.voltage_v[i] > voltage_v) continue;
    if (i == discharge.first) return 0.0;
    const double share = (log.voltage_v[i - 1] - voltage_v) / (log.voltage_v[i - 1] - log.voltage_v[i]);
    return log.time_s[i - 1] + share * (log.time_s[i] - log.time_s[i - 1]) - start_s;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace cosiva::battery
