#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "base/pose.h"
#include "base/time.h"

namespace cosiva::virtual_side {

/// The twin of a physical obstacle, as vehicles saw it.
struct SeenObstacle {
  struct Witness {
    std::string vehicle;
    SimTime last{};
  };
  std::string id;          ///< "S1"
  std::uint16_t handle{};  ///< on binary frames, from SeenObstacles::first_handle on
  Point2 at;
  double radius_m{};
  std::vector<Witness> seen_by;  ///< in the order of their first sightings
  SimTime first{};
  SimTime last{};
  std::uint32_t sightings{0};
};

/// Obstacles that vehicles report become twins, and vanish when their place is found free. Sightings of one thing from
/// several sides, and by several vehicles, are merged.
class SeenObstacles {
 public:
  static constexpr double merge_within_m = 0.15;
  static constexpr std::size_t obstacles_max = 64;  ///< beyond, the one not seen for longest gives way
  static constexpr std::uint16_t first_handle = 0xC000;
  static constexpr std::uint16_t handles = 0x3FFF;
  /// A vehicle that saw it so recently is before it, not in it: its twin may be shown a little too far.
  static constexpr SimDuration just_seen{std::chrono::milliseconds{500}};

  /// @return  true when a twin appeared; false when one that was there was seen again
  bool see(std::string_view vehicle, SimTime now, Point2 at, double radius_m);
  /// A vehicle's body, `length_m` × `width_m` around X_MB, is where it is: what lies there and was not seen by it just
  /// now has gone. Gives the number of those.
  std::size_t pass(std::string_view vehicle, SimTime now, const Pose2& X_MB, double length_m, double width_m);
  void remove(std::string_view id);
  void clear() { obstacles_.clear(); }

  [[nodiscard]] static bool seen_by(const SeenObstacle& obstacle, std::string_view vehicle);
  [[nodiscard]] const std::vector<SeenObstacle>& obstacles() const { return obstacles_; }
  [[nodiscard]] bool empty() const { return obstacles_.empty(); }
  void fold(Digest& digest) const;

 private:
  void appear(std::string_view vehicle, SimTime now, Point2 at, double radius_m);

  std::vector<SeenObstacle> obstacles_;
  std::uint64_t running_{0};
};

}  // namespace cosiva::virtual_side
