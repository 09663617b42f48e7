#include "cosiva/experiments/battery/autonomy_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "cosiva/experiments/battery/autonomy_output.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"
#include "cosiva/experiments/statistics/crossed.h"

namespace cosiva::experiments {
namespace {

constexpr std::size_t curves_max = 6;

std::string seconds_text(double seconds) { return duration_text(seconds) + " (" + readable(seconds, 0) + " s)"; }
std::string range_text(const std::optional<statistics::Interval>& interval) {
  return interval ? seconds_text(interval->low) + " to " + seconds_text(interval->high)
                  : std::string("needs two batteries");
}

/// Curves of the first run, one line each.
template <typename X, typename Y>
std::string curves(std::span<const BatteryRun> records, const char* x_label, const char* y_label, const X& x,
                   const Y& y) {
  Chart chart{{x_label, {}, {}}, {y_label, {}, {}}, {}};
  for (const BatteryRun& record : records) {
    if (record.run != 0 || chart.series.size() == curves_max) continue;
    Series series{record.tag.id, {}, {}, Series::Form::line};
    double used_ah = 0.0;
    for (std::size_t i = 0; i < record.curve.size(); ++i) {
      const BatterySample& sample = record.curve[i];
      if (i > 0)
        used_ah += 0.5 * (record.curve[i - 1].current_a + sample.current_a) *
                   to_seconds(sample.at - record.curve[i - 1].at) / 3600.0;
      series.x.push_back(x(record, sample, used_ah));
      series.y.push_back(y(sample));
    }
    chart.series.push_back(std::move(series));
  }
  return to_svg(chart);
}

/// Draws voltage, charge and temperature, each over time, distance driven and charge taken out.
void add_curves(Report& report, std::span<const BatteryRun> records) {
  if (std::ranges::all_of(records, [](const BatteryRun& record) { return record.curve.empty(); })) return;
  using Across = double (*)(const BatteryRun&, const BatterySample&, double used_ah);
  using Up = double (*)(const BatterySample&);
  struct X {
    const char* label;
    const char* text;
    Across of;
  };
  struct Y {
    const char* label;
    const char* text;
    Up of;
  };
  constexpr std::array<X, 3> across{
      {{"time [h]", "time",
        [](const BatteryRun& record, const BatterySample& sample, double) {
          return to_seconds(sample.at - record.started) / 3600.0;
        }},
       {"driven [m]", "the distance driven",
        [](const BatteryRun& record, const BatterySample& sample, double) {
          return sample.distance_m - record.curve.front().distance_m;
        }},
       {"discharged [Ah]", "the charge taken out",
        [](const BatteryRun&, const BatterySample&, double used_ah) { return used_ah; }}}};
  constexpr std::array<Y, 3> up{
      {{"voltage [V]", "Voltage, as measured on board", [](const BatterySample& s) { return s.voltage_v; }},
       {"charge [%]", "Charge, as estimated by the gauges", [](const BatterySample& s) { return 100.0 * s.charge; }},
       {"temperature [°C]", "Temperature", [](const BatterySample& s) { return s.temperature_c; }}}};
  report.heading("Discharge");
  report.paragraph("The first run of each battery; at most six are drawn.");
  for (const Y& y : up)
    for (const X& x : across)
      report.figure(curves(records, x.label, y.label, x.of, y.of), std::string(y.text) + ", over " + x.text + ".");
}

std::string survival_svg(const statistics::Survival& survival) {
  Chart chart{{"autonomy [h]", {}, {}}, {"still running [%]", 0.0, 100.0}, {}};
  Series ratio{"ratio", {0.0}, {100.0}, Series::Form::steps};
  Series low{"95 % band, low", {0.0}, {100.0 * survival.band_before.low}, Series::Form::steps};
  Series high{"95 % band, high", {0.0}, {100.0 * survival.band_before.high}, Series::Form::steps};
  for (const statistics::SurvivalStep& step : survival.steps) {
    for (Series* series : {&ratio, &low, &high}) series->x.push_back(step.at / 3600.0);
    ratio.y.push_back(100.0 * step.ratio);
    low.y.push_back(100.0 * step.band.low);
    high.y.push_back(100.0 * step.band.high);
  }
  chart.series = {ratio, low, high};
  return to_svg(chart);
}

/// The gauge's error at the record's samples; the ground truth is interpolated to their times.
std::string gauge_svg(std::span<const BatteryRun> records, std::span<const TrueEnd> ground_truth) {
  Chart chart{{"time [h]", {}, {}}, {"gauge − ground truth [percent]", {}, {}}, {}};
  for (const TrueEnd& end : ground_truth) {
    if (end.run != 0 || chart.series.size() == curves_max) continue;
    for (const BatteryRun& record : records) {
      if (record.run != end.run || record.vehicle != end.vehicle) continue;
      Series series{record.tag.id, {}, {}, Series::Form::line};
      std::size_t k = 0;
      for (const BatterySample& sample : record.curve) {
        const double at_s = to_seconds(sample.at - record.started);
        while (k + 1 < end.curve_s.size() && end.curve_s[k + 1] <= at_s) ++k;
        if (k + 1 >= end.curve_s.size()) break;
        const double t = (at_s - end.curve_s[k]) / (end.curve_s[k + 1] - end.curve_s[k]);
        const double charge = end.curve_charge[k] + t * (end.curve_charge[k + 1] - end.curve_charge[k]);
        series.x.push_back(at_s / 3600.0);
        series.y.push_back(100.0 * (sample.charge - charge));
      }
      chart.series.push_back(std::move(series));
    }
  }
  return to_svg(chart);
}

void add_statement(Report& report, const AutonomyMetrics& metrics, const ReportMetadata& metadata) {
  report.heading("Statement");
  report.metadata({{duration_text(metrics.mean_s), "mean autonomy, AT"},
                   {metrics.tolerance_low_s ? duration_text(*metrics.tolerance_low_s) : "–",
                    "95 % last longer, with 95 % confidence"},
                   {std::to_string(metrics.batteries), metrics.batteries == 1 ? "battery" : "batteries"},
                   {std::to_string(metrics.failed), "runs failed", metrics.failed > 0}});
  std::vector<std::vector<std::string>> rows{
      {"Battery type", metadata.type},
      {"Data of the type", metadata.source},
      {"Licence of the data", metadata.licence},
      {"Load", metadata.load},
      {"Floor", metadata.floor ? readable(100.0 * *metadata.floor, 1) + " % by the gauge, for 3 s"
                               : std::string("as it was measured")},
      {"Mean autonomy", seconds_text(metrics.mean_s) + ", " + metrics.method},
      {"95 % interval of the mean, Student", range_text(metrics.mean_t)}};
  if (metrics.runs_t)
    rows.push_back({"Of this battery's runs alone: standard deviation; 95 % interval of their mean",
                    seconds_text(metrics.runs_sd_s) + "; " + range_text(metrics.runs_t)});
  if (metrics.mean_bca) rows.push_back({"95 % interval of the mean, BCa bootstrap", range_text(metrics.mean_bca)});
  if (metrics.sd_interval)
    rows.push_back({"Standard deviation, and its upper bound",
                    seconds_text(metrics.sd_s) + "; " + seconds_text(metrics.sd_interval->high)});
  rows.push_back({"The next single battery, 95 %", range_text(metrics.next)});
  rows.push_back({"Above the smallest, whatever the distribution",
                  readable(100.0 * metrics.smallest_covers, 0) + " % with 95 % confidence"});
  if (const auto b10 = metrics.survival.when_ended(0.1))
    rows.push_back({"B10: one in ten has ended", seconds_text(*b10)});
  if (metrics.trend)
    rows.push_back({"Drift per run", readable(metrics.trend->slope, 2) + " s, p " + chance_text(metrics.trend->p) +
                                         "; at run 1 " + seconds_text(metrics.trend->at_first)});
  if (metrics.normality_p) rows.push_back({"Normality (Anderson–Darling), p", readable(*metrics.normality_p, 3)});
  report.table({"what", "figure"}, rows);
}

void add_records(Report& report, const AutonomyMetrics& metrics, std::span<const BatteryRun> records,
                 std::span<const TrueEnd> ground_truth) {
  report.heading("Runs");
  std::vector<std::vector<std::string>> rows;
  for (const BatteryRun& record : records) {
    const BatteryMetrics& own = metrics.each[record.battery];
    std::string true_end = "–";
    for (const TrueEnd& end : ground_truth)
      if (end.run == record.run && end.vehicle == record.vehicle) true_end = readable(100.0 * end.charge, 2);
    rows.push_back({record.tag.id + (own.is_outlier ? " (outlier, kept)" : ""), std::to_string(record.run + 1),
                    vehicle_name(record), readable(record.autonomy_s, 1), std::string(to_string(record.stop)),
                    readable(record.charge_ah, 3), readable(record.energy_wh, 2), readable(record.distance_m, 0),
                    readable(record.tag.cycles, 1), readable(record.temperature_end_c, 1),
                    readable(100.0 * record.charge_end, 2), true_end});
  }
  report.table({"battery", "run", "vehicle", "autonomy [s]", "stopped by", "Ah", "Wh", "m", "cycles", "°C", "gauge [%]",
                "true [%]"},
               rows);
}

void add_variance(Report& report, const AutonomyMetrics& metrics) {
  if (!metrics.crossed) return;
  report.heading("Where the differences come from");
  const statistics::Crossed& crossed = *metrics.crossed;
  if (crossed.confounded) {
    report.paragraph(
        "Each battery stayed on its vehicle: battery and vehicle effects cannot be separated. Run with --swap.");
    return;
  }
  report.figure(to_svg(Bars{"part of variance [%]",
                            {{"battery", 100.0 * crossed.unit.ratio},
                             {"vehicle", 100.0 * crossed.carrier.ratio},
                             {"run", 100.0 * crossed.run.ratio},
                             {"rest", 100.0 * crossed.noise_ratio}}}),
                "Parts of variance: battery F " + readable(crossed.unit.f, 1) + " (p " + chance_text(crossed.unit.p) +
                    "), vehicle F " + readable(crossed.carrier.f, 1) + " (p " + chance_text(crossed.carrier.p) +
                    "), slope " + readable(crossed.slope, 2) + " s per run.");
}

}  // namespace

std::string report_html(const AutonomyMetrics& metrics, std::span<const BatteryRun> records,
                        std::span<const TrueEnd> ground_truth, const ReportMetadata& metadata) {
  Report report{"Autonomy of " + metadata.type,
                std::to_string(metrics.batteries) + " batteries, " + std::to_string(records.size()) + " runs"};
  add_statement(report, metrics, metadata);
  report.page_break();
  add_curves(report, records);
  if (!ground_truth.empty())
    report.figure(gauge_svg(records, ground_truth),
                  "Gauge against ground truth, which only an emulated battery has. The test itself does not use it.");
  if (!metrics.survival.steps.empty())
    report.figure(survival_svg(metrics.survival),
                  "Ratio of batteries still running (Kaplan and Meier), with its pointwise 95 % band.");
  add_variance(report, metrics);
  add_records(report, metrics, records, ground_truth);
  report.heading("Again");
  report.verbatim(metadata.command);
  return report.html();
}

}  // namespace cosiva::experiments
