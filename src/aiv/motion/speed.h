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

/// The five states an operator sees (A7).
enum class Status { normal, stopped, slow_speed, medium_speed, fast_speed };
[[nodiscard]] std::string_view to_string(Status status);  ///< "Normal", "stopped", "slow speed", …
/// Stopped when standing (|v| < 1 cm/s); the imposed profile's when one is imposed; else Normal.
[[nodiscard]] Status status_of(double speed_mps, std::optional<Profile> imposed);

/// What the agent perceives when it chooses a speed; distances along its path [m], infinite when there is nothing.
struct Situation {
  double speed_mps;
  double obstacle_ahead_m;         ///< from the vehicle's front to what its sensors see in its corridor
  double end_of_base_m;            ///< to where its right to drive ends
  double crossing_ahead_m;         ///< to the next crossing it may not yet enter
  double charge;                   ///< state of charge, 0…1
  std::optional<Profile> imposed;  ///< an instruction from the operator
  /// How fast the way to what its sensors see shrinks; nothing: not known, so it counts as standing.
  std::optional<double> closing_mps{};
  /// By how much it would be at that crossing before the other one who wants it [s]; below 0: after. Infinite: nobody
  /// else is known to want it.
  double crossing_margin_s{std::numeric_limits<double>::infinity()};
  double crossing_priority{0.0};     ///< its own against the other one's there, −1 lower … 1 higher
  std::optional<Profile> present{};  ///< what it has chosen last; nothing: it stood, or just began
};

/// What those near say (Neighbours), as far as it matters to the next decision.
struct Others {
  double leader_gap_m{std::numeric_limits<double>::infinity()};  ///< from its front to the first of them on its way
  std::optional<double> leader_mps{};                            ///< that one's speed along this one's way
  double crossing_margin_s{std::numeric_limits<double>::infinity()};  ///< as Situation's
  double crossing_priority{0.0};
};

/// Chooses among the profiles, crisp here or fuzzy (agent_rules.h), behind one interface (A10). What it chooses is a
/// wish: the envelope above it may only lower it. It keeps nothing in mind: the same situation, the same choice.
class SpeedPolicy {
 public:
  virtual ~SpeedPolicy() = default;
  [[nodiscard]] virtual Profile choose(const Situation& situation) const = 0;
  /// Whether it makes anything of what others say (closing, margin, priority): who does not is spared the work.
  [[nodiscard]] virtual bool heeds_others() const { return true; }
};
class CrispSpeedPolicy final : public SpeedPolicy {
 public:
  [[nodiscard]] Profile choose(const Situation& situation) const override;
  [[nodiscard]] bool heeds_others() const override { return false; }
};

/// The highest speed from which `braking_mps2` stops within `distance_m`, when braking starts `late_s` late.
/// v·t + v²/(2b) = d. Zero for d ≤ 0.
[[nodiscard]] double stoppable_speed(double distance_m, double braking_mps2, double late_s);

}  // namespace cosiva::aiv
