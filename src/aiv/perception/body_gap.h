#pragma once

#include <limits>

#include "cosiva/aiv/perception/path_look_ahead.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// How far bodies that the vehicle only knows of stand from its front along its way: in the same corridor that Corridor
/// looks through. What is only virtual (PerceivedWorld) and what other vehicles say of themselves (Neighbours) are
/// judged by it.
class BodyGap {
 public:
  struct Model {
    double margin_m{0.02};  ///< on each side of the vehicle's body, as Corridor's
    double sample_m{0.03};
    double reach_m{1.30};
  };
  BodyGap(const zone::TrafficZone& zone, Model model);

  /// From where and along which way; until the next call.
  void update(const Outlook& outlook);
  /// @param carried_s  by so much the body has moved on since it was told of
  /// @return           along the way from the vehicle's front, ≥ 0; infinite: it is not in the way ahead
  [[nodiscard]] double gap_m(const wire::Body& body, double carried_s) const;

 private:
  /// To one disc; infinite where it is outside the corridor or not ahead of the middle.
  [[nodiscard]] double disc_gap_m(Point2 p_B, double radius_m) const;

  const zone::TrafficZone& zone_;
  Model model_;
  PathLookAhead path_ahead_;
  Pose2 X_BM_;
};

}  // namespace cosiva::aiv
