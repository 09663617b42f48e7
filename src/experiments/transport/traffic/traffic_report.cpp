#include "cosiva/experiments/transport/traffic/traffic_report.h"

#include <algorithm>
#include <utility>

#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"
#include "cosiva/experiments/transport/traffic/heat_map.h"

namespace cosiva::experiments {
namespace {

std::string percent(double ratio) { return readable(100.0 * ratio, 1) + " %"; }

std::vector<Report::MetadataField> metadata_of(const TrafficMetrics& f) {
  std::vector<Report::MetadataField> metadata;
  if (f.jobs_due > 0) {
    metadata.push_back({readable(f.jobs_per_hour, 1), "jobs an hour"});
    metadata.push_back({readable(distribution_of(f.job_s).p50, 1) + " s", "job, median"});
    metadata.push_back({percent(f.busy_ratio), "of their time AIVs have a job"});
  } else {
    metadata.push_back({readable(f.laps_per_hour, 1), "laps an hour"});
    metadata.push_back({readable(distribution_of(f.lap_s).p50, 1) + " s", "lap, median"});
  }
  metadata.push_back({percent(f.waiting_ratio), "of their time AIVs wait"});
  metadata.push_back({readable(f.mean_speed_mps, 3) + " m/s", "on average"});
  metadata.push_back({readable(f.energy_wh, 1) + " Wh", "taken by all, roughly"});
  metadata.push_back({std::to_string(f.collisions), "collisions", f.collisions > 0});
  metadata.push_back({std::to_string(f.near_misses), "near misses", f.near_misses > 0});
  metadata.push_back({std::to_string(f.stuck), "AIVs stuck at the end", f.stuck > 0});
  return metadata;
}

std::vector<std::string> spread_row(const std::string& name, const std::vector<double>& values) {
  const Distribution d = distribution_of(values);
  return {name,
          std::to_string(d.count),
          readable(d.mean, 1),
          readable(d.p50, 1),
          readable(d.p90, 1),
          readable(d.p99, 1),
          readable(d.max, 1)};
}

void add_times(Report& report, const TrafficMetrics& f) {
  report.heading("Times");
  std::vector<std::vector<std::string>> rows;
  if (!f.job_s.empty()) rows.push_back(spread_row("job, from due to done [s]", f.job_s));
  if (!f.wait_s.empty()) rows.push_back(spread_row("load waits for its AIV [s]", f.wait_s));
  if (!f.lap_s.empty()) rows.push_back(spread_row("lap [s]", f.lap_s));
  if (!rows.empty()) report.table({"", "how many", "mean", "median", "p90", "p99", "longest"}, rows);
  if (!f.job_s.empty())
    report.figure(to_svg(Histogram{{"job, from due to done [s]", 0.0, {}}, "jobs", f.job_s, 40}),
                  "How long jobs took.");
  else if (!f.lap_s.empty())
    report.figure(to_svg(Histogram{{"lap [s]", {}, {}}, "laps", f.lap_s, 40}), "How long laps took.");
  Chart chart{
      {"time [s]", {}, {}}, {"AIVs, jobs", 0.0, {}}, {{"waiting AIVs", f.time_s, f.stopped, Series::Form::steps}}};
  if (f.jobs_due > 0) chart.series.push_back({"unassigned jobs", f.time_s, f.open_jobs, Series::Form::steps});
  report.figure(to_svg(chart), "Waiting AIVs and unassigned jobs over time.");
}

void add_crossings(Report& report, const TrafficMetrics& f) {
  if (f.crossings.empty()) return;
  report.heading("Crossings");
  auto crossings = f.crossings;
  std::ranges::stable_sort(crossings, std::ranges::greater{}, &TrafficMetrics::Crossing::waiting_s);
  constexpr std::size_t shown_max = 20;
  Bars bars{"total waiting time [s]", {}};
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < std::min(shown_max, crossings.size()); ++i) {
    const auto& x = crossings[i];
    bars.bars.push_back({x.name, x.waiting_s});
    const double mean_s = x.grants > 0 ? x.waiting_s / static_cast<double>(x.grants) : 0.0;
    rows.push_back({x.name, std::to_string(x.grants), readable(x.waiting_s, 1), readable(mean_s, 2)});
  }
  report.figure(to_svg(bars), crossings.size() > shown_max ? "The twenty crossings with the longest waits."
                                                           : "Waiting time at each crossing.");
  report.table({"crossing", "passed", "waiting [s]", "waiting each [s]"}, rows);
}

std::string cell(const std::optional<double>& seconds) { return seconds ? readable(*seconds) : std::string{}; }

}  // namespace

std::string to_html(const zone::TrafficZone& zone, const TrafficMetrics& f, const std::string& command) {
  Report report{"Traffic on " + f.zone, std::to_string(f.aivs) + " AIVs, " + readable(f.duration_s / 60.0, 1) +
                                            " minutes after " + readable(f.warm_up_s, 0) + " s of warm-up, seed " +
                                            std::to_string(f.seed) + ", rules " + f.rules};
  report.metadata(metadata_of(f));
  report.heading("Waiting");
  report.figure(heat_map(zone, f, true), "Stopped without having arrived, by position.");
  report.heading("Occupancy");
  report.figure(heat_map(zone, f, false), "Occupied by a vehicle's body origin, by position.");
  add_times(report, f);
  add_crossings(report, f);
  report.heading("Reproduction");
  report.verbatim(command + "\ndigest " + f.digest);
  return report.html();
}

std::string jobs_csv(const zone::TrafficZone& zone, const Dispatcher& dispatcher, double until_s) {
  std::string csv = "due_s,from,to,priority,vehicle,given_s,fetched_s,done_s\n";
  const auto& jobs = dispatcher.jobs();
  for (std::size_t i = 0; i < jobs.size() && jobs[i].due_s <= until_s; ++i) {
    const Job& job = jobs[i];
    const JobCourse& course = dispatcher.courses()[i];
    csv += readable(job.due_s) + "," + zone.stations[job.from].name + "," + zone.stations[job.to].name + "," +
           std::to_string(job.priority) + ",";
    if (course.vehicle != virtual_side::Fleet::none) csv += "AIV" + std::to_string(course.vehicle + 1);
    csv += "," + cell(course.given_s) + "," + cell(course.fetched_s) + "," + cell(course.done_s) + "\n";
  }
  return csv;
}

}  // namespace cosiva::experiments
