#include "cosiva/aiv/localisation/off_path_estimator.h"

#include <cmath>
#include <utility>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::aiv {
namespace {

/// An odometer that has advanced further than this does not belong to the manoeuvre during which it did not count.
constexpr double still_m = 0.002;
/// The sender that considers the vehicle near enough to a path knows the vehicle's pose in rounded form.
constexpr double reported_off_m = 0.005;
/// An off-path vehicle has found a path when its wheels move this far in no manoeuvre.
constexpr double follows_m = 0.010;

/// A manoeuvre only turns further from its start, and moves further away from it: a smaller value is another manoeuvre.
bool begins_again(const Pose2& X_OB, const Pose2& X_OB_next) {
  constexpr double back_m = 0.003;
  constexpr double back_rad = 0.02;
  constexpr double spot_m = 0.0005;
  const double traversed_m = norm(X_OB.x_m, X_OB.y_m);
  const double next_m = norm(X_OB_next.x_m, X_OB_next.y_m);
  if (next_m < traversed_m - back_m) return true;
  return traversed_m <= spot_m && next_m <= spot_m &&
         std::fabs(X_OB_next.heading_rad) < std::fabs(X_OB.heading_rad) - back_rad;
}

}  // namespace

void OffPathEstimator::set(const Pose2& X_MB, OnPathEstimator& on_path) {
  X_MO_ = X_OB_ ? X_MB * inverse(*X_OB_) : X_MB;
  strayed_m_ = 0.0;
  const zone::Circuit& circuit = on_path.path().circuit();
  const auto entry_point = zone::snap_to_path(circuit, X_MB, zone::snap_within_m + reported_off_m);
  near_path_ = entry_point.has_value();
  on_path.leave_path(entry_point ? std::optional{entry_point->position} : std::nullopt);
  off_by_m_ = entry_point ? entry_point->distance_m : circuit.locate(position(X_MB)).distance_m;
  COSIVA_EXPECT(X_MO_ || !near_path_);
}

void OffPathEstimator::on_path_at(const Pose2& X_MB) {
  find_path();
  if (X_OB_) X_MO_ = X_MB;
}

void OffPathEstimator::find_path() {
  X_MO_.reset();
  near_path_ = false;
}

void OffPathEstimator::resume_manoeuvre(const Pose2& X_OB, double travelled_m, const OnPathEstimator& on_path) {
  if (X_OB_) return;  // PILS has reported the manoeuvre already
  X_MO_ = X_MO_ ? *X_MO_ * inverse(X_OB) : on_path.path().pose();
  X_OB_ = X_OB;
  manoeuvre_travelled_m_ = travelled_m;
}

void OffPathEstimator::take_over_manoeuvre(const OffPathEstimator& before) {
  X_OB_ = before.X_OB_;
  manoeuvre_travelled_m_ = before.manoeuvre_travelled_m_;
  on_old_floor_ = X_OB_.has_value();
}

EstimateStep OffPathEstimator::on_odometry(double step_m, double travelled_m, const wire::Odometry& odometry,
                                           OnPathEstimator& on_path) {
  EstimateStep result;
  const auto& manoeuvre = odometry.manoeuvre;
  // Between two manoeuvres there may have been no frame, or none that arrived.
  const bool another = std::fabs(travelled_m - manoeuvre_travelled_m_) > still_m ||
                       (X_OB_ && manoeuvre && begins_again(*X_OB_, to_pose(*manoeuvre)));
  if (X_OB_ && (!manoeuvre || another)) end_manoeuvre(odometry.line_lost && !manoeuvre, on_path, result);
  if (step_m != 0.0 && !X_OB_) roll(step_m, on_path, result);
  if (manoeuvre) {
    if (!X_OB_) begin_manoeuvre(travelled_m, on_path, result);
    X_OB_ = to_pose(*manoeuvre);
  }
  return result;
}

void OffPathEstimator::roll(double step_m, OnPathEstimator& on_path, EstimateStep& result) {
  if (!X_MO_) {
    if (on_path.known()) result.step_m += on_path.shift(step_m);
    return;
  }
  strayed_m_ += step_m;
  if (!on_path.known()) {
    X_MO_ = *X_MO_ * Pose2{step_m, 0.0, 0.0};
  } else if (std::fabs(strayed_m_) > follows_m) {
    find_path();
    result.step_m += on_path.shift(strayed_m_);
  }
}

void OffPathEstimator::begin_manoeuvre(double travelled_m, OnPathEstimator& on_path, EstimateStep& result) {
  manoeuvre_travelled_m_ = travelled_m;
  if (!on_path.known() || X_MO_) return;
  result.step_m += on_path.on_turn_begun();
  X_MO_ = on_path.path().pose();
}

void OffPathEstimator::end_manoeuvre(bool line_lost, OnPathEstimator& on_path, EstimateStep& result) {
  const Pose2 X_OB = *X_OB_;
  X_OB_.reset();
  const bool on_old_floor = std::exchange(on_old_floor_, false);
  if (!X_MO_) return;
  const Pose2 X_MB = *X_MO_ * X_OB;
  // The end of a manoeuvre to a path of the old zone is on no path of this zone, even near one.
  if (on_old_floor) {
    set(X_MB, on_path);
    result.kind = FixKind::relocated;
    return;
  }
  if (on_path.known() && !near_path_) {
    if (const auto turned = on_path.on_turn_ended(X_OB.heading_rad)) {
      X_MO_.reset();
      result.kind = *turned;
      return;
    }
  }
  land(X_MB, line_lost, on_path, result);
}

void OffPathEstimator::land(const Pose2& X_MB, bool line_lost, OnPathEstimator& on_path, EstimateStep& result) {
  const zone::Circuit& circuit = on_path.path().circuit();
  const auto line = zone::snap_to_path(circuit, X_MB, landed_m_);
  const double across_rad = line ? wrap_angle(circuit.pose_at(line->position).heading_rad - X_MB.heading_rad) : pi;
  if (line_lost || std::fabs(across_rad) > landed_rad_) {
    // Abandoned before its end: the vehicle is where the manoeuvre left it, possibly near a path that its sensors do
    // not detect.
    set(X_MB, on_path);
    result.kind = FixKind::relocated;
    return;
  }
  find_path();
  if (on_path.known() && line->position.section == on_path.path().motion().current_section()) {
    result.step_m += on_path.shift(line->position.s_m - on_path.path().track_position().s_m);
  } else {
    on_path.land_on(line->position);
    result.kind = FixKind::relocated;
  }
}

void OffPathEstimator::archive(Archive& archive) {
  archive(X_MO_, X_OB_, near_path_, off_by_m_, strayed_m_, manoeuvre_travelled_m_, on_old_floor_);
}

}  // namespace cosiva::aiv
