#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// What a vehicle is expected to do next: the decision that its agent's own rules make from what the server knows.
struct Expectation {
  zone::SpeedProfile target;  ///< of the profile chosen; speed 0: it stops
  double end_m{
      std::numeric_limits<double>::infinity()};  ///< along its path, to where it must stop: the end of its base
  /// From the vehicle's front to the rear of the vehicle ahead; infinite: there is none near.
  double leader_gap_m{std::numeric_limits<double>::infinity()};
  double leader_mps{0.0};
  /// Its acceleration up to the report. The vehicle may see more than the server: while it does not accelerate although
  /// nothing that the server knows of prevents it, it is not expected to.
  double trend_mps2{std::numeric_limits<double>::infinity()};
};

/// The motion that is expected of a vehicle after a report (A27): speed and distance as its own envelope and its motors
/// limit them, towards the expected speed. Computed once for a report, so that every query is a table's value.
///
/// Invariant: the distance never decreases, and it never exceeds the larger of 0 and the expectation's end_m.
class Anticipation {
 public:
  static constexpr double step_s = 0.05;
  static constexpr std::size_t steps = 20;

  /// At standstill.
  Anticipation() = default;
  /// @param speed_mps  at the time of the report, along the path, not negative (checked)
  Anticipation(double speed_mps, const Expectation& expected);

  /// Distance along the path since the report [m]. Beyond `steps` the last speed continues.
  /// @param since_s  not negative (checked)
  [[nodiscard]] double distance_m(double since_s) const;
  [[nodiscard]] double speed_mps(double since_s) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::array<double, steps + 1> distance_m_{};
  std::array<double, steps + 1> speed_mps_{};
  double end_m_{std::numeric_limits<double>::infinity()};
};

}  // namespace cosiva::virtual_side
