#include "cosiva/virtual/vehicle/virtual_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::virtual_side {
namespace {

/// The motors' own braking if there is no command, or a command without a braking value.
constexpr double own_braking_mps2 = 1.0;

}  // namespace

VirtualBody::VirtualBody(std::shared_ptr<const zone::TrafficZone> zone, zone::TrackPosition start)
    : zone_{std::move(zone)}, motion_{zone_->circuit, start} {
  antenna_.put(*zone_, track_position(), position(X_MB()));
}

Pose2 VirtualBody::X_MB() const {
  if (!off_line_) return motion_.pose(zone_->circuit);
  return manoeuvre_ ? X_MS_ * manoeuvre_->X_SB() : X_MS_;
}

zone::TrackPosition VirtualBody::track_position() const {
  if (!off_line_ || lies_on_line_) return motion_.track_position(zone_->circuit);
  const Pose2 pose = X_MB();
  return zone_->circuit.locate(position(pose), pose.heading_rad).position;
}

void VirtualBody::change_floor(std::shared_ptr<const zone::TrafficZone> zone) {
  if (!zone::same_geometry(*zone_, *zone)) {
    next_ = std::move(zone);
    return;
  }
  next_.reset();
  zone_ = std::move(zone);
  antenna_.put(*zone_, track_position(), position(X_MB()));
}

void VirtualBody::adopt_next_zone() {
  X_MS_ = X_MB();
  if (next_->circuit.indirect() != zone_->circuit.indirect()) X_MS_ = turned_round(X_MS_);
  zone_ = std::exchange(next_, nullptr);
  manoeuvre_.reset();
  off_line_ = true;
  // If the old and the new floor have a section in common, the body is already on the path and may continue unchanged.
  constexpr double on_line_m = 1e-3;
  constexpr double on_line_rad = 1e-2;
  const auto entry_point = zone::snap_to_path(zone_->circuit, X_MS_, on_line_m);
  lies_on_line_ = entry_point && std::fabs(wrap_angle(zone_->circuit.pose_at(entry_point->position).heading_rad -
                                                      X_MS_.heading_rad)) <= on_line_rad;
  if (lies_on_line_) motion_ = aiv::AivMotion{zone_->circuit, entry_point->position};
  antenna_.put(*zone_, track_position(), position(X_MS_));
}

void VirtualBody::move(const wire::Drive* drive, double dt_s, std::vector<Antenna::Reading>& readings) {
  if (next_ && is_stopped()) adopt_next_zone();
  if (drive != nullptr) branch_ = drive->branch;
  if (off_line_) return move_off_line(drive, dt_s);
  COSIVA_EXPECT(!manoeuvre_);
  const double before_mps = speed_mps_;
  change_speed(drive, dt_s);
  const double wanted_m = 0.5 * (before_mps + speed_mps_) * dt_s;
  if (wanted_m == 0.0) return;
  const zone::TrackPosition from = track_position();
  const Point2 p_from = position(X_MB());
  if (wanted_m > 0.0)
    roll(wanted_m, drive != nullptr && drive->speed_mmps > 0);
  else
    roll_back(wanted_m);
  antenna_.move(*zone_, from, motion_.track_position(zone_->circuit), p_from, position(motion_.pose(zone_->circuit)),
                readings);
}

void VirtualBody::change_speed(const wire::Drive* drive, double dt_s) {
  const double wanted_mps = drive == nullptr ? 0.0 : 1e-3 * drive->speed_mmps;
  const bool faster = std::fabs(wanted_mps) > std::fabs(speed_mps_) && wanted_mps * speed_mps_ >= 0.0;
  const std::uint16_t commanded = drive == nullptr ? 0 : faster ? drive->acceleration_mmps2 : drive->braking_mmps2;
  const double step_mps = (commanded == 0 ? own_braking_mps2 : 1e-3 * commanded) * dt_s;
  speed_mps_ += std::clamp(wanted_mps - speed_mps_, -step_mps, step_mps);
}

void VirtualBody::roll(double wanted_m, bool goes_on) {
  const zone::Circuit& circuit = zone_->circuit;
  for (double left_m = wanted_m;;) {
    const zone::TrackPosition here = motion_.track_position(circuit);
    const double room_m = circuit.section(here.section).length_m() - here.s_m;
    if (left_m <= room_m) {
      count(motion_.move(circuit, left_m));
      return;
    }
    count(room_m);
    left_m -= room_m;
    const aiv::Onward onward = aiv::onward(circuit, here.section, branch_);
    if (onward.section == zone::no_section || onward.turn_rad != 0.0) {
      stop_at({here.section, here.s_m + room_m});
      if (onward.section == zone::no_section || !goes_on) return;
      X_MS_ = motion_.pose(circuit);
      goal_ = {onward.section, 0.0};
      manoeuvre_.emplace(Pose2{0.0, 0.0, onward.turn_rad});
      off_line_ = lies_on_line_ = true;
      return;
    }
    motion_ = aiv::AivMotion{circuit, {onward.section, 0.0}};
  }
}

void VirtualBody::roll_back(double wanted_m) {
  const zone::Circuit& circuit = zone_->circuit;
  const zone::TrackPosition here = motion_.track_position(circuit);
  const auto branches = circuit.previous(here.section);
  const bool ends = branches.empty() || circuit.turn_at(branches.front(), here.section) != 0.0;
  if (-wanted_m <= here.s_m || !ends) {
    count(motion_.shift(circuit, wanted_m));
    return;
  }
  count(-here.s_m);
  stop_at({here.section, 0.0});
}

void VirtualBody::stop_at(zone::TrackPosition track_position) {
  motion_ = aiv::AivMotion{zone_->circuit, track_position};
  speed_mps_ = 0.0;
}

bool VirtualBody::begin_seek(const wire::Drive& drive) {
  const auto track_position = aiv::sought(zone_->circuit, X_MS_, drive.goal);
  if (!track_position) return false;
  goal_ = *track_position;
  Pose2 X_SG = inverse(X_MS_) * zone_->circuit.pose_at(goal_);
  if (drive.goal && aiv::to_stay(*drive.goal)) X_SG = {0.0, 0.0, X_SG.heading_rad};
  manoeuvre_.emplace(X_SG);
  return true;
}

void VirtualBody::move_off_line(const wire::Drive* drive, double dt_s) {
  const double speed_mps = drive == nullptr ? 0.0 : 1e-3 * drive->speed_mmps;
  if (!manoeuvre_) {
    const bool seeks = speed_mps > 0.0 && drive->seek;
    if (!seeks && speed_mps != 0.0 && lies_on_line_) off_line_ = false;
    if (!seeks || !begin_seek(*drive)) return;
  }
  manoeuvre_->step(speed_mps, dt_s);
  if (!manoeuvre_->done()) return;
  manoeuvre_.reset();
  off_line_ = false;
  stop_at(goal_);
}

void VirtualBody::fold(Digest& digest) const {
  const Pose2 pose = X_MB();
  digest.add(std::uint64_t{motion_.current_section()});
  digest.add(pose.x_m);
  digest.add(pose.y_m);
  digest.add(pose.heading_rad);
  digest.add(speed_mps());
  digest.add(distance_m_);
  digest.add(std::uint64_t{off_line_});
}

void VirtualBody::archive(Archive& archive) {
  archive(motion_, antenna_, speed_mps_, distance_m_, branch_, off_line_, lies_on_line_, manoeuvre_, X_MS_, goal_);
}

void VirtualBody::put_on(std::shared_ptr<const zone::TrafficZone> zone, std::shared_ptr<const zone::TrafficZone> next) {
  COSIVA_EXPECT(zone);
  zone_ = std::move(zone);
  next_ = std::move(next);
  antenna_.know(*zone_);
}

}  // namespace cosiva::virtual_side
