#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/alignment.h"
#include "cosiva/zone/geometry/section.h"

/// Metrology of position estimation (A33, A35, A36): the inputs of an algorithm, the actual positions of the vehicle,
/// and the metrics of the difference.
namespace cosiva::experiments {

using Event = std::variant<estimation::Odometry, estimation::Reading, estimation::Range>;

/// An instant with known ground truth, at which the algorithm's estimate is taken.
struct Moment {
  std::size_t events{};  ///< number of the run's events before
  double t_s{};
  Pose2 ground_truth;         ///< X_MB
  double travelled_m{};       ///< since the start of the run
  double since_fiducial_m{};  ///< since the last reading or range; since the start before the first
  std::optional<zone::SectionKind> section;
};

/// One run: the article's loop (figures 16 and 17), live or recorded.
struct Trial {
  std::string name;
  estimation::Setting setting;  ///< the algorithm's inputs before the start
  std::vector<Event> events;
  std::vector<Moment> moments;
  bool heading_known{true};  ///< the ground truth has a heading; else only positions are evaluated
  /// The sensors' data are assumed, not measured: then so is a limit based on them.
  bool sensors_assumed{false};
};

/// The estimates of an algorithm at each moment, with their errors.
struct Trace {
  std::vector<double> error_m;   ///< distance to the ground truth
  std::vector<double> along_m;   ///< component along the ground truth's heading; forward is positive
  std::vector<double> across_m;  ///< component across; left is positive
  std::vector<double> heading_rad;
  std::vector<double> nees;      ///< squared position error over its stated covariance; expected 2
  std::vector<double> nis;       ///< of each reading and range that had one, per dimension
  std::size_t nis_dimensions{};  ///< of those together
  std::size_t refused{};         ///< readings and ranges that the algorithm rejected
  std::vector<estimation::Estimate> estimates;
  std::vector<double> ground_truth_heading_rad, ground_truth_sin,
      ground_truth_cos;  ///< of the ground truth, for along and across
};

/// Gives the algorithm all events of the run and takes its estimate at every moment; of a smoother
/// also at the end. The content of `trace` is replaced, its memory reused. Fails with the algorithm's own fault.
Result<void> apply(estimation::Algorithm& algorithm, const Trial& run, Trace& trace);

/// Moves all estimates of a run by one motion, covariances with them, and evaluates them again: X such that X ·
/// estimate is nearest to the ground truth (se2), or the first pose on that of the ground truth (origin). Fails as
/// rigid_alignment does, and ("align.heading") for origin where the ground truth has no heading.
/// @param how  se2 or origin: a run is planar
Result<Pose2> align(Alignment how, const Trial& run, Trace& trace);

}  // namespace cosiva::experiments
