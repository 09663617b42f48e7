// What our own vehicles say beyond VDA 5050: what they felt, what they see, how their boards fare.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/math.h"
#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/wire/in_process/said.h"

namespace cosiva::virtual_side {
namespace {

/// Of a known vehicle's body: what is seen nearer is that vehicle, and errors of two places. Besides, what is seen may
/// have its middle anywhere in the beams that it fills, as uncertain as its radius.
constexpr double vehicle_margin_m = 0.10;
/// A time stamp that falls back further than any network delays is a clock that was set, not a late message.
constexpr SimDuration reorder_max{std::chrono::seconds{5}};
constexpr double way_step_m = 0.04;
constexpr double clear_m_max = 3.0;

/// How far `p` is outside of the body around X_MB.
double outside_m(const Pose2& X_MB, const zone::VehicleShape& shape, Point2 p) {
  const Point2 p_B = inverse(X_MB) * p;
  return norm(std::max(0.0, std::fabs(p_B.x_m) - 0.5 * shape.length_m),
              std::max(0.0, std::fabs(p_B.y_m) - 0.5 * shape.width_m));
}

std::string health_of(const wire::BoardsReport& report) {
  std::string text;
  for (const wire::BoardsReport::Line& line : report.boards)
    text += (text.empty() ? "" : ", ") + std::string(wire::to_string(line.board)) + " " + line.health;
  return text;
}

std::string place_text(double x_m, double y_m) { return "(" + metres_text(x_m) + ", " + metres_text(y_m) + ")"; }

}  // namespace

bool ServerCore::Inside::take_own_stamp(AivProxy& proxy, std::optional<SimTime>& last, SimTime stamp) {
  if (last && stamp < *last && *last - stamp < reorder_max) {
    ++proxy.outdated;
    return false;
  }
  last = stamp;
  return true;
}

void ServerCore::Inside::on_felt(VehicleIndex vehicle, const wire::Input& input) {
  const auto felt = wire::felt_from_json(input.payload);
  if (!felt) return refuse(vehicle, VehicleTopic::felt, input, felt.error());
  AivProxy& proxy = registry[vehicle];
  std::string summary = "ahead " + std::to_string(felt->ahead_header_id) + ": ";
  summary += felt->braking ? "brakes for " + felt->body : std::string("nothing to brake for");
  traces.add(now, proxy.name, "AIV_Server", "felt", summary, input.source, input.payload);
  if (!virtual_obstacles.on_felt(vehicle, *felt, clock_of(proxy, felt->decided))) ++proxy.outdated;
}

/// A late word is of a vehicle that has driven on: its body counts where its twin is shown, where it last reported
/// itself, and where it was when it was seen.
bool ServerCore::Inside::is_vehicle(VehicleIndex seer, Point2 p, double radius_m, SimTime seen_at) const {
  const zone::VehicleShape& shape = simulator.zone()->vehicle;
  const auto touches = [&](const Pose2& X_MB) { return outside_m(X_MB, shape, p) <= vehicle_margin_m + radius_m; };
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    const AivProxy& proxy = registry[v];
    if (v == seer || !proxy.here() || proxy.augmented) continue;
    const Twin& twin = simulator.twin(*proxy.twin);
    const MotionReport& report = twin.last_report();
    const double since_m = twin.speed_mps() * std::max(0.0, to_seconds(report.at - seen_at));
    if (touches(simulator.image(*proxy.twin, now).X_MB)) return true;
    if (report.on_map && (touches(report.X_MB) || touches(report.X_MB * Pose2{-since_m, 0.0, 0.0}))) return true;
  }
  return false;
}

void ServerCore::Inside::on_seen(VehicleIndex vehicle, const wire::Input& input) {
  const auto message = wire::heard_seen(input);
  if (!message) return refuse(vehicle, VehicleTopic::seen, input, message.error());
  AivProxy& proxy = registry[vehicle];
  if (!take_own_stamp(proxy, proxy.seen_stamp, message->timestamp)) return;
  const auto& thing = message->thing;
  traces.add(now, proxy.name, "AIV_Server", "seen",
             thing ? "something at " + place_text(thing->x_m, thing->y_m) : std::string("nothing in its way"),
             input.source, input.payload);
  if (!simulator.zone() || message->map_id != simulator.zone()->name) {
    ++proxy.outdated;  // of a zone that is no more, or not yet
    return;
  }
  if (!thing) {
    forget_where_clear(vehicle, message->clear_m);
    return;
  }
  const Point2 at{thing->x_m, thing->y_m};
  const SimTime seen_at = clock_of(proxy, message->timestamp);
  if (is_vehicle(vehicle, at, thing->radius_m, seen_at)) return;
  if (!simulator.seen().see(proxy.name, now, at, thing->radius_m)) return;
  const std::string& id = simulator.seen().obstacles().back().id;
  traces.add(now, "AIV_Server", "Simulator", "appear", id + ": an obstacle at " + place_text(at.x_m, at.y_m));
  if (proxy.augmented) return;
  simulator.monitor().effect(WorldEffect::shown, to_seconds(now - seen_at) * 1e3);
}

void ServerCore::Inside::forget_where_clear(VehicleIndex vehicle, double clear_m) {
  const AivProxy& proxy = registry[vehicle];
  if (simulator.seen().empty() || !proxy.here()) return;
  const zone::VehicleShape& shape = simulator.zone()->vehicle;
  const Twin::Image image = simulator.image(*proxy.twin, now);
  const double reach_m = 0.5 * shape.length_m + std::min(clear_m, clear_m_max);
  std::vector<Point2> way;
  for (double d = 0.0; d <= reach_m; d += way_step_m) {
    way.push_back(image.place ? position(simulator.circuit()->pose_at(simulator.ahead_of(*proxy.twin, *image.place, d)))
                              : image.X_MB * Point2{d, 0.0});
  }
  std::vector<std::string> gone;
  for (const SeenObstacle& obstacle : simulator.seen().obstacles()) {
    if (!SeenObstacles::seen_by(obstacle, proxy.name)) continue;
    // In its way by half of itself at least; one beside the way would not be reported.
    const bool in_way = std::ranges::any_of(
        way, [&](Point2 p) { return distance(p, obstacle.at) <= 0.5 * (shape.width_m + obstacle.radius_m); });
    if (in_way) gone.push_back(obstacle.id);
  }
  for (const std::string& id : gone) {
    simulator.seen().remove(id);
    traces.add(now, "AIV_Server", "Simulator", "disappear", id + ": " + proxy.name + " sees its place free");
  }
}

void ServerCore::Inside::look_through(VehicleIndex vehicle, const wire::Ranges& ranges) {
  const AivProxy& proxy = registry[vehicle];
  if (simulator.seen().empty() || !simulator.zone() || !proxy.here() || !proxy.position_known) return;
  const Pose2 X_MB = simulator.image(*proxy.twin, now).X_MB;
  const Pose2 X_MS = X_MB * Pose2{0.5 * simulator.zone()->vehicle.length_m, 0.0, 0.0};
  for (const std::string& id : simulator.seen().look_through(X_MS, ranges))
    traces.add(now, "AIV_Server", "Simulator", "disappear", id + ": " + proxy.name + " looks through its place");
}

void ServerCore::Inside::on_boards(VehicleIndex vehicle, const wire::Input& input) {
  auto report = wire::heard_boards_report(input);
  if (!report) return refuse(vehicle, VehicleTopic::boards, input, report.error());
  AivProxy& proxy = registry[vehicle];
  if (!take_own_stamp(proxy, proxy.boards_stamp, report->timestamp)) return;
  const std::string health = health_of(*report);
  // Twice a second from each would drown the rest; what changes is news.
  if (!proxy.boards || health_of(*proxy.boards) != health) {
    traces.add(now, proxy.name, "AIV_Server", "boards", health, input.source, input.payload);
  }
  proxy.boards = std::move(*report);
  if (proxy.boards->power && !proxy.augmented) batteries.on_power(now, proxy.name, *proxy.boards->power);
  if (proxy.boards->ranges && !proxy.augmented) look_through(vehicle, *proxy.boards->ranges);
}

}  // namespace cosiva::virtual_side
