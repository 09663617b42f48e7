#include "cosiva/experiments/transport/traffic/jobs.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "cosiva/base/expect.h"
#include "cosiva/base/random.h"
#include "cosiva/base/text.h"

namespace cosiva::experiments {
namespace {

constexpr double jobs_max = 1e7;

/// Exponentially distributed with mean 1, by comparisons alone (von Neumann 1951): the same bits everywhere, which a
/// library's logarithm does not guarantee. A run of falling uniforms that ends at an even length continues with the
/// next integer.
double exponential(Random& random) {
  for (double whole = 0.0;; whole += 1.0) {
    const double first = random.uniform();
    double last = first;
    bool odd = true;
    for (;; odd = !odd) {
      const double next = random.uniform();
      if (next >= last) break;
      last = next;
    }
    if (odd) return whole + first;
  }
}

/// Splits a line into values. Values in quotation marks, as spreadsheets write names, may contain commas.
std::vector<std::string_view> values_of(std::string_view line) {
  constexpr std::string_view blanks = " \t\r";
  if (line.find('"') == std::string_view::npos) return cut_at_commas(line, blanks);
  std::vector<std::string_view> values;
  bool is_quoted = false;
  std::size_t begin = 0;
  for (std::size_t at = 0; at <= line.size(); ++at) {
    if (at < line.size() && line[at] == '"') is_quoted = !is_quoted;
    if (at < line.size() && (is_quoted || line[at] != ',')) continue;
    std::string_view value = trimmed(line.substr(begin, at - begin), blanks);
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
    values.push_back(value);
    begin = at + 1;
  }
  return values;
}

/// Reads one file, line by line.
///
/// Invariant: below the head, the columns of time, origin and destination are known.
class CsvReader {
 public:
  CsvReader(const zone::TrafficZone& zone, std::string_view origin) : zone_{zone}, origin_{origin} {}

  Result<void> read(std::string_view line, std::vector<Job>& jobs) {
    ++line_;
    const auto cells = values_of(line);
    if (cells.size() == 1 && cells[0].empty()) return {};
    if (!has_head_) return read_head(cells);
    if (cells.size() != columns_)
      return wrong(std::to_string(cells.size()) + " values for " + std::to_string(columns_) + " columns");
    COSIVA_EXPECT(at_[time] && at_[from] && at_[to]);
    Job job;
    const auto due_s = number_of<double>(cells[*at_[time]]);
    if (!due_s || !(*due_s >= 0.0 && *due_s <= 1e9))
      return wrong("time_s must be a number of seconds from 0, not '" + std::string(cells[*at_[time]]) + "'");
    job.due_s = *due_s;
    for (const auto& [column, station] : {std::pair{from, &job.from}, {to, &job.to}}) {
      const auto found = station_named(cells[*at_[column]]);
      if (!found) return wrong("zone '" + zone_.name + "' has no station '" + std::string(cells[*at_[column]]) + "'");
      *station = *found;
    }
    if (job.from == job.to)
      return wrong("the load is carried from '" + zone_.stations[job.from].name + "' to the same station");
    if (at_[priority]) {
      const auto value = number_of<std::int32_t>(cells[*at_[priority]]);
      if (!value || *value < 0 || *value > zone::priority_max) return wrong("priority is a whole number from 0 to 999");
      job.priority = *value;
    }
    jobs.push_back(job);
    return {};
  }
  [[nodiscard]] bool has_head() const { return has_head_; }
  [[nodiscard]] tl::unexpected<Error> wrong(std::string what) const {
    return fail("jobs.csv", std::move(what), origin_ + ":" + std::to_string(line_));
  }

 private:
  enum Column : std::size_t { time, from, to, priority, column_count };
  static constexpr std::array<std::string_view, column_count> names{"time_s", "from", "to", "priority"};

  Result<void> read_head(const std::vector<std::string_view>& cells) {
    has_head_ = true;
    columns_ = cells.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto name = std::ranges::find(names, cells[i]);
      if (name == names.end())
        return wrong("there is no column '" + std::string(cells[i]) +
                     "'; the columns are time_s, from, to and priority");
      auto& at = at_[static_cast<std::size_t>(name - names.begin())];
      if (at) return wrong("column '" + std::string(cells[i]) + "' is given twice");
      at = i;
    }
    for (const Column column : {time, from, to})
      if (!at_[column])
        return wrong("column '" + std::string(names[column]) + "' is missing; the first line names the columns");
    return {};
  }
  [[nodiscard]] std::optional<std::size_t> station_named(std::string_view name) const {
    const auto it = std::ranges::find(zone_.stations, name, &zone::Station::name);
    if (it == zone_.stations.end()) return std::nullopt;
    return static_cast<std::size_t>(it - zone_.stations.begin());
  }

  const zone::TrafficZone& zone_;
  std::string origin_;
  std::size_t line_{0};
  bool has_head_{false};
  std::size_t columns_{0};
  std::array<std::optional<std::size_t>, column_count> at_;
};

}  // namespace

std::vector<std::size_t> stops_of(const zone::TrafficZone& zone) {
  std::vector<std::size_t> stops;
  for (std::size_t i = 0; i < zone.stations.size(); ++i)
    if (zone.stations[i].kind == zone::StationKind::stop) stops.push_back(i);
  return stops;
}

Result<std::vector<Job>> poisson_jobs(const zone::TrafficZone& zone, double per_hour, double duration_s,
                                      std::uint64_t seed) {
  const std::vector<std::size_t> stops = stops_of(zone);
  if (stops.size() < 2) {
    return fail("jobs.stations", "jobs lead from one station to another, and zone '" + zone.name + "' has " +
                                     std::to_string(stops.size()) + " where vehicles stop for loads");
  }
  if (!(per_hour > 0.0) || !(per_hour * duration_s / 3600.0 <= jobs_max))
    return fail("jobs.rate", "jobs per hour must be more than 0, and make no more than ten million jobs");
  Random random{seed, "traffic/jobs"};
  std::vector<Job> jobs;
  const double mean_s = 3600.0 / per_hour;
  for (double due_s = mean_s * exponential(random); due_s < duration_s; due_s += mean_s * exponential(random)) {
    const std::size_t from = random.below(stops.size());
    const std::size_t other = random.below(stops.size() - 1);
    jobs.push_back({due_s, stops[from], stops[other + (other >= from ? 1 : 0)], 0});
  }
  return jobs;
}

Result<std::vector<Job>> jobs_from_csv(const zone::TrafficZone& zone, std::string_view csv, std::string_view origin) {
  std::vector<Job> jobs;
  CsvReader reader{zone, origin};
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (csv.starts_with(byte_order_mark)) csv.remove_prefix(byte_order_mark.size());
  Lines lines{csv};
  for (std::string_view line; lines.next(line);)
    if (auto read = reader.read(line, jobs); !read) return tl::unexpected(read.error());
  if (!reader.has_head()) return reader.wrong("the file is empty; its first line must be time_s,from,to");
  std::ranges::stable_sort(jobs, {}, &Job::due_s);
  return jobs;
}

}  // namespace cosiva::experiments
