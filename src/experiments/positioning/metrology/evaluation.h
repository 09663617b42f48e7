#pragma once

#include "cosiva/base/workers.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// One algorithm on one run.
struct Evaluated {
  std::optional<Error> failed;
  RunMetrics metrics;
  std::optional<Pose2> alignment;  ///< the motion that was applied to all estimates
  std::vector<float> errors_m;     ///< a float suffices for percentiles
  double worth{};                  ///< of the first few runs alone, as is the next member
  double nees_worth{};
  std::vector<double> squares_m2;                        ///< of the first run alone, as are all members below
  std::vector<std::pair<double, double>> over_distance;  ///< (travelled, error), thinned
  std::vector<Pose2> path;
};

/// One run, with the results of all algorithms.
struct EvaluatedRun {
  std::optional<Error> failed;  ///< why the run does not exist
  std::optional<RunLimit> limit;
  bool sensors_assumed{false};
  std::vector<Evaluated> algorithms;  ///< one per candidate; meaningless for those that failed in an earlier run
  std::vector<double> times_s;        ///< of the first run alone
  std::vector<Pose2> ground_truth;
};

/// Number of runs whose effective size is computed: this takes longer than all other metrics together.
inline constexpr std::size_t worth_runs_most = 10;

/// Evaluates all candidates on all runs, in parts that may run in parallel: the result does not depend on the
/// assignment of parts. Fails with the error of the first run that has one.
[[nodiscard]] Result<std::vector<EvaluatedRun>> evaluate_all(const std::vector<Candidate>& candidates, std::size_t runs,
                                                             const TrialSource& source,
                                                             const QualificationOptions& options, Workers& workers,
                                                             const TimeIsUp& time_is_up, const Progress& progress);

}  // namespace cosiva::experiments
