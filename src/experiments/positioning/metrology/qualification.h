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

/// One that is to be qualified.
struct Candidate {
  std::string name;
  std::string what;
  bool backtracks{false};
  std::function<Result<std::unique_ptr<estimation::Algorithm>>(const estimation::Setting&)> make;
};

struct QualificationOptions {
  double threshold_m{0.01};  ///< of the article's precision
  double tolerance_m{0.05};  ///< a run passes when no error in it is larger (ASTM F45's way)
  double reliability{0.95};
  double confidence{0.95};
  /// Of estimates to the truth before they are judged; then there is no limit, which knows of none.
  Alignment alignment{Alignment::none};
  ReferenceBudget reference{};  ///< of the truth; differences under its total are called unresolved
  statistics::BootstrapOptions bootstrap{};
};

/// A figure with its interval at run level; none where one run cannot tell.
struct Figure {
  double value{};
  std::optional<statistics::Interval> interval;
};

struct Passes {
  std::size_t runs{};
  std::size_t passed{};
  std::size_t in_a_row{};  ///< the longest row
  std::size_t needed{};
  double reliability_shown{};   ///< by that row
  double tolerance_passed_m{};  ///< every run would have passed with this one
};

/// What is said of one algorithm after all runs.
struct Qualified {
  std::string name;
  std::string what;
  bool backtracks{false};
  std::optional<Error> failed;  ///< why it has no figures
  std::vector<RunMetrics> runs;
  std::size_t iterations{};
  Figure rmse_m, mean_m, precision;
  double variance_m2{};
  double max_m{}, p50_m{}, p90_m{}, p95_m{}, p99_m{};
  double along_rmse_m{}, along_bias_m{}, across_rmse_m{}, across_bias_m{}, heading_rmse_rad{};
  double nees{};
  statistics::Interval nees_band;  ///< in which 95 % of honest ones' means lie
  std::array<double, region_ratios.size()> covered{};
  double nis{};
  std::size_t nis_dimensions{};
  /// In which 95 % of honest ones' means lie; their innovations are independent. None where nobody states any.
  std::optional<statistics::Interval> nis_band;
  std::size_t refused{};
  double worth{};  ///< independent values in all runs together
  std::array<Part, 3> by_section{};
  std::array<Part, since_fiducial_m.size() + 1> by_distance{};
  std::optional<double> limit_m;      ///< what nobody can beat
  std::optional<double> gap_percent;  ///< over it
  bool limit_assumed{false};          ///< made of guesses at the sensors: then nobody below it is called a leak
  bool leak{false};                   ///< significantly below it: it knows what it cannot know, or the limit is wrong
  std::vector<Pose2> alignments;      ///< of each run, what its estimates were moved by; empty where nobody asked
  Passes passes;
  statistics::Cdf cdf;
  std::vector<std::pair<double, double>> over_distance;  ///< of the first run: (travelled, error), thinned
  std::vector<Pose2> path;                               ///< of the first run, at every moment
};

enum class Verdict { different, not_shown_different, unresolved };
[[nodiscard]] std::string_view to_string(Verdict verdict);

/// Two of them on the same runs: b's figure minus a's, run by run.
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
  std::vector<std::size_t> ranked;  ///< which algorithms the ranks are of
  Digest digest;
  std::vector<double> times_s;  ///< of the first run's moments, for writing trajectories
  std::vector<Pose2> ground_truth;
};

/// Gives run number `index`, made in `room` (what was in it goes, its memory is used again) or kept elsewhere until all
/// is done. Asked by several at a time, and for one run more than once. Fails with what is wrong with it.
using TrialSource = std::function<Result<const Trial*>(std::size_t index, Trial& room)>;
/// Whether it is time to say how far it is; asked by several at a time before each part. Nothing: it never is.
using TimeIsUp = std::function<bool()>;
/// Told then, and at the end, by whoever has asked for all: how many runs are done for certain.
using Progress = std::function<void(std::size_t done)>;

/// All candidates on the same runs; workers do not change what comes out. One that fails keeps its error, the others
/// their results. Fails where a run does.
[[nodiscard]] Result<Qualification> qualify(const std::vector<Candidate>& candidates, std::size_t runs,
                                            const TrialSource& source, const QualificationOptions& options,
                                            Workers& workers, const TimeIsUp& time_is_up = {},
                                            const Progress& progress = {});
/// Alone.
[[nodiscard]] Result<Qualification> qualify(const std::vector<Candidate>& candidates, std::size_t runs,
                                            const TrialSource& source, const QualificationOptions& options);

}  // namespace cosiva::experiments
