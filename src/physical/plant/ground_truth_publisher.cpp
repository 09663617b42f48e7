#include "cosiva/physical/plant/ground_truth_publisher.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::physical {
namespace {

/// To the micrometre or microradian: more digits would be below the emulation's own accuracy.
double rounded(double value) { return std::nearbyint(value * 1e6) * 1e-6; }

std::string ground_truth_json(SimTime now, std::span<const Vehicle> vehicles, const Obstacles& obstacles,
                              std::size_t contacts) {
  JsonWriter json;
  json.begin_object().field("timestamp", to_iso8601(now)).key("vehicles").begin_array();
  for (const Vehicle& vehicle : vehicles) {
    const Pose2 pose = body_pose(vehicle);
    json.begin_object().field("number", vehicle.number()).field("x", rounded(pose.x_m)).field("y", rounded(pose.y_m));
    json.field("heading", rounded(pose.heading_rad)).field("speed", rounded(vehicle.motion().speed_mps()));
    json.field("charge", rounded(vehicle.power().pack().charge())).end_object();
  }
  json.end_array().key("obstacles").begin_array();
  for (const auto& obstacle : obstacles.all()) {
    json.begin_object().field("id", obstacle.id).field("x", obstacle.disc.centre.x_m);
    json.field("y", obstacle.disc.centre.y_m).field("radius", obstacle.disc.radius_m).end_object();
  }
  json.end_array().field("collisions", contacts).end_object();
  return json.take();
}

wire::GvsDetections::Detection detection_of(const Vehicle& vehicle, SimTime now) {
  const Pose2 pose = body_pose(vehicle);
  const wire::VehicleId id{std::string(wire::our_manufacturer), "AIV" + std::to_string(vehicle.number())};
  return {wire::to_string(id), 0, now, {rounded(pose.x_m), rounded(pose.y_m), rounded(pose.heading_rad)}, 0.0};
}

}  // namespace

void GroundTruthPublisher::start(SimTime at) {
  ground_truth_.start(at);
  reference_.start(at);
}

void GroundTruthPublisher::tick(SimTime at, bool publishes, std::span<const Vehicle> vehicles,
                                const Obstacles& obstacles, std::size_t contacts, wire::Effects& effects) {
  if (ground_truth_.take(at) && publishes)
    effects.emplace_back(wire::Publish{std::string(wire::ground_truth_topic),
                                       ground_truth_json(at, vehicles, obstacles, contacts), 0, false});
  const bool reference_due = reference_.take(at);
  COSIVA_EXPECT(!ground_truth_.due(at) && !reference_.due(at));
  if (!reference_due || !publishes) return;
  for (std::size_t first = 0; first < vehicles.size(); first += wire::GvsDetections::detections_max) {
    wire::GvsDetections poses{0, at, to_seconds(reference_period), {}, {}};
    const std::size_t count = std::min(vehicles.size() - first, wire::GvsDetections::detections_max);
    for (const Vehicle& vehicle : vehicles.subspan(first, count)) poses.detections.push_back(detection_of(vehicle, at));
    effects.emplace_back(wire::Publish{std::string(wire::reference_poses_topic), to_json(poses), 0, false});
  }
}

std::optional<wire::Publish> GroundTruthPublisher::actual_position(SimTime at, const wire::VehicleId& vehicle,
                                                                   std::string_view request,
                                                                   std::span<const Vehicle> vehicles) {
  const auto read = wire::actual_position_request_from_json(request);
  if (!read) return std::nullopt;
  for (const Vehicle& one : vehicles) {
    const wire::GvsDetections::Detection detection = detection_of(one, at);
    if (detection.vehicle != wire::to_string(vehicle)) continue;
    const wire::ActualPosition position{read->session, read->sequence, at, detection.pose, 0.0};
    return wire::Publish{wire::own_topic(wire::plant_position_response_topic_prefix, vehicle), to_json(position), 0,
                         false};
  }
  return std::nullopt;
}

}  // namespace cosiva::physical
