#include "cosiva/zone/opendrive/folds.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace cosiva::zone::opendrive {
namespace {

constexpr double room_min = 0.2;  // of the bend's radius: nearer to its centre than this, a lane folds
// ratio of its length that must lead along the road; otherwise its width leads it across
constexpr double aslant_min = 0.3;
constexpr double kink_min_rad = 0.1;   // more is a corner
constexpr double step_m = 0.25;        // between two samples
constexpr double samples_max = 4'000;  // of one lane
// a bridge with this radius, or one as large as the lane's lateral offset, reaches far enough
constexpr double radius_good_m = 2.0;
constexpr double radius_min_m = 0.15;  // no bridge is better than a tighter one
constexpr double reach_max_m = 30.0;   // to each side of a fold

double corner_between(Point2 a, Point2 b) {
  return std::fabs(wrap_angle(det_atan2(b.y_m, b.x_m) - det_atan2(a.y_m, a.x_m)));
}

/// A lane at an offset from its reference line, before anything is cut.
class Folding {
 public:
  Folding(const ReferenceLine& line, const Lateral& lateral, double from, double to)
      : line_{line}, lateral_{lateral}, from_{from}, to_{to} {}

  [[nodiscard]] std::vector<std::pair<double, double>> folds(std::size_t& work) const;
  [[nodiscard]] std::optional<Bridge> bridge_over(double from, double to) const;

 private:
  [[nodiscard]] Bridge bridge(double from, double to) const;

  const ReferenceLine& line_;
  const Lateral& lateral_;
  double from_;
  double to_;
};

/// Where the lane itself has folded, the bridge leaves and meets it along the reference line.
Bridge Folding::bridge(double from, double to) const {
  const auto heading = [&](double s, const LanePoint& point_there) {
    const Point2 d = point_there.folds() ? line_.at(s).d : point_there.d;
    return det_atan2(d.y_m, d.x_m);
  };
  const LanePoint one = lane_point(line_, lateral_, from);
  const LanePoint two = lane_point(line_, lateral_, to);
  const double start = heading(from, one);
  const double end = heading(to, two);
  // The handles of a cubic that is nearly an arc.
  const double quarter = det_cos(0.25 * wrap_angle(end - start));
  const double handle_m = distance(one.p, two.p) / std::max(quarter * quarter, 0.25);
  const SinCos at_start = sincos(start);
  const SinCos at_end = sincos(end);
  return {from,  to,
          one.p, {handle_m * at_start.cos, handle_m * at_start.sin},
          two.p, {handle_m * at_end.cos, handle_m * at_end.sin}};
}

/// The nearest bridge that is gentle enough, else the gentlest.
std::optional<Bridge> Folding::bridge_over(double from, double to) const {
  std::optional<Bridge> best;
  const double good_m = std::clamp(std::fabs(lateral_.at(0.5 * (from + to)).t), radius_min_m, radius_good_m);
  double widest_m = radius_min_m;
  for (double reach_m = step_m; reach_m < reach_max_m; reach_m *= 1.25) {
    const Bridge tried = bridge(std::max(from - reach_m, from_), std::min(to + reach_m, to_));
    const double tightest_m = tried.tightest_m();
    if (tightest_m > widest_m) {
      widest_m = tightest_m;
      best = tried;
    }
    if (tightest_m >= good_m || (tried.from <= from_ && tried.to >= to_)) break;
  }
  return best;
}

/// Stretches of s in which the lane folds; stretches near to each other are merged.
std::vector<std::pair<double, double>> Folding::folds(std::size_t& work) const {
  if (work == 0) return {};
  const double step = std::max({step_m, (to_ - from_) / samples_max, 1e-6});
  std::vector<double> positions;
  for (double s = from_; s < to_; s += step) positions.push_back(s);
  positions.push_back(to_);
  for (const auto* breaks : {&line_.breaks(), &lateral_.breaks()}) {
    for (const double s : *breaks) {
      if (s > from_ && s < to_) positions.insert(positions.end(), {s - 1e-9, s + 1e-9});
    }
  }
  work -= std::min(work, positions.size());
  std::sort(positions.begin(), positions.end());
  std::vector<std::pair<double, double>> found;
  Point2 before{1.0, 0.0};
  double before_s = from_ - 1.0;
  for (const double s : positions) {
    const LanePoint here = lane_point(line_, lateral_, s);
    // Across a break: where the road begins to bend, a lane that does not run along it kinks.
    const bool kinks = s - before_s < 1e-8 && corner_between(before, here.d) > kink_min_rad;
    before = here.d;
    before_s = s;
    if (!here.folds() && !kinks) continue;
    if (!found.empty() && s - found.back().second < 4.0 * step)
      found.back().second = s;
    else
      found.emplace_back(s, s);
  }
  return found;
}

}  // namespace

LanePoint lane_point(const ReferenceLine& line, const Lateral& lateral, double s) {
  const Jet jet = line.at(s);
  const auto [t, slope] = lateral.at(s);
  const double v = norm(jet.d.x_m, jet.d.y_m);
  if (!(v > 1e-12)) return {jet.p, {1.0, 0.0}};
  const Point2 along{jet.d.x_m / v, jet.d.y_m / v};
  const Point2 left{-along.y_m, along.x_m};
  // Along a bend the lane is longer or shorter than the line: the normal turns with the tangent.
  const double turn = (jet.dd.x_m * left.x_m + jet.dd.y_m * left.y_m) / v;
  return {{jet.p.x_m + t * left.x_m, jet.p.y_m + t * left.y_m},
          {(v - t * turn) * along.x_m + slope * left.x_m, (v - t * turn) * along.y_m + slope * left.y_m},
          (v - t * turn) / v,
          v - t * turn};
}

bool LanePoint::folds() const { return room < room_min || along < aslant_min * norm(d.x_m, d.y_m); }

Point2 Bridge::at(double s) const {
  const double u = (s - from) / (to - from);
  const double w = 1.0 - u;
  const auto of = [&](double a, double da, double b, double db) {
    return w * w * ((1.0 + 2.0 * u) * a + u * da) + u * u * ((1.0 + 2.0 * w) * b - w * db);
  };
  return {of(start.x_m, start_d.x_m, end.x_m, end_d.x_m), of(start.y_m, start_d.y_m, end.y_m, end_d.y_m)};
}

Point2 Bridge::slope_at(double s) const {
  const double u = (s - from) / (to - from);
  const double w = 1.0 - u;
  const auto of = [&](double a, double da, double b, double db) {
    return (6.0 * u * w * (b - a) + w * (1.0 - 3.0 * u) * da + u * (3.0 * u - 2.0) * db) / (to - from);
  };
  return {of(start.x_m, start_d.x_m, end.x_m, end_d.x_m), of(start.y_m, start_d.y_m, end.y_m, end_d.y_m)};
}

double Bridge::tightest_m() const {
  constexpr int samples = 32;
  double tightest = 1e9;
  Point2 before = slope_at(from);
  for (int i = 1; i <= samples; ++i) {
    const Point2 here = slope_at(from + (to - from) * i / samples);
    const double distance_m = 0.5 * (norm(before.x_m, before.y_m) + norm(here.x_m, here.y_m)) * (to - from) / samples;
    const double turn = corner_between(before, here);
    if (turn > 1e-9) tightest = std::min(tightest, distance_m / turn);
    before = here;
  }
  return tightest;
}

std::vector<Bridge> bridge_folds(const ReferenceLine& line, const Lateral& lateral, double from, double to,
                                 std::size_t& work) {
  const Folding lane{line, lateral, from, to};
  std::vector<Bridge> bridges;
  for (const auto& [start_of_fold, end_of_fold] : lane.folds(work)) {
    auto found = lane.bridge_over(start_of_fold, end_of_fold);
    // Bridges that would overlap are one, over both folds.
    while (found && !bridges.empty() && found->from < bridges.back().to) {
      const double start = std::min(found->from, bridges.back().from);
      bridges.pop_back();
      found = lane.bridge_over(start, found->to);
    }
    if (found) bridges.push_back(*found);
  }
  return bridges;
}

}  // namespace cosiva::zone::opendrive
