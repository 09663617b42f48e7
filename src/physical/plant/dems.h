#pragma once

#include <cstddef>
#include <cstdint>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/random.h"
#include "cosiva/physical/boards/line_tracker.h"

namespace cosiva::physical {

/// The emulated sensors of the ground marking (DEMS, A16): the rows of reflectance sensors over a line whose paint is
/// uneven. Only the leading row is read: the one in front, or behind the axle where the vehicle drives backwards.
/// Invariant: a stuck sensor exists in the row.
class Dems {
 public:
  /// @param line_sd_m  unevenness of the line's paint and of its measurement, correlated over 5 cm
  Dems(double line_sd_m, Random random);

  /// The row reads the line, after it has moved by `distance_m`.
  /// @param offset_m  of the line's centre from the row's, left positive
  void read(double offset_m, double distance_m);
  /// No line is under the row.
  void read_nothing();
  [[nodiscard]] const DemsRow& readings() const { return readings_; }

  /// Of the line's lateral position where the body comes onto it.
  [[nodiscard]] double lateral_error_m();
  /// Of the line's heading, as the sensors detect it.
  [[nodiscard]] double heading_error_rad();

  /// From now on this sensor has this reading, whatever is under it; LT_SENSORS: none is stuck.
  void stick(std::size_t sensor, std::uint8_t reading);
  void archive(Archive& archive);  ///< the state, for a restart of the emulation

 private:
  void overlay_fault();

  double line_sd_m_;
  Random random_;
  double unevenness_m_;
  DemsRow exact_{};     ///< what sensors without a fault read
  DemsRow readings_{};  ///< what the sensors read
  std::size_t stuck_{LT_SENSORS};
  std::uint8_t stuck_reading_{0};
};

}  // namespace cosiva::physical
