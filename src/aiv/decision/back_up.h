#pragma once

#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// One backUp: the vehicle drives backwards along the path, slowly and without sensing; the sender of the action has
/// checked the floor behind the vehicle. Invariant: while the backUp is active its end lies no further back than
/// distance_m_max.
class BackUp {
 public:
  static constexpr double distance_m_max = 0.5;

  /// @param distance_m   in (0, distance_m_max]
  /// @param travelled_m  the vehicle's own odometer, now
  void begin(double distance_m, double travelled_m);
  void end() { end_at_m_.reset(); }
  /// After a reading: ends the backUp at its end, off the path, or when it takes too long.
  void on_odometry(double travelled_m, bool on_line);

  [[nodiscard]] bool active() const { return end_at_m_.has_value(); }
  [[nodiscard]] bool completed() const { return completed_; }  ///< the last backUp reached its commanded end
  /// The speed, ≥ 0, from which the vehicle still stops at the end: v = √(2bs), at most 0.1 m/s. Only while active.
  [[nodiscard]] double speed_mps(const zone::SpeedProfile& slow, double travelled_m) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<double> end_at_m_;  ///< of the vehicle's own odometer, while active
  bool completed_{false};
  int readings_{0};  ///< since it began
};

}  // namespace cosiva::aiv
