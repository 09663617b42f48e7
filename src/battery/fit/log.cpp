#include "cosiva/battery/fit/log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>

#include "cosiva/base/text.h"
#include "cosiva/battery/fit/discharge.h"
#include "cosiva/battery/fit/log_checks.h"
#include "cosiva/battery/fit/log_columns.h"

namespace cosiva::battery {
namespace {

constexpr std::size_t samples_min = 10;
constexpr std::size_t series_max = 1000;
/// Whether a column's name contains one of these words: "cell_id" contains "cell" and "id".
bool has_word(std::string_view name, std::initializer_list<std::string_view> terms) {
  while (!name.empty()) {
    const std::size_t end = std::min(name.find_first_of("_ -"), name.size());
    if (std::ranges::find(terms, name.substr(0, end)) != terms.end()) return true;
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return false;
}
bool belongs_to_samples(std::string_view name) {
  return has_word(name, {"step", "record", "data", "point", "sample", "row", "cycle", "index"});
}
/// Columns that state a sample's battery or test: each of their values is a series.
bool names_a_series(std::string_view name) {
  return !belongs_to_samples(name) && has_word(name, {"id", "cell", "series", "battery", "file", "channel"});
}
/// Columns that count, or may count: if one of these has changed when the time restarts, another series begins.
bool may_name_a_series(std::string_view name) {
  return has_word(name, {"rate", "number", "name", "run", "cycle", "id"});
}

std::string in_small_letters(std::string_view text) {
  std::string small{text};
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return small;
}

/// A log's time if a tester restarts it with each step of its test, or writes 0 for a step's first sample.
class StepTime {
 public:
  [[nodiscard]] bool goes_back(double raw_s) const { return is_begun_ && raw_s < raw_s_; }
  [[nodiscard]] bool begins_anew(double raw_s) const { return raw_s <= began_s_ + 0.05 * (raw_s_ - began_s_); }
  [[nodiscard]] bool is_other_step(const std::string& step) const { return step != step_; }
  [[nodiscard]] double last_s() const { return raw_s_; }

  /// The time of the next sample; `before` contains those until now, the last of which may be corrected.
  double next(double raw_s, const std::string& step, std::vector<double>& before) {
    if (!is_begun_) began_s_ = raw_s;
    const bool is_back = goes_back(raw_s);
    if (is_doubtful_ && !is_back && raw_s >= whole_s_) {  // only the time of that one sample was wrong
      ++slips_;
    } else if (is_doubtful_) {
      ++resets_;
      offset_s_ = before.back() - std::min(0.0, raw_s_);
      before.back() = offset_s_ + raw_s_;
    } else if (resets_ > 0 && !is_back && is_other_step(step)) {
      offset_s_ = before.back();
    }
    is_begun_ = true;
    step_ = step;
    is_doubtful_ = is_back;
    if (is_back) whole_s_ = raw_s_;
    raw_s_ = raw_s;
    return is_back ? before.back() : offset_s_ + raw_s;
  }

  [[nodiscard]] std::string diagnostic() const {
    if (resets_ > 0) return "the time restarts with each step: the steps are read one after the other";
    if (slips_ > 0)
      return std::to_string(slips_) +
             " steps begin with a sample whose time goes back: the previous sample's time is used";
    return {};
  }

 private:
  bool is_begun_{false};
  bool is_doubtful_{false};  ///< the last sample's time went back
  double began_s_{0.0};
  double raw_s_{0.0};     ///< the last one as written …
  double whole_s_{0.0};   ///< … and the one before it went back
  double offset_s_{0.0};  ///< of a step's times
  std::string step_;
  std::size_t slips_{0};
  std::size_t resets_{0};
};

/// A tester's own count of charge, which restarts at zero with each step, with each cycle or never; some testers
/// subtract a flow in the opposite direction.
class TesterCount {
 public:
  /// The increment since the last sample; 0 if the field is no number.
  double next(const std::optional<double>& count_ah) {
    if (!count_ah) return 0.0;
    const double before_ah = last_ah_.value_or(*count_ah);
    const bool begins_anew = *count_ah < 0.5 * before_ah;
    last_ah_ = count_ah;
    return *count_ah - (begins_anew ? 0.0 : before_ah);
  }

 private:
  std::optional<double> last_ah_;
};

/// Of a number as written; a large number if it has an exponent.
std::size_t digits_behind_point(std::string_view field) {
  constexpr std::size_t plenty = 12;
  if (field.find_first_of("eE") != std::string_view::npos) return plenty;
  const std::size_t point = field.find_first_of(".,");
  return point == std::string_view::npos ? 0 : std::min(plenty, field.size() - point - 1);
}

class Reader {
 public:
  Reader(std::string_view csv, const std::string& origin) : lines_{csv}, origin_{origin} {}

  Result<std::vector<Log>> read() {
    if (!lines_.next(line_)) return fail("log.column", "is empty", origin_);
    if (auto header = read_header(); !header) return tl::unexpected(header.error());
    while (lines_.next(line_)) {
      if (trimmed(line_, " \t\r\"").empty()) continue;
      if (auto row = read_row(); !row) return tl::unexpected(row.error());
    }
    if (auto percent = check_percent(); !percent) return tl::unexpected(percent.error());
    std::vector<Log> logs = finished();
    for (Log& log : logs) {
      if (log.time_s.size() < samples_min)
        return fail("log.short", "has " + std::to_string(log.time_s.size()) + " samples, which are too few", log.name);
      if (auto good = check_log(log); !good) return tl::unexpected(good.error());
      detect_load_changes(log);
    }
    if (logs.empty()) return fail("log.short", "has no samples", origin_);
    return logs;
  }

 private:
  [[nodiscard]] std::string here() const { return origin_ + ":" + std::to_string(lines_.number()); }

  /// The header is the first line, or, below a tester's preamble, the first valid one of forty.
  Result<void> read_header() {
    auto columns = read_columns(line_, here());
    constexpr std::size_t preamble_max = 40;
    Lines ahead = lines_;
    for (std::size_t i = 0; !columns && i < preamble_max && ahead.next(line_); ++i) {
      auto below = read_columns(line_, origin_ + ":" + std::to_string(ahead.number()));
      if (!below) continue;
      columns = std::move(below);
      lines_ = ahead;
    }
    if (!columns) return tl::unexpected(columns.error());
    columns_ = std::move(*columns);
    for (std::size_t i = 0; i < columns_.names.size(); ++i) {
      if (std::ranges::find(columns_.columns, i, &ColumnUnit::at) != columns_.columns.end()) continue;
      const std::string name = in_small_letters(columns_.names[i]);
      if (names_a_series(name))
        series_at_.push_back(i);
      else if (may_name_a_series(name))
        counters_at_.push_back(i);
    }
    ranges_.assign(columns_.names.size(),
                   {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
    return {};
  }

  Result<void> read_row() {
    std::vector<std::string_view> fields = cut_fields(line_, columns_.separator);
    while (fields.size() > columns_.names.size() && fields.back().empty()) fields.pop_back();
    if (fields.size() != columns_.names.size())
      return fail(
          "log.number",
          "has " + std::to_string(fields.size()) + " fields, the header " + std::to_string(columns_.names.size()),
          here());
    std::array<double, wanted_columns.size()> values{};
    for (std::size_t k = 0; k < wanted_columns.size(); ++k) {
      const std::string_view field = fields[columns_.columns[k].at];
      const auto value = value_of(fields, columns_.columns[k]);
      if (!value)
        return fail(
            "log.number",
            std::string(wanted_columns[k]) + " is '" + std::string(field) + "', not a number" + field_hint(field),
            here());
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

  [[nodiscard]] std::optional<double> value_of(const std::vector<std::string_view>& fields,
                                               const ColumnUnit& location) const {
    const auto value = field_number(fields[location.at], columns_.separator);
    if (!value) return std::nullopt;
    const double scaled = location.scale * *value + location.offset;
    return std::isfinite(scaled) ? std::optional{scaled} : std::nullopt;
  }

  /// A series under construction, with the first and last values of its counting columns.
  struct Growing {
    Log log;
    std::string key;
    std::vector<std::string> first;
    std::vector<std::string> last;
    std::vector<bool> is_steady;
    StepTime clock{};
    TesterCount out{};
    TesterCount in{};
    std::size_t count_digits{0};  ///< decimals of the tester's count
  };

  Result<void> book(const std::vector<std::string_view>& fields,
                    const std::array<double, wanted_columns.size()>& values) {
    std::string key;
    for (const std::size_t i : series_at_) key += ", " + columns_.names[i] + "=" + std::string(fields[i]);
    std::vector<std::string> counters;
    counters.reserve(counters_at_.size());
    for (const std::size_t i : counters_at_) counters.emplace_back(fields[i]);
    const std::string step = columns_.step ? std::string(fields[*columns_.step]) : std::string{};
    // The latest series with this key: rows of several batteries may be mixed.
    const auto found = std::ranges::find(growing_.rbegin(), growing_.rend(), key, &Growing::key);
    Growing* own = found == growing_.rend() ? nullptr : &*found;
    if (own != nullptr && own->clock.goes_back(values[0])) {
      const bool is_anew = own->clock.begins_anew(values[0]);
      if (is_anew && counters != own->last)
        own = nullptr;
      else if (!(is_anew && own->clock.is_other_step(step)))
        return fail(
            "log.time",
            "the time goes back from " + short_number(own->clock.last_s()) + " s to " + short_number(values[0]) + " s",
            here());
    }
    if (own == nullptr) {
      if (growing_.size() == series_max)
        return fail("log.column",
                    "columns that name a battery contain more than " + std::to_string(series_max) + " names", here());
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
    write_down(*own, fields, values, step);
    return {};
  }

  void write_down(Growing& own, const std::vector<std::string_view>& fields,
                  const std::array<double, wanted_columns.size()>& values, const std::string& step) {
    Log& log = own.log;
    // Two samples of the same time are the two sides of a step; the time between them is zero.
    log.time_s.push_back(own.clock.next(values[0], step, log.time_s));
    log.voltage_v.push_back(values[1]);
    log.current_a.push_back(-values[2]);
    log.line.push_back(lines_.number());
    if (columns_.temperature) {
      const auto celsius = value_of(fields, *columns_.temperature);
      log.temperature_c.push_back(celsius ? *celsius : log.temperature_c.empty() ? 25.0 : log.temperature_c.back());
    }
    if (!columns_.discharged || !columns_.charged) return;
    own.count_digits = std::max(own.count_digits, digits_behind_point(fields[columns_.discharged->at]));
    const double out_ah =
        own.out.next(value_of(fields, *columns_.discharged)) - own.in.next(value_of(fields, *columns_.charged));
    log.counted_ah.push_back((log.counted_ah.empty() ? 0.0 : log.counted_ah.back()) + out_ah);
  }

  /// A count with a resolution worse than one in five thousand of its total is no better than the samples.
  [[nodiscard]] bool is_fine(const Growing& one) const {
    if (one.log.counted_ah.empty()) return false;
    double quantum_ah = columns_.discharged->scale;
    for (std::size_t k = 0; k < one.count_digits; ++k) quantum_ah *= 0.1;
    return quantum_ah <= 2e-4 * charge_moved_ah(one.log);
  }

  /// "rates.csv, cell_id=B1, rate=1C": includes the values of counting columns that never changed.
  [[nodiscard]] std::vector<Log> finished() {
    std::vector<Log> logs;
    logs.reserve(growing_.size());
    for (Growing& one : growing_) {
      const auto logs_of_key = std::ranges::count(growing_, one.key, &Growing::key);
      for (std::size_t i = 0; i < counters_at_.size(); ++i)
        if (one.is_steady[i] &&
            (!belongs_to_samples(in_small_letters(columns_.names[counters_at_[i]])) || logs_of_key > 1))
          one.log.name += ", " + columns_.names[counters_at_[i]] + "=" + one.first[i];
      if (!is_fine(one)) one.log.counted_ah.clear();
      if (!columns_.diagnostic.empty())
        one.log.diagnostics.push_back(origin_ + ": read " + columns_.diagnostic +
                                      "; its current must charge where it is positive");
      if (const std::string diagnostic = one.clock.diagnostic(); !diagnostic.empty())
        one.log.diagnostics.push_back(one.log.name + ": " + diagnostic);
      logs.push_back(std::move(one.log));
    }
    return logs;
  }

  /// Names imply a range: a percentage that never exceeds 1 is a fraction, and the results would be too small by a
  /// factor of a hundred.
  Result<void> check_percent() const {
    for (std::size_t i = 0; i < columns_.names.size(); ++i) {
      const auto [low, high] = ranges_[i];
      if (!(high >= low)) continue;
      const std::string range = short_number(low) + " to " + short_number(high);
      const bool is_percent =
          columns_.names[i].find("percent") != std::string::npos || columns_.names[i].ends_with('%');
      if (is_percent && high <= 1.0 && high > 0.0 && low >= 0.0 && low < high)
        return fail("log.percent", "column '" + columns_.names[i] + "' goes from " + range + ": fractions, not percent",
                    origin_ + ":1");
      if (columns_.names[i].find("fraction") != std::string::npos && high > 1.5)
        return fail("log.percent", "column '" + columns_.names[i] + "' goes from " + range + ": percent, not fractions",
                    origin_ + ":1");
    }
    return {};
  }

  /// Rests are logged infrequently. If the last sample of a rest is further back than the load's sampling interval, it
  /// is repeated just before the load, so that the load's first sample does not count for the rest's time as well.
  static void detect_load_changes(Log& log) {
    double largest_a = 0.0;
    for (const double current : log.current_a) largest_a = std::max(largest_a, std::fabs(current));
    Log whole{log.name, {}, {}, {}, {}, log.origin, {}, {}, log.diagnostics};
    const std::size_t size = log.time_s.size();
    const auto copy = [&](std::size_t i, double time_s) {
      whole.time_s.push_back(time_s);
      whole.voltage_v.push_back(log.voltage_v[i]);
      whole.current_a.push_back(log.current_a[i]);
      whole.line.push_back(log.line[i]);
      if (!log.temperature_c.empty()) whole.temperature_c.push_back(log.temperature_c[i]);
      if (!log.counted_ah.empty()) whole.counted_ah.push_back(log.counted_ah[i]);
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
  LogColumns columns_;
  std::vector<std::size_t> series_at_;
  std::vector<std::pair<double, double>> ranges_;
  std::vector<std::size_t> counters_at_;
  std::vector<Growing> growing_;
};

}  // namespace

Result<std::vector<Log>> read_logs(std::string_view csv, const std::string& origin) {
  return Reader{csv, origin}.read();
}

}  // namespace cosiva::battery
