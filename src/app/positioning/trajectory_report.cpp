#include "cosiva/app/positioning/trajectory_report.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/positioning/qualify_candidates.h"
#include "cosiva/experiments/positioning/metrology/evo_zip.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::app {
namespace {

using experiments::Chart;
using experiments::Pair;
using experiments::readable;
using experiments::Report;
using experiments::Series;
using experiments::Stamped;

/// The colours of a chart, one of which is the reference's.
constexpr std::size_t drawn_most = 5;

std::string mm(double metres) { return readable(1e3 * metres, 2); }

/// The fewest digits that read back to the same number.
std::string shortest(double value) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

double error_of(const Pair& pair) {
  double squares = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = pair.estimate.p_m[i] - pair.reference.p_m[i];
    squares += d * d;
  }
  return std::sqrt(squares);
}

std::vector<double> errors_of(const EvaluatedTrajectory& one) {
  std::vector<double> errors;
  errors.reserve(one.pairs.size());
  for (const Pair& pair : one.pairs) errors.push_back(error_of(pair));
  return errors;
}

std::vector<double> times_of(const EvaluatedTrajectory& one) {
  std::vector<double> times;
  times.reserve(one.pairs.size());
  for (const Pair& pair : one.pairs) times.push_back(pair.estimate.t_s);
  return times;
}

/// The estimates with metrics, the best first.
std::vector<const EvaluatedTrajectory*> best_of(const std::vector<EvaluatedTrajectory>& all) {
  std::vector<const EvaluatedTrajectory*> ones;
  for (const EvaluatedTrajectory& one : all) {
    if (!one.failed) ones.push_back(&one);
  }
  std::ranges::stable_sort(ones, {}, [](const EvaluatedTrajectory* one) { return one->ape.rmse; });
  if (ones.size() > drawn_most) ones.resize(drawn_most);
  return ones;
}

void add_metrics(Report& report, const std::vector<EvaluatedTrajectory>& all,
                 const experiments::Trajectory& reference) {
  Chart error{{"time [s]", {}, {}}, {"error [mm]", 0.0, {}}, {}};
  Chart distribution{{"error [mm]", 0.0, {}}, {"ratio of pairs", 0.0, 1.0}, {}};
  Chart map{{"x [m]", {}, {}}, {"y [m]", {}, {}}, {}};
  map.equal_scale = true;
  Series ground_truth{"reference", {}, {}, Series::Form::line};
  for (const Stamped& pose : reference.poses) {
    ground_truth.x.push_back(pose.p_m[0]);
    ground_truth.y.push_back(pose.p_m[1]);
  }
  map.series.push_back(std::move(ground_truth));
  for (const EvaluatedTrajectory* one : best_of(all)) {
    std::vector<double> errors_mm = errors_of(*one);
    for (double& e : errors_mm) e *= 1e3;
    std::vector<double> since_s = times_of(*one);
    for (double& t : since_s) t -= reference.poses.front().t_s;
    const auto cdf = statistics::cdf(errors_mm);
    distribution.series.push_back({one->name, cdf.value, cdf.ratio, Series::Form::steps});
    error.series.push_back({one->name, std::move(since_s), std::move(errors_mm), Series::Form::line});
    Series path{one->name, {}, {}, Series::Form::line};
    for (const Pair& pair : one->pairs) {
      path.x.push_back(pair.estimate.p_m[0]);
      path.y.push_back(pair.estimate.p_m[1]);
    }
    map.series.push_back(std::move(path));
  }
  report.figure(to_svg(map), "Reference and estimates from above, where they were paired");
  report.figure(to_svg(error), "Error over time, since the reference begins");
  report.figure(to_svg(distribution), "Distribution of all errors");
}

void add_table(Report& report, const std::vector<EvaluatedTrajectory>& all) {
  std::vector<std::vector<std::string>> rows;
  for (const EvaluatedTrajectory& one : all) {
    if (one.failed) {
      rows.push_back({one.name, "failed: " + to_string(*one.failed), "", "", "", "", "", "", ""});
      continue;
    }
    std::string rmse = mm(one.ape.rmse);
    if (one.interval) rmse += " (" + mm(one.interval->interval.low) + "–" + mm(one.interval->interval.high) + ")";
    rows.push_back({one.name, std::move(rmse), mm(one.ape.mean), mm(one.ape.median), mm(one.p95_m), mm(one.ape.max),
                    readable(100.0 * one.precision, 1),
                    std::to_string(one.ape.pairs) + " (" + std::to_string(one.unpaired) + ")",
                    readable(1e3 * one.offset_s, 1)});
  }
  report.table({"estimate", "rmse [mm]", "mean [mm]", "median [mm]", "p95 [mm]", "max [mm]", "precision [%]",
                "pairs (poses without)", "delay [ms]"},
               rows);
}

void add_comparisons(Report& report, const std::vector<EvaluatedTrajectory>& all,
                     const experiments::ReferenceBudget& budget) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      if (all[i].failed || all[k].failed) continue;
      rows.push_back({all[k].name + " − " + all[i].name, mm(all[k].ape.rmse - all[i].ape.rmse),
                      unresolved(all[i], all[k], budget) ? "unresolved" : "not shown different"});
    }
  }
  if (rows.empty()) return;
  report.heading("Against each other");
  report.table({"difference", "rmse [mm]", "verdict"}, rows);
  report.paragraph(
      "One run is one vote, and one vote shows no difference, however many poses it has. Unresolved: less than the "
      "reference's own uncertainty.");
}

std::string page_of(const std::vector<EvaluatedTrajectory>& all, const experiments::Trajectory& reference,
                    const QualifyArguments& arguments, const experiments::ReferenceBudget& budget) {
  Report report{"Trajectories, evaluated", "against " + arguments.reference};
  if (const auto best = best_of(all); !best.empty())
    report.metadata({{mm(best[0]->ape.rmse) + " mm", "least rmse: " + best[0]->name, false},
                     {std::to_string(best[0]->ape.pairs), "pairs of it", false}});
  add_table(report, all);
  report.paragraph(
      "Of the distance in space between paired poses. Brackets: 95 % interval of this run, by blocks as long as its "
      "errors are correlated. Precision: the ratio of pairs with an error below " +
      mm(arguments.threshold_m) + " mm. The delay is estimated from errors along the path, and not corrected.");
  const auto alignment = alignment_of(arguments);
  if (alignment != experiments::Alignment::none)
    report.paragraph("Aligned (" + arguments.align + "), as requested: estimates were " +
                     std::string(text_of(alignment)) +
                     ". The metrics describe the shape of paths, not their position.");
  add_metrics(report, all, reference);
  add_comparisons(report, all, budget);
  report.heading("Conditions");
  const bool nearest = arguments.associate == "nearest";
  report.table({"setting", "value"},
               {{"paired by", nearest ? "the nearest stamp, within 10 ms" : "interpolating the reference"},
                {"longest gap of the reference", nearest ? "–" : readable(arguments.gap_s, 3) + " s"},
                {"alignment", arguments.align},
                {"the reference's own error", budget.parts.empty() ? "not given" : text_of(budget) + " [mm]"}});
  report.verbatim(arguments.command);
  return report.html();
}

std::string lines_of(const EvaluatedTrajectory& one) {
  std::string text;
  for (const Pair& pair : one.pairs) {
    text += one.name + "," + shortest(pair.estimate.t_s) + "," + shortest(error_of(pair));
    for (std::size_t i = 0; i < 3; ++i) text += "," + shortest(pair.estimate.p_m[i] - pair.reference.p_m[i]);
    text += "\n";
  }
  return text;
}

}  // namespace

bool unresolved(const EvaluatedTrajectory& a, const EvaluatedTrajectory& b,
                const experiments::ReferenceBudget& reference) {
  return std::fabs(b.ape.rmse - a.ape.rmse) < reference.total_m();
}

Result<void> write_trajectories(const std::vector<EvaluatedTrajectory>& all, const experiments::Trajectory& reference,
                                const QualifyArguments& arguments, const experiments::ReferenceBudget& budget,
                                const std::string& json) {
  std::vector<std::pair<std::string, std::string>> files{
      {"report.html", page_of(all, reference, arguments, budget)},
      {"result.json", json + "\n"},
      {"reference.tum", experiments::write_tum(reference)},
  };
  std::string errors = "estimate,time_s,error_m,x_error_m,y_error_m,z_error_m\n";
  for (const EvaluatedTrajectory& one : all) {
    if (one.failed) continue;
    errors += lines_of(one);
    experiments::Trajectory evaluated{one.name, {}};
    for (const Pair& pair : one.pairs) evaluated.poses.push_back(pair.estimate);
    files.emplace_back(one.name + ".tum", experiments::write_tum(evaluated));
    files.emplace_back(one.name + ".zip",
                       experiments::evo_zip(one.name, times_of(one), errors_of(one), alignment_of(arguments)));
  }
  files.emplace_back("errors.csv", std::move(errors));
  if (auto written = adapters::write_files(arguments.out_folder, files); !written) return written;
  print_info("written into " + arguments.out_folder);
  return {};
}

}  // namespace cosiva::app
