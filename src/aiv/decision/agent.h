#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/aiv/order/order_book.h"
#include "cosiva/aiv/perception/corridor.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// Why a vehicle stands although its order would let it go. Several may hold at once.
enum class Hold : std::uint8_t {
  paused = 1U << 0U,        ///< startPause
  broker_lost = 1U << 1U,   ///< nothing can be heard from outside
  server_lost = 1U << 2U,   ///< a server it has heard beats no more
  board_lost = 1U << 3U,    ///< it cannot sense or act
  board_faulty = 1U << 4U,  ///< a board that it drives by says that it is broken
  line_lost = 1U << 5U,     ///< nothing to follow under the sensors
  zone_change = 1U << 6U,   ///< another zone is in force as soon as it stands
};
[[nodiscard]] std::string_view to_string(Hold hold);

/// The vehicle's mind (A9, A10), free of wires: readings and instructions in, a drive command out. It follows its
/// order, keeps its distance, waits at crossings, and stops when told or when it hears nothing any more. The physical
/// vehicle's on-board program and a virtual AIV run this same object.
class Agent {
 public:
  /// @param zone     must outlive the agent
  /// @param chooser  the decision that may be fuzzy; the envelope above it is not. Nothing: the crisp rules
  explicit Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedChooser> chooser = nullptr, Lateness late = {});

  // What it perceives.
  void on_odometry(const wire::Odometry& odometry);
  void on_odometry_lost();   ///< nothing more is known of the speed: its motors stop by themselves
  void on_odometer_reset();  ///< the board powered up anew
  PositionEstimator::Fix on_tag(const wire::TagRead& tag);
  void on_ranges(const wire::Ranges& ranges);
  void on_charge(double charge) { charge_ = charge; }
  /// From its front along its way to the first body that is only virtual (FeltWorld); infinite: none. It decides like
  /// an echo of the same distance, until the next call.
  void feel(double gap_m) { felt_m_ = gap_m; }
  /// What those near say of themselves, until the next call. It is a matter of comfort: where the first body before it
  /// is, its own senses say; whether it may enter a crossing, its order.
  void heed(const Others& others) { others_ = others; }
  [[nodiscard]] bool heeds_others() const { return chooser_->heeds_others(); }
  /// The zone's tags or beacons stand elsewhere from now on (the zone is the same object).
  void on_marks_moved() { estimator_.forget_doubt(); }

  // What it is told.
  /// Somebody who knows: configuration or memory.
  void stand_at(zone::Place place);
  void stand_off(const Pose2& X_MB);  ///< likewise a pose, maybe beside the line
  void resume_manoeuvre(const Pose2& X_OB, std::optional<zone::SectionId> next) {
    estimator_.resume_manoeuvre(X_OB, next);
  }
  /// initPosition: fails ("position.off_circuit") further than 0.25 m from the circuit or looking another way, and
  /// ("position.busy") while an order is active or the vehicle moves.
  [[nodiscard]] Result<void> initialise_position(const Pose2& X_MB, std::string last_node_id);
  /// joinLine: goes onto the line at this pose, which lies along it, with or without an order; until it is there or
  /// another is told. Fails ("join.on_line", "join.busy", "join.too_far", "join.no_line").
  [[nodiscard]] Result<void> join_line(const Pose2& X_MG);
  [[nodiscard]] bool joining() const { return joining_; }
  /// backUp: rolls back along the line, slowly and blindly: whoever tells it has looked behind it. 0 ends it. An order
  /// ends it, too. Fails ("back_up.off_line", "back_up.order", "back_up.distance": not in [0, back_up_m_max]).
  [[nodiscard]] Result<void> back_up(double distance_m);
  static constexpr double back_up_m_max = 0.5;
  [[nodiscard]] bool backing_up() const { return back_to_m_.has_value(); }
  /// Of the last backUp, once it is over: it came as far as it was told.
  [[nodiscard]] bool backed_up() const { return backed_up_; }
  [[nodiscard]] Result<OrderBook::Verdict> take_order(const wire::Order& order);
  void hold(Hold reason, bool on);
  void impose(std::optional<Profile> profile) { imposed_ = profile; }
  void limit_speed(std::optional<double> speed_mps) { speed_mps_max_ = speed_mps; }
  /// Brakes; once it stands the order is dropped and cancelling() ends. False: there is no order to cancel.
  [[nodiscard]] bool begin_cancel();
  /// In another zone from now on, as `before` left off: where the body is, what holds and limits it and which order it
  /// had last stay; the order itself is dropped. Only for one that stands.
  void take_over(const Agent& before);

  /// What the motors have to do now. At least every 100 ms: the board's watchdog waits 300 ms.
  [[nodiscard]] wire::Drive decide();

  // What it knows.
  [[nodiscard]] const PositionEstimator& position() const { return estimator_; }
  [[nodiscard]] const OrderBook& order() const { return order_; }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }
  [[nodiscard]] double turn_rate_radps() const;
  [[nodiscard]] bool standing() const { return standing_; }
  [[nodiscard]] bool cancelling() const { return cancelling_; }
  [[nodiscard]] bool holds(Hold reason) const { return (holds_ & static_cast<std::uint8_t>(reason)) != 0; }
  [[nodiscard]] std::uint8_t holds() const { return holds_; }
  /// The protective field is violated: an obstacle keeps the vehicle from going.
  [[nodiscard]] bool blocked() const { return blocked_; }
  /// What it feels keeps it slower than it would drive without.
  [[nodiscard]] bool braking_for_felt() const { return braking_for_felt_; }
  /// What DOBS saw last: the nearest echo in the corridor and which beam brought it, unfiltered.
  [[nodiscard]] const Corridor::Look& look() const { return look_; }
  [[nodiscard]] double look_reach_m() const { return corridor_.reach_m(); }
  /// It slows down, or stands for something before it.
  [[nodiscard]] bool braking() const { return blocked_ || 0.001 * told_.speed_mmps < speed_mps_ - braking_mps; }
  /// Its senses find a body on its way, or it is told of one that is only virtual.
  [[nodiscard]] bool finds_body() const {
    return std::min(felt_m_, obstacle_.obstacle_ahead_m(estimator_.travelled_m())) <
           std::numeric_limits<double>::infinity();
  }
  /// To the next crossing that it may not enter yet, at its last decision; infinite: none is near.
  [[nodiscard]] double crossing_ahead_m() const { return crossing_ahead_m_; }
  /// The base ends soon and more is announced (§6.10.3).
  [[nodiscard]] bool wants_base() const { return wants_base_; }
  [[nodiscard]] std::optional<Profile> imposed() const { return imposed_; }
  [[nodiscard]] std::optional<double> speed_mps_max() const { return speed_mps_max_; }
  [[nodiscard]] Status status() const {
    return status_of(estimator_.manoeuvring() && !standing_ ? bend_creep_mps : speed_mps_, imposed_);
  }
  [[nodiscard]] double charge() const { return charge_; }
  /// Nodes traversed since the last call, in order.
  [[nodiscard]] std::vector<wire::OrderNode> take_traversed();
  /// True once after the belief jumped off the order, which was dropped then.
  [[nodiscard]] bool take_lost_order();

 private:
  /// Odometry jitters by less.
  static constexpr double braking_mps = 0.05;
  void advance_order(double distance_m);
  void follow_order() { estimator_.follow(order_.course_from(estimator_.place())); }
  /// The belief jumped: the order goes on from there, or is dropped.
  void on_relocated();
  void note_motion(const wire::Odometry& odometry);
  /// Driving is asked for and nothing moves: PILS waits at the end of the way that it was told.
  void note_stuck();
  /// Which way at the fork or bend that PILS comes to next.
  [[nodiscard]] std::uint8_t branch() const;
  /// Something stands where its body will be on its way to the line.
  [[nodiscard]] bool in_entry(const wire::Ranges& ranges);
  [[nodiscard]] bool may_sweep(const Limit& limit) const;
  /// What it would do with so much room before it.
  struct Plan {
    zone::SpeedProfile wish;
    Limit limit;
    std::optional<Profile> chosen;  ///< nothing while it must not drive
  };
  [[nodiscard]] Plan plan(double room_m, double base_end_m) const;
  [[nodiscard]] bool limited_by_felt(const Plan& plan, double sensed_m, double base_end_m) const;
  [[nodiscard]] wire::Drive drive(double speed_mps, const zone::SpeedProfile& kinematics);
  /// A line is under it, followed or not.
  [[nodiscard]] bool on_line() const;
  void note_backing_up();
  [[nodiscard]] wire::Drive decide_backwards();

  const zone::TrafficZone& zone_;
  std::unique_ptr<SpeedChooser> chooser_;
  PositionEstimator estimator_;
  OrderBook order_;
  Corridor corridor_;
  ObstacleFilter obstacle_;
  Corridor::Look look_;
  double felt_m_{std::numeric_limits<double>::infinity()};
  Others others_;
  Envelope envelope_;
  EntrySweep sweep_;
  bool one_way_;           ///< nothing to choose and nothing to turn at in this zone
  ObstacleFilter around_;  ///< echoes near the body, whatever its way
  ObstacleFilter entry_;   ///< 0: one on its way to the line

  double speed_mps_{0.0};
  int slow_readings_{2};  ///< in a row under a centimetre per second; it starts standing
  bool standing_{true};
  std::optional<wire::Manoeuvre> manoeuvre_;  ///< as last read
  std::uint32_t manoeuvre_ms_{};
  int still_readings_{0};  ///< in a row in which the manoeuvre did not go on
  double turn_radps_{0.0};
  wire::Drive told_{};  ///< to the motors, last
  int stuck_readings_{0};
  double stuck_travelled_m_{0.0};
  double charge_{1.0};
  std::optional<Profile> chosen_;  ///< what it drives by since the last decision; nothing while it must stand
  std::uint8_t holds_{0};
  std::optional<Profile> imposed_;
  std::optional<double> speed_mps_max_;
  bool cancelling_{false};
  std::optional<double> back_to_m_;  ///< of travelled_m(), while it backs up
  bool backed_up_{false};
  int back_readings_{0};  ///< in which it ought to back up
  bool joining_{false};   ///< told where to go onto the line, and not there yet
  bool blocked_{false};
  bool braking_for_felt_{false};
  bool wants_base_{false};
  bool lost_order_{false};
  double crossing_ahead_m_{std::numeric_limits<double>::infinity()};
  std::vector<wire::OrderNode> traversed_;
};

}  // namespace cosiva::aiv
