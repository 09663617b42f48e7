#pragma once

#include <limits>
#include <optional>
#include <string_view>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

enum class Profile { stop, slow, medium, fast };
[[nodiscard]] std::string_view to_string(Profile profile);
[[nodiscard]] std::optional<Profile> parse_profile(std::string_view word);
/// Speed, acceleration and braking of a profile; stop has speed 0 and the medium profile's braking.
[[nodiscard]] zone::SpeedProfile kinematics(const zone::SpeedProfiles& profiles, Profile profile);

/// The five states that an operator is shown (A7).
enum class Status { normal, stopped, slow_speed, medium_speed, fast_speed };
[[nodiscard]] std::string_view to_string(Status status);  ///< "Normal", "stopped", "slow speed", …
/// Stopped at standstill (|v| < 1 cm/s); the imposed profile's status when a profile is imposed; otherwise Normal.
[[nodiscard]] Status status_of(double speed_mps, std::optional<Profile> imposed);

/// The input of the agent's choice of a speed; distances along the path [m], infinite when there is no such object.
struct Situation {
  double speed_mps;
  double obstacle_ahead_m;         ///< from the vehicle's front to the obstacle detected in the corridor
  double end_of_base_m;            ///< to the end of the released part of the order
  double crossing_ahead_m;         ///< to the next crossing that the vehicle may not enter yet
  double charge;                   ///< state of charge, 0…1
  std::optional<Profile> imposed;  ///< an instruction from the operator
  /// Rate at which the distance to the detected obstacle shrinks; nothing: not known, so the obstacle counts as
  /// stopped.
  std::optional<double> closing_mps{};
  /// Time by which the vehicle would reach that crossing before the other vehicle that requests it [s]; below 0: after
  /// that vehicle. Infinite: no other vehicle is known to request the crossing.
  double crossing_margin_s{std::numeric_limits<double>::infinity()};
  double crossing_priority{0.0};  ///< own priority against the other vehicle's there, −1 lower … 1 higher
  /// To the end of the base, where more of the order is announced: the vehicle may have to wait there until it is
  /// released. Infinite: the order ends there.
  double release_distance_m{std::numeric_limits<double>::infinity()};
  /// From the exit of the last crossing; 0 in a crossing, infinite where none is near.
  double passed_m{std::numeric_limits<double>::infinity()};
  std::optional<Profile> present{};  ///< the last choice; nothing: the vehicle was stopped or has just started
};

/// What vehicles nearby report (Neighbours), as far as it matters to the next decision.
struct Others {
  double leader_gap_m{std::numeric_limits<double>::infinity()};  ///< from the vehicle's front to the first of them on
                                                                 ///< its path
  std::optional<double> leader_mps{};                            ///< that vehicle's speed along this vehicle's path
  double crossing_margin_s{std::numeric_limits<double>::infinity()};  ///< as in Situation
  double crossing_priority{0.0};
};

/// The target of a speed policy.
struct SpeedChoice {
  Profile profile;
  double ratio{1.0};  ///< of that profile's speed, in (0, 1]; less than 1 with the slow profile only: creeping
};

/// Chooses among the profiles, crisp here or fuzzy (agent_rules.h), behind one interface (A10). The choice is a target,
/// which the envelope may only lower. The policy has no state: equal situations give equal choices.
class SpeedPolicy {
 public:
  virtual ~SpeedPolicy() = default;
  [[nodiscard]] virtual SpeedChoice target(const Situation& situation) const = 0;
  [[nodiscard]] Profile choose(const Situation& situation) const { return target(situation).profile; }
  /// Whether the policy uses reports of other vehicles (closing, margin, priority); false saves the agent the
  /// evaluation.
  [[nodiscard]] virtual bool heeds_others() const { return true; }
};
class CrispSpeedPolicy final : public SpeedPolicy {
 public:
  [[nodiscard]] SpeedChoice target(const Situation& situation) const override;
  [[nodiscard]] bool heeds_others() const override { return false; }
};

/// The highest speed from which `braking_mps2` stops within `distance_m`, when braking starts `late_s` late.
/// v·t + v²/(2b) = d. Zero for d ≤ 0.
[[nodiscard]] double stoppable_speed(double distance_m, double braking_mps2, double late_s);

}  // namespace cosiva::aiv
