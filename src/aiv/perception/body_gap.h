#pragma once

#include <limits>

#include "cosiva/aiv/perception/path_look_ahead.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// Distance from the vehicle's front along its path to bodies that the vehicle knows only from messages, in the same
/// corridor as Corridor: of virtual bodies and of other vehicles. Invariant: the corridor is as wide as the body.
class BodyGap {
 public:
  struct Model {
    double margin_m{0.02};  ///< on each side of the vehicle's body, as Corridor's
    double sample_m{0.03};
    double reach_m{1.30};
  };
  BodyGap(const zone::TrafficZone& zone, Model model);

  /// Sets position and path for gap_m(), until the next call.
  void update(const Outlook& outlook);
  /// @param carried_s  time since the report of the body, over which its motion is extrapolated
  /// @return           along the path from the vehicle's front, ≥ 0; infinite: the body is not on the path ahead
  [[nodiscard]] double gap_m(const wire::Body& body, double carried_s) const;

 private:
  /// To one disc; infinite where the disc is outside the corridor or not ahead of the body origin.
  [[nodiscard]] double disc_gap_m(Point2 p_B, double radius_m) const;

  const zone::TrafficZone& zone_;
  Model model_;
  PathLookAhead look_ahead_;
  Pose2 X_BM_;
};

}  // namespace cosiva::aiv
