#pragma once

#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/perception/corridor.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// Obstacles in the vehicle's ranges: on its path, around it, and where its body will be while it joins the path.
/// Invariant: echoes count only from a known position on.
class ObstacleWatch {
 public:
  /// @param zone     must outlive this object
  /// @param one_way  no vehicle ever turns on the spot in this zone
  ObstacleWatch(const zone::TrafficZone& zone, bool one_way);

  /// @param position  known
  void on_ranges(const PositionEstimator& position, const wire::Ranges& ranges);
  /// The estimated position has jumped: earlier frames have no meaning there.
  void clear_ahead() { ahead_.clear(); }
  /// The vehicle joins the path at another pose.
  void clear_entry() { entry_.clear(); }

  /// From the vehicle's front along its path to the nearest body, filtered; infinite: none.
  [[nodiscard]] double ahead_m(const PositionEstimator& position) const {
    return ahead_.obstacle_ahead_m(position.travelled_m());
  }
  /// Whether the body may move sideways where it is: turn on the spot, or join the path.
  /// @param bend_ahead_m  to the next bend where the vehicle turns on the spot
  [[nodiscard]] bool may_sweep(const PositionEstimator& position, double bend_ahead_m) const;
  /// The last detection of DOBS: the nearest echo in the corridor and the beam that measured it, unfiltered.
  [[nodiscard]] const Corridor::Scan& scan() const { return scan_; }
  [[nodiscard]] double reach_m() const { return corridor_.reach_m(); }  ///< as Corridor::reach_m()
  void archive(Archive& archive);                                       ///< the state, for a snapshot

 private:
  [[nodiscard]] bool in_entry(const PositionEstimator& position, const wire::Ranges& ranges);

  const zone::TrafficZone& zone_;
  bool one_way_;
  Corridor corridor_;
  Corridor::Scan scan_;
  EntrySweep sweep_;
  ObstacleFilter ahead_;
  ObstacleFilter around_;  ///< echoes near the body, whatever its path
  ObstacleFilter entry_;   ///< 0: an echo where the body will be while it joins the path
};

}  // namespace cosiva::aiv
