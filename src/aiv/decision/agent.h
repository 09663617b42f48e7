#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "cosiva/aiv/decision/back_up.h"
#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/hold.h"
#include "cosiva/aiv/decision/motion_state.h"
#include "cosiva/aiv/decision/obstacle_watch.h"
#include "cosiva/aiv/decision/order_progress.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// An operator's limits on a vehicle.
struct Instructions {
  std::optional<Profile> imposed;       ///< the profile to drive by; nothing: the agent's own choice
  std::optional<double> speed_mps_max;  ///< > 0; nothing: no limit
};

/// The agent's last decision, and its consequences for other components.
struct Decision {
  wire::Drive drive{};              ///< to the motors
  std::optional<Profile> profile;   ///< nothing while the vehicle must stop
  bool blocked{false};              ///< the protective field is violated: an obstacle keeps the vehicle from going
  bool braking_for_virtual{false};  ///< a virtual body keeps the vehicle slower than it would drive without
  bool wants_base{false};           ///< the base ends soon and more is announced (§6.10.3)
  /// To the next crossing that the vehicle may not enter yet; infinite: none is near.
  double crossing_ahead_m{std::numeric_limits<double>::infinity()};
};

/// Decides what a vehicle does (A9, A10), without I/O: readings and instructions in, a drive command out. The vehicle
/// follows its order, keeps its distance, waits at crossings, and stops on command or when its links are lost. The
/// physical vehicle's on-board program and a virtual AIV run this same class. Invariant: while a hold is in force, a
/// cancelOrder is pending or the position is unknown, the command's speed is 0 (a backUp stops for holds, too).
class Agent {
 public:
  /// @param zone          must outlive the agent
  /// @param speed_policy  the decision that may be fuzzy; the envelope above it is not. Null: the crisp rules
  explicit Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedPolicy> speed_policy = nullptr,
                 Lateness late = {});

  // Perception.
  void on_odometry(const wire::Odometry& odometry);
  void on_odometry_lost() { motion_.on_odometry_lost(); }  ///< the motors stop by themselves
  PositionFix on_tag(const wire::TagRead& tag);
  void on_ranges(const wire::Ranges& ranges);
  void on_charge(double charge) { inputs_.charge = charge; }
  /// Distance from the vehicle's front along its path to the first virtual body (PerceivedWorld); infinite: none. The
  /// body has the effect of an echo at the same distance, until the next call.
  void perceive(double gap_m) { inputs_.perceived_m = gap_m; }
  /// What vehicles nearby report, until the next call. These reports only make driving smoother: the vehicle's own
  /// sensors determine the distance to the first body ahead, and its order determines whether it may enter a crossing.
  void heed(const Others& others) { inputs_.others = others; }
  [[nodiscard]] bool heeds_others() const { return speed_policy_->heeds_others(); }

  // Commands.
  /// For sources that know the position better: configuration, state file, boards, and tags that changed.
  [[nodiscard]] PositionEstimator& estimator() { return estimator_; }
  /// initPosition: fails ("position.off_circuit") further than 0.25 m from the circuit or with another heading, and
  /// ("position.busy") while an order is active or the vehicle moves.
  [[nodiscard]] Result<void> initialise_position(const Pose2& X_MB, std::string last_node_id);
  /// joinLine: drives onto the path at this pose, which lies along the path, with or without an order; in force until
  /// the vehicle is there or another pose is commanded. Fails ("join.on_line", "join.busy", "join.too_far",
  /// "join.no_line").
  [[nodiscard]] Result<void> join_line(const Pose2& X_MG);
  [[nodiscard]] bool joining() const { return joining_; }
  /// backUp: drives backwards along the path, slowly and without sensing: the sender of the command has checked the
  /// floor behind the vehicle. 0 ends the backUp; an order ends it, too. Fails ("back_up.off_path", "back_up.order",
  /// "back_up.distance": not in [0, BackUp::distance_m_max]).
  [[nodiscard]] Result<void> begin_back_up(double distance_m);
  [[nodiscard]] Result<OrderBook::Verdict> take_order(const wire::Order& order);
  void hold(Hold reason, bool on) { holds_.set(reason, on); }
  [[nodiscard]] Instructions& instructions() { return instructions_; }
  /// In another zone from now on, in succession of the agent `before`: its pose, holds, limits and the ids of its last
  /// order stay; the order itself is dropped. Only for a vehicle that has stopped.
  void take_over(const Agent& before);

  /// The present command to the motors. Required at least every 100 ms: the board's watchdog waits 300 ms.
  [[nodiscard]] wire::Drive decide();

  // State.
  [[nodiscard]] const PositionEstimator& position() const { return estimator_; }
  [[nodiscard]] const OrderBook& order() const { return progress_.book(); }
  [[nodiscard]] const OrderProgress& progress() const { return progress_; }
  [[nodiscard]] OrderProgress& progress() { return progress_; }
  [[nodiscard]] const MotionState& motion() const { return motion_; }
  [[nodiscard]] const BackUp& back_up() const { return back_up_; }
  [[nodiscard]] const HoldSet& holds() const { return holds_; }
  [[nodiscard]] const Instructions& instructions() const { return instructions_; }
  [[nodiscard]] const Decision& decision() const { return decision_; }
  [[nodiscard]] const ObstacleWatch& watch() const { return watch_; }
  [[nodiscard]] double charge() const { return inputs_.charge; }
  [[nodiscard]] double turn_rate_radps() const;
  /// The vehicle slows down, or has stopped for an obstacle ahead.
  [[nodiscard]] bool braking() const {
    return decision_.blocked || 0.001 * decision_.drive.speed_mmps < motion_.speed_mps() - braking_mps;
  }
  /// The sensors detect a body on the path, or a virtual body is known there.
  [[nodiscard]] bool finds_body() const {
    return std::min(inputs_.perceived_m, watch_.ahead_m(estimator_)) < std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Status status() const {
    return status_of(
        estimator_.off_path_estimator().manoeuvring() && !motion_.stopped() ? bend_creep_mps : motion_.speed_mps(),
        instructions_.imposed);
  }

 private:
  /// Noise of odometry is below this.
  static constexpr double braking_mps = 0.05;
  void follow_order() { estimator_.follow(order().course_from(estimator_.track_position())); }
  /// The estimated position jumped: the order continues from there, or is dropped.
  void on_relocated();
  /// The decision for a given free distance ahead.
  struct Plan {
    zone::SpeedProfile target_speed;
    Limit limit;
    std::optional<Profile> chosen;  ///< nothing while the vehicle must not drive
  };
  [[nodiscard]] Plan plan(double room_m, double base_end_m) const;
  [[nodiscard]] bool limited_by_virtual(const Plan& plan, double sensed_m, double base_end_m) const;
  [[nodiscard]] wire::Drive drive(double speed_mps, const zone::SpeedProfile& kinematics);
  /// Whether the vehicle is on a path, followed or not.
  [[nodiscard]] bool on_line() const;
  [[nodiscard]] wire::Drive decide_backwards();

  const zone::TrafficZone& zone_;
  std::unique_ptr<SpeedPolicy> speed_policy_;
  PositionEstimator estimator_;
  OrderProgress progress_;
  Envelope envelope_;
  bool one_way_;  ///< the zone has no branches and no turns on the spot
  ObstacleWatch watch_;
  MotionState motion_;
  /// Inputs about the surroundings and the vehicle itself, valid until replaced.
  struct Inputs {
    double perceived_m{std::numeric_limits<double>::infinity()};
    Others others;
    double charge{1.0};
  };
  Inputs inputs_;
  HoldSet holds_;
  Instructions instructions_;
  BackUp back_up_;
  bool joining_{false};  ///< a pose on the path is commanded, and not reached yet
  Decision decision_;
};

}  // namespace cosiva::aiv
