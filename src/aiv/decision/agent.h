#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/vehicle_state.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/archive_fwd.h"
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

/// Decides what a vehicle does (A9, A10), without I/O: from its state and instructions, a drive command. The vehicle
/// follows its order, keeps its distance, waits at crossings, and stops on command or when its links are lost. The
/// physical vehicle's on-board program and a virtual AIV run this same class. Invariant: while a hold is in force, a
/// cancelOrder is pending or the position is unknown, the command's speed is 0 (a backUp stops for holds, too).
class Agent {
 public:
  /// @param zone          must outlive the agent
  /// @param speed_policy  the decision that may be fuzzy; the envelope above it is not. Null: the crisp rules
  /// @param catalogue     the actions of orders that the vehicle performs
  explicit Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedPolicy> speed_policy = nullptr, Lateness late = {},
                 ActionCatalogue catalogue = {});

  [[nodiscard]] const zone::TrafficZone& zone() const { return zone_; }

  // What the agent decides on.
  [[nodiscard]] VehicleState& vehicle() { return vehicle_; }
  [[nodiscard]] const VehicleState& vehicle() const { return vehicle_; }
  void on_odometry(const wire::Odometry& odometry);
  void on_charge(double charge) { inputs_.charge = charge; }
  /// Distance from the vehicle's front along its path to the first virtual body (PerceivedWorld); infinite: none. The
  /// body has the effect of an echo at the same distance, until the next call.
  void perceive(double gap_m) { inputs_.perceived_m = gap_m; }
  /// What vehicles nearby report, until the next call. These reports only make driving smoother: the vehicle's own
  /// sensors determine the distance to the first body ahead, and its order determines whether it may enter a crossing.
  void heed(const Others& others) { inputs_.others = others; }
  /// Along the path to the first crossing that the vehicles nearby have not left to this vehicle yet; infinite: none,
  /// or the server alone decides. Until the next call.
  void stop_before_crossing(double barrier_m) { barrier_m_ = barrier_m; }
  [[nodiscard]] bool heeds_others() const { return speed_policy_->heeds_others(); }
  [[nodiscard]] Instructions& instructions() { return instructions_; }
  [[nodiscard]] const Instructions& instructions() const { return instructions_; }
  [[nodiscard]] double charge() const { return inputs_.charge; }
  /// In another zone from now on, in succession of the agent `before`, with its charge, its instructions and its
  /// vehicle's state (VehicleState::take_over()). Only for a vehicle that has stopped.
  void take_over(const Agent& before);

  /// The present command to the motors. Required at least every 100 ms: the board's watchdog waits 300 ms.
  [[nodiscard]] wire::Drive decide();

  // The decision.
  [[nodiscard]] const Decision& decision() const { return decision_; }
  /// The vehicle slows down, or has stopped for an obstacle ahead.
  [[nodiscard]] bool braking() const {
    return decision_.blocked || 0.001 * decision_.drive.speed_mmps < vehicle_.motion().speed_mps() - braking_mps;
  }
  /// The sensors detect a body on the path, or a virtual body is known there.
  [[nodiscard]] bool finds_body() const {
    return std::min(inputs_.perceived_m, vehicle_.watch().ahead_m(vehicle_.position())) <
           std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Status status() const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// Noise of odometry is below this.
  static constexpr double braking_mps = 0.05;
  /// The decision for a given free distance ahead.
  struct Plan {
    zone::SpeedProfile target_speed;
    Limit limit;
    std::optional<Profile> chosen;  ///< nothing while the vehicle must not drive
  };
  [[nodiscard]] Plan plan(double room_m, double base_end_m) const;
  [[nodiscard]] bool limited_by_virtual(const Plan& plan, double sensed_m, double base_end_m) const;
  /// @param room_m  within which, and the stopping accuracy, the vehicle must stop, whether or not another command
  /// follows
  [[nodiscard]] wire::Drive drive(double speed_mps, const zone::SpeedProfile& kinematics,
                                  double room_m = std::numeric_limits<double>::infinity());
  [[nodiscard]] wire::Drive decide_backwards();

  const zone::TrafficZone& zone_;
  std::unique_ptr<SpeedPolicy> speed_policy_;
  Envelope envelope_;
  bool one_way_;  ///< the zone has no branches and no turns on the spot
  VehicleState vehicle_;
  /// Inputs about the surroundings and the battery, valid until replaced.
  struct Inputs {
    double perceived_m{std::numeric_limits<double>::infinity()};
    Others others;
    double charge{1.0};
  };
  Inputs inputs_;
  double barrier_m_{std::numeric_limits<double>::infinity()};
  Instructions instructions_;
  Decision decision_;
};

}  // namespace cosiva::aiv
