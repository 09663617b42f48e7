#include "cosiva/zone/opendrive/lane_curve.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
/// The derivative by s at s; p becomes the point.
Point2 LaneCurve::derivative(double s, Point2& p) const {
  Point2 d;
  const auto over = std::find_if(bridges_.begin(), bridges_.end(),
                                 [s](const Bridge& bridge) { return s >= bridge.from && s <= bridge.to; });
  if (over != bridges_.end()) {
    p = over->at(s);
    d = over->slope_at(s);
  } else {
    const LanePoint here = lane_point(*line_, lateral_, s);
    p = here.p;
    d = here.d;
  }
  const auto add = [&](const Moved& moved, double x, double sign) {
    p = {p.x_m + moved.x.at(x), p.y_m + moved.y.at(x)};
    d = {d.x_m + sign * moved.x.slope_at(x), d.y_m + sign * moved.y.slope_at(x)};
  };
  if (at_from_) add(*at_from_, std::max(s - from_, 0.0), 1.0);
  if (at_to_) add(*at_to_, std::max(to_ - s, 0.0), -1.0);
  return d;
}

Pose2 LaneCurve::pose_at(double s) const {
  Point2 p;
  const Point2 d = derivative(s, p);
  return {p.x_m, p.y_m, forward_ ? det_atan2(d.y_m, d.x_m) : det_atan2(-d.y_m, -d.x_m)};
}

double LaneCurve::cut_folds(std::size_t& work) {
  bridges_ = bridge_folds(*line_, lateral_, from_, to_, work);
  double cut = 0.0;
  for (const Bridge& bridge : bridges_) cut += bridge.to - bridge.from;
  return cut;
}

void LaneCurve::move_end(bool entry, const Pose2& target, double reach_m) {
  const bool start = entry == forward_;
  const double s = start ? from_ : to_;
  Point2 p;
  const Point2 d = derivative(s, p);
  const SinCos direction = sincos(target.heading_rad);
  const double v = (forward_ ? 1.0 : -1.0) * norm(d.x_m, d.y_m);
  const double sign = start ? 1.0 : -1.0;  // slopes of an easing are by the distance from the end
  const double over = std::min(reach_m, span());
  Moved moved;
  moved.x = {target.x_m - p.x_m, sign * (v * direction.cos - d.x_m), over};
  moved.y = {target.y_m - p.y_m, sign * (v * direction.sin - d.y_m), over};
  (start ? at_from_ : at_to_) = moved;
}

PlaneCurve LaneCurve::curve(double scale, const std::vector<double>& more_breaks) const {
  std::vector<double> breaks = line_->breaks();
  breaks.insert(breaks.end(), lateral_.breaks().begin(), lateral_.breaks().end());
  breaks.insert(breaks.end(), more_breaks.begin(), more_breaks.end());
  for (const Bridge& bridge : bridges_) breaks.insert(breaks.end(), {bridge.from, bridge.to});
  if (at_from_) breaks.push_back(from_ + at_from_->x.over);
  if (at_to_) breaks.push_back(to_ - at_to_->x.over);
  std::erase_if(breaks, [&](double s) { return !(s > from_ + 1e-9 && s < to_ - 1e-9); });

  PlaneCurve curve;
  curve.from = forward_ ? from_ : -to_;
  curve.to = forward_ ? to_ : -from_;
  for (const double s : breaks) curve.breaks.push_back(forward_ ? s : -s);
  std::sort(curve.breaks.begin(), curve.breaks.end());
  curve.at = [this, scale](double u) {
    const Pose2 pose = pose_at(forward_ ? u : -u);
    return Pose2{scale * pose.x_m, scale * pose.y_m, pose.heading_rad};
  };
  return curve;
}

}  // namespace cosiva::zone::opendrive
