#include "cosiva/experiments/battery/recorded.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "cosiva/base/json_value.h"
#include "cosiva/base/text.h"

namespace cosiva::experiments {
namespace {

constexpr std::string_view blanks = " \t\r\"";
constexpr std::size_t runs_max = 10'000;
constexpr std::size_t result_bytes_max = 512U << 20U;

struct Unit {
  std::string_view ending;
  double seconds;
};
constexpr std::array units{Unit{"_second", 1.0}, Unit{"_seconds", 1.0}, Unit{"_s", 1.0},   Unit{"_minute", 60.0},
                           Unit{"_min", 60.0},   Unit{"_hour", 3600.0}, Unit{"_h", 3600.0}};
std::optional<double> seconds_of_unit(std::string_view name) {
  for (const Unit& unit : units)
    if (name.ends_with(unit.ending)) return unit.seconds;
  return std::nullopt;
}

/// Numbers ids in the order of their first occurrence.
class Numbering {
 public:
  std::size_t of(const std::string& id) { return numbers_.try_emplace(id, numbers_.size()).first->second; }
  [[nodiscard]] std::size_t size() const { return numbers_.size(); }

 private:
  std::map<std::string, std::size_t> numbers_;
};

class TableReader {
 public:
  TableReader(std::string_view csv, const std::string& origin, const RecordedColumns& columns)
      : lines_{csv}, origin_{origin}, wanted_{columns} {}

  Result<std::vector<RecordedSeries>> read() {
    if (!lines_.next(line_)) return fail("recorded.column", "is empty", origin_);
    if (auto header = read_header(); !header) return tl::unexpected(header.error());
    while (lines_.next(line_)) {
      if (trimmed(line_, blanks).empty()) continue;
      if (auto row = read_row(); !row) return tl::unexpected(row.error());
    }
    std::vector<RecordedSeries> all;
    for (Growing& one : growing_) {
      one.series.batteries = one.batteries.size();
      all.push_back(std::move(one.series));
    }
    if (all.empty()) return fail("recorded.number", "has no runs", origin_);
    return all;
  }

 private:
  struct Growing {
    RecordedSeries series;
    Numbering batteries;
    Numbering vehicles;
  };

  [[nodiscard]] std::string here() const { return origin_ + ":" + std::to_string(lines_.number()); }
  [[nodiscard]] std::string header_text() const {
    std::string there;
    for (const std::string& name : header_) there += (there.empty() ? "" : ", ") + name;
    return there;
  }

  /// The given column, else the first of the usual names that exists.
  Result<std::optional<std::size_t>> column(const std::string& wanted, const std::vector<std::string_view>& usual) {
    const auto location = [&](std::string_view name) -> std::optional<std::size_t> {
      const auto found = std::ranges::find(header_, name);
      if (found == header_.end()) return std::nullopt;
      return static_cast<std::size_t>(found - header_.begin());
    };
    if (!wanted.empty()) {
      const auto at = location(wanted);
      if (!at) return fail("recorded.column", "has no column '" + wanted + "'; there are " + header_text(), here());
      return at;
    }
    for (const std::string_view name : usual)
      if (const auto at = location(name)) return at;
    return std::nullopt;
  }

  Result<void> read_header() {
    if (line_.starts_with("\xEF\xBB\xBF")) line_.remove_prefix(3);  // a spreadsheet's byte order mark
    for (const std::string_view name : cut_at_commas(line_, blanks)) header_.emplace_back(name);
    if (std::ranges::find(header_, "voltage_volt") != header_.end())
      return fail("recorded.column", "is a log, sample by sample: `cosiva battery fit` reads those", here());
    const auto take = [&](std::optional<std::size_t>& location, const std::string& wanted,
                          const std::vector<std::string_view>& usual) -> Result<void> {
      auto found = column(wanted, usual);
      if (!found) return tl::unexpected(found.error());
      location = *found;
      return {};
    };
    std::optional<std::size_t> time;
    for (const auto& done :
         {take(battery_at_, wanted_.battery, {"battery_id", "battery", "cell_id", "cell", "id"}),
          take(vehicle_at_, wanted_.vehicle, {"vehicle", "vehicle_id", "aiv", "tester_channel", "channel"}),
          take(run_at_, wanted_.run, {"run", "run_number", "repeat"}), take(series_at_, {}, {"series"}),
          take(stop_at_, {}, {"stop", "stop_cause"}), take(time, wanted_.time, {"autonomy_s", "autonomy_second"})})
      if (!done) return done;
    if (!time) {
      // The only other column whose name begins or ends as a duration's.
      for (std::size_t i = 0; i < header_.size(); ++i) {
        if (!seconds_of_unit(header_[i]) || i == battery_at_ || i == vehicle_at_ || i == run_at_) continue;
        if (time)
          return fail("recorded.column",
                      "'" + header_[*time] + "' or '" + header_[i] + "': select the column of durations with --time",
                      here());
        time = i;
      }
    }
    if (!time)
      return fail("recorded.column",
                  "no column holds how long a battery lasted, such as 'autonomy_second'; there are " + header_text(),
                  here());
    const auto unit = seconds_of_unit(header_[*time]);
    if (!unit)
      return fail("recorded.column", "column '" + header_[*time] + "' lacks its unit: _second, _minute or _hour",
                  here());
    time_at_ = *time;
    unit_s_ = *unit;
    return {};
  }

  Result<void> read_row() {
    const std::vector<std::string_view> fields = cut_at_commas(line_, blanks);
    if (fields.size() != header_.size())
      return fail("recorded.number",
                  "has " + std::to_string(fields.size()) + " fields, the header " + std::to_string(header_.size()),
                  here());
    const auto lasted = number_of<double>(fields[time_at_]);
    if (!lasted || !(*lasted > 0.0))
      return fail("recorded.number",
                  header_[time_at_] + " is '" + std::string(fields[time_at_]) + "': expected more than 0", here());
    const auto field = [&](const std::optional<std::size_t>& at) {
      return at ? std::string(fields[*at]) : std::string{};
    };
    Growing& own = growing(series_at_ ? field(series_at_) : origin_);
    if (own.series.records.size() == runs_max || growing_.size() > runs_max)
      return fail("recorded.number",
                  "has more than " + std::to_string(runs_max) + " runs: the file may not be a table of runs", here());
    BatteryRun record;
    record.tag.id = battery_at_ ? field(battery_at_) : "line " + std::to_string(lines_.number());
    record.battery = own.batteries.of(record.tag.id);
    record.carrier = field(vehicle_at_);
    if (vehicle_at_ && number_of<double>(record.carrier)) record.carrier = header_[*vehicle_at_] + " " + record.carrier;
    record.vehicle = vehicle_at_ ? own.vehicles.of(record.carrier) : record.battery;
    record.autonomy_s = unit_s_ * *lasted;
    if (run_at_) {
      const auto run = number_of<int>(fields[*run_at_]);
      if (!run || *run < 1 || *run > 1'000'000)
        return fail("recorded.number",
                    header_[*run_at_] + " is '" + std::string(fields[*run_at_]) + "': runs count from 1", here());
      record.run = static_cast<std::size_t>(*run) - 1;
    }
    for (const BatteryRun& other : own.series.records) {
      if (other.battery != record.battery) continue;
      if (!run_at_) record.run = other.run + 1;
      if (other.run == record.run)
        return fail("recorded.twice",
                    "battery " + record.tag.id + " has run " + std::to_string(record.run + 1) +
                        " twice: tests that are not one need a column 'series'",
                    here());
    }
    if (stop_at_ && !field(stop_at_).empty()) {
      const auto stop = parse_stop(field(stop_at_));
      if (!stop)
        return fail(
            "recorded.stop",
            header_[*stop_at_] + " is '" + field(stop_at_) + "': expected floor, cut-off, fault, operator or lost",
            here());
      record.stop = *stop;
    }
    own.series.records.push_back(std::move(record));
    return {};
  }

  Growing& growing(const std::string& name) {
    for (Growing& one : growing_)
      if (one.series.name == name) return one;
    growing_.push_back({{name, 0, {}}, {}, {}});
    return growing_.back();
  }

  Lines lines_;
  const std::string& origin_;
  const RecordedColumns& wanted_;
  std::string_view line_;
  std::vector<std::string> header_;
  std::size_t time_at_{};
  double unit_s_{1.0};
  std::optional<std::size_t> battery_at_, vehicle_at_, run_at_, series_at_, stop_at_;
  std::vector<Growing> growing_;
};

Result<BatteryRun> run_of(const JsonValue& json, const std::string& origin) {
  BatteryRun run;
  const auto lasted = json.number("autonomy_s");
  const auto stop = parse_stop(json.text("stop").value_or(""));
  run.tag.id = json.text("id").value_or("");
  if (!lasted || !stop || run.tag.id.empty())
    return fail("recorded.result", "a run lacks 'id', 'autonomy_s' or 'stop'", origin);
  run.autonomy_s = *lasted;
  run.stop = *stop;
  run.run = static_cast<std::size_t>(std::clamp(json.number("run").value_or(1.0), 1.0, 1e6)) - 1;
  run.carrier = json.text("vehicle").value_or("");
  run.tag.type = json.text("type").value_or("");
  run.charge_ah = json.number("charge_ah").value_or(0.0);
  run.energy_wh = json.number("energy_wh").value_or(0.0);
  run.distance_m = json.number("distance_m").value_or(0.0);
  run.paused_s = json.number("paused_s").value_or(0.0);
  run.charge_end = json.number("charge_end").value_or(0.0);
  run.temperature_end_c = json.number("temperature_end_c").value_or(0.0);
  run.tag.cycles = json.number("cycles").value_or(0.0);
  return run;
}

}  // namespace

Result<std::vector<RecordedSeries>> read_recorded(std::string_view csv, const std::string& origin,
                                                  const RecordedColumns& columns) {
  return TableReader{csv, origin, columns}.read();
}

Result<RecordedSeries> read_results(const std::vector<RecordedFile>& files) {
  RecordedSeries all;
  Numbering batteries;
  Numbering vehicles;
  std::map<std::size_t, std::size_t> runs_before;  // of each battery, in the previous files
  for (const RecordedFile& file : files) {
    all.name += (all.name.empty() ? "" : ", ") + file.origin;
    const auto json = JsonValue::parse(file.text, result_bytes_max);
    if (!json) return fail("recorded.result", json.error().message, file.origin);
    const JsonValue* records = json->find("records");
    if (records == nullptr || records->array() == nullptr)
      return fail("recorded.result", "is no result of a battery test: it has no 'records'", file.origin);
    std::map<std::size_t, std::size_t> runs_here;
    for (const JsonValue& record : *records->array()) {
      auto run = run_of(record, file.origin);
      if (!run) return tl::unexpected(run.error());
      run->battery = batteries.of(run->tag.id);
      run->vehicle = vehicles.of(run->carrier);
      std::size_t& here = runs_here[run->battery];
      here = std::max(here, run->run + 1);
      run->run += runs_before[run->battery];
      all.records.push_back(std::move(*run));
    }
    for (const auto& [battery, runs] : runs_here) runs_before[battery] += runs;
  }
  all.batteries = batteries.size();
  return all;
}

Result<void> end_early(RecordedSeries& series, const std::string& battery_id, double after_s) {
  const std::string what = battery_id + " after " + std::to_string(after_s) + " s";
  for (BatteryRun& record : series.records) {
    if (record.tag.id != battery_id || record.run != 0) continue;
    if (!(after_s > 0.0 && after_s < record.autonomy_s))
      return fail("recorded.failed", "it lasted " + std::to_string(record.autonomy_s) + " s, no longer", what);
    record.autonomy_s = after_s;
    record.stop = StopCause::fault;
    return {};
  }
  return fail("recorded.failed", "there is no such battery in " + series.name, what);
}

}  // namespace cosiva::experiments
