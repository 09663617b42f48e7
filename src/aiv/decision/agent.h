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

/// What an agent decided last, and what of it matters to others.
struct Decision {
  wire::Drive drive{};              ///< to the motors
  std::optional<Profile> profile;   ///< nothing while the vehicle must stop
  bool blocked{false};              ///< the protective field is violated: an obstacle keeps the vehicle from going
  bool braking_for_virtual{false};  ///< a body that is only virtual keeps it slower than it would drive without
  bool wants_base{false};           ///< the base ends soon and more is announced (§6.10.3)
  /// To the next crossing that the vehicle may not enter yet; infinite: none is near.
  double crossing_ahead_m{std::numeric_limits<double>::infinity()};
};

/// Decides what a vehicle does (A9, A10), free of wires: readings and instructions in, a drive command out. The vehicle
/// follows its order, keeps its distance, waits at crossings, and stops when told or when it hears nothing any more.
/// The physical vehicle's on-board program and a virtual AIV run this same object. Invariant: while a hold is in force,
/// a cancelOrder is pending or the position is unknown, the command's speed is 0 (a backUp stops for holds, too).
class Agent {
 public:
  /// @param zone     must outlive the agent
  /// @param chooser  the decision that may be fuzzy; the envelope above it is not. Nothing: the crisp rules
  explicit Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedPolicy> speed_policy = nullptr,
                 Lateness late = {});

  // What it perceives.
  void on_odometry(const wire::Odometry& odometry);
  void on_odometry_lost() { motion_.on_odometry_lost(); }  ///< its motors stop by themselves
  PositionEstimator::Fix on_tag(const wire::TagRead& tag);
  void on_ranges(const wire::Ranges& ranges);
  void on_charge(double charge) { inputs_.charge = charge; }
  /// From its front along its way to the first body that is only virtual (PerceivedWorld); infinite: none. It decides
  /// like an echo of the same distance, until the next call.
  void perceive(double gap_m) { inputs_.perceived_m = gap_m; }
  /// What those near say of themselves, until the next call. It is a matter of comfort: where the first body before it
  /// is, its own senses say; whether it may enter a crossing, its order.
  void heed(const Others& others) { inputs_.others = others; }
  [[nodiscard]] bool heeds_others() const { return speed_policy_->heeds_others(); }

  // What it is told.
  /// For those who know better where it is: configuration, memory, boards and tags that changed.
  [[nodiscard]] PositionEstimator& estimator() { return estimator_; }
  /// initPosition: fails ("position.off_circuit") further than 0.25 m from the circuit or looking another way, and
  /// ("position.busy") while an order is active or the vehicle moves.
  [[nodiscard]] Result<void> initialise_position(const Pose2& X_MB, std::string last_node_id);
  /// joinLine: goes onto the line at this pose, which lies along it, with or without an order; until it is there or
  /// another is told. Fails ("join.on_line", "join.busy", "join.too_far", "join.no_line").
  [[nodiscard]] Result<void> join_line(const Pose2& X_MG);
  [[nodiscard]] bool joining() const { return joining_; }
  /// backUp: rolls back along the line, slowly and blindly: whoever tells it has looked behind it. 0 ends it. An order
  /// ends it, too. Fails ("back_up.off_path", "back_up.order", "back_up.distance": not in [0, BackUp::distance_m_max]).
  [[nodiscard]] Result<void> begin_back_up(double distance_m);
  [[nodiscard]] Result<OrderBook::Verdict> take_order(const wire::Order& order);
  void hold(Hold reason, bool on) { holds_.set(reason, on); }
  [[nodiscard]] Instructions& instructions() { return instructions_; }
  /// In another zone from now on, as `before` left off: where the body is, what holds and limits it and which order it
  /// had last stay; the order itself is dropped. Only for one that has stopped.
  void take_over(const Agent& before);

  /// What the motors have to do now. At least every 100 ms: the board's watchdog waits 300 ms.
  [[nodiscard]] wire::Drive decide();

  // What it knows.
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
  /// It slows down, or has stopped for something before it.
  [[nodiscard]] bool braking() const {
    return decision_.blocked || 0.001 * decision_.drive.speed_mmps < motion_.speed_mps() - braking_mps;
  }
  /// Its senses find a body on its way, or it is told of one that is only virtual.
  [[nodiscard]] bool finds_body() const {
    return std::min(inputs_.perceived_m, watch_.ahead_m(estimator_)) < std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Status status() const {
    return status_of(estimator_.manoeuvring() && !motion_.stopped() ? bend_creep_mps : motion_.speed_mps(),
                     instructions_.imposed);
  }

 private:
  /// Odometry jitters by less.
  static constexpr double braking_mps = 0.05;
  void follow_order() { estimator_.follow(order().course_from(estimator_.track_position())); }
  /// The belief jumped: the order goes on from there, or is dropped.
  void on_relocated();
  /// What it would do with so much room before it.
  struct Plan {
    zone::SpeedProfile target_speed;
    Limit limit;
    std::optional<Profile> chosen;  ///< nothing while it must not drive
  };
  [[nodiscard]] Plan plan(double room_m, double base_end_m) const;
  [[nodiscard]] bool limited_by_virtual(const Plan& plan, double sensed_m, double base_end_m) const;
  [[nodiscard]] wire::Drive drive(double speed_mps, const zone::SpeedProfile& kinematics);
  /// A line is under it, followed or not.
  [[nodiscard]] bool on_line() const;
  [[nodiscard]] wire::Drive decide_backwards();

  const zone::TrafficZone& zone_;
  std::unique_ptr<SpeedPolicy> speed_policy_;
  PositionEstimator estimator_;
  OrderProgress progress_;
  Envelope envelope_;
  bool one_way_;  ///< nothing to choose and nothing to turn at in this zone
  ObstacleWatch watch_;
  MotionState motion_;
  /// What it is told of its surroundings and of itself, until told anew.
  struct Inputs {
    double perceived_m{std::numeric_limits<double>::infinity()};
    Others others;
    double charge{1.0};
  };
  Inputs inputs_;
  HoldSet holds_;
  Instructions instructions_;
  BackUp back_up_;
  bool joining_{false};  ///< told where to go onto the line, and not there yet
  Decision decision_;
};

}  // namespace cosiva::aiv
