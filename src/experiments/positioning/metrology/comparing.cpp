#include "cosiva/experiments/positioning/metrology/comparing.h"

#include <cmath>

namespace cosiva::experiments {
namespace {

/// The significance level of the comparisons.
constexpr double alpha = 0.05;

Comparison compared(const Qualification& all, std::size_t a, std::size_t b) {
  Comparison comparison;
  comparison.a = a;
  comparison.b = b;
  std::vector<double> rmse;
  std::vector<double> precision;
  for (std::size_t i = 0; i < all.runs; ++i) {
    const RunMetrics& of_a = all.algorithms[a].runs[i];
    const RunMetrics& of_b = all.algorithms[b].runs[i];
    rmse.push_back(std::sqrt(of_b.mse_m2) - std::sqrt(of_a.mse_m2));
    precision.push_back(of_b.precision - of_a.precision);
  }
  comparison.rmse_difference_m = {statistics::mean(rmse), statistics::bca(rmse, all.options.bootstrap)};
  comparison.precision_difference = {statistics::mean(precision), statistics::bca(precision, all.options.bootstrap)};
  comparison.p = statistics::wilcoxon(rmse);
  const double pairs = 0.5 * static_cast<double>(all.ranked.size() * (all.ranked.size() - 1));
  comparison.runs_to_decide = statistics::runs_to_decide(rmse, alpha / pairs);
  return comparison;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::different: return "different";
    case Verdict::not_shown_different: return "not shown different";
    case Verdict::unresolved: return "unresolved";
  }
  return "";
}

void compare_all(Qualification& all) {
  for (std::size_t i = 0; i < all.algorithms.size(); ++i) {
    if (!all.algorithms[i].failed) all.ranked.push_back(i);
  }
  std::vector<double> p_values;
  for (std::size_t i = 0; i < all.ranked.size(); ++i) {
    for (std::size_t k = i + 1; k < all.ranked.size(); ++k) {
      all.comparisons.push_back(compared(all, all.ranked[i], all.ranked[k]));
      p_values.push_back(all.comparisons.back().p);
    }
  }
  const std::vector<double> raised = statistics::holm(p_values);
  for (std::size_t i = 0; i < all.comparisons.size(); ++i) {
    Comparison& comparison = all.comparisons[i];
    comparison.p_holm = raised[i];
    if (raised[i] < alpha) comparison.verdict = Verdict::different;
    // A difference below the reference's own uncertainty decides nothing, however often it is observed.
    if (std::fabs(comparison.rmse_difference_m.value) < all.options.reference.total_m())
      comparison.verdict = Verdict::unresolved;
  }
  std::vector<std::vector<double>> metrics(all.runs);
  for (std::size_t run = 0; run < all.runs; ++run) {
    for (const std::size_t i : all.ranked) metrics[run].push_back(all.algorithms[i].runs[run].mse_m2);
  }
  all.ranks = statistics::friedman(metrics);
}

}  // namespace cosiva::experiments
