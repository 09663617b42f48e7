#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/workers.h"
#include "cosiva/experiments/positioning/metrology/limit.h"
#include "cosiva/experiments/positioning/metrology/metrics.h"
#include "cosiva/experiments/positioning/metrology/reference_budget.h"
#include "cosiva/experiments/statistics/interval.h"
#include "cosiva/experiments/statistics/paired.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {

/// An algorithm to be qualified.
struct Candidate {
  std::string name;
  std::string what;
  bool backtracks{false};
  std::function<Result<std::unique_ptr<estimation::Algorithm>>(const estimation::Setting&)> make;
};

struct QualificationOptions {
  double threshold_m{0.01};  ///< of the article's precision
  double tolerance_m{0.05};  ///< a run passes when no error in it is larger (as in ASTM F45)
  double reliability{0.95};
  double confidence{0.95};
  /// Alignment of estimates with the ground truth before they are evaluated; there is no limit for aligned estimates.
  Alignment alignment{Alignment::none};
  ReferenceBudget reference{};  ///< of the ground truth; differences below its total are called unresolved
  statistics::BootstrapOptions bootstrap{};
};

/// A metric with its interval at run level; none where one run does not suffice.
struct Figure {
  double value{};
  std::optional<statistics::Interval> interval;
};

struct Passes {
  std::size_t runs{};
  std::size_t passed{};
  std::size_t in_a_row{};  ///< the longest sequence of passes
  std::size_t needed{};
  double reliability_shown{};   ///< by that sequence
  double tolerance_passed_m{};  ///< the tolerance that every run would have passed
};

/// The results of one algorithm after all runs.
struct Qualified {
  std::string name;
  std::string what;
  bool backtracks{false};
  std::optional<Error> failed;  ///< why there are no metrics
  std::vector<RunMetrics> runs;
  std::size_t iterations{};
  Figure rmse_m, mean_m, precision;
  double variance_m2{};
  double max_m{}, p50_m{}, p90_m{}, p95_m{}, p99_m{};
  double along_rmse_m{}, along_bias_m{}, across_rmse_m{}, across_bias_m{}, heading_rmse_rad{};
  double nees{};
  statistics::Interval nees_band;  ///< contains 95 % of the means of realistic algorithms
  std::array<double, region_ratios.size()> covered{};
  double nis{};
  std::size_t nis_dimensions{};
  /// Contains 95 % of the means of realistic algorithms; their innovations are independent. None without innovations.
  std::optional<statistics::Interval> nis_band;
  std::size_t refused{};
  double worth{};  ///< independent values in all runs together
  std::array<Part, 4> by_section{};
  std::array<Part, since_fiducial_m.size() + 1> by_distance{};
  std::optional<double> limit_m;      ///< the error that no algorithm can surpass
  std::optional<double> gap_percent;  ///< above the limit
  bool limit_assumed{false};          ///< from assumed sensors: then no algorithm below it is called a leak
  bool leak{false};  ///< significantly below the limit: the algorithm uses information that it cannot have, or the
                     ///< limit is wrong
  std::vector<Pose2>
      alignments;  ///< of each run, the motion that was applied to its estimates; empty without alignment
  Passes passes;
  statistics::Cdf cdf;
  std::vector<std::pair<double, double>> over_distance;  ///< of the first run: (travelled, error), thinned
  std::vector<Pose2> path;                               ///< of the first run, at every moment
};

enum class Verdict { different, not_shown_different, unresolved };
[[nodiscard]] std::string_view to_string(Verdict verdict);

/// A comparison of two algorithms on the same runs: b's metric minus a's, run by run.
struct Comparison {
  std::size_t a{}, b{};
  Figure rmse_difference_m;
  Figure precision_difference;
  double p{1.0};
  double p_holm{1.0};
  Verdict verdict{Verdict::not_shown_different};
  std::optional<std::size_t> runs_to_decide;
};

struct Qualification {
  QualificationOptions options;
  std::size_t runs{};
  std::vector<Qualified> algorithms;
  std::vector<Comparison> comparisons;  ///< of all pairs without faults
  std::optional<statistics::Friedman> ranks;
  std::vector<std::size_t> ranked;  ///< the ranked algorithms
  Digest digest;
  std::vector<double> times_s;  ///< of the first run's moments, for writing trajectories
  std::vector<Pose2> ground_truth;
};

/// Provides run number `index`, in `room` (whose content is replaced and memory reused) or stored elsewhere until the
/// end. Called by several threads, and repeatedly for the same run. Fails with the run's error.
using TrialSource = std::function<Result<const Trial*>(std::size_t index, Trial& room)>;
/// Whether to report the progress; called by several threads before each part. Without it there are no reports.
using TimeIsUp = std::function<bool()>;
/// Called at each report, and at the end, by the thread that called qualify: number of runs that are done for certain.
using Progress = std::function<void(std::size_t done)>;

/// Evaluates all candidates on the same runs; the result does not depend on the workers. A candidate that fails keeps
/// its error, the others their results. Fails where a run does.
[[nodiscard]] Result<Qualification> qualify(const std::vector<Candidate>& candidates, std::size_t runs,
                                            const TrialSource& source, const QualificationOptions& options,
                                            Workers& workers, const TimeIsUp& time_is_up = {},
                                            const Progress& progress = {});
/// The same without parallel workers.
[[nodiscard]] Result<Qualification> qualify(const std::vector<Candidate>& candidates, std::size_t runs,
                                            const TrialSource& source, const QualificationOptions& options);

}  // namespace cosiva::experiments
