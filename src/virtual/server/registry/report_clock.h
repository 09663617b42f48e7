#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// Times of a vehicle's reports, their usual interval, and the time without a report after which the vehicle is lost.
/// Each vehicle chooses its own rate, as VDA 5050 permits.
///
/// Invariant: the usual gap is a mean of the times between reports, in (0 s, gap_max]. on_report() is therefore called
/// once per received message, whatever the message carries: a second call would count a gap of zero. What the last
/// report describes is not later than its arrival, and never goes back.
class ReportClock {
 public:
  /// A longer gap is an absence and does not count for the rate.
  static constexpr SimDuration gap_max{std::chrono::seconds{5}};
  /// A vehicle is lost after this number of usual gaps.
  static constexpr double gaps_until_lost = 3.0;

  /// A report has arrived.
  /// @param now          not before the last report (checked)
  /// @param reported_at  when the vehicle measured what it reports, on the server's clock: not after `now` (checked)
  void on_report(SimTime now, SimTime reported_at);

  /// Arrival of the first report; nothing: no report has arrived.
  [[nodiscard]] std::optional<SimTime> first() const { return first_; }
  /// Arrival of the last report; the epoch before the first one.
  [[nodiscard]] SimTime last() const { return last_; }
  /// Reference for the age of what is known of the vehicle: the newest time that a report describes.
  [[nodiscard]] SimTime reported_at() const { return reported_at_; }
  /// Smoothed over about ten gaps. The mean starts as if one gap of gap_max had been observed: the rate of a vehicle
  /// with few reports is unknown, and its first messages often arrive together.
  [[nodiscard]] SimDuration usual_gap() const { return usual_gap_; }
  /// The longest time without a report that is not yet a loss: three usual gaps, and at least `at_least`.
  [[nodiscard]] SimDuration longest_silence(SimDuration at_least) const;
  /// The vehicle has reported, and the time since its last report is longer than longest_silence().
  [[nodiscard]] bool lost(SimTime now, SimDuration at_least) const {
    return first_ && now - last_ > longest_silence(at_least);
  }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<SimTime> first_;
  SimTime last_{};
  SimTime reported_at_{};
  SimDuration usual_gap_{gap_max};
  std::uint32_t gaps_{1};  ///< number of gaps in the mean, up to `gaps_smoothed`
};

}  // namespace cosiva::virtual_side
