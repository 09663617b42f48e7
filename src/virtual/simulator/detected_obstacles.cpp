#include "cosiva/virtual/simulator/detected_obstacles.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {
namespace {

/// Minimum weight of a new detection: late detections come from a shorter distance and are better than the first.
constexpr double newest_ratio = 0.3;
/// A vehicle stops for a body within this distance of its sides; most of the obstacle's own radius counts, since the
/// radius is only an estimate.
constexpr double swept_margin_m = 0.02;
constexpr double swept_ratio = 0.8;
/// A beam passes through an obstacle's position only if it reaches this far beyond the obstacle's far side.
constexpr double through_margin_m = 0.10;

enum class Inspection : std::uint8_t { through, hidden, there };

/// Result of the beams that the obstacle would fill.
Inspection inspect_obstacle(const DetectedObstacle& obstacle, const Pose2& X_SM, const wire::Ranges& ranges) {
  const Point2 p_S = X_SM * obstacle.at;
  const double away_m = norm(p_S.x_m, p_S.y_m);
  if (away_m > DetectedObstacles::checked_m_max || away_m <= obstacle.radius_m || ranges.beam_width_crad == 0)
    return Inspection::hidden;
  const double width_rad = 0.01 * ranges.beam_width_crad;
  const double first_edge_rad = 0.01 * ranges.first_bearing_crad - 0.5 * width_rad;
  const double bearing_rad = det_atan2(p_S.y_m, p_S.x_m);
  const double half_rad = obstacle.radius_m / away_m;
  const double from = std::floor((bearing_rad - half_rad - first_edge_rad) / width_rad);
  const double to = std::floor((bearing_rad + half_rad - first_edge_rad) / width_rad);
  if (from < 0.0 || to >= static_cast<double>(ranges.range_mm.size())) return Inspection::hidden;
  const double far_side_m = away_m + obstacle.radius_m + through_margin_m;
  const double near_side_m = away_m - obstacle.radius_m - through_margin_m;
  bool hidden = false;
  for (auto i = static_cast<std::size_t>(from); i <= static_cast<std::size_t>(to); ++i) {
    if (ranges.range_mm[i] == wire::no_echo) continue;
    const double range_m = 0.001 * ranges.range_mm[i];
    if (range_m >= far_side_m) continue;
    if (range_m >= near_side_m) return Inspection::there;
    hidden = true;
  }
  return hidden ? Inspection::hidden : Inspection::through;
}

}  // namespace

bool DetectedObstacles::detected_by(const DetectedObstacle& obstacle, std::string_view vehicle) {
  return std::ranges::find(obstacle.detected_by, vehicle, &DetectedObstacle::Witness::vehicle) !=
         obstacle.detected_by.end();
}

bool DetectedObstacles::see(std::string_view vehicle, SimTime now, Point2 at, double radius_m) {
  DetectedObstacle* nearest = nullptr;
  for (DetectedObstacle& obstacle : obstacles_) {
    const double apart_m = distance(obstacle.at, at);
    if (apart_m <= merge_within_m && (nearest == nullptr || apart_m < distance(nearest->at, at))) nearest = &obstacle;
  }
  if (nearest == nullptr) {
    appear(vehicle, now, at, radius_m);
    return true;
  }
  const double ratio = std::max(newest_ratio, 1.0 / (1.0 + nearest->sightings));
  nearest->at.x_m += ratio * (at.x_m - nearest->at.x_m);
  nearest->at.y_m += ratio * (at.y_m - nearest->at.y_m);
  nearest->radius_m += ratio * (radius_m - nearest->radius_m);
  nearest->last = now;
  nearest->doubts = 0;
  ++nearest->sightings;
  const auto witness = std::ranges::find(nearest->detected_by, vehicle, &DetectedObstacle::Witness::vehicle);
  if (witness == nearest->detected_by.end())
    nearest->detected_by.push_back({std::string(vehicle), now});
  else
    witness->last = now;
  return false;
}

void DetectedObstacles::appear(std::string_view vehicle, SimTime now, Point2 at, double radius_m) {
  if (obstacles_.size() >= obstacles_max)
    obstacles_.erase(std::ranges::min_element(obstacles_, {}, &DetectedObstacle::last));
  DetectedObstacle obstacle;
  const auto used = [&](std::uint16_t handle) {
    return std::ranges::find(obstacles_, handle, &DetectedObstacle::handle) != obstacles_.end();
  };
  do {
    obstacle.handle = static_cast<std::uint16_t>(first_handle + running_ % handles);
    ++running_;
  } while (used(obstacle.handle));
  obstacle.id = "S" + std::to_string(running_);
  obstacle.at = at;
  obstacle.radius_m = radius_m;
  obstacle.detected_by.push_back({std::string(vehicle), now});
  obstacle.first = now;
  obstacle.last = now;
  obstacle.sightings = 1;
  obstacles_.push_back(std::move(obstacle));
  COSIVA_EXPECT(obstacles_.size() <= obstacles_max);
}

std::size_t DetectedObstacles::pass(std::string_view vehicle, SimTime now, const Pose2& X_MB, double length_m,
                                    double width_m) {
  if (obstacles_.empty()) return 0;
  const Pose2 X_BM = inverse(X_MB);
  return std::erase_if(obstacles_, [&](const DetectedObstacle& obstacle) {
    const Point2 p_B = X_BM * obstacle.at;
    // The obstacle is abreast of the vehicle and within the vehicle's corridor: a real obstacle would have stopped the
    // vehicle.
    const double beside_m = 0.5 * width_m + swept_margin_m + swept_ratio * obstacle.radius_m;
    if (std::fabs(p_B.x_m) > 0.5 * (length_m + obstacle.radius_m) || std::fabs(p_B.y_m) > beside_m) return false;
    const auto witness = std::ranges::find(obstacle.detected_by, vehicle, &DetectedObstacle::Witness::vehicle);
    return witness == obstacle.detected_by.end() || now - witness->last > just_detected;
  });
}

std::vector<std::string> DetectedObstacles::clear_through(const Pose2& X_MS, const wire::Ranges& ranges) {
  std::vector<std::string> removed;
  const Pose2 X_SM = inverse(X_MS);
  for (DetectedObstacle& obstacle : obstacles_) {
    const Inspection inspect = inspect_obstacle(obstacle, X_SM, ranges);
    if (inspect == Inspection::there) obstacle.doubts = 0;
    if (inspect == Inspection::through && ++obstacle.doubts >= doubts_max) removed.push_back(obstacle.id);
  }
  for (const std::string& id : removed) remove(id);
  return removed;
}

void DetectedObstacles::remove(std::string_view id) {
  std::erase_if(obstacles_, [id](const DetectedObstacle& obstacle) { return obstacle.id == id; });
}

void DetectedObstacles::fold(Digest& digest) const {
  digest.add(running_);
  for (const DetectedObstacle& obstacle : obstacles_) {
    digest.add(std::string_view{obstacle.id});
    digest.add(obstacle.at.x_m);
    digest.add(obstacle.at.y_m);
    digest.add(obstacle.radius_m);
    digest.add(obstacle.last);
    digest.add(static_cast<std::uint64_t>(obstacle.detected_by.size()));
    digest.add(std::int64_t{obstacle.doubts});
  }
}

void DetectedObstacles::archive(Archive& archive) { archive(obstacles_, running_); }

}  // namespace cosiva::virtual_side
