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

/// Metrology of position estimation (A33, A35, A36): what an algorithm is told, where the vehicle truly was, and what
/// to say of the difference.
namespace cosiva::experiments {

using Event = std::variant<estimation::Odometry, estimation::Reading, estimation::Range>;

/// An instant at which the truth is known and the algorithm is asked.
struct Moment {
  std::size_t events{};  ///< how many of the run's events came before
  double t_s{};
  Pose2 ground_truth;         ///< X_MB
  double travelled_m{};       ///< since the run's beginning
  double since_fiducial_m{};  ///< since the last reading or range; since the beginning before the first
  std::optional<zone::SectionKind> section;
};

/// One run: the article's loop (figures 16 and 17), as it was lived or recorded.
struct Trial {
  std::string name;
  estimation::Setting setting;  ///< what an algorithm is told before it starts
  std::vector<Event> events;
  std::vector<Moment> moments;
  bool heading_known{true};  ///< the truth has a heading; else only positions are judged
  /// Nobody has measured how good the sensors are, so their figures are guesses: then so is a limit made of them.
  bool sensors_assumed{false};
};

/// What an algorithm said at each moment, beside the truth.
struct Trace {
  std::vector<double> error_m;   ///< distance to the truth
  std::vector<double> along_m;   ///< of that, along the truth's heading; ahead is positive
  std::vector<double> across_m;  ///< and across, left is positive
  std::vector<double> heading_rad;
  std::vector<double> nees;      ///< squared position error over its stated covariance; expected 2
  std::vector<double> nis;       ///< of each reading and range that had one, per dimension
  std::size_t nis_dimensions{};  ///< of those together
  std::size_t refused{};         ///< readings and ranges that the algorithm did not take
  std::vector<estimation::Estimate> estimates;
  std::vector<double> ground_truth_heading_rad, ground_truth_sin,
      ground_truth_cos;  ///< of the truth, for along and across
};

/// Tells the algorithm all events of the run and asks it at every moment; who looks back is asked again at the end.
/// What was in `trace` goes, its memory is used again. Fails with the algorithm's own fault.
Result<void> apply(estimation::Algorithm& algorithm, const Trial& run, Trace& trace);

/// Moves all estimates of a run as one, covariances with them, and judges them anew: X such that X · estimate is
/// nearest to the truth (se2), or the first on the truth's first (origin). Fails as rigid_alignment does, and
/// ("align.heading") for origin where the truth has none.
/// @param how  se2 or origin: a run lies on the floor
Result<Pose2> align(Alignment how, const Trial& run, Trace& trace);

}  // namespace cosiva::experiments
