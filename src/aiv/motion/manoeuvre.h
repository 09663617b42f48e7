#pragma once

#include <cstddef>

#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/circuit/circuit.h"

/// How a body leaves the path; the boards of physical and of virtual vehicles do so in the same manner.
namespace cosiva::aiv {

/// Meaning of a Drive's branch at the end of a section.
struct Onward {
  zone::SectionId section{zone::no_section};  ///< none: stop there
  double turn_rad{};                          ///< on the spot before the body continues, left positive; 0: no turn
};
/// @param branch  the n-th successor, beyond the last: the last; wire::no_branch: stop at a fork or a sharp bend
[[nodiscard]] Onward onward(const zone::Circuit& circuit, zone::SectionId from, std::size_t branch);

/// Limits of a body that turns on the spot or drives off its path.
struct ManoeuvreRates {
  double turn_radps{1.5};
  double turn_radps2{3.0};
  double speed_mps{0.15};
  double speed_mps2{0.5};
};
/// Minimum duration of a manoeuvre, so that no receiver of odometry misses the manoeuvre.
inline constexpr double manoeuvre_s_min = 0.1;
/// An unfinished manoeuvre is abandoned this long after its last command, if the floor has been replaced by then.
inline constexpr double manoeuvre_abandoned_s = 0.3;
/// Largest distance at which a vehicle seeks a path, and largest heading error of a vehicle that is already on a path.
inline constexpr double seek_within_m = 0.35;
inline constexpr double on_line_rad = 0.5;

/// Largest distance between a commanded goal and the path; beyond this distance there is no path at the goal.
inline constexpr double goal_within_m = 0.10;

/// Where a body at X_MB that seeks joins the path: the nearest position (zone::snap_to_path), or the commanded one
/// (wire::Drive::goal). Nothing: there is no path.
[[nodiscard]] std::optional<zone::TrackPosition> sought(const zone::Circuit& circuit, const Pose2& X_MB,
                                                        const std::optional<wire::Manoeuvre>& goal);
/// A body that is commanded to a goal this near only turns to the goal's heading; the steering removes the remaining
/// lateral offset. A body that is already stopped along the path therefore neither sweeps the floor around its pose nor
/// turns past the path and back; the server (PathPositions::is_off_path, follow_line) relies on both.
inline constexpr double stays_within_m = 0.006;
/// Whether the commanded goal is where the body already is.
[[nodiscard]] bool to_stay(const wire::Manoeuvre& goal);
/// As represented by the boards, rounded to millimetres and milliradians.
[[nodiscard]] wire::Manoeuvre to_manoeuvre(const Pose2& X_AB);
[[nodiscard]] Pose2 to_pose(const wire::Manoeuvre& manoeuvre);

/// Turn on the spot, drive straight, turn on the spot: the simplest manoeuvre of a differential drive from one pose to
/// another. Legs accelerate and brake at constant rates. Invariant: each ends exactly at its target, never beyond.
class Manoeuvre {
 public:
  Manoeuvre() : Manoeuvre{Pose2{}} {}
  /// @param X_SG  the goal in the frame of the start pose. The body does not drive to a goal nearer than half a
  ///              millimetre: the manoeuvre is then one turn, by the goal's heading.
  explicit Manoeuvre(const Pose2& X_SG, const ManoeuvreRates& rates = {});

  /// Motion of the wheels in one step: a turn or a distance, never both.
  struct Step {
    double turned_rad{};
    double moved_m{};
  };
  /// @param speed_mps  commanded; the straight leg is no faster. 0 or less: the body stops where it is
  Step step(double speed_mps, double dt_s);

  /// Pose of the body in the frame of the start pose.
  // NOLINTNEXTLINE(readability-identifier-naming): frames are written so everywhere
  [[nodiscard]] const Pose2& X_SB() const { return X_SB_; }
  [[nodiscard]] bool done() const { return leg_ == legs && lasted_s_ >= manoeuvre_s_min; }
  /// Stopped before the goal, and without a command for manoeuvre_abandoned_s.
  [[nodiscard]] bool abandoned() const { return rate_ == 0.0 && uncommanded_s_ >= manoeuvre_abandoned_s; }
  /// Of the straight leg.
  [[nodiscard]] double speed_mps() const { return leg_ == 1 ? rate_ : 0.0; }
  void archive(Archive& archive);  ///< the state, for a snapshot

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
