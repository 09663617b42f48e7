#include "cosiva/experiments/battery/analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "cosiva/experiments/statistics/crossed.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

BatteryMetrics metrics_of(std::span<const BatteryRun> records, std::size_t battery) {
  BatteryMetrics metrics{battery, {}, 0, 0, nan, 0.0, 0.0, false, {}};
  double sum = 0.0;
  for (const BatteryRun& record : records) {
    if (record.battery != battery) continue;
    metrics.id = record.tag.id;
    ++metrics.runs;
    metrics.lasted_at_least_s = std::max(metrics.lasted_at_least_s, record.autonomy_s);
    if (record.ended())
      sum += record.autonomy_s;
    else
      ++metrics.failed;
  }
  const auto ended = static_cast<double>(metrics.runs - metrics.failed);
  if (ended > 0.0) metrics.autonomy_s = sum / ended;
  std::vector<double> runs;
  std::vector<double> values;
  for (const BatteryRun& record : records) {
    if (record.battery != battery || !record.ended()) continue;
    runs.push_back(static_cast<double>(record.run) + 1.0);
    values.push_back(record.autonomy_s);
  }
  metrics.trend = statistics::trend(runs, values);
  return metrics;
}

std::optional<VehicleEffect> vehicle_effect(std::span<const BatteryRun> records,
                                            const std::vector<BatteryMetrics>& each) {
  // By vehicle: its name, and the batteries that it carried.
  std::map<std::size_t, std::pair<std::string, std::set<std::size_t>>> carried;
  std::map<std::size_t, std::size_t> vehicle_of;
  for (const BatteryRun& record : records) {
    if (std::isnan(each[record.battery].autonomy_s)) continue;
    if (vehicle_of.try_emplace(record.battery, record.vehicle).first->second != record.vehicle) return std::nullopt;
    auto& [name, batteries] = carried[record.vehicle];
    name = vehicle_name(record);
    batteries.insert(record.battery);
  }
  VehicleEffect effect{};
  std::vector<std::vector<double>> groups;
  for (const auto& [vehicle, one] : carried) {
    if (one.second.size() < 2) continue;
    std::vector<double> values;
    for (const std::size_t battery : one.second) values.push_back(each[battery].autonomy_s);
    effect.groups.push_back(
        {one.first, values.size(), statistics::mean(values), std::sqrt(statistics::sample_variance(values))});
    groups.push_back(std::move(values));
  }
  const auto variance = statistics::one_factor(groups);
  if (!variance) return std::nullopt;
  effect.variance = *variance;
  return effect;
}

/// Fits a straight line over runs, with each battery's own level removed; degrees of freedom as of the levels' fit.
std::optional<statistics::Trend> trend_of(std::span<const BatteryRun> records,
                                          const std::vector<BatteryMetrics>& each) {
  std::vector<double> runs;
  std::vector<double> values;
  double level = 0.0;
  double count = 0.0;
  for (const BatteryMetrics& one : each) {
    if (std::isnan(one.autonomy_s)) continue;
    level += one.autonomy_s;
    count += 1.0;
  }
  for (const BatteryRun& record : records) {
    const BatteryMetrics& own = each[record.battery];
    if (!record.ended() || own.runs - own.failed < 2) continue;
    runs.push_back(static_cast<double>(record.run) + 1.0);
    values.push_back(record.autonomy_s - own.autonomy_s + level / count);
  }
  return statistics::trend(runs, values);
}

}  // namespace

AutonomyMetrics analyse(std::span<const BatteryRun> records, std::size_t batteries, double wanted_half_width,
                        std::uint64_t seed) {
  AutonomyMetrics metrics;
  metrics.batteries = batteries;
  std::vector<double> ended;
  std::vector<std::size_t> whose;
  std::vector<statistics::Duration> durations;
  for (std::size_t b = 0; b < batteries; ++b) {
    metrics.each.push_back(metrics_of(records, b));
    const BatteryMetrics& one = metrics.each.back();
    metrics.failed += one.failed;
    if (std::isnan(one.autonomy_s)) {
      // A battery whose end was never observed lasts longer than its longest run.
      if (one.lasted_at_least_s > 0.0) durations.push_back({one.lasted_at_least_s, false});
      continue;
    }
    ended.push_back(one.autonomy_s);
    whose.push_back(b);
    durations.push_back({one.autonomy_s, true});
  }
  for (const BatteryRun& record : records) {
    metrics.runs = std::max(metrics.runs, record.run + 1);
    metrics.cut_off += record.stop == StopCause::cut_off ? 1U : 0U;
  }
  std::vector<double> counted;
  counted.reserve(durations.size());
  for (const statistics::Duration& one : durations) counted.push_back(one.value);
  metrics.mean_if_counted_s = statistics::mean(counted);
  metrics.at_s = statistics::mean(ended);
  metrics.mean_s = metrics.at_s;
  metrics.sd_s = std::sqrt(statistics::sample_variance(ended));
  metrics.method = "equation (4)";
  metrics.mean_t = statistics::mean_interval(ended);
  if (ended.size() >= 10) metrics.mean_bca = statistics::bca(ended, {0.95, 4000, seed});
  metrics.sd_interval = statistics::deviation_interval(ended);
  metrics.next = statistics::prediction_interval(ended);
  if (ended.size() >= 2)
    metrics.tolerance_low_s = metrics.mean_s - statistics::tolerance_factor(ended.size()) * metrics.sd_s;
  if (!ended.empty()) metrics.smallest_covers = statistics::ratio_above_smallest(ended.size());
  metrics.grubbs = statistics::grubbs(ended);
  metrics.normality_p = statistics::normality_p(ended);
  metrics.survival = statistics::kaplan_meier(durations);
  metrics.censored = statistics::censored_normal(durations);
  if (durations.size() > ended.size() && metrics.censored) {
    metrics.method = "normal, censored where a vehicle failed";
    metrics.mean_s = metrics.censored->mean;
    metrics.sd_s = metrics.censored->sd;
    metrics.mean_t = metrics.censored->mean_interval;
    metrics.mean_bca.reset();
    metrics.tolerance_low_s = metrics.censored->tolerance_low;
    const double degrees = static_cast<double>(metrics.censored->ended) - 1.0;
    const double half = statistics::student_quantile(0.975, degrees) * metrics.sd_s *
                        std::sqrt(1.0 + 1.0 / metrics.censored->effective_size);
    metrics.next = statistics::Interval{metrics.mean_s - half, metrics.mean_s + half};
  }
  const std::vector<double> scores = statistics::robust_scores(ended);
  for (std::size_t i = 0; i < whose.size(); ++i) metrics.each[whose[i]].robust_score = scores[i];
  if (metrics.grubbs && metrics.grubbs->is_outlier) metrics.each[whose[metrics.grubbs->index]].is_outlier = true;
  metrics.trend = trend_of(records, metrics.each);
  std::vector<statistics::Trial> trials;
  for (const BatteryRun& record : records)
    if (record.ended())
      trials.push_back({record.battery, record.vehicle, static_cast<double>(record.run) + 1.0, record.autonomy_s});
  if (metrics.runs > 1 && batteries > 1) metrics.crossed = statistics::crossed(trials);
  // Where batteries changed vehicles, the vehicles' effect must not hide the drift.
  if (metrics.crossed && !metrics.crossed->confounded && metrics.trend) {
    metrics.trend->slope = metrics.crossed->slope;
    metrics.trend->p = metrics.crossed->run.p;
  }
  if (batteries == 1 && metrics.runs > 1) {
    std::vector<double> runs;
    for (const BatteryRun& record : records)
      if (record.ended()) runs.push_back(record.autonomy_s);
    metrics.runs_t = statistics::mean_interval(runs);
    metrics.runs_sd_s = std::sqrt(statistics::sample_variance(runs));
  }
  metrics.vehicles = vehicle_effect(records, metrics.each);
  if (wanted_half_width > 0.0) metrics.stopped_after = statistics::stops_at(ended, wanted_half_width);
  return metrics;
}

std::string duration_text(double seconds) {
  if (!std::isfinite(seconds)) return "unknown";
  const auto whole = static_cast<long long>(std::nearbyint(seconds));
  const auto two = [](long long number) { return (number < 10 ? "0" : "") + std::to_string(number); };
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return std::to_string(whole / 60) + " min " + two(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + two(whole / 60 % 60) + " min " + two(whole % 60) + " s";
}

}  // namespace cosiva::experiments
