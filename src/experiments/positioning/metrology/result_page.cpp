#include "cosiva/experiments/positioning/metrology/result_page.h"

#include <algorithm>
#include <cmath>

#include "cosiva/experiments/positioning/metrology/result_bars.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

constexpr std::size_t colours = 6;

std::string mm(double metres, int digits = 2) { return readable(1e3 * metres, digits); }

std::vector<const Qualified*> figured(const Qualification& all) {
  std::vector<const Qualified*> ones;
  for (const Qualified& one : all.algorithms) {
    if (!one.failed) ones.push_back(&one);
  }
  return ones;
}

/// As many as a chart has colours, the best first.
std::vector<const Qualified*> drawn(const Qualification& all, std::size_t most = colours) {
  auto ones = figured(all);
  std::ranges::stable_sort(ones, {}, [](const Qualified* one) { return one->rmse_m.value; });
  if (ones.size() > most) ones.resize(most);
  return ones;
}

std::string chance(double p) { return p < 1e-4 ? "< 0.0001" : readable(p, 4); }

std::string with_interval(const Figure& figure, double factor) {
  std::string text = readable(factor * figure.value, 2);
  if (figure.interval)
    text += " (" + readable(factor * figure.interval->low, 2) + (figure.interval->low < 0.0 ? " to " : "–") +
            readable(factor * figure.interval->high, 2) + ")";
  return text;
}

void add_table(Report& report, const Qualification& all) {
  std::vector<std::vector<std::string>> rows;
  for (const Qualified& one : all.algorithms) {
    if (one.failed) {
      rows.push_back({one.name, "failed: " + to_string(*one.failed), "", "", "", "", "", ""});
      continue;
    }
    rows.push_back({one.name, with_interval(one.rmse_m, 1e3), one.limit_m ? mm(*one.limit_m) : "–",
                    one.gap_percent
                        ? readable(*one.gap_percent, 1) + (one.leak ? " leak" : (one.limit_assumed ? " (assumed)" : ""))
                        : "–",
                    with_interval(one.mean_m, 1e3), readable(1e6 * one.variance_m2, 2),
                    with_interval(one.precision, 100.0),
                    mm(one.p50_m, 1) + " / " + mm(one.p95_m, 1) + " / " + mm(one.p99_m, 1) + " / " + mm(one.max_m, 1)});
  }
  report.table({"algorithm", "rmse [mm]", "limit [mm]", "gap [%]", "mean [mm]", "variance [mm²]", "precision [%]",
                "p50 / p95 / p99 / max [mm]"},
               rows);
}

std::string in_band(double value, double low, double high) {
  return readable(value, 2) + " (" + readable(low, 2) + "–" + readable(high, 2) + ")";
}

/// Prints whether the stated uncertainties are realistic.
void add_honesty(Report& report, const Qualification& all) {
  std::vector<std::vector<std::string>> rows;
  for (const Qualified* one : figured(all)) {
    rows.push_back({one->name, in_band(0.5 * one->nees, 0.5 * one->nees_band.low, 0.5 * one->nees_band.high),
                    one->nis_band ? in_band(one->nis, one->nis_band->low, one->nis_band->high) : "–"});
    for (const double covered : one->covered) rows.back().push_back(readable(100.0 * covered, 1));
  }
  report.table(
      {"algorithm", "NEES/2", "NIS per dimension", "50 % region covers [%]", "90 % region [%]", "95 % region [%]"},
      rows);
}

void add_splits(Report& report, const Qualification& all) {
  std::vector<std::string> titles{"algorithm", "along: rmse [mm]", "bias [mm]", "across: rmse [mm]",
                                  "bias [mm]", "straights [mm]",   "arcs [mm]", "clothoids [mm]"};
  constexpr auto shaped = static_cast<std::size_t>(zone::SectionKind::shaped);
  const bool some_shaped =
      std::ranges::any_of(figured(all), [](const Qualified* one) { return one->by_section[shaped].iterations > 0; });
  if (some_shaped) titles.emplace_back("other kinds [mm]");
  std::vector<std::vector<std::string>> rows;
  for (const Qualified* one : figured(all)) {
    rows.push_back(
        {one->name, mm(one->along_rmse_m), mm(one->along_bias_m), mm(one->across_rmse_m), mm(one->across_bias_m)});
    for (std::size_t kind = 0; kind < shaped + (some_shaped ? 1 : 0); ++kind)
      rows.back().push_back(mm(one->by_section[kind].rmse_m()));
  }
  report.table(titles, rows);
}

std::string trajectory(const Qualification& all, const Conditions& conditions) {
  Chart chart{{"x [m]", {}, {}}, {"y [m]", {}, {}}, {}};
  const auto line = [](const std::string& name, const std::vector<Pose2>& path) {
    Series series{name, {}, {}, Series::Form::line};
    const std::size_t stride = path.size() / 3000 + 1;
    for (std::size_t i = 0; i < path.size(); i += stride) {
      series.x.push_back(path[i].x_m);
      series.y.push_back(path[i].y_m);
    }
    return series;
  };
  chart.series.push_back(line("ground truth", all.ground_truth));
  for (const Qualified* one : drawn(all, colours - 1)) chart.series.push_back(line(one->name, one->path));
  for (const std::vector<Point2>& one : conditions.lines) {
    Series ground;
    for (const Point2 p : one) {
      ground.x.push_back(p.x_m);
      ground.y.push_back(p.y_m);
    }
    chart.ground.push_back(std::move(ground));
  }
  chart.equal_scale = true;
  return to_svg(chart);
}

std::string error_over_distance(const Qualification& all) {
  Chart chart{{"travelled [m]", {}, {}}, {"error [mm]", 0.0, {}}, {}};
  for (const Qualified* one : drawn(all)) {
    Series series{one->name, {}, {}, Series::Form::line};
    for (const auto& [distance_m, error_m] : one->over_distance) {
      series.x.push_back(distance_m);
      series.y.push_back(1e3 * error_m);
    }
    chart.series.push_back(std::move(series));
  }
  return to_svg(chart);
}

std::string distribution(const Qualification& all) {
  Chart chart{{"error [mm]", 0.0, {}}, {"ratio of iterations", 0.0, 1.0}, {}};
  for (const Qualified* one : drawn(all)) {
    Series series{one->name, {}, one->cdf.ratio, Series::Form::steps};
    for (const double v : one->cdf.value) series.x.push_back(1e3 * v);
    chart.series.push_back(std::move(series));
  }
  return to_svg(chart);
}

/// With continuous measurements, such as ranges, the distance since the last one is never large.
bool ever_far(const Qualification& all) {
  return std::ranges::any_of(all.algorithms, [](const Qualified& one) {
    return !one.failed &&
           std::ranges::count_if(one.by_distance, [](const Part& part) { return part.iterations > 0; }) > 1;
  });
}

std::string by_distance(const Qualification& all) {
  Chart chart{{"since the last fiducial, up to [m]", 0.0, {}}, {"rmse [mm]", 0.0, {}}, {}};
  for (const Qualified* one : drawn(all)) {
    Series series{one->name, {}, {}, Series::Form::line};
    for (std::size_t k = 0; k < since_fiducial_m.size(); ++k) {
      if (one->by_distance[k].iterations == 0) continue;
      series.x.push_back(since_fiducial_m[k]);
      series.y.push_back(1e3 * one->by_distance[k].rmse_m());
    }
    chart.series.push_back(std::move(series));
  }
  return to_svg(chart);
}

void add_comparisons(Report& report, const Qualification& all) {
  if (all.comparisons.empty()) return;
  report.heading("Comparison, run by run");
  std::vector<std::vector<std::string>> rows;
  for (const Comparison& comparison : all.comparisons) {
    rows.push_back({all.algorithms[comparison.b].name + " − " + all.algorithms[comparison.a].name,
                    with_interval(comparison.rmse_difference_m, 1e3),
                    with_interval(comparison.precision_difference, 100.0), chance(comparison.p),
                    chance(comparison.p_holm), std::string(to_string(comparison.verdict)),
                    comparison.runs_to_decide ? std::to_string(*comparison.runs_to_decide) : "–"});
  }
  report.table(
      {"difference", "rmse [mm]", "precision [points]", "p (Wilcoxon)", "p (Holm)", "verdict", "runs to decide"}, rows);
  report.paragraph(
      "A run is one vote. Different: Wilcoxon's signed-rank test, exact, with Holm's correction over all pairs, at 5 "
      "%. "
      "Unresolved: a difference smaller than the reference's own uncertainty. Runs to decide: as many as would show a "
      "difference like this with a chance of 80 %.");
  if (!all.ranks) return;
  Bars bars{"mean rank over the runs, 1 is best (Friedman: p " + chance(all.ranks->p) + ")", {}};
  for (std::size_t i = 0; i < all.ranked.size(); ++i)
    bars.bars.push_back({all.algorithms[all.ranked[i]].name, all.ranks->mean_ranks[i]});
  report.figure(to_svg(bars), "Ranks of the rmse");
}

void add_success(Report& report, const Qualification& all) {
  report.heading("Consecutive passes");
  report.paragraph("A run passes when no error in it exceeds " + mm(all.options.tolerance_m, 1) + " mm. " +
                   std::to_string(statistics::passes_needed(all.options.reliability, all.options.confidence)) +
                   " passes in a row show a reliability of " + readable(100.0 * all.options.reliability, 1) +
                   " % with a confidence of " + readable(100.0 * all.options.confidence, 1) +
                   " % (as in ASTM F45's tests).");
  std::vector<std::vector<std::string>> rows;
  for (const Qualified* one : figured(all)) {
    rows.push_back({one->name, std::to_string(one->passes.passed) + " of " + std::to_string(one->passes.runs),
                    std::to_string(one->passes.in_a_row), readable(100.0 * one->passes.reliability_shown, 1),
                    mm(one->passes.tolerance_passed_m, 1)});
  }
  report.table({"algorithm", "passed", "longest sequence", "reliability shown [%]", "tolerance all would pass [mm]"},
               rows);
}

void add_reference(Report& report, const Qualification& all) {
  const ReferenceBudget& budget = all.options.reference;
  if (budget.parts.empty()) return;
  report.heading("The reference's own error");
  std::vector<std::vector<std::string>> rows;
  for (const ReferencePart& part : budget.parts)
    rows.push_back({part.name, part.uncertainty_m ? mm(*part.uncertainty_m) : "not given",
                    part.uncertainty_m ? readable(budget.ratio_percent(part), 1) : "–", part.source});
  rows.push_back({"u, all together", mm(budget.total_m()), "100", "root of the sum of squares"});
  report.table({"part", "standard uncertainty [mm]", "part of u² [%]", "source"}, rows);
  report.paragraph("A difference below u is called unresolved, however often it is observed." +
                   std::string(budget.untold() > 0 ? " Some parts are not given: u is more than this." : ""));
  rows.clear();
  for (const Qualified* one : figured(all))
    rows.push_back({one->name, mm(one->rmse_m.value), mm(without_reference_m(one->rmse_m.value, budget.total_m()))});
  report.table({"algorithm", "observed rmse [mm]", "without the reference's part [mm]"}, rows);
}

}  // namespace

std::string to_html(const Qualification& all, const Conditions& conditions) {
  Report report{"Position estimation, qualified", conditions.what};
  const auto best = drawn(all, 1);
  if (!best.empty()) {
    std::vector<Report::MetadataField> metadata{
        {mm(best[0]->rmse_m.value) + " mm", "least rmse: " + best[0]->name, false},
        {std::to_string(all.runs), all.runs == 1 ? "run" : "runs", false}};
    if (best[0]->limit_m) metadata.push_back({mm(*best[0]->limit_m) + " mm", "its limit", best[0]->leak});
    report.metadata(metadata);
  }
  add_table(report, all);
  report.paragraph(
      "Brackets: 95 % intervals over runs (BCa bootstrap); over one run by blocks as long as its errors are "
      "correlated. Precision: the ratio of iterations with an error below " +
      mm(all.options.threshold_m, 1) +
      " mm. The limit is the "
      "posterior Cramér-Rao bound for the readings that the runs had.");
  if (all.options.alignment != Alignment::none)
    report.paragraph("Aligned (" + std::string(to_string(all.options.alignment)) +
                     "), as requested: each run's estimates were " + std::string(text_of(all.options.alignment)) +
                     ". The metrics describe the shape of paths, not their position; no limit is drawn, because it "
                     "excludes alignment.");
  for (const std::string& diagnostic : conditions.diagnostics) report.paragraph(diagnostic);
  add_honesty(report, all);
  report.paragraph(
      "Stated uncertainties: NEES/2 and NIS are 1 where stated covariances are realistic; in brackets the bands "
      "that contain 95 % of realistic ones. A region should contain the ground truth as often as stated.");
  report.figure(limits_beside_bars(all),
                "Bar: rmse of all runs, with its interval; box: the runs' smallest, quartiles and largest; the stroke "
                "across: the limit, and on the right the gap to it");
  report.figure(distribution(all), "Distribution of all errors");
  report.figure(error_over_distance(all), "Error over the distance, first run");
  if (ever_far(all)) report.figure(by_distance(all), "Error by the distance since the last fiducial");
  report.figure(trajectory(all, conditions), conditions.lines.empty()
                                                 ? "Ground truth and estimates, first run"
                                                 : "Ground truth and estimates, first run, on the zone's lines (grey)");
  report.heading("Along and across, by section");
  add_splits(report, all);
  add_comparisons(report, all);
  add_reference(report, all);
  add_success(report, all);
  report.heading("Conditions");
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, value] : conditions.settings) rows.push_back({name, value});
  rows.push_back({"alignment", std::string(to_string(all.options.alignment))});
  rows.push_back({"uncertainty of the reference [mm]", mm(all.options.reference.total_m())});
  rows.push_back({"digest", all.digest.hex()});
  report.table({"setting", "value"}, rows);
  report.verbatim(conditions.command);
  return report.html();
}

}  // namespace cosiva::experiments
