#include "cosiva/experiments/positioning/metrology/result_text.h"

#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

std::string padded(std::string text, std::size_t width) {
  text.insert(0, text.size() < width ? width - text.size() : 1, ' ');
  return text;
}

std::string mm(double metres, int digits = 2) { return readable(1e3 * metres, digits); }

std::string number(double v) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), v).ptr};
}

}  // namespace

std::string to_text(const Qualification& all) {
  std::size_t width = 10;
  for (const Qualified& one : all.algorithms) width = std::max(width, one.name.size());
  std::string text =
      std::string(width, ' ') + "  rmse [mm]  (95 % interval)   mean   p95   max  precision  NEES/2  limit    gap\n";
  for (const Qualified& one : all.algorithms) {
    text += one.name + std::string(width - one.name.size(), ' ');
    if (one.failed) {
      text += "  failed: " + to_string(*one.failed) + "\n";
      continue;
    }
    const std::string interval =
        one.rmse_m.interval ? "(" + mm(one.rmse_m.interval->low) + " to " + mm(one.rmse_m.interval->high) + ")" : "(–)";
    text += padded(mm(one.rmse_m.value), 11) + padded(interval, 18) + padded(mm(one.mean_m.value), 7) +
            padded(mm(one.p95_m, 1), 6) + padded(mm(one.max_m, 1), 6) +
            padded(readable(100.0 * one.precision.value, 1) + " %", 11) + padded(readable(0.5 * one.nees, 2), 8);
    if (one.limit_m) text += padded(mm(*one.limit_m), 7) + padded(readable(*one.gap_percent, 1) + " %", 8);
    if (one.leak) text += "  below the limit: a leak";
    if (one.limit_m && one.limit_assumed) text += "  (limit of assumed sensors)";
    text += "\n";
  }
  if (all.options.alignment != Alignment::none)
    text += "Aligned (" + std::string(to_string(all.options.alignment)) + "): each run's estimates were " +
            std::string(text_of(all.options.alignment)) + ".\n";
  if (!all.options.reference.parts.empty())
    text += "The reference's own error: " + text_of(all.options.reference) +
            " [mm]; smaller differences are called unresolved.\n";
  if (!all.comparisons.empty() && all.runs < 6) {
    return text + "With " + std::to_string(all.runs) + (all.runs == 1 ? " run" : " runs") +
           " no difference can be shown; at least six are needed.\n";
  }
  for (const Comparison& comparison : all.comparisons) {
    text += all.algorithms[comparison.b].name + " − " + all.algorithms[comparison.a].name + ": " +
            mm(comparison.rmse_difference_m.value) + " mm, p " +
            (comparison.p_holm < 1e-4 ? std::string("< 0.0001") : "= " + readable(comparison.p_holm, 4)) + ", " +
            std::string(to_string(comparison.verdict));
    if (comparison.verdict == Verdict::not_shown_different && comparison.runs_to_decide)
      text += " (" + std::to_string(*comparison.runs_to_decide) + " runs would likely decide)";
    text += "\n";
  }
  return text;
}

std::string to_csv(const Qualification& all) {
  std::string text =
      "algorithm,run,iterations,rmse_m,mean_m,variance_m2,precision,max_m,along_rmse_m,across_rmse_m,nees\n";
  for (const Qualified& one : all.algorithms) {
    for (std::size_t i = 0; i < one.runs.size(); ++i) {
      const RunMetrics& run = one.runs[i];
      text += one.name + "," + std::to_string(i + 1) + "," + std::to_string(run.iterations);
      for (const double v : {std::sqrt(run.mse_m2), run.mean_m, run.variance_m2, run.precision, run.max_m,
                             std::sqrt(run.along_mse_m2), std::sqrt(run.across_mse_m2), run.nees})
        text += "," + number(v);
      text += "\n";
    }
  }
  return text;
}

}  // namespace cosiva::experiments
