#include "cosiva/virtual/server/augmented/third_party_pause.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/augmented/virtual_obstacle_publisher.h"

namespace cosiva::virtual_side {
namespace {

constexpr double step_m = 0.04;

}  // namespace

bool ThirdPartyPause::in_path(VehicleIndex vehicle, const Pose2& X_MB, const Body& body, double within_m) const {
  const zone::VehicleShape shape = simulator_.zone()->vehicle;
  double reach_m = 0.5 * shape.length_m + within_m;
  const auto& track_position = traffic_.track_position(vehicle);
  if (body.is_aiv && track_position && map_ != nullptr && traffic_.base_end(vehicle) != no_waypoint) {
    if (const auto left_m = traffic_.base_left_m(vehicle, *track_position))
      reach_m = std::min(reach_m, *left_m + 0.5 * shape.length_m);
  }
  const double half_width_m = 0.5 * shape.width_m + beside_m;
  const zone::Circuit& circuit = *simulator_.circuit();
  // The path is checked from the vehicle's body origin on: a body that touches only the tail is behind the vehicle.
  for (double d_m = 0.0; d_m <= reach_m; d_m += step_m) {
    const Point2 p = track_position
                         ? position(circuit.pose_at(circuit.advance(*track_position, d_m, traffic_.remaining(vehicle))))
                         : X_MB * Point2{d_m, 0.0};
    if (distance_to(*body.body, p) <= half_width_m) return true;
  }
  return false;
}

void ThirdPartyPause::evaluate(VehicleIndex vehicle, const Pose2& X_MB, std::span<const Body> bodies) {
  AivProxy& proxy = registry_[vehicle];
  if (!proxy.state()) return;
  const double within_m = proxy.settings.paused_for_body() ? let_go_beyond_m : pause_within_m;
  const auto blocking =
      std::ranges::find_if(bodies, [&](const Body& body) { return in_path(vehicle, X_MB, body, within_m); });
  if (blocking == bodies.end()) {
    let_go(vehicle);
    return;
  }
  if (proxy.settings.paused_for_body()) pauses_[vehicle].body = blocking->body->id;
  // The end of this pause would lift a Stop that the vehicle has not confirmed yet.
  if (proxy.settings.paused_for_body() || proxy.state()->paused || proxy.settings.stop_awaited() ||
      proxy.supports("startPause") == std::optional{false})
    return;
  proxy.settings.on_body_in_path();
  pauses_[vehicle].body = blocking->body->id;
  publisher_.log('i', proxy.name() + ": does not perceive virtual objects; paused for " + blocking->body->id);
  send(vehicle, "startPause");
}

void ThirdPartyPause::let_go(VehicleIndex vehicle) {
  AivProxy& proxy = registry_[vehicle];
  pauses_[vehicle].body.clear();
  if (!proxy.settings.paused_for_body()) return;
  proxy.settings.on_body_left();
  send(vehicle, "stopPause");
}

void ThirdPartyPause::send(VehicleIndex vehicle, std::string action) {
  ++changes_;
  COSIVA_EXPECT(vehicle < pauses_.size());
  Pause& pause = pauses_[vehicle];
  const InstantActionSender::ActionHandle previous = pause.handle;
  // The previous action, unacknowledged and sent again, would undo this one.
  if (previous != 0) action_sender_.drop(previous);
  pause.handle = action_sender_.send(registry_[vehicle], vehicle,
                                     {{std::move(action), {}, {}, wire::BlockingType::none, {}}}, timeout, false);
  COSIVA_EXPECT(pause.handle > previous && action_sender_.find(previous) == nullptr);
}

void ThirdPartyPause::archive(Archive& archive) { archive(changes_, pauses_); }

}  // namespace cosiva::virtual_side
