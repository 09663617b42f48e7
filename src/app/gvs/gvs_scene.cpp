#include "cosiva/app/gvs/gvs_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/random.h"
#include "cosiva/physical/vision/floor_fit.h"
#include "cosiva/physical/vision/painter.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::app {
namespace {

constexpr double margin_m = 0.25;  // for vehicles, their heights and a camera that hangs askew
constexpr double tag_height_m = 0.10;

double half_side_m(const zone::Bounds& bounds) {
  return margin_m + 0.5 * std::max(bounds.high.x_m - bounds.low.x_m, bounds.high.y_m - bounds.low.y_m);
}

zone::Bounds centre_of(const zone::Bounds& bounds, double half_m) {
  const Point2 centre{0.5 * (bounds.low.x_m + bounds.high.x_m), 0.5 * (bounds.low.y_m + bounds.high.y_m)};
  return {{centre.x_m - half_m, centre.y_m - half_m}, {centre.x_m + half_m, centre.y_m + half_m}};
}

}  // namespace

vision::SceneCamera camera_over(const zone::Bounds& bounds, const SceneChoice& choice) {
  vision::SceneCamera camera;
  camera.frame = {choice.size_px, choice.size_px};
  camera.foot = {0.5 * (bounds.low.x_m + bounds.high.x_m), 0.5 * (bounds.low.y_m + bounds.high.y_m)};
  camera.height_m = choice.height_m;
  const double half_m = half_side_m(bounds);
  const double half_px = 0.5 * choice.size_px;
  camera.focal_px = half_px * (choice.height_m - choice.tag_height_m) / half_m;
  camera.principal = {half_px * 1.004, half_px * 0.996};
  camera.tilt_x_rad = 0.004;
  camera.tilt_y_rad = -0.006;
  // The distortion at the corners is the same whatever the lens's angle, so that a long lens has as much to correct as
  // a short one.
  const double corner = 1.414 * half_m / choice.height_m;
  camera.lens = {-0.11 / (corner * corner), 0.03 / (corner * corner * corner * corner), 0.0, 4e-4, -3e-4};
  camera.exposure_s = 1e-3 * choice.exposure_ms;
  camera.line_s = 1e-3 * choice.rolling_ms / static_cast<double>(choice.size_px);
  camera.noise_grey = choice.noise_grey;
  camera.brightness = choice.brightness;
  return camera;
}

std::vector<vision::SceneLine> lines_of(const std::vector<zone::Primitive>& primitives) {
  std::vector<vision::SceneLine> lines;
  for (const zone::Primitive& one : primitives)
    if (one.layer == "line" && one.shape == zone::Primitive::Shape::polyline) lines.push_back({one.points, 0.019});
  return lines;
}

std::vector<vision::FloorPoint> corners_of(const vision::SceneCamera& camera, std::uint64_t seed) {
  Random random{seed, "gvs/corners"};
  constexpr double noise_px = 0.05;
  constexpr int half = 20;
  const double reach_m = camera.height_m * 0.5 * static_cast<double>(camera.frame.width) / camera.focal_px * 1.3;
  const double pitch_m = std::max(0.1, std::ceil(reach_m / half * 10.0) / 10.0);
  std::vector<vision::FloorPoint> points;
  for (int j = -half; j <= half; ++j) {
    for (int i = -half; i <= half; ++i) {
      const Point2 floor{camera.foot.x_m + i * pitch_m, camera.foot.y_m + j * pitch_m};
      const auto pixel = camera.pixel_of(floor, 0.0);
      const double most = static_cast<double>(camera.frame.width) - 3.0;
      if (!pixel || pixel->u < 3.0 || pixel->v < 3.0 || pixel->u > most || pixel->v > most) continue;
      points.push_back({floor, {random.gaussian(pixel->u, noise_px), random.gaussian(pixel->v, noise_px)}});
    }
  }
  return points;
}

std::optional<GroundTruth> read_plant_ground_truth(const std::string& text) {
  const auto json = JsonValue::parse(text);
  if (!json) return std::nullopt;
  const auto stamp = parse_iso8601(json->text("timestamp").value_or(""));
  const JsonValue* vehicles = json->find("vehicles");
  if (!stamp || vehicles == nullptr || vehicles->array() == nullptr) return std::nullopt;
  GroundTruth ground_truth{*stamp, {}};
  ground_truth.vehicles.reserve(vehicles->array()->size());
  for (const JsonValue& one : *vehicles->array()) {
    const auto number = one.number("number");
    const auto x = one.number("x");
    const auto y = one.number("y");
    const auto heading = one.number("heading");
    const auto speed = one.number("speed");
    if (!number || !(*number >= 0.0 && *number < vision::tags_in_family) || !x || !y || !heading || !speed)
      return std::nullopt;
    ground_truth.vehicles.push_back({static_cast<std::uint32_t>(*number), {*x, *y, *heading}, *speed});
  }
  return ground_truth;
}

EmulatedCamera::EmulatedCamera(vision::Calibration calibration, vision::Painter painter, zone::VehicleShape shape,
                               double tag_side_m, double width_m)
    : calibration_{std::move(calibration)},
      painter_{std::move(painter)},
      shape_{shape},
      tag_side_m_{tag_side_m},
      width_m_{width_m} {}

Result<EmulatedCamera> EmulatedCamera::over(const zone::TrafficZone& zone) {
  const auto primitives = zone::draw(zone);
  const zone::Bounds whole = zone::bounds(primitives);
  // As large as the tag's white margin on the roof allows: 9 of 12 cm.
  const double side_m = 0.75 * zone.vehicle.width_m;
  const double half_m_max = 0.5 * size_px * side_m / tag_px_min;
  const double half_m = std::min(half_side_m(whole), half_m_max);
  SceneChoice choice;
  choice.size_px = size_px;
  choice.height_m = std::max(choice.height_m, 2.0 * half_m);
  const vision::SceneCamera camera = camera_over(centre_of(whole, half_m - margin_m), choice);
  vision::CalibrationOptions options;
  options.models = {{vision::FloorModel::lens, 5}};
  options.block_m = half_m / 2.0;
  options.camera_height_m = choice.height_m;
  auto made = vision::calibrate(corners_of(camera, 1), camera.frame, options);
  if (!made) return tl::unexpected(made.error());
  made->calibration.camera = {camera.foot, camera.height_m};  // by a plumb line and a tape measure
  vision::MarkerProfile marker;
  marker.height_m = tag_height_m;
  made->calibration.markers = {marker};
  return EmulatedCamera{std::move(made->calibration), vision::Painter{camera, lines_of(primitives), 1}, zone.vehicle,
                        side_m, 2.0 * half_m};
}

vision::Image EmulatedCamera::take(const GroundTruth& ground_truth, const std::optional<GroundTruth>& before) {
  std::vector<vision::SceneBody> bodies;
  bodies.reserve(ground_truth.vehicles.size());
  const double since_s = before ? to_seconds(ground_truth.at - before->at) : 0.0;
  for (const TruthfulVehicle& vehicle : ground_truth.vehicles) {
    vision::SceneBody body;
    body.tag = static_cast<int>(vehicle.number);
    body.X_MB = vehicle.X_MB;
    body.speed_mps = vehicle.speed_mps;
    if (since_s > 1e-3 && since_s < 1.0) {
      const auto was = std::ranges::find(before->vehicles, vehicle.number, &TruthfulVehicle::number);
      if (was != before->vehicles.end())
        body.turn_radps = wrap_angle(vehicle.X_MB.heading_rad - was->X_MB.heading_rad) / since_s;
    }
    body.height_m = tag_height_m;
    body.side_m = tag_side_m_;
    body.length_m = shape_.length_m;
    body.width_m = shape_.width_m;
    bodies.push_back(body);
  }
  return painter_.paint(bodies, images_++);
}

}  // namespace cosiva::app
