#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::virtual_side {

/// The twin of a physical obstacle, as vehicles saw it.
struct DetectedObstacle {
  struct Witness {
    std::string vehicle;
    SimTime last{};
  };
  std::string id;          ///< "S1"
  std::uint16_t handle{};  ///< on binary frames, from DetectedObstacles::first_handle on
  Point2 at;
  double radius_m{};
  std::vector<Witness> detected_by;  ///< in the order of their first sightings
  SimTime first{};
  SimTime last{};
  std::uint32_t sightings{0};
  int doubts{0};  ///< frames in a row whose beams went through its place
};

/// Obstacles that vehicles report become twins, and vanish when their place is found free. Sightings of one thing from
/// several sides, and by several vehicles, are merged.
class DetectedObstacles {
 public:
  static constexpr double merge_within_m = 0.15;
  static constexpr std::size_t obstacles_max = 64;  ///< beyond, the one not seen for longest gives way
  static constexpr std::uint16_t first_handle = 0xC000;
  static constexpr std::uint16_t handles = 0x3FFF;
  /// A vehicle that saw it so recently is before it, not in it: its twin may be shown a little too far.
  static constexpr SimDuration just_detected{std::chrono::milliseconds{500}};
  static constexpr double checked_m_max = 1.5;  ///< further away a beam is too wide to say that nothing is there
  static constexpr int doubts_max = 3;          ///< one echo that does not come back ends nothing

  /// @return  true when a twin appeared; false when one that was there was seen again
  bool see(std::string_view vehicle, SimTime now, Point2 at, double radius_m);
  /// A vehicle's body, `length_m` × `width_m` around X_MB, is where it is: what lies there and was not seen by it just
  /// now has gone. Gives the number of those.
  std::size_t pass(std::string_view vehicle, SimTime now, const Pose2& X_MB, double length_m, double width_m);
  /// One frame of a vehicle's obstacle detection, whoever it is: what its beams go through, three times in a row, has
  /// gone (A2: passed again and not seen). Without this a sighting that was wrong, beside the way of every physical
  /// vehicle, would hold a virtual one for ever. Gives the ids of those.
  /// @param X_MS  of the sensor, in the middle of the vehicle's front
  std::vector<std::string> clear_through(const Pose2& X_MS, const wire::Ranges& ranges);
  void remove(std::string_view id);
  void clear() { obstacles_.clear(); }

  [[nodiscard]] static bool detected_by(const DetectedObstacle& obstacle, std::string_view vehicle);
  [[nodiscard]] const std::vector<DetectedObstacle>& obstacles() const { return obstacles_; }
  [[nodiscard]] bool empty() const { return obstacles_.empty(); }
  void fold(Digest& digest) const;

 private:
  void appear(std::string_view vehicle, SimTime now, Point2 at, double radius_m);

  std::vector<DetectedObstacle> obstacles_;
  std::uint64_t running_{0};
};

}  // namespace cosiva::virtual_side
