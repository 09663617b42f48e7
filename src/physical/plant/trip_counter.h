#pragma once

#include <cstdint>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::physical {

/// What a vehicle has driven along sections, and how long it had to wait; motion in manoeuvres is not counted as
/// driven. Invariant: no wait was longer than the longest one.
class TripCounter {
 public:
  /// @param loop_length_m  of the floor's one loop; 0: the floor forms no loop
  explicit TripCounter(double loop_length_m) : loop_length_m_{loop_length_m} {}

  /// The vehicle has driven this far, in either direction.
  void add(double moved_m);
  /// The vehicle is on another floor from now on.
  void begin_floor(double loop_length_m);
  void on_moving();
  /// The vehicle is stopped; counts from its first motion on.
  void on_waiting(SimDuration dt);

  [[nodiscard]] double distance_m() const { return distance_m_; }
  /// Complete laps, on floors that form one loop.
  [[nodiscard]] std::uint32_t laps() const;
  [[nodiscard]] double longest_wait_s() const { return to_seconds(longest_wait_); }
  void archive(Archive& archive);  ///< the state, for a restart of the emulation

 private:
  double loop_length_m_;
  double distance_m_{0.0};
  double distance_before_m_{0.0};  ///< on the previous floors
  std::uint32_t laps_before_{0};
  bool has_moved_{false};
  SimDuration wait_{};
  SimDuration longest_wait_{};
};

}  // namespace cosiva::physical
