#pragma once

#include "cosiva/base/workers.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// One algorithm on one run.
struct Evaluated {
  std::optional<Error> failed;
  RunMetrics metrics;
  std::optional<Pose2> alignment;  ///< what all its estimates were moved by
  std::vector<float> errors_m;     ///< a millionth of a metre is enough for a percentile
  double worth{};                  ///< of the first few runs alone, as is the next
  double nees_worth{};
  std::vector<double> squares_m2;                        ///< of the first run alone, as is all below
  std::vector<std::pair<double, double>> over_distance;  ///< (travelled, error), thinned
  std::vector<Pose2> path;
};

/// One run, and all algorithms on it.
struct EvaluatedRun {
  std::optional<Error> failed;  ///< why there is no such run
  std::optional<RunLimit> limit;
  bool sensors_assumed{false};
  std::vector<Evaluated> algorithms;  ///< one per candidate; of those that failed in an earlier run it means nothing
  std::vector<double> times_s;        ///< of the first run alone
  std::vector<Pose2> ground_truth;
};

/// Runs whose effective size is looked at: it takes longer than all other figures together.
inline constexpr std::size_t worth_runs_most = 10;

/// All candidates on all runs, in parts that may be done at the same time: what comes out does not depend on who does
/// which. Fails with the first run's error that has one.
[[nodiscard]] Result<std::vector<EvaluatedRun>> evaluate_all(const std::vector<Candidate>& candidates, std::size_t runs,
                                                             const TrialSource& source,
                                                             const QualificationOptions& options, Workers& workers,
                                                             const TimeIsUp& time_is_up, const Progress& progress);

}  // namespace cosiva::experiments
