#include "cosiva/zone/opendrive/lane_curve.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

constexpr double near_min_m = 1e-3;
constexpr double near_max_m = 0.05;
constexpr double jump_free_m = 1e-6;
constexpr double kink_free = 1e-6;
constexpr double lengths_of_jump = 20.0;  // that a jump takes to be smoothed
constexpr double short_max_m = 1.0;

}  // namespace

double nearness(double from, double to) { return std::clamp(0.1 * (to - from), near_min_m, near_max_m); }

Pieces holding(std::vector<Polynomial> records, double from, double to, bool before) {
  std::stable_sort(records.begin(), records.end(), [](const Polynomial& a, const Polynomial& b) { return a.s < b.s; });
  const double near = nearness(from, to);
  Pieces pieces{{from}};
  if (before && !records.empty()) pieces.front().a = records.front().a;
  for (const Polynomial& record : records) {
    if (record.s <= from + near) {
      pieces.front() = moved(record, from);
    } else if (record.s < to - near) {
      if (record.s - pieces.back().s <= near)
        pieces.back() = moved(record, pieces.back().s);
      else
        pieces.push_back(record);
    }
  }
  return pieces;
}

const Polynomial& piece_at(const Pieces& pieces, double s) {
  const auto after = std::upper_bound(pieces.begin() + 1, pieces.end(), s,
                                      [](double value, const Polynomial& piece) { return value < piece.s; });
  return *(after - 1);
}

Pieces sum(const Pieces& left, double a, const Pieces& right, double b, double near) {
  std::vector<double> starts;
  for (const Pieces* pieces : {&left, &right}) {
    for (const Polynomial& piece : *pieces) starts.push_back(piece.s);
  }
  std::sort(starts.begin(), starts.end());
  Pieces total;
  for (const double s : starts) {
    if (!total.empty() && s - total.back().s <= near) continue;
    // Starts that close together are one, and what begins at the later one holds.
    const Polynomial one = moved(piece_at(left, s + near), s);
    const Polynomial two = moved(piece_at(right, s + near), s);
    total.push_back({s, a * one.a + b * two.a, a * one.b + b * two.b, a * one.c + b * two.c, a * one.d + b * two.d});
  }
  return total;
}

namespace {

/// A piece too short for the jump at its start or end to be smoothed within it gives way to its neighbours.
void drop_short_jumps(Pieces& pieces, double to) {
  std::size_t kept = 1;  // so many of those before i stay
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    Polynomial after = pieces[i];
    const double length_after = (i + 1 < pieces.size() ? pieces[i + 1].s : to) - after.s;
    bool stays = true;
    while (stays && kept > 0) {
      const Polynomial& before = pieces[kept - 1];
      const double length_before = after.s - before.s;
      const double jump = std::fabs(after.a - before.at(length_before));
      const double room = std::min(length_before, length_after);
      if (jump <= jump_free_m || room > std::min(lengths_of_jump * jump, short_max_m)) break;
      stays = length_before < length_after;
      // Where the first gives way, the next begins in its place.
      if (stays && kept == 1) after = moved(after, before.s);
      if (stays) --kept;
    }
    if (stays) pieces[kept++] = after;
  }
  pieces.resize(kept);
}

}  // namespace

std::optional<Lateral> Lateral::make(Pieces pieces, double to) {
  Lateral lateral;
  drop_short_jumps(pieces, to);
  lateral.pieces_ = std::move(pieces);
  const std::size_t count = lateral.pieces_.size();
  lateral.at_start_.resize(count);
  lateral.at_end_.resize(count);
  for (std::size_t i = 0; i < count; ++i) lateral.ends_.push_back(i + 1 < count ? lateral.pieces_[i + 1].s : to);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Polynomial& before = lateral.pieces_[i];
    const Polynomial& after = lateral.pieces_[i + 1];
    const double ds = after.s - before.s;
    const double jump = after.a - before.at(ds);
    const double kink = after.b - before.slope_at(ds);
    lateral.breaks_.push_back(after.s);
    if (std::fabs(jump) <= jump_free_m && std::fabs(kink) <= kink_free) continue;
    const double over_before = std::min(easing_reach(0.5 * jump, 0.5 * kink), ds);
    const double over_after = std::min(easing_reach(0.5 * jump, 0.5 * kink), lateral.ends_[i + 1] - after.s);
    if (!(std::fabs(jump) <= std::min(gap_max_m, 0.5 * std::min(over_before, over_after)))) return std::nullopt;
    lateral.at_end_[i] = {0.5 * jump, -0.5 * kink, over_before};
    lateral.at_start_[i + 1] = {-0.5 * jump, -0.5 * kink, over_after};
    lateral.breaks_.push_back(after.s - over_before);
    lateral.breaks_.push_back(after.s + over_after);
    lateral.jump_ = std::max(lateral.jump_, std::fabs(jump));
    lateral.kink_ = std::max(lateral.kink_, std::fabs(kink));
  }
  return lateral;
}

Lateral::Value Lateral::at(double s) const {
  const Polynomial& piece = piece_at(pieces_, s);
  const auto index = static_cast<std::size_t>(&piece - pieces_.data());
  const double ds = s - piece.s;
  const double left = std::max(ends_[index] - s, 0.0);
  return {piece.at(ds) + at_start_[index].at(ds) + at_end_[index].at(left),
          piece.slope_at(ds) + at_start_[index].slope_at(ds) - at_end_[index].slope_at(left)};
}

LaneCurve::Beside LaneCurve::beside(double s) const {
  const Jet jet = line_->at(s);
  const auto [t, slope] = lateral_.at(s);
  const double v = norm(jet.d.x_m, jet.d.y_m);
  if (!(v > 1e-12)) return {jet.p, {1.0, 0.0}};
  const Point2 along{jet.d.x_m / v, jet.d.y_m / v};
  const Point2 left{-along.y_m, along.x_m};
  // Beside a bend the way is longer or shorter: the normal turns with the tangent.
  const double turn = (jet.dd.x_m * left.x_m + jet.dd.y_m * left.y_m) / v;
  return {{jet.p.x_m + t * left.x_m, jet.p.y_m + t * left.y_m},
          {(v - t * turn) * along.x_m + slope * left.x_m, (v - t * turn) * along.y_m + slope * left.y_m},
          (v - t * turn) / v,
          v - t * turn};
}

/// The derivative by s at s; p becomes the point.
Point2 LaneCurve::derivative(double s, Point2& p) const {
  Point2 d;
  const auto over = std::find_if(bridges_.begin(), bridges_.end(),
                                 [s](const Bridge& bridge) { return s >= bridge.from && s <= bridge.to; });
  if (over != bridges_.end()) {
    p = over->at(s);
    d = over->slope_at(s);
  } else {
    const Beside here = beside(s);
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
