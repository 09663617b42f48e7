#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/experiments/statistics/interval.h"

/// Durations some of which nobody saw the end of: a run that failed for another reason lasted at least so long.
namespace cosiva::statistics {

struct Duration {
  double value;  ///< > 0
  bool ended;    ///< false: censored, it would have gone on
};

/// How the curve's pointwise band comes about; either stays inside [0, 1].
enum class SurvivalBand : std::uint8_t {
  /// Wilson's interval of a share, of as many durations as would tell it as well as Greenwood's variance says (Rothman,
  /// J. Chronic Diseases 31, 1978). Has a width before the first and after the last end, too, and holds about as often
  /// as it says with a dozen durations, some of them censored (bench/autonomy).
  wilson,
  /// Greenwood's variance on the log-log scale, the default of most programs: of small samples it holds far too seldom
  /// at the curve's ends.
  log_log,
};

/// Kaplan and Meier's curve: how many of all still last, after each end that was seen.
struct SurvivalStep {
  double at;
  double ratio;   ///< still lasting after it
  Interval band;  ///< of the share, pointwise
  std::size_t ended;
  std::size_t at_risk;  ///< right before
};
struct Survival {
  std::vector<SurvivalStep> steps;
  /// The area under the curve up to the longest duration: the mean where that one ended, else a lower bound of it.
  double restricted_mean;
  double restricted_mean_sd;
  double restricted_to;
  Interval band_before{1.0, 1.0};  ///< up to the first end; the share is 1 there
  /// Of the share that still lasts at this time.
  [[nodiscard]] Interval band_at(double time) const;
  /// The time at which this share has ended; nothing where the curve does not come down so far.
  [[nodiscard]] std::optional<double> when_ended(double ratio) const;
};
[[nodiscard]] Survival kaplan_meier(std::span<const Duration> durations, double level = 0.95,
                                    SurvivalBand band = SurvivalBand::wilson);

/// A normal distribution of which censored durations are known to be longer: maximum likelihood. SD is corrected for
/// the ends seen as √(d/(d − 1)), so that without censoring it is the usual one.
struct CensoredNormal {
  double mean;
  double sd;
  Interval mean_interval;  ///< by the observed information and Student's t of the information in the sample
  double tolerance_low;    ///< 95 % of all last longer, with a confidence of 95 %
  double effective_size;   ///< how many uncensored durations would tell the mean as well
  std::size_t ended;
};
/// Nothing for fewer than two ends, or equal ones.
[[nodiscard]] std::optional<CensoredNormal> censored_normal(std::span<const Duration> durations, double level = 0.95);

}  // namespace cosiva::statistics
