#pragma once

#include <string>

#include "cosiva/aiv/decision/back_up.h"
#include "cosiva/aiv/decision/hold.h"
#include "cosiva/aiv/decision/motion_state.h"
#include "cosiva/aiv/decision/obstacle_watch.h"
#include "cosiva/aiv/decision/order_progress.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What the agent knows of its vehicle, and what the vehicle is to do: position, motion, obstacles in the ranges,
/// order, backUp and holds. Readings and commands change the state; the agent decides on it. Invariant: no backUp is
/// active while an order is.
class VehicleState {
 public:
  /// @param zone     must outlive the state
  /// @param one_way  the zone has no branches and no turns on the spot
  /// @param catalogue  the actions of orders that the vehicle performs
  VehicleState(const zone::TrafficZone& zone, bool one_way, ActionCatalogue catalogue = {});

  // Readings.
  /// @param driving  the motors are commanded to drive along the path
  void on_odometry(const wire::Odometry& odometry, bool driving);
  void on_odometry_lost() { motion_.on_odometry_lost(); }  ///< the motors stop by themselves
  PositionFix on_tag(const wire::TagRead& tag);
  void on_ranges(const wire::Ranges& ranges);

  // Commands.
  /// For sources that know the position better: configuration, state file, boards, and tags that changed.
  [[nodiscard]] PositionEstimator& estimator() { return estimator_; }
  /// initPosition: fails ("position.off_circuit") further than 0.25 m from the circuit or with another heading, and
  /// ("position.busy") while an order is active or the vehicle moves.
  [[nodiscard]] Result<void> initialise_position(const Pose2& X_MB, std::string last_node_id);
  /// joinLine: drives onto the path at this pose, which lies along the path, with or without an order; in force until
  /// the vehicle is there or another pose is commanded. Fails ("join.on_line", "join.busy", "join.too_far",
  /// "join.no_line").
  /// A manoeuvre that was abandoned with its order is completed instead: PILS takes no other goal before.
  [[nodiscard]] Result<void> join_line(const Pose2& X_MG);
  /// backUp: drives backwards along the path, slowly and without sensing: the sender of the command has checked the
  /// floor behind the vehicle. 0 ends the backUp; an order ends it, too. Fails ("back_up.off_path", "back_up.order",
  /// "back_up.distance": not in [0, BackUp::distance_m_max]).
  [[nodiscard]] Result<void> begin_back_up(double distance_m);
  /// @param actions_left  actions of the present order have not ended
  /// Fails as OrderProgress::offer(), and ("noRouteError") where no path is near the vehicle.
  [[nodiscard]] Result<OrderBook::Verdict> take_order(const wire::Order& order, bool actions_left = false);
  /// Drops the order whose cancellation is pending; only once the vehicle has stopped.
  void end_cancel();
  [[nodiscard]] OrderProgress& progress() { return progress_; }
  void hold(Hold reason, bool on) { holds_.set(reason, on); }
  /// In another zone from now on, in succession of the state `before`: pose, motion, holds and the ids of the last
  /// order stay; the order itself is dropped. Only for a vehicle that has stopped.
  void take_over(const VehicleState& before);

  // Parts.
  [[nodiscard]] const PositionEstimator& position() const { return estimator_; }
  [[nodiscard]] const MotionState& motion() const { return motion_; }
  [[nodiscard]] const ObstacleWatch& watch() const { return watch_; }
  [[nodiscard]] const OrderProgress& progress() const { return progress_; }
  [[nodiscard]] const OrderBook& order() const { return progress_.book(); }
  [[nodiscard]] const BackUp& back_up() const { return back_up_; }
  [[nodiscard]] const HoldSet& holds() const { return holds_; }
  [[nodiscard]] bool joining() const { return joining_; }
  [[nodiscard]] double turn_rate_radps() const;  ///< of a manoeuvre as measured, elsewhere that of the path
  void archive(Archive& archive);                ///< the state, for a snapshot

 private:
  void follow_order() { estimator_.follow(order().course_from(estimator_.track_position())); }
  /// The estimated position jumped: the order continues from there, or is dropped.
  void on_relocated();

  const zone::TrafficZone& zone_;
  bool one_way_;
  PositionEstimator estimator_;
  OrderProgress progress_;
  ObstacleWatch watch_;
  MotionState motion_;
  HoldSet holds_;
  BackUp back_up_;
  bool joining_{false};  ///< a pose on the path is commanded, and not reached yet
};

}  // namespace cosiva::aiv
