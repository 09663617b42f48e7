#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/physical/plant/body.h"
#include "cosiva/physical/plant/collisions.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {

/// The obstacles that instruments put into the emulated plant: round objects. Invariant: each has its own name.
class Obstacles {
 public:
  static constexpr std::size_t count_max = 1000;
  static constexpr double radius_m_min = 0.01;
  static constexpr double radius_m_max = 2.0;
  static constexpr double off_world_m = 1.0;  ///< there is floor up to this distance from the zone's drawing

  struct Obstacle {
    std::string id;
    Disc disc;
    CollisionWatch::BodyKey key;
  };

  explicit Obstacles(const zone::TrafficZone& zone);

  /// The floor is this zone's from now on: obstacles on it stay, even off the new floor.
  void set_zone(const zone::TrafficZone& zone);

  /// Puts {"id","x","y","radius"}, or moves the obstacle of this id. Refuses ("plant.command", a sentence) a missing or
  /// too long id, a position off the floor, a radius outside 0.01…2 m, one obstacle too many, and a position on one of
  /// the vehicles: the contact would count as that vehicle's collision, which the vehicle could not prevent.
  /// @param bodies  the vehicles, AIV1 first
  [[nodiscard]] std::optional<Error> add(const JsonValue& given, std::span<const BodyPose> bodies);
  [[nodiscard]] std::optional<Error> remove(std::string_view id);

  [[nodiscard]] const std::vector<Obstacle>& all() const { return all_; }  ///< sorted by id
  /// The same in the collision monitor's form.
  [[nodiscard]] std::span<const CollisionWatch::Obstacle> discs() const { return discs_; }
  [[nodiscard]] std::string name_of(CollisionWatch::BodyKey key) const;
  void archive(Archive& archive);  ///< all obstacles, for a restart of the emulation

 private:
  [[nodiscard]] std::optional<Error> check(const std::string& id, const Disc& disc,
                                           std::span<const BodyPose> bodies) const;
  void record_discs();

  zone::VehicleShape shape_;
  zone::Bounds world_;
  std::vector<Obstacle> all_;
  std::vector<CollisionWatch::Obstacle> discs_;
  CollisionWatch::BodyKey next_key_{CollisionWatch::obstacle_bit};
};

}  // namespace cosiva::physical
