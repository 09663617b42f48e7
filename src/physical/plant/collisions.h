#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/physical/plant/body.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {

/// Whether two bodies of this shape overlap (separating axes of two rectangles).
[[nodiscard]] bool touch(const BodyPose& a, const BodyPose& b, const zone::VehicleShape& shape);
[[nodiscard]] bool touch(const BodyPose& body, const Disc& disc, const zone::VehicleShape& shape);

/// Reports each contact of two bodies once, when it begins; also again later. Invariant: compared in the order of x.
class CollisionWatch {
 public:
  /// Two bodies by number: vehicles 0 … n−1 in order, obstacles by their key with the highest bit set.
  using BodyKey = std::uint64_t;
  static constexpr BodyKey obstacle_bit = BodyKey{1} << 63U;
  struct Pair {
    BodyKey a;
    BodyKey b;
    friend auto operator<=>(const Pair&, const Pair&) = default;
  };
  struct Obstacle {
    BodyKey key;
    Disc disc;
  };

  explicit CollisionWatch(const zone::VehicleShape& shape);

  /// Appends the contacts that began since the last call.
  void detect_contacts(std::span<const BodyPose> vehicles, std::span<const Obstacle> obstacles,
                       std::vector<Pair>& began);

 private:
  void sort_by_x(std::span<const BodyPose> vehicles);
  void met(Pair pair, std::vector<Pair>& began);

  zone::VehicleShape shape_;
  double diagonal_m_;
  std::vector<std::size_t> by_x_;  ///< kept between calls: nearly sorted, so that sorting costs one pass
  std::vector<Pair> touching_;
  std::vector<Pair> still_touching_;
};

}  // namespace cosiva::physical
