#include "cosiva/zone/lif/lif_tracks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cosiva::zone::lif {
namespace {

/// Nodes nearer than this are one point: no section leads from one to the other.
constexpr double distance_min_m = 1e-3;
/// A trajectory this close to its nodes meets them.
constexpr double meets_m = 1e-3;
/// A trajectory that must be stretched further is another curve.
constexpr double stretch_max = 20.0;
/// A trajectory may kink this much and be rounded; where it kinks more, vehicles turn on the spot.
constexpr double kink_max_rad = 0.15;
/// The limit of the work for one trajectory's fit, of the limit for all.
constexpr double work_of_one = 1e8;
constexpr int checks_per_span = 24;

std::string decimal(double value, double unit) {
  const double rounded = std::round(value / unit * 1000.0) / 1000.0;
  std::string text = std::to_string(rounded);
  return text.substr(0, text.find('.') + 4);
}

/// Whether all control points lie on the straight line between the ends, in this order.
bool is_straight(const Nurbs& curve) {
  const Point2 a = curve.points.front();
  const Point2 b = curve.points.back();
  const double length_m = distance(a, b);
  if (length_m < distance_min_m) return false;
  double reached_m = 0.0;
  for (const Point2 p : curve.points) {
    const double along_m = ((p.x_m - a.x_m) * (b.x_m - a.x_m) + (p.y_m - a.y_m) * (b.y_m - a.y_m)) / length_m;
    const double aside_m = ((p.y_m - a.y_m) * (b.x_m - a.x_m) - (p.x_m - a.x_m) * (b.y_m - a.y_m)) / length_m;
    if (std::fabs(aside_m) > 1e-6 || along_m < reached_m - 1e-6) return false;
    reached_m = along_m;
  }
  return true;
}

/// A step of the parameter too small to matter to a vehicle.
double hair_of(const Nurbs& curve) { return 1e-9 * (curve.to() - curve.from()); }

}  // namespace

Track TrackMaker::make(const Edge& edge, Point2 from, Point2 to) {
  if (edge.trajectory) {
    Nurbs curve = *edge.trajectory;
    Track track;
    if (meet(curve, edge, from, to) && !is_straight(curve) && follow(curve, edge, track)) return track;
  }
  const double length_m = distance(from, to);
  if (length_m < distance_min_m) return {};
  auto section = Section::make({from.x_m, from.y_m, det_atan2(to.y_m - from.y_m, to.x_m - from.x_m)}, length_m);
  if (!section) {
    diagnostics_.add(Diagnostic::Kind::lost, edge.location,
                     "no path can be made of it: " + section.error().message + "; not taken");
    return {};
  }
  return {{std::move(*section)}, {false}};
}

/// Moves the curve's ends to the nodes.
bool TrackMaker::meet(Nurbs& curve, const Edge& edge, Point2 from, Point2 to) {
  const Point2 a = position(curve.pose_at(curve.from()));
  const Point2 b = position(curve.pose_at(curve.to()));
  const double chord_m = distance(a, b);
  const double wanted_m = distance(from, to);
  const double off_m = std::max(distance(a, from), distance(b, to));
  // z ↦ from + (z − a)·k as complex numbers; a closed curve is only moved.
  double kx = 1.0;
  double ky = 0.0;
  if (chord_m >= distance_min_m && wanted_m >= distance_min_m) {
    const Point2 c{b.x_m - a.x_m, b.y_m - a.y_m};
    const Point2 w{to.x_m - from.x_m, to.y_m - from.y_m};
    kx = (w.x_m * c.x_m + w.y_m * c.y_m) / (chord_m * chord_m);
    ky = (w.y_m * c.x_m - w.x_m * c.y_m) / (chord_m * chord_m);
  } else if (chord_m >= distance_min_m || wanted_m >= distance_min_m) {
    diagnostics_.add(Diagnostic::Kind::mended, edge.location + ".trajectory",
                     "the trajectory and its nodes do not belong together; a straight line from node to node instead");
    return false;
  }
  const double stretch = norm(kx, ky);
  if (!(stretch < stretch_max && stretch > 1.0 / stretch_max)) {
    diagnostics_.add(Diagnostic::Kind::mended, edge.location + ".trajectory",
                     "the trajectory would have to be stretched by " + decimal(stretch, 1.0) +
                         " to meet its nodes; a straight line from node to node instead",
                     "trajectory not stretched");
    return false;
  }
  for (Point2& p : curve.points) {
    const double x = p.x_m - a.x_m;
    const double y = p.y_m - a.y_m;
    p = {from.x_m + kx * x - ky * y, from.y_m + ky * x + kx * y};
  }
  if (off_m > meets_m) {
    diagnostics_.add(Diagnostic::Kind::mended, edge.location + ".trajectory",
                     "the trajectory misses its nodes by " + decimal(off_m, 1.0) +
                         " m; it is moved to them, turned by " + decimal(det_atan2(ky, kx), 1.0) +
                         " rad and stretched by " + decimal(stretch, 1.0),
                     "trajectory stretched");
  }
  return true;
}

bool TrackMaker::follow(const Nurbs& curve, const Edge& edge, Track& track) {
  // From corner to corner.
  const double hair = hair_of(curve);
  double from = curve.from();
  std::vector<double> ends;
  for (const Nurbs::Knot& knot : curve.inner_knots()) {
    if (!knot.corner) continue;
    const double kink_rad = curve.pose_at(knot.u + hair).heading_rad - curve.pose_at(knot.u - hair).heading_rad;
    if (std::fabs(wrap_angle(kink_rad)) > kink_max_rad) ends.push_back(knot.u);
  }
  ends.push_back(curve.to());
  std::string why;
  for (const double to : ends) {
    if (!follow_span(curve, from, to, track, why)) {
      track = {};
      diagnostics_.add(Diagnostic::Kind::mended, edge.location + ".trajectory",
                       "the trajectory cannot be driven: " + why + "; a straight line from node to node instead",
                       "trajectory not fitted");
      return false;
    }
    track.corner.back() = true;
    from = to;
  }
  track.corner.back() = false;
  if (ends.size() > 1) {
    diagnostics_.add(Diagnostic::Kind::mended, edge.location + ".trajectory",
                     "the trajectory has corners; vehicles turn on the spot there");
  }
  return true;
}

bool TrackMaker::follow_span(const Nurbs& curve, double from, double to, Track& track, std::string& why) {
  const double cost = static_cast<double>((curve.degree + 1) * (curve.degree + 1) + 20);
  double budget = std::min(work_of_one, work_left_);
  const double granted = budget;
  PlaneCurve plane;
  plane.from = from;
  plane.to = to;
  // At a corner the curve has the direction of its continuation, but this stretch ends before it.
  const double last = to < curve.to() ? to - hair_of(curve) : to;
  plane.at = [&](double u) {
    budget -= cost;
    if (budget > 0.0) return curve.pose_at(std::min(u, last));
    // A value that is not finite ends the fit.
    return Pose2{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  };
  std::vector<Nurbs::Knot> knots;
  for (const Nurbs::Knot& knot : curve.inner_knots()) {
    if (knot.u > from && knot.u < to) knots.push_back(knot);
  }

  // A file's curve is often one arc or clothoid in several spans: first tried as one, with dense samples.
  Result<Fit> made = fit(plane, tolerance_);
  bool close = made && made->sections.size() == 1;
  if (close && !knots.empty()) {
    const Section& section = made->sections.front();
    double low = from;
    for (std::size_t i = 0; i <= knots.size() && close; ++i) {
      const double high = i < knots.size() ? knots[i].u : to;
      for (int step = 1; step < checks_per_span && close; ++step) {
        const Pose2 pose = curve.pose_at(low + (high - low) * step / checks_per_span);
        const Section::Nearest near = section.nearest(position(pose));
        const double turned_rad = wrap_angle(section.pose_at(near.s_m).heading_rad - pose.heading_rad);
        close = near.distance_m <= tolerance_.position_m && std::fabs(turned_rad) <= tolerance_.heading_rad;
      }
      low = high;
    }
  }
  if (!close && !knots.empty()) {
    for (const Nurbs::Knot& knot : knots) plane.breaks.push_back(knot.u);
    made = fit(plane, tolerance_);
  }
  work_left_ -= granted - std::max(budget, 0.0);
  if (!made) {
    why = budget > 0.0 ? made.error().message : "it takes too long to follow";
    return false;
  }
  ++fitted_;
  worst_position_m_ = std::max(worst_position_m_, made->worst_position_m);
  worst_heading_rad_ = std::max(worst_heading_rad_, made->worst_heading_rad);
  for (Section& section : made->sections) {
    track.sections.push_back(std::move(section));
    track.corner.push_back(false);
  }
  return true;
}

std::optional<Section> TrackMaker::as_one(const std::vector<Section>& sections) const {
  std::vector<double> ends_m;
  ends_m.reserve(sections.size());
  for (const Section& section : sections) ends_m.push_back((ends_m.empty() ? 0.0 : ends_m.back()) + section.length_m());
  PlaneCurve curve;
  curve.from = 0.0;
  curve.to = ends_m.back();
  curve.at = [&](double s_m) {
    const auto at = static_cast<std::size_t>(std::lower_bound(ends_m.begin(), ends_m.end() - 1, s_m) - ends_m.begin());
    return sections[at].pose_at(s_m - (at == 0 ? 0.0 : ends_m[at - 1]));
  };
  auto made = fit(curve, tolerance_);
  if (!made || made->sections.size() != 1) return std::nullopt;
  return std::move(made->sections.front());
}

void TrackMaker::record_worst() {
  if (fitted_ == 0) return;
  diagnostics_.add(Diagnostic::Kind::notice, "layouts",
                   std::to_string(fitted_) + " trajectories are followed within " + decimal(worst_position_m_, 1e-3) +
                       " mm and " + decimal(worst_heading_rad_, 1e-3) + " mrad");
}

}  // namespace cosiva::zone::lif
