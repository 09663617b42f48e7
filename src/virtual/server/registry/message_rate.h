#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// Limits the rate of the messages of one vehicle, so that a vehicle that floods the server delays no other. The limit
/// is a generous multiple of the rate that is usual for the vehicle, or that its factsheet announces, and never above
/// the largest rate that the server's options permit. While neither rate is known, the limit is that largest rate.
///
/// Invariant: in any time of length t at most (burst + t) · limit messages are accepted, and a message that is not
/// accepted never raises the limit.
class MessageRate {
 public:
  /// Multiple of the usual rate that is accepted: events such as tags and obstacles cause additional messages.
  static constexpr double usual_multiple = 5.0;
  /// Accepted of every vehicle, unless the options permit less [1/s].
  static constexpr double per_s_min = 100.0;
  /// The usual rate is measured over windows of this length.
  static constexpr SimDuration window{std::chrono::seconds{10}};
  /// Messages that were delayed arrive together: so many seconds' worth of them are accepted at once.
  static constexpr SimDuration burst{std::chrono::seconds{2}};
  /// A flood is over after this time without a message above the limit.
  static constexpr SimDuration calm_after{std::chrono::seconds{10}};

  enum class Decision : std::uint8_t {
    accepted,
    flood_begins,  ///< not accepted: the first one of a flood
    dropped,       ///< not accepted
  };
  /// A message has arrived.
  /// @param now        not before the last message (checked)
  /// @param per_s_max  the largest rate that is accepted of any vehicle [1/s]; 0: unlimited
  Decision on_message(SimTime now, double per_s_max);
  /// The factsheet announces this rate of states and positions [1/s]; 0: none.
  void on_announced(double per_s) { announced_per_s_ = per_s; }

  /// Messages per second that are accepted [1/s].
  [[nodiscard]] double limit_per_s(double per_s_max) const;
  void archive(Archive& archive);  ///< the state, for a snapshot
  [[nodiscard]] bool flooding(SimTime now) const { return dropped_at_ && now - *dropped_at_ <= calm_after; }

 private:
  void measure(SimTime now);

  double announced_per_s_{0.0};
  std::optional<double> usual_per_s_;  ///< mean of windows without a flood
  std::optional<SimTime> window_began_;
  std::uint32_t in_window_{0};
  double tokens_{0.0};  ///< messages that would be accepted at once
  SimTime refilled_at_{};
  std::optional<SimTime> dropped_at_;
};

}  // namespace cosiva::virtual_side
