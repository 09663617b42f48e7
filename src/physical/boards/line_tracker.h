#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/line_tracking/line_tracking.h"

namespace cosiva::physical {

/// The names of the line-tracking algorithms; the first is the usual one.
[[nodiscard]] std::vector<std::string> line_tracking_names();

/// The readings of one row of DEMS, from right to left in the direction of travel; 0: floor … 255: marking.
using DemsRow = std::array<std::uint8_t, LT_SENSORS>;

/// The geometry of the emulated vehicle's rows: one before the axle, and one as far behind it for driving backwards.
inline constexpr lt_geometry dems_geometry{8'000, 60'000, 19'000};
inline constexpr double dems_row_m = 1e-6 * dems_geometry.row_um;

/// Line tracking by PILS (A16): runs one of the algorithms of physical/line_tracking, 50 times a second, on the
/// readings of DEMS and the speed of the wheels. Invariant: the time since the last step is shorter than a cycle.
class LineTracker {
 public:
  static constexpr std::int32_t cycle_us = 20'000;

  /// @param algorithm  one of line_tracking_names() (checked)
  explicit LineTracker(std::string_view algorithm);

  /// Time passes while the vehicle drives in this direction.
  /// @return  the time since the last step [s], if the next step is due now; 0: it is not
  [[nodiscard]] double pass(double dt_s, bool forwards);
  /// One step, with the readings of the leading row. Only when pass() has reported that it is
  /// due (checked).
  void step(const DemsRow& readings, double speed_mps);
  /// The vehicle has been off its line, and starts on one.
  void restart();

  /// What PMOT has to drive, left positive in the direction of travel.
  [[nodiscard]] double curvature_per_m() const { return 1e-3 * out_.curvature_per_km; }
  /// As measured last: the line's offset from the row's centre, left positive in the direction of travel.
  [[nodiscard]] double offset_m() const { return 1e-6 * out_.offset_um; }
  [[nodiscard]] bool line_lost() const { return out_.line_lost != 0; }
  /// For 0.1 s no marking could give the readings: a sensor is stuck.
  [[nodiscard]] bool implausible() const { return implausible_steps_ >= implausible_steps_max; }
  [[nodiscard]] std::string_view algorithm() const { return algorithm_->name; }

 private:
  static constexpr int implausible_steps_max = 5;

  const lt_algorithm* algorithm_;
  lt_state state_{};
  lt_output out_{};
  std::int32_t since_us_{0};
  std::int32_t due_us_{0};  ///< the time that the step is for; 0: none is due
  int implausible_steps_{0};
  bool forwards_{true};
};

}  // namespace cosiva::physical
