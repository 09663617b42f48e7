#include "cosiva/virtual/server/reports/own_reports.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/wire/in_process/typed_message.h"

namespace cosiva::virtual_side {
namespace {

/// Margin around a known vehicle's body: an obstacle detected within this distance is that vehicle; the margin covers
/// the errors of two positions. In addition, the centre of a detected obstacle may be anywhere in the beams that the
/// obstacle fills: its uncertainty equals its radius.
constexpr double vehicle_margin_m = 0.10;
constexpr double path_step_m = 0.04;
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

bool same_health(const wire::BoardsReport& a, const wire::BoardsReport& b) {
  return std::ranges::equal(a.boards, b.boards, [](const auto& one, const auto& other) {
    return one.board == other.board && one.health == other.health;
  });
}

std::string position_text(double x_m, double y_m) { return "(" + metres_text(x_m) + ", " + metres_text(y_m) + ")"; }

}  // namespace

void OwnReports::on_acknowledged(VehicleIndex vehicle, const wire::Input& input) {
  const auto perceived = wire::virtual_obstacles_ack_from_json(input.payload);
  if (!perceived) return checks_.refuse(vehicle, VehicleTopic::perceived, input, perceived.error());
  AivProxy& proxy = context_.registry[vehicle];
  std::string summary = "virtual obstacles " + std::to_string(perceived->virtual_obstacles_header_id) + ": ";
  summary += perceived->braking ? "brakes for " + perceived->body : std::string("nothing to brake for");
  proxy.deliver(context_.traces, context_.now, {"virtual_obstacles_ack", summary, input.source, input.payload});
  if (!augmented_.virtual_obstacles.on_virtual_obstacles_ack(vehicle, *perceived,
                                                             checks_.server_time(proxy, perceived->decided)))
    proxy.counters.on_outdated();
}

/// A late report may be about a vehicle that has driven on: the vehicle's body counts at its twin's pose, at its last
/// reported pose, and at its pose at detection time.
bool OwnReports::is_vehicle(VehicleIndex observer, Point2 p, double radius_m, SimTime detected_at) const {
  const zone::VehicleShape& shape = context_.simulator.zone()->vehicle;
  const double within_m = vehicle_margin_m + radius_m;
  // No point of a body is further from its centre than its corners: most vehicles are far away.
  const double far_m = 0.5 * norm(shape.length_m, shape.width_m) + within_m + 1e-6;
  const auto touches = [&](const Pose2& X_MB) {
    return distance(position(X_MB), p) <= far_m && outside_m(X_MB, shape, p) <= within_m;
  };
  const auto any_other = [&](auto test) {
    for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
      const AivProxy& proxy = context_.registry[v];
      if (v != observer && proxy.here() && !proxy.augmented() && test(*proxy.twin())) return true;
    }
    return false;
  };
  // The reported poses of all vehicles first: most echoes are found there, and extrapolating a twin costs more.
  return any_other([&](auto entity) {
           const Twin& twin = context_.simulator.twin(entity);
           const MotionReport& report = twin.last_report();
           const double since_m = twin.speed_mps() * std::max(0.0, to_seconds(report.at - detected_at));
           return report.on_map && (touches(report.X_MB) || touches(report.X_MB * Pose2{-since_m, 0.0, 0.0}));
         }) ||
         any_other([&](auto entity) { return touches(context_.simulator.image(entity, context_.now).X_MB); });
}

void OwnReports::on_detected(VehicleIndex vehicle, const wire::Input& input) {
  const auto message = wire::detected_obstacle_from(input);
  if (!message) return checks_.refuse(vehicle, VehicleTopic::detected, input, message.error());
  AivProxy& proxy = context_.registry[vehicle];
  if (!proxy.on_board.on_detected(message->timestamp)) {
    proxy.counters.on_outdated();
    return;
  }
  const auto& obstacle = message->obstacle;
  const std::string summary =
      obstacle ? "obstacle at " + position_text(obstacle->x_m, obstacle->y_m) : std::string("no obstacle in its path");
  proxy.deliver(context_.traces, context_.now, {"detected_obstacle", summary, input.source, input.payload});
  if (!context_.simulator.zone() || message->map_id != context_.simulator.zone()->name) {
    proxy.counters.on_outdated();  // of a zone that is not in force any more, or not yet
    return;
  }
  if (!obstacle) {
    forget_where_clear(vehicle, message->clear_m);
    return;
  }
  const Point2 at{obstacle->x_m, obstacle->y_m};
  const SimTime detected_at = checks_.server_time(proxy, message->timestamp);
  if (is_vehicle(vehicle, at, obstacle->radius_m, detected_at)) return;
  if (!context_.simulator.detected().see(proxy.name(), context_.now, at, obstacle->radius_m)) return;
  COSIVA_EXPECT(!context_.simulator.detected().empty());
  const std::string& id = context_.simulator.detected().obstacles().back().id;
  context_.traces.add(context_.now, "AIV_Server", "Simulator", "appear",
                      id + ": an obstacle at " + position_text(at.x_m, at.y_m));
  if (proxy.augmented()) return;
  context_.simulator.monitor().effect(WorldEffect::shown, to_milliseconds_by_seconds(context_.now - detected_at));
}

void OwnReports::forget_where_clear(VehicleIndex vehicle, double clear_m) {
  const AivProxy& proxy = context_.registry[vehicle];
  if (context_.simulator.detected().empty() || !proxy.here()) return;
  const zone::VehicleShape& shape = context_.simulator.zone()->vehicle;
  const Twin::Image image = context_.simulator.image(*proxy.twin(), context_.now);
  const double reach_m = 0.5 * shape.length_m + std::min(clear_m, clear_m_max);
  const zone::Circuit& circuit = *context_.simulator.circuit();
  std::span<const zone::SectionId> course;
  if (image.position) course = context_.simulator.twin(*proxy.twin()).remaining(image.position->section);
  std::vector<Point2> path;
  for (double d = 0.0; d <= reach_m; d += path_step_m) {
    path.push_back(image.position ? position(circuit.pose_at(circuit.advance(*image.position, d, course)))
                                  : image.X_MB * Point2{d, 0.0});
  }
  std::vector<std::string> removed;
  for (const DetectedObstacle& obstacle : context_.simulator.detected().obstacles()) {
    if (!DetectedObstacles::detected_by(obstacle, proxy.name())) continue;
    // At least half of the obstacle is in the path; an obstacle next to the path would not be reported.
    const bool in_path = std::ranges::any_of(
        path, [&](Point2 p) { return distance(p, obstacle.at) <= 0.5 * (shape.width_m + obstacle.radius_m); });
    if (in_path) removed.push_back(obstacle.id);
  }
  for (const std::string& id : removed) {
    context_.simulator.detected().remove(id);
    context_.traces.add(context_.now, "AIV_Server", "Simulator", "disappear",
                        id + ": " + proxy.name() + " detects no obstacle there");
  }
}

void OwnReports::clear_through(VehicleIndex vehicle, const wire::Ranges& ranges) {
  const AivProxy& proxy = context_.registry[vehicle];
  if (context_.simulator.detected().empty() || !context_.simulator.zone() || !proxy.here() || !proxy.position.known())
    return;
  // The sensor is at the leading end, and its bearings are in the body frame.
  const zone::TrafficZone& zone = *context_.simulator.zone();
  const Pose2 X_MT = context_.simulator.image(*proxy.twin(), context_.now).X_MB;
  const Pose2 X_MS = zone::body_pose(zone, X_MT * Pose2{0.5 * zone.vehicle.length_m, 0.0, 0.0});
  for (const std::string& id : context_.simulator.detected().clear_through(X_MS, ranges))
    context_.traces.add(context_.now, "AIV_Server", "Simulator", "disappear",
                        id + ": " + proxy.name() + " measures beyond its position");
}

void OwnReports::on_boards(VehicleIndex vehicle, const wire::Input& input) {
  auto report = wire::boards_report_from(input);
  if (!report) return checks_.refuse(vehicle, VehicleTopic::boards, input, report.error());
  AivProxy& proxy = context_.registry[vehicle];
  if (proxy.on_board.boards_outdated(report->timestamp)) {
    proxy.counters.on_outdated();
    return;
  }
  // Two traces a second from each vehicle would obscure the others; only changes are traced.
  if (!proxy.on_board.boards() || !same_health(*proxy.on_board.boards(), *report))
    proxy.deliver(context_.traces, context_.now, {"boards", health_of(*report), input.source, input.payload});
  else
    proxy.deliver_untraced();
  proxy.on_board.on_boards(std::move(*report));
  const wire::BoardsReport& boards = *proxy.on_board.boards();
  if (boards.power && !proxy.augmented()) instruments_.batteries.on_power(context_.now, proxy.name(), *boards.power);
  if (boards.ranges && !proxy.augmented()) clear_through(vehicle, *boards.ranges);
}

}  // namespace cosiva::virtual_side
