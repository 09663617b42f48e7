#include "cosiva/aiv/localisation/estimator.h"

#include "cosiva/aiv/motion/motion.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

PositionEstimator::PositionEstimator(const zone::TrafficZone& zone, const EstimatorModel& model)
    : zone_{zone},
      reading_latency_s_{model.reading_latency_s},
      counter_{model.odometry_step_m_max},
      on_path_{zone.circuit, model},
      off_path_{model} {}

Outlook PositionEstimator::outlook() const {
  Outlook outlook = on_path_.path().outlook();
  if (off_path_.has_pose()) outlook.X_MB = off_path_.pose();
  return outlook;
}

void PositionEstimator::position_at(zone::TrackPosition track_position) {
  on_path_.position_at(track_position);
  off_path_.on_path_at(on_path_.path().pose());
}

void PositionEstimator::take_same_position(zone::TrackPosition track_position) {
  on_path_.take_same_position(track_position);
  off_path_.on_path_at(on_path_.path().pose());
}

void PositionEstimator::set_off_path(const Pose2& X_MB) {
  off_path_.set(X_MB, on_path_);
  COSIVA_EXPECT(known() || !off_path_.near_path());
}

void PositionEstimator::aim(zone::TrackPosition track_position) {
  COSIVA_EXPECT(near_path());
  on_path_.aim(track_position);
}

void PositionEstimator::resume_manoeuvre(const Pose2& X_OB, std::optional<zone::SectionId> next) {
  if (!pose_known()) return;
  if (next && known() && !near_path()) on_path_.expect_turn(*next);
  off_path_.resume_manoeuvre(X_OB, travelled_m(), on_path_);
}

void PositionEstimator::take_over(const PositionEstimator& before) {
  counter_.take_over(before.counter_);
  on_path_.take_over_variance(before.on_path_);
  off_path_.take_over_manoeuvre(before.off_path_);
  if (zone_.circuit.indirect() == before.zone_.circuit.indirect()) {
    if (before.pose_known()) set_off_path(before.pose());
    return;
  }
  counter_.restart();  // the boards count on in the body frame
  if (before.known() && !before.off_path() && zone::is_reversed(zone_.circuit, before.zone_.circuit)) {
    // Figure 13: on the request mDTCS is mirrored first; it is the position on the reversed circuit.
    AivMotion motion{before.zone_.circuit, before.track_position()};
    motion.on_indirect_move_req(before.zone_.circuit);
    take_same_position({motion.current_section(), motion.mDTCS_m()});
  } else if (before.pose_known()) {
    set_off_path(turned_round(before.pose()));
  }
}

EstimateStep PositionEstimator::on_odometry(const wire::Odometry& odometry) {
  const double step_m = counter_.count(odometry.distance_um);
  on_path_.on_driven(step_m);
  if (odometry.manoeuvre || off_path()) return off_path_.on_odometry(step_m, travelled_m(), odometry, on_path_);
  return {known() ? on_path_.shift(step_m) : 0.0, FixKind::none};
}

void PositionEstimator::on_odometer_reset() {
  counter_.restart();
  on_path_.on_odometer_reset();
}

double PositionEstimator::on_stuck() { return known() && !off_path() ? on_path_.on_stuck() : 0.0; }

PositionFix PositionEstimator::on_tag(std::uint32_t number, double age_s, double speed_mps) {
  const double latency_m = speed_mps * (age_s + reading_latency_s_);
  if (const zone::Tag* tag = zone_.find_tag(number)) {
    last_tag_ = LastTag{number, travelled_m() - latency_m};
    // Off the path a tag shows only that it is near; the manoeuvre's end will give a better fix.
    if (off_path()) return {};
    return on_path_.on_tag(tag->position, latency_m, travelled_m());
  }
  if (!zone_.beacons || off_path() || !known()) return {};
  const std::optional<Point2> beacon = zone_.beacons->find(number);
  return beacon ? on_path_.on_beacon(*beacon, latency_m, travelled_m()) : PositionFix{};
}

void PositionEstimator::archive(Archive& archive) { archive(counter_, on_path_, off_path_, last_tag_); }

}  // namespace cosiva::aiv
