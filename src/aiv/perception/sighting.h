#pragma once

#include <optional>

#include "cosiva/aiv/perception/corridor.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::aiv {

/// Where the thing stands that the beam `look.beam` hears, as far as can be told from one side: its middle lies behind
/// its nearest point, in the middle of the beams that it fills.
/// @param X_MS  of the sensor, in the middle of the vehicle's front
[[nodiscard]] wire::DetectedObstacleReport::Obstacle body_in_beams(const Corridor::Scan& scan,
                                                                   const wire::Ranges& ranges, const Pose2& X_MS);

/// Makes of DOBS' frames what the vehicle tells of things in its way (wire::DetectedObstacleReport): a new thing at
/// once, then ten times a second, and three times that there is none any more. One echo that does not come back ends
/// nothing.
class Sighting {
 public:
  static constexpr double reported_m_max = 1.0;  ///< things further ahead are not told
  static constexpr int misses_max = 3;           ///< frames in a row without it: it is gone
  static constexpr int farewells = 3;
  static constexpr SimDuration period = std::chrono::milliseconds{100};

  /// One frame. Gives what is to be told now, without header and map.
  /// @param reach_m  so far from its front the vehicle can tell whether its way is free
  [[nodiscard]] std::optional<wire::DetectedObstacleReport> on_frame(SimTime now, const Corridor::Scan& scan,
                                                                     const wire::Ranges& ranges, const Pose2& X_MS,
                                                                     double reach_m);
  void fold(Digest& digest) const;

 private:
  [[nodiscard]] bool due(SimTime now) const {
    return !reported_at_ || now - *reported_at_ >= period || now < *reported_at_;
  }

  bool there_{false};
  int misses_{0};
  int farewells_left_{0};
  std::optional<SimTime> reported_at_;
};

}  // namespace cosiva::aiv
