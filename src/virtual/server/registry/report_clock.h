#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// When a vehicle reports, how often it usually does, and how long a silence means that it is lost. Vehicles choose
/// their own rate, as VDA 5050 lets them.
///
/// Invariant: the usual gap is a mean of the times between reports, in (0 s, gap_max]. on_report() is therefore called
/// once per received message, whatever the message carries: a second call would count a gap of zero.
class ReportClock {
 public:
  /// A longer silence is an absence, and no rate.
  static constexpr SimDuration gap_max{std::chrono::seconds{5}};
  /// A vehicle is lost after so many of its usual gaps.
  static constexpr double gaps_until_lost = 3.0;

  /// A report has arrived.
  /// @param now  not before the last report (checked)
  void on_report(SimTime now);

  /// Arrival of the first report; nothing: none has come.
  [[nodiscard]] std::optional<SimTime> first() const { return first_; }
  /// Arrival of the last report; the epoch before the first one.
  [[nodiscard]] SimTime last() const { return last_; }
  /// Smoothed over some ten gaps. The mean starts as if one gap of gap_max had been seen: the rate of a vehicle that
  /// has hardly reported is not known, and its first messages often come together.
  [[nodiscard]] SimDuration usual_gap() const { return usual_gap_; }
  /// The longest silence that is no loss: three usual gaps, and at least `at_least`.
  [[nodiscard]] SimDuration longest_silence(SimDuration at_least) const;
  /// Reported once, and has been silent for longer than that since.
  [[nodiscard]] bool lost(SimTime now, SimDuration at_least) const {
    return first_ && now - last_ > longest_silence(at_least);
  }

 private:
  std::optional<SimTime> first_;
  SimTime last_{};
  SimDuration usual_gap_{gap_max};
  std::uint32_t gaps_{1};  ///< that the mean is of, up to `gaps_smoothed`
};

}  // namespace cosiva::virtual_side
