#include "cosiva/experiments/positioning/recording/heading.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva::experiments {
namespace {

/// A chord of this length defines a course in spite of the positions' own noise, a few cm.
constexpr double chord_m = 0.5;
/// Beyond this turn a chord defines no course.
constexpr double bend_rad = 0.5;
/// Three times the uncertainty of a start's heading.
constexpr double offset_rad = 0.15;
/// Mean resultant length of motion along the heading: a spread of 37 degrees; for unrelated directions it would be
/// 1/√n.
constexpr double follows = 0.8;
constexpr int enough = 10;

/// The distance (backwards negative) or the turn that odometry has counted until a time.
class Odometer {
 public:
  Odometer(const std::vector<Recording::Step>& steps, double Recording::Step::*what) : steps_{steps}, what_{what} {
    counted_.reserve(steps.size());
    double sum = 0.0;
    for (const Recording::Step& step : steps) counted_.push_back(sum += step.*what);
  }
  [[nodiscard]] double at(double t_s) const {
    const auto after = std::ranges::lower_bound(steps_, t_s, {}, &Recording::Step::t_s);
    if (after == steps_.end()) return counted_.empty() ? 0.0 : counted_.back();
    const auto i = static_cast<std::size_t>(after - steps_.begin());
    const double left = std::clamp((after->t_s - t_s) / after->duration_s, 0.0, 1.0);
    return counted_[i] - left * (*after).*what_;
  }

 private:
  const std::vector<Recording::Step>& steps_;
  double Recording::Step::*what_;
  std::vector<double> counted_;
};

struct Offset {
  double mean_rad;
  double together;  ///< mean resultant length: 1 where all chords agree
  int chords;
};

/// The angle between the direction of motion, forwards, and the heading.
Offset offset_of(const Recording& recording) {
  const Odometer odometer{recording.odometry, &Recording::Step::distance_m};
  const Odometer turns{recording.odometry, &Recording::Step::turn_rad};
  const auto& ground_truth = recording.ground_truth;
  double along = 0.0;
  double aside = 0.0;
  int chords = 0;
  std::size_t from = 0;
  for (std::size_t to = 1; to < ground_truth.size(); ++to) {
    const double dx = ground_truth[to].position_M.x_m - ground_truth[from].position_M.x_m;
    const double dy = ground_truth[to].position_M.y_m - ground_truth[from].position_M.y_m;
    if (norm(dx, dy) < chord_m) continue;
    const double counted_m = odometer.at(ground_truth[to].t_s) - odometer.at(ground_truth[from].t_s);
    const double bent_rad = std::fabs(turns.at(ground_truth[to].t_s) - turns.at(ground_truth[from].t_s));
    // Without a count of odometry the direction, forwards or backwards, is unknown.
    if (std::fabs(counted_m) > 0.5 * norm(dx, dy) && bent_rad < bend_rad) {
      const double course_rad = det_atan2(dy, dx) + (counted_m < 0.0 ? pi : 0.0);
      const double turn_rad = wrap_angle(ground_truth[to].heading_rad - ground_truth[from].heading_rad);
      const SinCos off = sincos(course_rad - ground_truth[from].heading_rad - 0.5 * turn_rad);
      along += off.cos;
      aside += off.sin;
      ++chords;
    }
    from = to;
  }
  return {det_atan2(aside, along), chords > 0 ? norm(along, aside) / chords : 0.0, chords};
}

}  // namespace

void check_heading(Recording& recording) {
  if (!recording.ground_truth_has_heading) return;
  const Offset offset = offset_of(recording);
  if (offset.chords < enough) return;
  if (offset.together < follows) {
    recording.ground_truth_has_heading = false;
    for (Recording::True& ground_truth : recording.ground_truth) ground_truth.heading_rad = 0.0;
    recording.diagnostics.emplace_back(
        "the ground truth's heading does not follow the direction of motion (expected: radians, counter-clockwise from "
        "x); it is left "
        "out, and algorithms have to estimate the heading");
  } else if (std::fabs(offset.mean_rad) > offset_rad) {
    for (Recording::True& ground_truth : recording.ground_truth) ground_truth.heading_rad += offset.mean_rad;
    recording.diagnostics.push_back(
        "the ground truth's heading is " + std::to_string(std::lround(std::fabs(offset.mean_rad) * 180.0 / pi)) +
        " degrees off the direction of motion, forwards by odometry; it is corrected by this angle");
  }
}

}  // namespace cosiva::experiments
