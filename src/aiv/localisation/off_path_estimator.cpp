// Off the path: the vehicle turns on the spot, seeks a path, or is stopped where there is none.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/motion/manoeuvre.h"
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

Pose2 PositionEstimator::pose() const {
  if (!X_MO_) return motion_.pose(zone_.circuit);
  return X_OB_ ? *X_MO_ * *X_OB_ : *X_MO_;
}

void PositionEstimator::set_off_path(const Pose2& X_MB) {
  X_MO_ = X_OB_ ? X_MB * inverse(*X_OB_) : X_MB;
  strayed_m_ = 0.0;
  course_.clear();
  doubt_.reset();
  const auto entry_point = zone::snap_to_path(zone_.circuit, X_MB, zone::snap_within_m + reported_off_m);
  known_ = entry_point.has_value();
  near_path_ = known_;
  if (entry_point) motion_ = AivMotion{zone_.circuit, entry_point->position};
  off_by_m_ = entry_point ? entry_point->distance_m : zone_.circuit.locate(position(X_MB)).distance_m;
  variance_m2_ = std::max(variance_m2_, model_.sigma_start_m * model_.sigma_start_m);
}

void PositionEstimator::aim(zone::TrackPosition track_position) {
  COSIVA_EXPECT(near_path_);
  motion_ = AivMotion{zone_.circuit, track_position};
  course_.clear();
}

void PositionEstimator::resume_manoeuvre(const Pose2& X_OB, std::optional<zone::SectionId> next) {
  if (!pose_known()) return;
  if (next && known_ && !near_path_) course_ = zone::Course{{motion_.current_section(), *next}};
  if (X_OB_) return;  // PILS has reported the manoeuvre already
  X_MO_ = X_MO_ ? *X_MO_ * inverse(X_OB) : motion_.pose(zone_.circuit);
  X_OB_ = X_OB;
  manoeuvre_travelled_m_ = travelled_m_;
}

void PositionEstimator::take_over(const PositionEstimator& before) {
  odometer_um_ = before.odometer_um_;
  travelled_m_ = before.travelled_m_;
  variance_m2_ = before.variance_m2_;
  X_OB_ = before.X_OB_;
  manoeuvre_travelled_m_ = before.manoeuvre_travelled_m_;
  on_old_floor_ = X_OB_.has_value();
  if (before.pose_known()) set_off_path(before.pose());
}

PositionEstimator::Rolled PositionEstimator::off_path(double step_m, const wire::Odometry& odometry) {
  Rolled rolled;
  const auto& manoeuvre = odometry.manoeuvre;
  // Between two manoeuvres there may have been no frame, or none that arrived.
  const bool another = std::fabs(travelled_m_ - manoeuvre_travelled_m_) > still_m ||
                       (X_OB_ && manoeuvre && begins_again(*X_OB_, to_pose(*manoeuvre)));
  if (X_OB_ && (!manoeuvre || another)) end_manoeuvre(odometry.line_lost && !manoeuvre, rolled);
  if (step_m != 0.0 && !X_OB_) roll_off_line(step_m, rolled);
  if (manoeuvre) {
    if (!X_OB_) begin_manoeuvre(rolled);
    X_OB_ = to_pose(*manoeuvre);
  }
  return rolled;
}

void PositionEstimator::roll_off_line(double step_m, Rolled& rolled) {
  if (!X_MO_) {
    if (known_) rolled.step_m += shift(step_m);
    return;
  }
  strayed_m_ += step_m;
  if (!known_) {
    X_MO_ = *X_MO_ * Pose2{step_m, 0.0, 0.0};
  } else if (std::fabs(strayed_m_) > follows_m) {
    X_MO_.reset();
    near_path_ = false;
    rolled.step_m += shift(strayed_m_);
  }
}

void PositionEstimator::begin_manoeuvre(Rolled& rolled) {
  manoeuvre_travelled_m_ = travelled_m_;
  if (!known_ || X_MO_) return;
  // The vehicle turns where the path bends, and is therefore at the bend.
  const zone::Circuit& circuit = zone_.circuit;
  double end_m = -track_position().s_m;
  for (zone::SectionLookAhead ahead = section_look_ahead(circuit, outlook());;) {
    const zone::SectionId id = ahead.section();
    end_m += circuit.section(id).length_m();
    if (end_m > joint_gate_m()) break;
    const auto bends = [&](zone::SectionId to) { return bend_rad(circuit, id, to) != 0.0; };
    if (ahead.decided() ? bends(ahead.next()) : std::ranges::any_of(circuit.next(id), bends)) {
      constexpr double hair_m = 1e-6;  // the joint itself stops the estimate
      rolled.step_m += shift(end_m + hair_m);
      break;
    }
    if (!ahead.decided() || !ahead.step()) break;
  }
  X_MO_ = motion_.pose(circuit);
}

void PositionEstimator::end_manoeuvre(bool line_lost, Rolled& rolled) {
  const Pose2 X_MB = pose_known() ? pose() : Pose2{};
  const double turned_rad = X_OB_->heading_rad;
  X_OB_.reset();
  const bool on_old_floor = std::exchange(on_old_floor_, false);
  if (!X_MO_) return;
  // The end of a manoeuvre to a path of the old zone is on no path of this zone, even near one.
  if (on_old_floor) {
    set_off_path(X_MB);
    rolled.kind = FixKind::relocated;
    return;
  }
  const bool turning = known_ && !near_path_;
  if (!(turning && end_turn(turned_rad, rolled))) land(X_MB, line_lost, rolled);
}

bool PositionEstimator::end_turn(double turned_rad, Rolled& rolled) {
  const zone::SectionId here = motion_.current_section();
  const auto to = turned_to(turned_rad);
  if (!to || track_position().s_m < zone_.circuit.section(here).length_m()) return false;
  X_MO_.reset();
  if (course_.remaining().empty() || course_.remaining().front() != *to) {
    // PILS took another branch than the commanded one, or none was commanded.
    if (!course_.remaining().empty()) rolled.kind = FixKind::relocated;
    course_.cut(0);
    if (course_.empty()) course_ = zone::Course{{here}};
  }
  enter(*to);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m;
  doubt_.reset();
  return true;
}

std::optional<zone::SectionId> PositionEstimator::turned_to(double turned_rad) const {
  const zone::Circuit& circuit = zone_.circuit;
  const zone::SectionId here = motion_.current_section();
  const auto misfit_rad = [&](zone::SectionId to) {
    const double bend = bend_rad(circuit, here, to);
    return bend == 0.0 ? pi : std::fabs(wrap_angle(bend - turned_rad));
  };
  if (!course_.remaining().empty() && misfit_rad(course_.remaining().front()) <= model_.landed_rad)
    return course_.remaining().front();
  const auto branches = circuit.next(here);
  const auto best = std::ranges::min_element(branches, {}, misfit_rad);
  return best != branches.end() && misfit_rad(*best) <= model_.landed_rad ? std::optional{*best} : std::nullopt;
}

void PositionEstimator::land(const Pose2& X_MB, bool line_lost, Rolled& rolled) {
  const auto line = zone::snap_to_path(zone_.circuit, X_MB, model_.landed_m);
  const double across_rad =
      line ? wrap_angle(zone_.circuit.pose_at(line->position).heading_rad - X_MB.heading_rad) : pi;
  if (line_lost || std::fabs(across_rad) > model_.landed_rad) {
    // Abandoned before its end: the vehicle is where the manoeuvre left it, possibly near a path that its sensors do
    // not detect.
    set_off_path(X_MB);
    rolled.kind = FixKind::relocated;
  } else if (known_ && line->position.section == track_position().section) {
    X_MO_.reset();
    near_path_ = false;
    rolled.step_m += shift(line->position.s_m - track_position().s_m);
  } else {
    const double variance_m2 = variance_m2_;
    position_at(line->position);
    variance_m2_ = std::max(variance_m2, variance_m2_);
    rolled.kind = FixKind::relocated;
  }
}

}  // namespace cosiva::aiv
