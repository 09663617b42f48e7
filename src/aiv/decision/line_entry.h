#pragma once

#include <span>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// How a vehicle joins a path, and what space that takes. The server checks the space before it commands a vehicle to
/// join, and the vehicle's own sensors check it meanwhile: both evaluate the boards' own manoeuvre.
namespace cosiva::aiv {

/// The vehicle turns on the spot, drives straight, and turns again (Manoeuvre); `to` is its final pose, along the path.
struct LineEntry {
  Pose2 from;
  Pose2 to;
};
/// Clearance on all sides of a body that joins the path; it covers the errors of reports.
inline constexpr double entry_clear_m = 0.02;

/// Whether two bodies come nearer to each other than `clear_m`: the first is enlarged by that on all sides.
[[nodiscard]] bool near_bodies(const zone::VehicleShape& shape, const Pose2& X_MA, const Pose2& X_MB, double clear_m);
/// Whether any part of B lies ahead of A's front, even to the side: within the view of A's sensors.
[[nodiscard]] bool lies_ahead(const zone::VehicleShape& shape, const Pose2& X_MA, const Pose2& X_MB);

/// The body's poses during an entry; no corner moves by over 1 cm in a step. Invariant: the last is the final one.
class EntrySweep {
 public:
  explicit EntrySweep(const zone::VehicleShape& shape) : shape_{shape} {}

  void take(const LineEntry& entry);
  /// Only the rest of the entry, for a body that has come as far as X_OB from its start.
  void take_rest(const LineEntry& entry, const Pose2& X_OB);

  /// Whether the entry comes nearer than `clear_m` to a body at X_MB. Where the direction of the vehicle's turn is
  /// uncertain, because the vehicle is almost on the path or has the path behind it, both directions count.
  [[nodiscard]] bool near_body(const Pose2& X_MB, double clear_m = entry_clear_m) const;
  /// Whether the entry sweeps over a point.
  [[nodiscard]] bool over(Point2 p_M) const;

 private:
  zone::VehicleShape shape_;
  LineEntry entry_;
  bool turns_either_direction_{false};
  std::vector<Pose2> poses_;  ///< reused to spare allocations
};

/// Whether the areas that two entries sweep may touch, at any time: half a diagonal about the path of the body origins.
[[nodiscard]] bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b);

}  // namespace cosiva::aiv
