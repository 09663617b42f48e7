#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/experiments/statistics/interval.h"

/// Durations, some without an observed end: a run that failed for another reason lasted at least this long.
namespace cosiva::statistics {

struct Duration {
  double value;  ///< > 0
  bool ended;    ///< false: censored, the end would have been later
};

/// Method of the curve's pointwise band; both stay inside [0, 1].
enum class SurvivalBand : std::uint8_t {
  /// Wilson's interval of a ratio, with the number of durations that is equivalent to Greenwood's variance (Rothman, J.
  /// Chronic Diseases 31, 1978). Has a width before the first and after the last end, and contains the true curve about
  /// as often as stated with a dozen durations, some of them censored (bench/autonomy).
  wilson,
  /// Greenwood's variance on the log-log scale, the default of most programs: for small samples it contains
  /// the true curve far too seldom at the curve's ends.
  log_log,
};

/// Kaplan and Meier's curve: the ratio that is still running, after each observed end.
struct SurvivalStep {
  double at;
  double ratio;   ///< still running after it
  Interval band;  ///< of the ratio, pointwise
  std::size_t ended;
  std::size_t at_risk;  ///< right before
};
struct Survival {
  std::vector<SurvivalStep> steps;
  /// The area under the curve up to the longest duration: the mean where that one ended, else a lower bound of the
  /// mean.
  double restricted_mean;
  double restricted_mean_sd;
  double restricted_to;
  Interval band_before{1.0, 1.0};  ///< up to the first end; the ratio is 1 there
  /// The band of the ratio that is still running at this time.
  [[nodiscard]] Interval band_at(double time) const;
  /// The time at which this ratio has ended; nothing where the curve does not reach that level.
  [[nodiscard]] std::optional<double> when_ended(double ratio) const;
};
[[nodiscard]] Survival kaplan_meier(std::span<const Duration> durations, double level = 0.95,
                                    SurvivalBand band = SurvivalBand::wilson);

/// A normal distribution with censored durations as lower bounds: maximum likelihood. SD is corrected for the observed
/// ends as √(d/(d − 1)), so that without censoring it is the usual one.
struct CensoredNormal {
  double mean;
  double sd;
  Interval mean_interval;  ///< by the observed information and Student's t of the information in the sample
  double tolerance_low;    ///< 95 % of all last longer, with a confidence of 95 %
  double effective_size;   ///< the equivalent number of uncensored durations for the mean
  std::size_t ended;
};
/// Nothing for fewer than two ends, or equal ones.
[[nodiscard]] std::optional<CensoredNormal> censored_normal(std::span<const Duration> durations, double level = 0.95);

}  // namespace cosiva::statistics
