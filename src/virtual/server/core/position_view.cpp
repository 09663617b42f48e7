#include "cosiva/virtual/server/core/position_view.h"

#include <algorithm>

namespace cosiva::virtual_side {
namespace {

constexpr std::uint8_t status_lost = 5;

/// A status is sent as its number in the order of aiv::Status.
std::uint8_t status_number(aiv::Status status) { return static_cast<std::uint8_t>(status); }

PositionRecord record_of(std::uint16_t handle, PositionRecord::Kind kind, const Pose2& X_MB, double speed_mps) {
  PositionRecord record;
  record.handle = handle;
  record.kind = kind;
  record.x_m = static_cast<float>(X_MB.x_m);
  record.y_m = static_cast<float>(X_MB.y_m);
  record.heading_rad = static_cast<float>(X_MB.heading_rad);
  record.speed_mps = static_cast<float>(speed_mps);
  return record;
}

PositionRecord record_of(const VirtualObject& virtual_object, SimTime at) {
  const Walk::Motion motion = virtual_object.at(at);
  const auto kind =
      virtual_object.kind == VirtualObjectKind::person ? PositionRecord::Kind::person : PositionRecord::Kind::obstacle;
  PositionRecord record = record_of(virtual_object.handle, kind, {motion.at.x_m, motion.at.y_m, motion.heading_rad},
                                    norm(motion.vx_mps, motion.vy_mps));
  record.augmented = true;
  return record;
}

}  // namespace

void PositionView::positions(SimTime now, std::vector<PositionRecord>& out) const {
  const Simulator& simulated = context_.simulator;
  const SimTime at = std::max(now, context_.now);
  out.clear();
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v)
    if (context_.registry[v].shown(context_.now)) out.push_back(record_of_vehicle(v, at));
  for (const VirtualObject& object : simulated.augmented().virtual_objects()) out.push_back(record_of(object, at));
  for (const DetectedObstacle& obstacle : simulated.detected().obstacles()) {
    const Pose2 X_MO{obstacle.at.x_m, obstacle.at.y_m, 0.0};
    out.push_back(record_of(obstacle.handle, PositionRecord::Kind::obstacle, X_MO, 0.0));
  }
  // Handles are reused cyclically, so the newest object may have the smallest one.
  std::ranges::sort(out, {}, &PositionRecord::handle);
}

PositionRecord PositionView::record_of_vehicle(VehicleIndex vehicle, SimTime at) const {
  const AivProxy& proxy = context_.registry[vehicle];
  const Twin::Image image = context_.simulator.image(*proxy.twin(), at);
  const Pose2& reported = context_.simulator.twin(*proxy.twin()).last_report().X_MB;
  const bool lost = proxy.lost(at, context_.options.lost_after) ||
                    proxy.connection.state() == wire::ConnectionState::connection_broken;
  const auto& zone = context_.simulator.zone();
  const Pose2 X_MB = zone ? zone::body_pose(*zone, image.X_MB) : image.X_MB;
  PositionRecord record =
      record_of(static_cast<std::uint16_t>(vehicle), PositionRecord::Kind::aiv, X_MB, lost ? 0.0 : image.speed_mps);
  record.status = lost ? status_lost : status_number(aiv::status_of(image.speed_mps, proxy.reported_state.imposed()));
  record.augmented = proxy.augmented();
  record.blocked = !lost && ((proxy.state() && proxy.state()->field_violation) ||
                             !augmented_.virtual_obstacles.perceives(vehicle).empty());
  record.reported_dx_m = static_cast<float>(reported.x_m - image.X_MB.x_m);
  record.reported_dy_m = static_cast<float>(reported.y_m - image.X_MB.y_m);
  return record;
}

}  // namespace cosiva::virtual_side
