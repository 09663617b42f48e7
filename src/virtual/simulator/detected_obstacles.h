#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::virtual_side {

/// The twin of a physical obstacle, as detected by vehicles.
struct DetectedObstacle {
  struct Witness {
    std::string vehicle;
    SimTime last{};
  };
  std::string id;          ///< "S1"
  std::uint16_t handle{};  ///< on binary frames, from DetectedObstacles::first_handle on
  Point2 at;
  double radius_m{};
  std::vector<Witness> detected_by;  ///< in the order of their first detections
  SimTime first{};
  SimTime last{};
  std::uint32_t sightings{0};
  int doubts{0};  ///< consecutive frames whose beams passed through its position
};

/// Obstacles that vehicles report become twins; a twin is removed when its position is found free. Detections of one
/// obstacle from several sides, and by several vehicles, are merged. Invariant: at most obstacles_max are known.
class DetectedObstacles {
 public:
  static constexpr double merge_within_m = 0.15;
  static constexpr std::size_t obstacles_max = 64;  ///< beyond this number, the obstacle with the oldest detection is
                                                    ///< removed
  static constexpr std::uint16_t first_handle = 0xC000;
  static constexpr std::uint16_t handles = 0x3FFF;
  /// A vehicle that detected the obstacle so recently is in front of it: the vehicle's twin may be shown a little too
  /// far forward.
  static constexpr SimDuration just_detected{std::chrono::milliseconds{500}};
  static constexpr double checked_m_max = 1.5;  ///< beyond this distance a beam is too wide to prove that nothing is
                                                ///< there
  static constexpr int doubts_max = 3;          ///< a single missing echo does not remove an obstacle

  /// @return  true if a new twin appeared; false if an existing one was detected again
  bool see(std::string_view vehicle, SimTime now, Point2 at, double radius_m);
  /// Removes the obstacles within the body of a vehicle, `length_m` × `width_m` around X_MB, unless this vehicle
  /// detected them just before. Returns the number of removed obstacles.
  std::size_t pass(std::string_view vehicle, SimTime now, const Pose2& X_MB, double length_m, double width_m);
  /// Evaluates one frame of any vehicle's obstacle detection: an obstacle is removed when the beams have passed through
  /// its position three times in a row (A2: passed again and not detected). Without this rule, a false detection off
  /// the paths of all physical vehicles would stop a virtual one for ever. Returns the ids of the removed obstacles.
  /// @param X_MS  of the sensor, in the centre of the vehicle's front
  std::vector<std::string> clear_through(const Pose2& X_MS, const wire::Ranges& ranges);
  void remove(std::string_view id);
  void clear() { obstacles_.clear(); }

  [[nodiscard]] static bool detected_by(const DetectedObstacle& obstacle, std::string_view vehicle);
  [[nodiscard]] const std::vector<DetectedObstacle>& obstacles() const { return obstacles_; }
  [[nodiscard]] bool empty() const { return obstacles_.empty(); }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void appear(std::string_view vehicle, SimTime now, Point2 at, double radius_m);

  std::vector<DetectedObstacle> obstacles_;
  std::uint64_t running_{0};
};

}  // namespace cosiva::virtual_side
