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

BatteryFigures figures_of(std::span<const BatteryRun> records, std::size_t battery) {
  BatteryFigures figures{battery, {}, 0, 0, nan, 0.0, 0.0, false, {}};
  double sum = 0.0;
  for (const BatteryRun& record : records) {
    if (record.battery != battery) continue;
    figures.id = record.tag.id;
    ++figures.runs;
    figures.lasted_at_least_s = std::max(figures.lasted_at_least_s, record.autonomy_s);
    if (record.ended())
      sum += record.autonomy_s;
    else
      ++figures.failed;
  }
  const auto ended = static_cast<double>(figures.runs - figures.failed);
  if (ended > 0.0) figures.autonomy_s = sum / ended;
  std::vector<double> runs;
  std::vector<double> values;
  for (const BatteryRun& record : records) {
    if (record.battery != battery || !record.ended()) continue;
    runs.push_back(static_cast<double>(record.run) + 1.0);
    values.push_back(record.autonomy_s);
  }
  figures.trend = statistics::trend(runs, values);
  return figures;
}

std::optional<VehicleEffect> vehicle_effect(std::span<const BatteryRun> records,
                                            const std::vector<BatteryFigures>& each) {
  // By vehicle: its name, and which batteries it carried.
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
  const auto variance = statistics::one_way(groups);
  if (!variance) return std::nullopt;
  effect.variance = *variance;
  return effect;
}

/// The straight line over runs, each battery's own level taken out; degrees of freedom as of the levels' fit.
std::optional<statistics::Trend> trend_of(std::span<const BatteryRun> records,
                                          const std::vector<BatteryFigures>& each) {
  std::vector<double> runs;
  std::vector<double> values;
  double level = 0.0;
  double count = 0.0;
  for (const BatteryFigures& one : each) {
    if (std::isnan(one.autonomy_s)) continue;
    level += one.autonomy_s;
    count += 1.0;
  }
  for (const BatteryRun& record : records) {
    const BatteryFigures& own = each[record.battery];
    if (!record.ended() || own.runs - own.failed < 2) continue;
    runs.push_back(static_cast<double>(record.run) + 1.0);
    values.push_back(record.autonomy_s - own.autonomy_s + level / count);
  }
  return statistics::trend(runs, values);
}

}  // namespace

AutonomyFigures analyse(std::span<const BatteryRun> records, std::size_t batteries, double wanted_half_width,
                        std::uint64_t seed) {
  AutonomyFigures figures;
  figures.batteries = batteries;
  std::vector<double> ended;
  std::vector<std::size_t> whose;
  std::vector<statistics::Duration> durations;
  for (std::size_t b = 0; b < batteries; ++b) {
    figures.each.push_back(figures_of(records, b));
    const BatteryFigures& one = figures.each.back();
    figures.failed += one.failed;
    if (std::isnan(one.autonomy_s)) {
      // Never seen to the end: it lasts longer than its longest run.
      if (one.lasted_at_least_s > 0.0) durations.push_back({one.lasted_at_least_s, false});
      continue;
    }
    ended.push_back(one.autonomy_s);
    whose.push_back(b);
    durations.push_back({one.autonomy_s, true});
  }
  for (const BatteryRun& record : records) {
    figures.runs = std::max(figures.runs, record.run + 1);
    figures.cut_off += record.stop == StopCause::cut_off ? 1U : 0U;
  }
  std::vector<double> counted;
  counted.reserve(durations.size());
  for (const statistics::Duration& one : durations) counted.push_back(one.value);
  figures.mean_if_counted_s = statistics::mean(counted);
  figures.at_s = statistics::mean(ended);
  figures.mean_s = figures.at_s;
  figures.sd_s = std::sqrt(statistics::sample_variance(ended));
  figures.method = "equation (4)";
  figures.mean_t = statistics::mean_interval(ended);
  if (ended.size() >= 10) figures.mean_bca = statistics::bca(ended, {0.95, 4000, seed});
  figures.sd_interval = statistics::deviation_interval(ended);
  figures.next = statistics::prediction_interval(ended);
  if (ended.size() >= 2)
    figures.tolerance_low_s = figures.mean_s - statistics::tolerance_factor(ended.size()) * figures.sd_s;
  if (!ended.empty()) figures.smallest_covers = statistics::ratio_above_smallest(ended.size());
  figures.grubbs = statistics::grubbs(ended);
  figures.normality_p = statistics::normality_p(ended);
  figures.survival = statistics::kaplan_meier(durations);
  figures.censored = statistics::censored_normal(durations);
  if (durations.size() > ended.size() && figures.censored) {
    figures.method = "normal, censored where a vehicle failed";
    figures.mean_s = figures.censored->mean;
    figures.sd_s = figures.censored->sd;
    figures.mean_t = figures.censored->mean_interval;
    figures.mean_bca.reset();
    figures.tolerance_low_s = figures.censored->tolerance_low;
    const double degrees = static_cast<double>(figures.censored->ended) - 1.0;
    const double half = statistics::student_quantile(0.975, degrees) * figures.sd_s *
                        std::sqrt(1.0 + 1.0 / figures.censored->effective_size);
    figures.next = statistics::Interval{figures.mean_s - half, figures.mean_s + half};
  }
  const std::vector<double> scores = statistics::robust_scores(ended);
  for (std::size_t i = 0; i < whose.size(); ++i) figures.each[whose[i]].robust_score = scores[i];
  if (figures.grubbs && figures.grubbs->is_outlier) figures.each[whose[figures.grubbs->index]].is_outlier = true;
  figures.trend = trend_of(records, figures.each);
  std::vector<statistics::Trial> trials;
  for (const BatteryRun& record : records)
    if (record.ended())
      trials.push_back({record.battery, record.vehicle, static_cast<double>(record.run) + 1.0, record.autonomy_s});
  if (figures.runs > 1 && batteries > 1) figures.crossed = statistics::crossed(trials);
  // Where batteries changed vehicles, what a vehicle makes of it must not hide the drift.
  if (figures.crossed && !figures.crossed->confounded && figures.trend) {
    figures.trend->slope = figures.crossed->slope;
    figures.trend->p = figures.crossed->run.p;
  }
  if (batteries == 1 && figures.runs > 1) {
    std::vector<double> runs;
    for (const BatteryRun& record : records)
      if (record.ended()) runs.push_back(record.autonomy_s);
    figures.runs_t = statistics::mean_interval(runs);
    figures.runs_sd_s = std::sqrt(statistics::sample_variance(runs));
  }
  figures.vehicles = vehicle_effect(records, figures.each);
  if (wanted_half_width > 0.0) figures.stopped_after = statistics::stops_at(ended, wanted_half_width);
  return figures;
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
