#include "cosiva/physical/plant/collisions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::physical {

bool touch(const BodyPose& a, const BodyPose& b, const zone::VehicleShape& shape) {
  const double l = 0.5 * shape.length_m;
  const double w = 0.5 * shape.width_m;
  // Equal rectangles, turned by δ to each other: on any of the four axes the other's half extent is the same pair.
  const double cos_delta = std::fabs(a.cos * b.cos + a.sin * b.sin);
  const double sin_delta = std::fabs(a.cos * b.sin - a.sin * b.cos);
  const double along = l + l * cos_delta + w * sin_delta;
  const double across = w + l * sin_delta + w * cos_delta;
  const Point2 b_from_a = a.to_body(position(b.X_MB));
  const Point2 a_from_b = b.to_body(position(a.X_MB));
  return std::fabs(b_from_a.x_m) <= along && std::fabs(b_from_a.y_m) <= across && std::fabs(a_from_b.x_m) <= along &&
         std::fabs(a_from_b.y_m) <= across;
}

bool touch(const BodyPose& body, const Disc& disc, const zone::VehicleShape& shape) {
  const Point2 centre = body.to_body(disc.centre);
  const double beyond_x = std::max(0.0, std::fabs(centre.x_m) - 0.5 * shape.length_m);
  const double beyond_y = std::max(0.0, std::fabs(centre.y_m) - 0.5 * shape.width_m);
  return beyond_x * beyond_x + beyond_y * beyond_y <= disc.radius_m * disc.radius_m;
}

CollisionWatch::CollisionWatch(const zone::VehicleShape& shape)
    : shape_{shape}, diagonal_m_{norm(shape.length_m, shape.width_m)} {}

void CollisionWatch::sort_by_x(std::span<const BodyPose> vehicles) {
  if (by_x_.size() != vehicles.size()) {
    by_x_.resize(vehicles.size());
    std::iota(by_x_.begin(), by_x_.end(), std::size_t{0});
  }
  for (std::size_t i = 1; i < by_x_.size(); ++i) {
    for (std::size_t j = i; j > 0 && vehicles[by_x_[j]].X_MB.x_m < vehicles[by_x_[j - 1]].X_MB.x_m; --j)
      std::swap(by_x_[j], by_x_[j - 1]);
  }
  COSIVA_EXPECT(std::ranges::is_sorted(by_x_, {}, [&](std::size_t i) { return vehicles[i].X_MB.x_m; }));
}

void CollisionWatch::detect_contacts(std::span<const BodyPose> vehicles, std::span<const Obstacle> obstacles,
                                     std::vector<Pair>& began) {
  still_touching_.clear();
  sort_by_x(vehicles);
  for (std::size_t i = 0; i < by_x_.size(); ++i) {
    const BodyPose& a = vehicles[by_x_[i]];
    for (std::size_t j = i + 1; j < by_x_.size(); ++j) {
      const BodyPose& b = vehicles[by_x_[j]];
      if (b.X_MB.x_m - a.X_MB.x_m > diagonal_m_) break;
      if (std::fabs(b.X_MB.y_m - a.X_MB.y_m) > diagonal_m_ || !touch(a, b, shape_)) continue;
      const auto [low, high] = std::minmax(by_x_[i], by_x_[j]);
      met({low, high}, began);
    }
  }
  for (const Obstacle& obstacle : obstacles) {
    for (std::size_t i = 0; i < vehicles.size(); ++i) {
      if (touch(vehicles[i], obstacle.disc, shape_)) met({i, obstacle.key}, began);
    }
  }
  std::swap(touching_, still_touching_);
}

void CollisionWatch::met(Pair pair, std::vector<Pair>& began) {
  still_touching_.push_back(pair);
  if (std::find(touching_.begin(), touching_.end(), pair) == touching_.end()) began.push_back(pair);
}

}  // namespace cosiva::physical
