#include "cosiva/virtual/server/orders/path_positions.h"

#include <array>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {
namespace {

/// A vehicle is on the path within this distance and this heading error.
constexpr double on_line_m = 0.005;
constexpr double on_line_rad = 0.2;
constexpr double stopped_mps = 0.01;

}  // namespace

void PathPositions::set_reported(VehicleIndex vehicle, const ReportedPose& reported) {
  Vehicle& stored = vehicles_[vehicle];
  stored.reported = reported;
  follow_line(vehicle);
  COSIVA_EXPECT(!stored.entry_point || stored.reported.position);
  const ReportedPose& now = stored.reported;
  // A CoSiVA vehicle that is to join the path keeps others away by its body until it is sent.
  const bool is_obstructing =
      now.position && (stored.entry_point || (now.off_m <= context_.rules.on_path_m && !goes_onto_line(vehicle)));
  if (now.position) context_.traffic.follow(vehicle, *now.position);
  context_.traffic.set_position(vehicle, is_obstructing ? now.position : std::nullopt);
}

void PathPositions::set_position(VehicleIndex vehicle, zone::TrackPosition position) {
  vehicles_[vehicle].reported.position = position;
}

void PathPositions::set_entry_point(VehicleIndex vehicle, zone::TrackPosition position) {
  vehicles_[vehicle].entry_point = position;
  vehicles_[vehicle].reported.position = position;
}

void PathPositions::set_entry_point(VehicleIndex vehicle, zone::TrackPosition position, double off_m) {
  set_entry_point(vehicle, position);
  vehicles_[vehicle].reported.off_m = off_m;
}

bool PathPositions::clear_entry_point(VehicleIndex vehicle) {
  return std::exchange(vehicles_[vehicle].entry_point, std::nullopt).has_value();
}

bool PathPositions::is_off_path(VehicleIndex vehicle) const {
  const auto& [reported, entry_point] = vehicles_[vehicle];
  return entry_point || reported.off_m > on_line_m || std::fabs(reported.heading_off_rad) > on_line_rad;
}

bool PathPositions::goes_onto_line(VehicleIndex vehicle) const {
  return vehicles_[vehicle].entry_point || (sessions_[vehicle].stage() == OrderSession::Stage::none &&
                                            is_off_path(vehicle) && context_.registry[vehicle].is_cosiva());
}

void PathPositions::follow_line(VehicleIndex vehicle) {
  auto& [reported, entry_point] = vehicles_[vehicle];
  if (!entry_point || context_.map == nullptr) return;
  const zone::Circuit& circuit = context_.map->circuit();
  const Sections remaining = context_.traffic.remaining(vehicle);
  const std::array<zone::SectionId, 2> candidates{entry_point->section,
                                                  remaining.empty() ? entry_point->section : remaining[0]};
  for (const zone::SectionId section : candidates) {
    const auto near = circuit.section(section).nearest(position(reported.X_MB));
    const double off_rad =
        wrap_angle(reported.X_MB.heading_rad - circuit.section(section).pose_at(near.s_m).heading_rad);
    if (near.distance_m > on_line_m || std::fabs(off_rad) > on_line_rad) continue;
    entry_point.reset();
    reported.position = zone::TrackPosition{section, near.s_m};
    reported.off_m = near.distance_m;
    reported.heading_off_rad = off_rad;
    return;
  }
  reported.position = entry_point;
  reported.off_m = distance(reported.X_MB, circuit.pose_at(*entry_point));
  reported.heading_off_rad = 0.0;
}

bool PathPositions::is_stopped(VehicleIndex vehicle) const {
  const AivProxy& proxy = context_.registry[vehicle];
  return proxy.here() && proxy.state() && !proxy.state()->driving &&
         std::fabs(context_.simulator.twin(*proxy.twin()).speed_mps()) < stopped_mps;
}

Pose2 PathPositions::body(VehicleIndex vehicle) const {
  return context_.simulator.image(*context_.registry[vehicle].twin(), context_.publisher.now()).X_MB;
}

bool detects(const Registry& registry, VehicleIndex vehicle, VehicleIndex ahead) {
  // A physical vehicle does not detect a virtual one by its own sensor, and the sensors of third-party vehicles are
  // unknown.
  return ahead != no_vehicle && registry[vehicle].is_cosiva() && registry[ahead].is_cosiva() &&
         (registry[vehicle].augmented() || !registry[ahead].augmented());
}

void PathPositions::archive(Archive& archive) { archive(vehicles_); }

}  // namespace cosiva::virtual_side
