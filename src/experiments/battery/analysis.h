#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cosiva/experiments/battery/procedure.h"
#include "cosiva/experiments/battery/virtual_rig.h"
#include "cosiva/experiments/statistics/crossed.h"
#include "cosiva/experiments/statistics/effects.h"
#include "cosiva/experiments/statistics/interval.h"
#include "cosiva/experiments/statistics/survival.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace cosiva::experiments {

/// One battery over all its runs.
struct BatteryMetrics {
  std::size_t battery;
  std::string id;
  std::size_t runs;
  std::size_t failed;        ///< runs that ended for another reason than the battery
  double autonomy_s;         ///< mean of the runs that ended; NaN where none did
  double lasted_at_least_s;  ///< the longest run, ended or not
  double robust_score;
  bool is_outlier;
  std::optional<statistics::Trend> trend{};  ///< over its own runs, from three runs on
};

/// The effect of the vehicles (or a tester's channels) where each battery stayed on one: the vehicles with two or more
/// batteries. Differences between the batteries themselves cannot be separated from the effect; --swap can.
struct VehicleEffect {
  struct Group {
    std::string vehicle;
    std::size_t batteries;
    double mean_s;
    double sd_s;
  };
  std::vector<Group> groups;
  statistics::OneFactor variance;
};

/// The claims that a test's records allow (section 5 of the notes behind the article's equation 4).
struct AutonomyMetrics {
  std::size_t batteries{};
  std::size_t runs{};
  std::size_t failed{};
  std::size_t cut_off{};
  /// AT = (1/N) Σ Tᵢ, the article's equation (4), over the batteries that ran to the end.
  double at_s{};
  double mean_s{};  ///< as equation (4); from the censored normal where a vehicle failed
  double sd_s{};
  std::string method;  ///< method of mean_s
  std::optional<statistics::Interval> mean_t;
  /// Of one battery's repeated runs about their mean: how well that battery is known; no statement about others.
  std::optional<statistics::Interval> runs_t;
  double runs_sd_s{};
  std::optional<statistics::Interval> mean_bca;  ///< from ten batteries on
  std::optional<statistics::Interval> sd_interval;
  std::optional<double> tolerance_low_s;     ///< 95 % of all batteries last longer, with a confidence of 95 %
  double smallest_covers{};                  ///< ratio above the smallest, whatever the distribution
  std::optional<statistics::Interval> next;  ///< prediction interval of the next battery
  std::optional<statistics::Outlier> grubbs;
  std::optional<double> normality_p;
  statistics::Survival survival{};
  std::optional<statistics::CensoredNormal> censored;
  std::optional<statistics::Trend> trend;      ///< over runs, with each battery's mean removed
  std::optional<statistics::Crossed> crossed;  ///< variance by cause
  std::optional<VehicleEffect> vehicles;
  double mean_if_counted_s{};                ///< the wrong mean: failures counted as ends
  std::optional<std::size_t> stopped_after;  ///< number of batteries after which the requested half width was reached
  std::vector<BatteryMetrics> each;
};
/// @param wanted_half_width  as a ratio of the mean, for the sequential stop; 0: none
[[nodiscard]] AutonomyMetrics analyse(std::span<const BatteryRun> records, std::size_t batteries,
                                      double wanted_half_width = 0.0, std::uint64_t seed = 1);

/// "1 h 02 min 03 s".
[[nodiscard]] std::string duration_text(double seconds);
}  // namespace cosiva::experiments
