#include "cosiva/experiments/positioning/campaign/result_page.h"

#include <algorithm>
#include <cmath>

#include "cosiva/experiments/positioning/campaign/result_text.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"

namespace cosiva::experiments {
namespace {

/// A chart has six colours: four algorithms, and the limits of smoothers and of filters.
constexpr std::size_t lines_per_chart = 4;
constexpr std::size_t charts_max = 24;
constexpr std::size_t rows_max = 500;

std::string mm(double metres) { return readable(1e3 * metres, 2); }

std::string evaluated_name(const CampaignPlan& plan) {
  return plan.evaluated == EvaluatedQuantity::p95 ? "p95" : "rmse";
}

std::vector<std::string> with_labels(const char* first, const std::vector<Swept>& factors) {
  std::vector<std::string> columns{first};
  for (const Swept swept : factors) columns.emplace_back(info_of(swept).label);
  return columns;
}

/// True for values a decade apart or more.
bool wide(const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::fmin(low, value);
    high = std::fmax(high, value);
  }
  return low > 0.0 && high >= 10.0 * low;
}

Series line_of(const Curve& curve, const std::string& name) {
  Series series{name, curve.x, {}, Series::Form::line};
  for (const Figure& y : curve.y) {
    series.y.push_back(1e3 * y.value);
    series.low.push_back(1e3 * (y.interval ? y.interval->low : y.value));
    series.high.push_back(1e3 * (y.interval ? y.interval->high : y.value));
  }
  return series;
}

Series limit_line(const Curve& curve, const std::string& name) {
  Series series{name, curve.x, {}, Series::Form::line};
  for (const double y : curve.limit) series.y.push_back(1e3 * y);
  series.dashed = true;
  return series;
}

class Page {
 public:
  Page(const CampaignResult& result, Report& report)
      : work_{result.work}, records_{result.records}, plan_{result.work.plan()}, report_{report} {}

  /// Draws all algorithms along a factor, as many per chart as it has colours.
  void add_charts(Swept factor, const Selection& selection, const std::string& caption) {
    for (std::size_t first = 0; first < plan_.algorithms.size(); first += lines_per_chart) {
      if (charts_++ >= charts_max) return;
      report_.figure(chart(factor, selection, first), caption);
    }
  }
  [[nodiscard]] bool full() const { return charts_ > charts_max; }

 private:
  [[nodiscard]] std::string chart(Swept factor, const Selection& selection, std::size_t first) const {
    Chart chart{{std::string(info_of(factor).label), {}, {}, wide(plan_.of(factor))},
                {evaluated_name(plan_) + " [mm]", {}, {}},
                {}};
    std::vector<Series> limits(2);
    std::vector<double> heights;
    const std::size_t end = std::min(first + lines_per_chart, plan_.algorithms.size());
    for (std::size_t i = first; i < end; ++i) {
      const Curve curve = curve_of(work_, records_, factor, i, selection);
      chart.series.push_back(line_of(curve, plan_.algorithms[i]));
      heights.insert(heights.end(), chart.series.back().y.begin(), chart.series.back().y.end());
      Series& limit = limits[work_.backtracks(i) ? 1 : 0];
      if (limit.x.empty() && plan_.evaluated == EvaluatedQuantity::rmse)
        limit = limit_line(curve, work_.backtracks(i) ? "limit of smoothers" : "limit");
    }
    for (Series& limit : limits)
      if (!limit.x.empty()) chart.series.push_back(std::move(limit));
    chart.y.logarithmic = wide(heights);
    if (!chart.y.logarithmic) chart.y.from = 0.0;
    return to_svg(chart);
  }

  const CampaignWork& work_;
  const std::vector<UnitRecord>& records_;
  const CampaignPlan& plan_;
  Report& report_;
  std::size_t charts_{0};
};

/// Charts by pitch, once for each surrounding, then by each factor over all others.
void add_curves(const CampaignResult& result, Report& report) {
  const CampaignPlan& plan = result.work.plan();
  const std::vector<Swept> swept = plan.swept();
  if (swept.empty()) return;
  Page page{result, report};
  report.heading("Error by swept factor");
  report.paragraph(
      "Bands: 95 % intervals over runs. Dashed: the limit, which no estimator can surpass with the readings "
      "that these runs had.");
  const std::size_t around = plan.algorithms.empty() ? 0 : result.summary.pitches_met.size() / plan.algorithms.size();
  for (std::size_t i = 0; i < around && !page.full(); ++i) {
    const Selection& at = result.summary.pitches_met[i * plan.algorithms.size()].at;
    const std::string where = to_string(plan, at);
    page.add_charts(Swept::pitch, at, "Against the pitch" + (where.empty() ? "" : ", " + where));
  }
  for (const Swept factor : swept) {
    if (factor == Swept::pitch && around == 1) continue;  // drawn already
    page.add_charts(factor, {}, std::string(info_of(factor).label) + ", over all values of the other factors");
  }
  if (page.full())
    report.paragraph("Not all combinations are drawn; cells.csv and campaign.sqlite contain all of them.");
}

void add_pitches(const CampaignResult& result, Report& report) {
  const CampaignPlan& plan = result.work.plan();
  const std::vector<PitchMet>& all = result.summary.pitches_met;
  if (all.empty()) return;
  report.heading("The pitch that meets " + mm(plan.tolerance_m) + " mm");
  std::vector<Swept> around;  // the factors with more than one value in the rows
  for (const Swept swept : plan.swept())
    if (all.front().at[static_cast<std::size_t>(swept)]) around.push_back(swept);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < std::min(all.size(), rows_max); ++i) {
    const PitchMet& met = all[i];
    rows.push_back({plan.algorithms[met.algorithm]});
    for (const Swept swept : around)
      rows.back().push_back(readable(plan.of(swept)[met.at[static_cast<std::size_t>(swept)].value_or(0)], 4));
    rows.back().push_back(to_string(met.pitch));
    rows.back().push_back(met.low && met.high ? to_string(*met.low) + " … " + to_string(*met.high) : "–");
    rows.back().push_back(met.limit ? to_string(*met.limit) : "–");
    if (plan.fiducials == Fiducials::grid) rows.back().push_back(to_string(met.worst));
  }
  std::vector<std::string> columns = with_labels("algorithm", around);
  for (const char* name : {"pitch [m]", "95 % [m]", "the limit's pitch [m]"}) columns.emplace_back(name);
  if (plan.fiducials == Fiducials::grid) columns.emplace_back("worst placement [m]");
  report.table(columns, rows);
  report.paragraph("The widest pitch at which the " + evaluated_name(plan) +
                   " stays within the tolerance, and at all narrower ones that were swept, interpolated between them "
                   "in logarithms. Its interval is where the error's 95 % interval passes the tolerance.");
  if (plan.fiducials == Fiducials::grid)
    report.paragraph(
        "Over all origins and rotations of the plan; the worst placement is the worst of them at each pitch.");
}

void add_cells(const CampaignResult& result, Report& report) {
  const CampaignPlan& plan = result.work.plan();
  const std::vector<CellMetrics>& cells = result.summary.cells;
  report.heading("Cells");
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < std::min(cells.size(), rows_max); ++i) {
    const CellMetrics& cell = cells[i];
    std::string interval = "–";
    if (cell.rmse_m.interval) interval = mm(cell.rmse_m.interval->low) + "–" + mm(cell.rmse_m.interval->high);
    rows.push_back({plan.algorithms[cell.algorithm]});
    const SweptValues values = plan.environment(cell.environment);
    for (const Swept swept : plan.swept()) rows.back().push_back(readable(value_of(values, swept), 4));
    for (const std::string& text :
         {mm(cell.rmse_m.value), interval, mm(cell.limit_m), readable(cell.gap_percent, 1) + (cell.leak ? " leak" : ""),
          mm(cell.p95_m.value), mm(cell.max_m), readable(100.0 * cell.precision, 1), readable(100.0 * cell.covered, 1),
          readable(cell.fiducials.spacing_m, 2), readable(cell.fiducials.longest_unread_m, 2)})
      rows.back().push_back(text);
  }
  std::vector<std::string> columns = with_labels("algorithm", plan.swept());
  for (const char* name : {"rmse [mm]", "95 % [mm]", "limit [mm]", "gap [%]", "p95 [mm]", "max [mm]", "precision [%]",
                           "95 % region covers [%]", "distance per beacon [m]", "longest distance without [m]"})
    columns.emplace_back(name);
  report.table(columns, rows);
  if (cells.size() > rows_max)
    report.paragraph("The first " + std::to_string(rows_max) + " of " + std::to_string(cells.size()) +
                     " cells; cells.csv and campaign.sqlite contain all of them.");
}

}  // namespace

std::string to_html(const CampaignResult& result, const std::string& plan_text) {
  const CampaignPlan& plan = result.work.plan();
  Report report{plan.name, "Position estimation swept on " + result.work.ground().zone->name + ", in virtual time"};
  report.metadata(
      {{std::to_string(plan.cells()), "cells"},
       {std::to_string(plan.votes()), "runs, over all algorithms"},
       {readable(1e-3 * plan.distance_m * plan.runs * static_cast<double>(plan.environments()), 1) + " km", "driven"},
       {std::to_string(result.summary.leaks), "cells below the limit", result.summary.leaks > 0}});
  add_pitches(result, report);
  add_curves(result, report);
  add_cells(result, report);
  report.heading("Reproduction");
  report.paragraph("cosiva campaign with this plan gives the same digest on any number of threads and processes.");
  report.verbatim(plan_text + "\ndigest " + result.summary.digest);
  return report.html();
}

}  // namespace cosiva::experiments
