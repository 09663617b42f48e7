#include "cosiva/experiments/statistics/survival.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/special.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace cosiva::statistics {
namespace {

std::vector<Duration> sorted(std::span<const Duration> durations) {
  std::vector<Duration> all{durations.begin(), durations.end()};
  std::ranges::sort(all, {}, &Duration::value);
  return all;
}

/// S^exp(±z·se(ln(−ln S))) after at least one end, so that S < 1: a band that stays within 0 and 1.
Interval log_log_band(double ratio, double greenwood, double z) {
  if (ratio <= 0.0) return {0.0, 0.0};
  const double log_ratio = det_log(ratio);
  // Each end's deviation is at most 1.03 times its −ln(1 − d/n), so that the exponent is hardly larger than z.
  const double most = det_exp(z * std::sqrt(greenwood) / -log_ratio);
  return {det_exp(std::max(log_ratio * most, -600.0)), det_exp(log_ratio / most)};
}

/// Wilson's interval of a ratio of this number.
Interval wilson_band(double ratio, double size, double z) {
  const double all = size + z * z;
  const double centre = (size * ratio + 0.5 * z * z) / all;
  const double half = z * std::sqrt(size * ratio * (1.0 - ratio) + 0.25 * z * z) / all;
  return {ratio <= 0.0 ? 0.0 : centre - half, ratio >= 1.0 ? 1.0 : centre + half};
}

/// A band along the curve.
class Band {
 public:
  Band(SurvivalBand kind, double level) : kind_{kind}, z_{normal_quantile(0.5 + 0.5 * level)} {}
  /// Before the first end.
  [[nodiscard]] Interval before(double at_risk) const {
    return kind_ == SurvivalBand::log_log ? Interval{1.0, 1.0} : wilson_band(1.0, at_risk, z_);
  }
  Interval after(double ratio, double greenwood) {
    if (kind_ == SurvivalBand::log_log) return log_log_band(ratio, greenwood, z_);
    // The number of uncensored durations with this variance; where none is left, the previous number.
    if (ratio > 0.0) size_ = (1.0 - ratio) / (ratio * greenwood);
    return wilson_band(ratio, size_, z_);
  }

 private:
  SurvivalBand kind_;
  double z_;
  double size_{1.0};
};

/// Standard normal density over its upper tail.
double hazard(double z) {
  if (z > 25.0) return z + 1.0 / z;
  return 0.39894228040143267794 * det_exp(-0.5 * z * z) / normal_cdf(-z);
}

struct NormalFit {
  double mean;
  double sd;
  double mean_variance;  ///< of the estimate, from the observed information
};

/// Newton's method is not needed: the EM step has a closed form and always increases the likelihood.
NormalFit fit_normal(std::span<const Duration> durations, double mean, double sd) {
  const auto n = static_cast<double>(durations.size());
  for (int round = 0; round < 500; ++round) {
    double sum = 0.0;
    double squares = 0.0;
    for (const Duration& one : durations) {
      if (one.ended) {
        sum += one.value;
        squares += (one.value - mean) * (one.value - mean);
        continue;
      }
      // The expected value of a censored duration, and its square about the present mean.
      const double z = (one.value - mean) / sd;
      const double h = hazard(z);
      sum += mean + sd * h;
      squares += sd * sd * (1.0 + z * h);
    }
    const double next_mean = sum / n;
    const double next_sd = std::sqrt(std::max(squares / n - (next_mean - mean) * (next_mean - mean), 1e-300));
    const double moved = std::fabs(next_mean - mean) + std::fabs(next_sd - sd);
    mean = next_mean;
    sd = next_sd;
    if (moved < 1e-10 * sd) break;
  }
  // Observed information in (mean, sd), over sd².
  double mm = 0.0;
  double ms = 0.0;
  double ss = 0.0;
  for (const Duration& one : durations) {
    const double z = (one.value - mean) / sd;
    if (one.ended) {
      mm += 1.0;
      ms += 2.0 * z;
      ss += 3.0 * z * z - 1.0;
    } else {
      const double h = hazard(z);
      const double slope = h * (h - z);
      mm += slope;
      ms += h + z * slope;
      ss += z * (2.0 * h + z * slope);
    }
  }
  const double determinant = mm * ss - ms * ms;
  return {mean, sd, determinant > 0.0 ? sd * sd * ss / determinant : sd * sd / n};
}

}  // namespace

Survival kaplan_meier(std::span<const Duration> durations, double level, SurvivalBand kind) {
  Survival survival{{}, 0.0, 0.0, 0.0};
  const std::vector<Duration> all = sorted(durations);
  if (all.empty()) return survival;
  Band band{kind, level};
  double ratio = 1.0;
  double greenwood = 0.0;
  double before = 0.0;
  struct Piece {
    double area;
    double term;  ///< of Greenwood's sum, for the end that closes this piece
  };
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t ended = 0;
    std::size_t j = i;
    for (; j < all.size() && all[j].value == all[i].value; ++j) ended += all[j].ended ? 1U : 0U;
    if (ended > 0) {
      const auto at_risk = static_cast<double>(all.size() - i);
      const auto out = static_cast<double>(ended);
      if (pieces.empty()) survival.band_before = band.before(at_risk);
      const double term = at_risk > out ? out / (at_risk * (at_risk - out)) : 0.0;
      pieces.push_back({ratio * (all[i].value - before), term});
      before = all[i].value;
      ratio *= 1.0 - out / at_risk;
      greenwood += term;
      survival.steps.push_back({before, ratio, band.after(ratio, greenwood), ended, all.size() - i});
    }
    i = j;
  }
  survival.restricted_to = all.back().value;
  const double last = ratio * (survival.restricted_to - before);
  for (const Piece& piece : pieces) survival.restricted_mean += piece.area;
  survival.restricted_mean += last;
  double variance = 0.0;
  double after = survival.restricted_mean;
  for (const Piece& piece : pieces) {
    after -= piece.area;  // the area after this end
    variance += after * after * piece.term;
  }
  survival.restricted_mean_sd = std::sqrt(variance);
  return survival;
}

Interval Survival::band_at(double time) const {
  const auto after = std::ranges::upper_bound(steps, time, {}, &SurvivalStep::at);
  return after == steps.begin() ? band_before : std::prev(after)->band;
}

std::optional<double> Survival::when_ended(double ratio) const {
  for (const SurvivalStep& step : steps)
    if (step.ratio <= 1.0 - ratio + 1e-12) return step.at;
  return std::nullopt;
}

std::optional<CensoredNormal> censored_normal(std::span<const Duration> durations, double level) {
  std::vector<double> ends;
  for (const Duration& one : durations)
    if (one.ended) ends.push_back(one.value);
  if (ends.size() < 2) return std::nullopt;
  const auto [shortest, longest] = std::ranges::minmax(ends);
  if (!(longest > shortest)) return std::nullopt;
  double mean = 0.0;
  for (const double end : ends) mean += end / static_cast<double>(ends.size());
  const NormalFit fit = fit_normal(durations, mean, 0.5 * (longest - shortest));

  const auto ended = static_cast<double>(ends.size());
  const double correction = std::sqrt(ended / (ended - 1.0));
  CensoredNormal found{fit.mean, fit.sd * correction, {}, 0.0, fit.sd * fit.sd / fit.mean_variance, ends.size()};
  const double degrees = ended - 1.0;
  const double half = student_quantile(0.5 + 0.5 * level, degrees) * correction * std::sqrt(fit.mean_variance);
  found.mean_interval = {found.mean - half, found.mean + half};
  // As for a complete sample whose mean is equally well known, with the ends' own degrees of freedom for the deviation.
  const double root = std::sqrt(found.effective_size);
  const double factor = shifted_student_quantile(0.95, degrees, normal_quantile(0.95) * root) / root;
  found.tolerance_low = found.mean - factor * found.sd;
  return found;
}

}  // namespace cosiva::statistics
