#pragma once

#include <cstddef>

#include <optional>

#include "cosiva/base/pose.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/circuit/circuit.h"

/// How a body leaves the line: the boards of a physical vehicle and those of a virtual one do it alike.
namespace cosiva::aiv {

/// What a Drive's branch means at the end of a section.
struct Onward {
  zone::SectionId section{zone::no_section};  ///< none: stop there
  double turn_rad{};                          ///< on the spot before it goes on, left positive; 0: it rolls on
};
/// @param branch  the n-th successor, beyond the last: the last; wire::no_branch: stop at a fork or a sharp bend
[[nodiscard]] Onward onward(const zone::Circuit& circuit, zone::SectionId from, std::size_t branch);

/// What a body on the spot and off its line can do.
struct ManoeuvreRates {
  double turn_radps{1.5};
  double turn_radps2{3.0};
  double speed_mps{0.15};
  double speed_mps2{0.5};
};
/// So long a manoeuvre lasts at least, so that nobody who listens misses it.
inline constexpr double manoeuvre_s_min = 0.1;
/// So long after its last command an unfinished manoeuvre is given up, if the floor is another by then.
inline constexpr double manoeuvre_abandoned_s = 0.3;
/// So far off a vehicle looks for a line, and so much it may be turned from one to be on it already.
inline constexpr double seek_within_m = 0.35;
inline constexpr double on_line_rad = 0.5;

/// A line that it was told of lies this near to where it was told, or there is none.
inline constexpr double goal_within_m = 0.10;

/// Where a body at X_MB that seeks comes onto the line: the nearest place (zone::snap_to_path), or the one that it was
/// told of (wire::Drive::goal). Nothing: no line is there.
[[nodiscard]] std::optional<zone::TrackPosition> sought(const zone::Circuit& circuit, const Pose2& X_MB,
                                                        const std::optional<wire::Manoeuvre>& goal);
/// Told of a goal this near to where it stands, a body only turns to its heading: what is left aside the steering takes
/// away. Nothing sweeps about where somebody stands along the line already, nor turns past the line and back; the
/// server (OrderManager::off_path, follow_line) counts on both.
inline constexpr double stays_within_m = 0.006;
/// Whether it was told to come onto the line just where it stands.
[[nodiscard]] bool to_stay(const wire::Manoeuvre& goal);
/// As boards tell it, rounded to millimetres and milliradians.
[[nodiscard]] wire::Manoeuvre to_manoeuvre(const Pose2& X_AB);
[[nodiscard]] Pose2 to_pose(const wire::Manoeuvre& manoeuvre);

/// Turn on the spot, go straight, turn on the spot: the plainest way of a differential drive from one pose to another.
/// Each leg speeds up and brakes at a constant rate, and ends exactly where it should.
class Manoeuvre {
 public:
  /// @param X_SG  the goal, seen from where the body stands. One nearer than half a millimetre is not driven to: then
  ///              there is one turn, by the goal's heading.
  explicit Manoeuvre(const Pose2& X_SG, const ManoeuvreRates& rates = {});

  /// What the wheels did in a step: never both.
  struct Step {
    double turned_rad{};
    double moved_m{};
  };
  /// @param speed_mps  commanded; the straight leg is no faster. 0 or less: it comes to rest where it is
  Step step(double speed_mps, double dt_s);

  /// Where the body is, seen from where it stood at first.
  // NOLINTNEXTLINE(readability-identifier-naming): frames are written so everywhere
  [[nodiscard]] const Pose2& X_SB() const { return X_SB_; }
  [[nodiscard]] bool done() const { return leg_ == legs && lasted_s_ >= manoeuvre_s_min; }
  /// At rest somewhere on the way, and nobody has commanded it for manoeuvre_abandoned_s.
  [[nodiscard]] bool abandoned() const { return rate_ == 0.0 && uncommanded_s_ >= manoeuvre_abandoned_s; }
  /// Of the straight leg.
  [[nodiscard]] double speed_mps() const { return leg_ == 1 ? rate_ : 0.0; }

 private:
  static constexpr int legs = 3;

  ManoeuvreRates rates_;
  Pose2 X_SG_;
  Pose2 X_SB_;
  double left_[legs];  ///< of each leg [rad, m, rad], positive
  double sign_[legs];
  int leg_{0};
  double rate_{0.0};  ///< of the present leg [rad/s or m/s], ≥ 0
  double lasted_s_{0.0};
  double uncommanded_s_{0.0};
};

}  // namespace cosiva::aiv
