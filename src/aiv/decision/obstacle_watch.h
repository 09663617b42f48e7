#pragma once

#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/perception/corridor.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What the vehicle's ranges show of obstacles: on its path, around it, and where its body will be while it goes onto
/// the line.
/// Invariant: echoes count only from a known position on.
class ObstacleWatch {
 public:
  /// @param zone     must outlive this object
  /// @param one_way  no vehicle ever turns on the spot in this zone
  ObstacleWatch(const zone::TrafficZone& zone, bool one_way);

  /// @param position  known
  void on_ranges(const PositionEstimator& position, const wire::Ranges& ranges);
  /// The vehicle believes to be elsewhere: earlier frames mean nothing there.
  void clear_ahead() { ahead_.clear(); }
  /// The vehicle goes onto the line at another pose.
  void clear_entry() { entry_.clear(); }

  /// From its front along its path to the nearest body, filtered; infinite: none.
  [[nodiscard]] double ahead_m(const PositionEstimator& position) const {
    return ahead_.obstacle_ahead_m(position.travelled_m());
  }
  /// Whether the body may move sideways where it is: turn on the spot, or go onto the line.
  /// @param bend_ahead_m  to the next bend where it turns on the spot
  [[nodiscard]] bool may_sweep(const PositionEstimator& position, double bend_ahead_m) const;
  /// What DOBS saw last: the nearest echo in the corridor and which beam brought it, unfiltered.
  [[nodiscard]] const Corridor::Scan& scan() const { return scan_; }
  [[nodiscard]] double reach_m() const { return corridor_.reach_m(); }  ///< as Corridor::reach_m()

 private:
  [[nodiscard]] bool in_entry(const PositionEstimator& position, const wire::Ranges& ranges);

  const zone::TrafficZone& zone_;
  bool one_way_;
  Corridor corridor_;
  Corridor::Scan scan_;
  EntrySweep sweep_;
  ObstacleFilter ahead_;
  ObstacleFilter around_;  ///< echoes near the body, whatever its path
  ObstacleFilter entry_;   ///< 0: one where the body will be on its way to the line
};

}  // namespace cosiva::aiv
