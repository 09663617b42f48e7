#include "cosiva/experiments/transport/traffic/metrics.h"

#include <algorithm>
#include <cmath>

#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

void write(JsonWriter& json, std::string_view name, const std::vector<double>& values) {
  const Distribution d = distribution_of(values);
  json.key(name).begin_object().field("count", d.count).field("mean", d.mean).field("p50", d.p50);
  json.field("p90", d.p90).field("p99", d.p99).field("max", d.max).end_object();
}

std::string spread_text(const std::vector<double>& values) {
  const Distribution d = distribution_of(values);
  return "median " + readable(d.p50, 1) + " s, p90 " + readable(d.p90, 1) + " s, p99 " + readable(d.p99, 1) + " s";
}

}  // namespace

Distribution distribution_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  double sum = 0.0;
  for (const double value : values) sum += value;
  const auto n = static_cast<double>(values.size());
  const auto at = [&](double ratio) {
    return values[static_cast<std::size_t>(std::max(0.0, std::ceil(ratio * n) - 1.0))];
  };
  return {values.size(), sum / n, at(0.5), at(0.9), at(0.99), values.back()};
}

void write_json(JsonWriter& json, const TrafficMetrics& f) {
  json.begin_object().field("zone", f.zone).field("aivs", f.aivs).field("duration_s", f.duration_s);
  json.field("warm_up_s", f.warm_up_s).field("seed", f.seed).field("step_s", f.step_s).field("rules", f.rules);
  json.key("jobs").begin_object().field("due", f.jobs_due).field("done", f.jobs_done).field("open", f.jobs_open);
  json.field("per_hour", f.jobs_per_hour);
  write(json, "time_s", f.job_s);
  write(json, "wait_s", f.wait_s);
  json.end_object();
  json.key("laps").begin_object().field("per_hour", f.laps_per_hour);
  write(json, "time_s", f.lap_s);
  json.end_object();
  json.field("distance_m", f.distance_m).field("mean_speed_mps", f.mean_speed_mps).field("energy_wh", f.energy_wh);
  json.field("waiting_ratio", f.waiting_ratio).field("busy_ratio", f.busy_ratio);
  json.key("crossings").begin_array();
  for (const auto& crossing : f.crossings) {
    json.begin_object().field("name", crossing.name).field("grants", crossing.grants);
    json.field("waiting_s", crossing.waiting_s).end_object();
  }
  json.end_array();
  json.field("smallest_gap_m", f.smallest_gap_m).field("near_misses", f.near_misses);
  json.field("collisions", f.collisions).field("stuck", f.stuck);
  json.field("digest", f.digest).end_object();
}

std::string to_text(const TrafficMetrics& f) {
  std::string text = f.zone + ": " + std::to_string(f.aivs) + " AIVs, " + readable(f.duration_s / 60.0, 1) +
                     " min, seed " + std::to_string(f.seed) + ", rules " + f.rules + "\n";
  if (f.jobs_due > 0) {
    text += "  jobs    " + std::to_string(f.jobs_done) + " of " + std::to_string(f.jobs_due) + " done, " +
            readable(f.jobs_per_hour, 1) + " an hour; due to done: " + spread_text(f.job_s) + "\n";
    text += "          fetched after " + spread_text(f.wait_s) + "; AIVs have one " +
            readable(100.0 * f.busy_ratio, 1) + " % of their time\n";
  }
  if (!f.lap_s.empty())
    text += "  laps    " + readable(f.laps_per_hour, 1) + " an hour; " + spread_text(f.lap_s) + "\n";
  text += "  driven  " + readable(f.distance_m / 1000.0, 2) + " km at " + readable(f.mean_speed_mps, 3) +
          " m/s on average; waiting " + readable(100.0 * f.waiting_ratio, 1) + " % of the time\n";
  text += "  energy  " + readable(f.energy_wh, 1) + " Wh, " +
          readable(f.distance_m > 0.0 ? f.energy_wh / f.distance_m * 1000.0 : 0.0, 2) + " Wh a km\n";
  text += "  safety  " + std::to_string(f.collisions) + " collisions, " + std::to_string(f.near_misses) +
          " near misses, smallest gap " + readable(f.smallest_gap_m, 3) + " m; " + std::to_string(f.stuck) + " stuck\n";
  return text;
}

}  // namespace cosiva::experiments
