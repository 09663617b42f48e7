#include "cosiva/aiv/v2x/intent.h"

#include <algorithm>
#include <cmath>

namespace cosiva::aiv {
namespace {

/// Rounding between the distances of the order and of the crossing, as in the envelope.
constexpr double rounding_m = 0.005;
constexpr double duration_s_max = 3600.0;
/// No name in a message is longer; a zone may have longer ones.
constexpr std::size_t name_bytes_max = 128;

double thousandths(double value) { return std::nearbyint(1e3 * value) / 1e3 + 0.0; }

/// Speed profile of the vehicle on a free path.
zone::SpeedProfile pace_of(const Agent& agent, const zone::TrafficZone& zone) {
  const Profile imposed = agent.instructions().imposed.value_or(Profile::medium);
  zone::SpeedProfile pace = kinematics(zone.profiles, imposed == Profile::stop ? Profile::medium : imposed);
  if (agent.instructions().speed_mps_max)
    pace.speed_mps = std::min(pace.speed_mps, *agent.instructions().speed_mps_max);
  return pace;
}

/// Calls `take(crossing_span, name, may_enter)` for each crossing that the intent has to list, in their order.
template <typename Take>
void each_crossing(const VehicleState& vehicle, const zone::TrafficZone& zone, const CrossingFinder& crossing_spans,
                   Take take) {
  const OrderBook& order = vehicle.order();
  const bool goes_on = order.active() && vehicle.holds().bits() == 0 && !vehicle.progress().cancelling();
  const double base_m = order.distance_to_base_end_m();
  static thread_local std::vector<CrossingSpan> listed;  // reused in every cycle of every vehicle
  crossing_spans.ahead(vehicle.position().outlook(), intent_reach_m, wire::Intent::crossings_max, listed);
  for (const CrossingSpan& crossing_span : listed) {
    const bool ends_there = !order.horizon_left() && base_m > crossing_span.entry_m;
    const bool may_enter = crossing_span.entry_m <= 0.0 ||
                           (order.active() && (base_m >= crossing_span.chain_exit_m - rounding_m || ends_there));
    if (!may_enter && !(goes_on && order.horizon_left())) return;
    const std::string& name = zone.crossings[crossing_span.crossing].name;
    if (name.size() <= name_bytes_max) take(crossing_span, name, may_enter);
  }
}

void add_crossings(const Agent& agent, const zone::TrafficZone& zone, const CrossingFinder& crossing_spans,
                   wire::Intent& intent) {
  const zone::SpeedProfile pace = pace_of(agent, zone);
  const auto after = [&](double distance_m) {
    return std::min(duration_s_max, thousandths(earliest_s(distance_m, agent.vehicle().motion().speed_mps(), pace)));
  };
  each_crossing(
      agent.vehicle(), zone, crossing_spans,
      [&](const CrossingSpan& crossing_span, const std::string& name, bool may_enter) {
        intent.crossings.push_back({name, thousandths(crossing_span.entry_m), thousandths(crossing_span.exit_m),
                                    after(crossing_span.entry_m), after(crossing_span.exit_m), may_enter});
      });
}

/// On the path, on a section whose name is short enough for a message.
bool has_position(const VehicleState& vehicle, const zone::TrafficZone& zone) {
  const PositionEstimator& position = vehicle.position();
  return position.known() && !position.off_path() &&
         zone.circuit.part(position.track_position().section).name.size() <= name_bytes_max;
}

void add_route(const VehicleState& vehicle, const zone::TrafficZone& zone, wire::Intent& intent) {
  zone::SectionLookAhead look_ahead = section_look_ahead(zone.circuit, vehicle.position().outlook());
  double left_m = intent_reach_m + vehicle.position().track_position().s_m;
  for (std::size_t i = 0; i < wire::Intent::route_max; ++i) {
    left_m -= zone.circuit.section(look_ahead.section()).length_m();
    if (left_m <= 0.0 || !look_ahead.step()) return;
    const std::string& name = zone.circuit.part(look_ahead.section()).name;
    if (name.size() > name_bytes_max) return;
    intent.route.push_back(name);
  }
}

}  // namespace

double earliest_s(double distance_m, double speed_mps, const zone::SpeedProfile& by) {
  if (!(distance_m > 0.0)) return 0.0;
  const double start_mps = std::max(0.0, speed_mps);
  if (start_mps >= by.speed_mps) return distance_m / start_mps;
  const double speeding_up_m = (by.speed_mps * by.speed_mps - start_mps * start_mps) / (2.0 * by.acceleration_mps2);
  if (distance_m <= speeding_up_m) {
    const double end_mps = std::sqrt(start_mps * start_mps + 2.0 * by.acceleration_mps2 * distance_m);
    return 2.0 * distance_m / (start_mps + end_mps);
  }
  return (by.speed_mps - start_mps) / by.acceleration_mps2 + (distance_m - speeding_up_m) / by.speed_mps;
}

bool is_news(const wire::Intent& published, const Agent& agent, const zone::TrafficZone& zone,
             const CrossingFinder& crossing_spans) {
  if (published.braking != agent.braking() || published.map_id != zone.name ||
      published.position.has_value() != has_position(agent.vehicle(), zone))
    return true;
  if (!agent.vehicle().position().known() || agent.vehicle().position().off_path()) return !published.crossings.empty();
  std::size_t same = 0;
  bool other = false;
  each_crossing(agent.vehicle(), zone, crossing_spans,
                [&](const CrossingSpan&, const std::string& name, bool may_enter) {
                  other = other || same == published.crossings.size() || published.crossings[same].name != name ||
                          published.crossings[same].may_enter != may_enter;
                  if (!other) ++same;
                });
  return other || same != published.crossings.size();
}

wire::Intent compose_intent(const Agent& agent, const zone::TrafficZone& zone, const CrossingFinder& crossing_spans) {
  const PositionEstimator& position = agent.vehicle().position();
  wire::Intent intent;
  intent.map_id = zone.name;
  const Pose2 X_MB = body_pose(zone, position.pose());
  intent.pose = {thousandths(X_MB.x_m), thousandths(X_MB.y_m), thousandths(wrap_angle(X_MB.heading_rad))};
  const double speed_mps = agent.vehicle().motion().speed_mps();
  intent.speed_mps = thousandths(zone.circuit.indirect() ? -speed_mps : speed_mps);  // along the body's heading
  intent.braking = agent.braking();
  if (!position.known() || position.off_path()) return intent;
  const zone::TrackPosition here = position.track_position();
  if (has_position(agent.vehicle(), zone))
    intent.position = wire::Intent::OnLine{zone.circuit.part(here.section).name, std::max(0.0, thousandths(here.s_m))};
  add_crossings(agent, zone, crossing_spans, intent);
  add_route(agent.vehicle(), zone, intent);
  return intent;
}

wire::Body body_of(const wire::Intent& intent, const zone::VehicleShape& shape) {
  const auto [sin, cos] = sincos(intent.pose.heading_rad);
  const double radius_m = 0.5 * shape.width_m;
  return {{},
          {},
          intent.pose.x_m,
          intent.pose.y_m,
          intent.pose.heading_rad,
          std::max(0.0, shape.length_m - 2.0 * radius_m),
          radius_m,
          intent.speed_mps * cos,
          intent.speed_mps * sin};
}

}  // namespace cosiva::aiv
