#include "cosiva/zone/opendrive/sloppy_records.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

constexpr double gap_ratio = 0.02;        // of a record's length
constexpr double kink_least_rad = 0.02;   // a polygon's corner
constexpr double kink_times_m = 1.0;      // beyond, a curve through the corners would bulge by more than 8 cm
constexpr double length_ratio_max = 0.2;  // by which a record's length may change

struct Joint {
  Pose2 left;
  Pose2 right;
  [[nodiscard]] double gap_m() const { return distance(left, right); }
  [[nodiscard]] double kink_rad() const { return wrap_angle(right.heading_rad - left.heading_rad); }
  [[nodiscard]] Pose2 centre() const {
    return {0.5 * (left.x_m + right.x_m), 0.5 * (left.y_m + right.y_m), left.heading_rad + 0.5 * kink_rad()};
  }
};

Pose2 pose_of(const Jet& jet) { return {jet.p.x_m, jet.p.y_m, jet.heading_rad()}; }

bool sloppy(const Joint& joint, double arc_m) {
  const double kink = std::fabs(joint.kink_rad());
  return joint.gap_m() > gap_ratio * arc_m || (kink > kink_least_rad && kink * arc_m < kink_times_m);
}

/// The heading of the circle through three positions, in the middle one. A file's own headings there are as inaccurate
/// as its positions: some exporters write the direction to the next position.
double heading_through(const Pose2& before, const Pose2& at, const Pose2& after) {
  const double first = det_atan2(at.y_m - before.y_m, at.x_m - before.x_m);
  const double turn = wrap_angle(det_atan2(after.y_m - at.y_m, after.x_m - at.x_m) - first);
  const double length_before = distance(before, at);
  const double ratio = length_before / std::max(length_before + distance(at, after), 1e-9);
  return first + ratio * turn;
}

/// A cubic from pose to pose, nearly an arc where an arc leads there.
std::optional<CubicPath> curve_between(const Pose2& from, const Pose2& to) {
  const double turn = wrap_angle(to.heading_rad - from.heading_rad);
  const SinCos start = sincos(from.heading_rad);
  const double x = start.cos * (to.x_m - from.x_m) + start.sin * (to.y_m - from.y_m);
  const double y = start.cos * (to.y_m - from.y_m) - start.sin * (to.x_m - from.x_m);
  const double quarter = det_cos(0.25 * turn);
  const double handle_m = norm(x, y) / (quarter * quarter);
  const SinCos end = sincos(turn);
  const auto cubic = [](double value, double first, double last) {
    return Polynomial{0.0, 0.0, first, 3.0 * value - 2.0 * first - last, first + last - 2.0 * value};
  };
  return CubicPath::make(
      from, {cubic(x, handle_m, handle_m * end.cos), cubic(y, 0.0, handle_m * end.sin), Cubics::Range::normalized},
      norm(x, y));
}

}  // namespace

void redraw_sloppy_records(const std::vector<const Geometry*>& plan, std::vector<PlanRecord>& records, Report& report) {
  std::vector<Joint> joints;
  std::vector<bool> redrawn(records.size());
  for (std::size_t i = 0; i + 1 < records.size(); ++i) {
    const Jet left = raw(records[i], records[i].arc);
    const Jet right = raw(records[i + 1], 0.0);
    joints.push_back({pose_of(left), pose_of(right)});
    if (!can_close(records[i], left, right, records[i + 1])) continue;
    for (const std::size_t at : {i, i + 1})
      if (sloppy(joints[i], records[at].arc)) redrawn[at] = true;
  }
  // The start of each record, and the end of the last one. A record that is not redrawn stays in place, and its
  // neighbour meets it.
  std::vector<Pose2> positions{pose_of(raw(records.front(), 0.0))};
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const bool both = redrawn[i] && redrawn[i + 1];
    positions.push_back(both ? joints[i].centre() : redrawn[i] ? joints[i].right : joints[i].left);
  }
  positions.push_back(pose_of(raw(records.back(), records.back().arc)));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (redrawn[i] && redrawn[i + 1])
      positions[i + 1].heading_rad = heading_through(positions[i], positions[i + 1], positions[i + 2]);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!redrawn[i]) continue;
    auto curve = curve_between(positions[i], positions[i + 1]);
    if (!curve || std::fabs(curve->length() - records[i].arc) > length_ratio_max * records[i].arc) continue;
    records[i].slack += std::fabs(curve->length() - records[i].arc);
    records[i].arc = curve->length();
    records[i].path = std::move(*curve);
    double gap_m = 0.0;
    double kink_rad = 0.0;
    for (std::size_t joint = i > 0 ? i - 1 : 0; joint <= i && joint < joints.size(); ++joint) {
      gap_m = std::max(gap_m, joints[joint].gap_m());
      kink_rad = std::max(kink_rad, std::fabs(joints[joint].kink_rad()));
    }
    report.add(Diagnostic::Kind::mended, "short records that do not meet", plan[i]->location,
               "misses its neighbours by up to " + metres(gap_m) + " and " + std::to_string(kink_rad) +
                   " rad, and is short; a curve leads through the positions where they should meet");
  }
}

}  // namespace cosiva::zone::opendrive
