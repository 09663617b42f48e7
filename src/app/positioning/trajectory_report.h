#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/experiments/positioning/metrology/reference_budget.h"
#include "cosiva/experiments/positioning/recording/alignment.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"
#include "cosiva/experiments/statistics/interval.h"

namespace cosiva::app {

/// One `--estimate`, evaluated against the `--reference`.
struct EvaluatedTrajectory {
  std::string name;  ///< the file's name without folder and ending; unique
  std::optional<Error> failed;
  experiments::ApeMetrics ape;
  double variance_m2{};
  double precision{};
  double p90_m{}, p95_m{}, p99_m{};
  double offset_s{};
  std::size_t unpaired{};
  std::optional<statistics::BlockInterval> interval;
  std::optional<experiments::RigidMotion> alignment;
  std::vector<experiments::Pair> pairs;  ///< after the alignment
};

/// Two estimates on the same stamps: a single run cannot show a difference, but it can show that a difference would not
/// be detectable.
[[nodiscard]] bool unresolved(const EvaluatedTrajectory& a, const EvaluatedTrajectory& b,
                              const experiments::ReferenceBudget& reference);

/// The files of `--out`: report.html, result.json, errors.csv with a line per pair, the reference and each estimate as
/// TUM (as evaluated, aligned where requested), and a zip file for evo of each.
/// @param json  the result as JSON
[[nodiscard]] Result<void> write_trajectories(const std::vector<EvaluatedTrajectory>& all,
                                              const experiments::Trajectory& reference,
                                              const QualifyArguments& arguments,
                                              const experiments::ReferenceBudget& budget, const std::string& json);

}  // namespace cosiva::app
