#include "cosiva/experiments/positioning/recording/silence.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

using Steps = std::vector<Recording::Step>;

double squared(double v) { return v * v; }

struct Rates {
  double speed_mps;
  double turn_radps;
};

/// The relation between the counted value over some time and the value extrapolated from the rates at both ends: a
/// factor and a variance.
class Habit {
 public:
  void see(double expected, double counted) {
    ++count_;
    expected_2_ += squared(expected);
    both_ += expected * counted;
    counted_2_ += squared(counted);
  }
  [[nodiscard]] double ratio() const { return expected_2_ > 0.0 ? std::clamp(both_ / expected_2_, 0.0, 1.0) : 0.0; }
  [[nodiscard]] double variance() const {
    const double left = counted_2_ - 2.0 * ratio() * both_ + squared(ratio()) * expected_2_;
    return count_ > 0 ? std::fmax(left, 0.0) / static_cast<double>(count_) : 0.0;
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  std::size_t count_{0};
  double expected_2_{0.0}, both_{0.0}, counted_2_{0.0};
};

/// A vehicle's usual motion, from the parts of the drive without gaps.
class Habits {
 public:
  Habits(const Steps& steps, double unresponsive_s) : steps_{steps}, unresponsive_s_{unresponsive_s} {
    std::vector<double> speeds;
    speeds.reserve(steps.size());
    for (const Recording::Step& step : steps) {
      if (step.duration_s <= unresponsive_s) speeds.push_back(std::fabs(step.distance_m) / step.duration_s);
    }
    if (!speeds.empty()) fastest_mps_ = statistics::percentile(speeds, 0.99);
  }

  /// Replaces the increment after a gap: its uncertainty is that of the vehicle's usual motion over the same time.
  void bridge(std::size_t unresponsive, const Rates& after, Recording::Step& step) const {
    constexpr std::size_t enough = 10;
    const double lasts_s = step.duration_s;
    const Rates before = unresponsive > 0 ? rates_before(unresponsive - 1) : after;
    Habit distance;
    Habit turn;
    see(lasts_s, distance, turn);
    const double path_distance_m = 0.5 * (before.speed_mps + after.speed_mps) * lasts_s;
    const double turn_rad = 0.5 * (before.turn_radps + after.turn_radps) * lasts_s;
    if (distance.count() >= enough) {
      step.distance_m = distance.ratio() * path_distance_m;
      step.turn_rad = turn.ratio() * turn_rad;
      step.distance_variance_m2 = distance.variance();
      step.turn_variance_rad2 = turn.variance();
    } else {
      // The drive is too short for statistics: the vehicle may have stopped, or moved at its highest speed in any
      // direction.
      step.distance_m = path_distance_m;
      step.turn_rad = 0.0;
      step.distance_variance_m2 = squared(fastest_mps_ * lasts_s);
      step.turn_variance_rad2 = squared(pi);
    }
    // Turns reduce the distance: for a random walk of the heading with variance v the mean distance is (1 −
    // e^(−v/2))/(v/2) of the straight distance.
    const double half = 0.5 * std::fmin(step.turn_variance_rad2, squared(pi));
    const double ahead = half > 1e-6 ? (1.0 - det_exp(-half)) / half : 1.0;
    step.distance_variance_m2 += squared((1.0 - ahead) * step.distance_m);
    step.turn_variance_rad2 = std::fmin(step.turn_variance_rad2, squared(pi));
  }

  /// The 99th percentile of the speeds.
  [[nodiscard]] double fastest_mps() const { return fastest_mps_; }

 private:
  /// The mean rates of the last second.
  [[nodiscard]] Rates rates_before(std::size_t last) const {
    double lasted_s = 0.0;
    Rates sum{};
    for (std::size_t i = last + 1; i-- > 0 && lasted_s < 1.0 && steps_[i].duration_s <= unresponsive_s_;) {
      lasted_s += steps_[i].duration_s;
      sum.speed_mps += steps_[i].distance_m;
      sum.turn_radps += steps_[i].turn_rad;
    }
    if (!(lasted_s > 0.0)) return {};
    return {sum.speed_mps / lasted_s, sum.turn_radps / lasted_s};
  }

  /// Uses every stretch of the drive that is as long and has no gap in it, beginning each quarter of that time.
  void see(double lasts_s, Habit& distance, Habit& turn) const {
    double next_s = -1e300;
    for (std::size_t from = 0; from < steps_.size(); ++from) {
      if (steps_[from].t_s < next_s || steps_[from].duration_s > unresponsive_s_) continue;
      double passed_s = 0.0;
      double traversed_m = 0.0;
      double turned_rad = 0.0;
      std::size_t to = from + 1;
      for (; to < steps_.size() && passed_s < lasts_s && steps_[to].duration_s <= unresponsive_s_; ++to) {
        passed_s += steps_[to].duration_s;
        traversed_m += steps_[to].distance_m;
        turned_rad += steps_[to].turn_rad;
      }
      if (passed_s < lasts_s) continue;
      next_s = steps_[from].t_s + 0.25 * lasts_s;
      const Rates first = rates_before(from);
      const Recording::Step& last = steps_[to - 1];
      distance.see(0.5 * (first.speed_mps + last.distance_m / last.duration_s) * passed_s, traversed_m);
      turn.see(0.5 * (first.turn_radps + last.turn_rad / last.duration_s) * passed_s, turned_rad);
    }
  }

  const Steps& steps_;
  double unresponsive_s_;
  double fastest_mps_{0.0};
};

}  // namespace

void bridge_silences(Recording& recording, bool speeds) {
  std::vector<double> durations;
  durations.reserve(recording.odometry.size());
  for (const Recording::Step& step : recording.odometry) durations.push_back(step.duration_s);
  if (durations.size() < 10) return;
  const double usual_s = statistics::percentile(durations, 0.5);
  const double unresponsive_s = std::fmax(1.0, 10.0 * usual_s);
  std::size_t bridged = 0;
  std::size_t was_stopped = 0;
  double longest_s = 0.0;
  const Steps as_recorded = recording.odometry;
  const Habits habits{as_recorded, unresponsive_s};
  // Twice the highest speed: no single step is this large.
  const double step_most_m = 2.0 * habits.fastest_mps() * usual_s;
  for (std::size_t i = 0; i < as_recorded.size(); ++i) {
    const Recording::Step& reported = as_recorded[i];
    if (reported.duration_s <= unresponsive_s) continue;
    longest_s = std::fmax(longest_s, reported.duration_s);
    if (!speeds && std::fabs(reported.distance_m) > step_most_m) {
      ++was_stopped;
      continue;
    }
    ++bridged;
    const double counted_s = speeds ? reported.duration_s : usual_s;
    habits.bridge(i, {reported.distance_m / counted_s, reported.turn_rad / counted_s}, recording.odometry[i]);
  }
  if (bridged + was_stopped == 0) return;
  const std::size_t often = bridged + was_stopped;
  std::string text = "odometry is missing " + std::to_string(often) + (often == 1 ? " time" : " times") + ", for " +
                     std::to_string(std::lround(longest_s)) + " s at most; ";
  if (bridged > 0)
    text += "the vehicle is assumed to have moved as usual over the same time, with the variance of its usual motion";
  if (bridged > 0 && was_stopped > 0) text += "; ";
  if (was_stopped > 0) text += "the next increment is too large for one step and is used for the whole gap";
  recording.diagnostics.push_back(std::move(text));
}

}  // namespace cosiva::experiments
