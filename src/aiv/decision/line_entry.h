#pragma once

#include <span>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// How a vehicle comes onto a line, and what room that takes. The server asks before it sends one off, the vehicle's
/// own eyes while it goes: both judge by the boards' own manoeuvre.
namespace cosiva::aiv {

/// It turns on the spot, drives straight, turns again (Manoeuvre), `to` being where it is then, along the line.
struct LineEntry {
  Pose2 from;
  Pose2 to;
};
/// What stays free on all sides of a body that goes onto the line; it covers what reports are wrong by.
inline constexpr double entry_clear_m = 0.02;

/// Whether two bodies come nearer to each other than `clear_m`: the first is taken larger by that on all sides.
[[nodiscard]] bool near_bodies(const zone::VehicleShape& shape, const Pose2& X_MA, const Pose2& X_MB, double clear_m);
/// Whether anything of B lies ahead of A's front, be it to the side: what A looks at.
[[nodiscard]] bool lies_ahead(const zone::VehicleShape& shape, const Pose2& X_MA, const Pose2& X_MB);

/// Where the body is all along an entry, in steps in which no corner moves by more than a centimetre.
class EntrySweep {
 public:
  explicit EntrySweep(const zone::VehicleShape& shape) : shape_{shape} {}

  void take(const LineEntry& entry);
  /// Only what is left of it for a body that has come so far, seen from where it began.
  void take_rest(const LineEntry& entry, const Pose2& X_OB);

  /// Whether it comes nearer than `clear_m` to a body that stands at X_MB. Where it is not sure which way round the
  /// vehicle will turn, as it stands almost on the line or with its back to it, both count.
  [[nodiscard]] bool near_body(const Pose2& X_MB, double clear_m = entry_clear_m) const;
  /// Whether it sweeps over a point.
  [[nodiscard]] bool over(Point2 p_M) const;

 private:
  zone::VehicleShape shape_;
  LineEntry entry_;
  bool turns_either_direction_{false};
  std::vector<Pose2> poses_;  ///< kept to spare allocations
};

/// Whether what two of them sweep may touch, whenever they go: half a diagonal about the way of their middles.
[[nodiscard]] bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b);

}  // namespace cosiva::aiv
