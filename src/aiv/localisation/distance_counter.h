#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/base/archive_fwd.h"

namespace cosiva::aiv {

/// The distance that the vehicle has driven, from the readings of a board's odometer that may restart or be damaged.
/// Invariant: no single reading changes the distance by more than the largest possible step.
class DistanceCounter {
 public:
  /// @param step_m_max  a larger step between two readings means that the board counts from zero again
  explicit DistanceCounter(double step_m_max) : step_m_max_{step_m_max} {}

  /// Takes a reading. Returns the distance since the last one [m], forwards positive; 0 for the first reading and where
  /// the step is impossible.
  double count(std::int64_t distance_um);
  /// The board counts from zero again: the next reading is a new origin.
  void restart() { reading_um_.reset(); }
  /// Continues from the distance and the reading of `before`, a counter of the same board.
  void take_over(const DistanceCounter& before);

  /// Total of all steps, forwards positive.
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  /// The last reading; nothing before the first one, and after a restart.
  [[nodiscard]] std::optional<std::int64_t> reading_um() const { return reading_um_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  double step_m_max_;
  double travelled_m_{};
  std::optional<std::int64_t> reading_um_;
};

}  // namespace cosiva::aiv
