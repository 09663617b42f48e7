#pragma once

#include <optional>

#include "cosiva/aiv/perception/corridor.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::aiv {

/// Estimated location of the body that the beam `look.beam` detects, as far as one side of the body shows it: its
/// centre lies behind its nearest point, at the centre of the beams that it fills.
/// @param X_MS  of the sensor, at the centre of the vehicle's front
[[nodiscard]] wire::DetectedObstacleReport::Obstacle body_in_beams(const Corridor::Scan& scan,
                                                                   const wire::Ranges& ranges, const Pose2& X_MS);

/// Derives the vehicle's reports of obstacles on its path (wire::DetectedObstacleReport) from the frames of DOBS: a new
/// obstacle at once, then ten times a second, and three times that there is none any more. One missing echo does not
/// end a detection. Invariant: an obstacle that is there has fewer than misses_max misses and all farewells left.
class Sighting {
 public:
  static constexpr double reported_m_max = 1.0;  ///< obstacles further ahead are not reported
  static constexpr int misses_max = 3;  ///< consecutive frames without the obstacle, after which it is no longer
                                        ///< detected
  static constexpr int farewells = 3;
  static constexpr SimDuration period = std::chrono::milliseconds{100};

  /// One frame. Returns the report to be sent now, without header and map.
  /// @param reach_m  distance from the vehicle's front up to which its sensors can establish that the path is free
  [[nodiscard]] std::optional<wire::DetectedObstacleReport> on_frame(SimTime now, const Corridor::Scan& scan,
                                                                     const wire::Ranges& ranges, const Pose2& X_MS,
                                                                     double reach_m);
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

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
