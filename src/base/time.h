#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva {

/// Time of the core: nanoseconds since 1970-01-01T00:00:00Z, always supplied by the shell. A live shell supplies the
/// wall clock, the virtual-time shell the time of its event queue.
struct SimClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<SimClock>;
  static constexpr bool is_steady = true;
  static time_point now() = delete;
};

using SimTime = SimClock::time_point;
using SimDuration = SimClock::duration;

/// Start of virtual time: 2023-07-11T00:00:00Z, the day the article appeared.
inline constexpr SimTime virtual_epoch{std::chrono::seconds{1'689'033'600}};

[[nodiscard]] constexpr double to_seconds(SimDuration duration) noexcept {
  return static_cast<double>(duration.count()) * 1e-9;
}

/// Milliseconds, to the nearest double.
[[nodiscard]] constexpr double to_milliseconds(SimDuration duration) noexcept {
  return static_cast<double>(duration.count()) / 1e6;
}
/// Milliseconds as the server's JSON members have them: multiplied, so that the last bit may differ from
/// to_milliseconds(), and a recorded text with it.
[[nodiscard]] constexpr double to_milliseconds_scaled(SimDuration duration) noexcept {
  return static_cast<double>(duration.count()) * 1e-6;
}
[[nodiscard]] constexpr double to_milliseconds_scaled(SimTime time) noexcept {
  return to_milliseconds_scaled(time.time_since_epoch());
}
/// Milliseconds as the options and the metrics of latencies have them: by way of seconds, with a last bit of its own.
[[nodiscard]] constexpr double to_milliseconds_by_seconds(SimDuration duration) noexcept {
  return to_seconds(duration) * 1e3;
}

/// Rounds to the nearest nanosecond, halves away from zero.
[[nodiscard]] constexpr SimDuration from_seconds(double seconds) noexcept {
  return SimDuration{static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5))};
}

/// ISO 8601 in UTC with milliseconds, as required by VDA 5050: 2023-07-11T00:00:00.000Z.
[[nodiscard]] std::string to_iso8601(SimTime time);

/// Reads ISO 8601 in UTC with any number of decimals (2.1 §6.4 shows two, 3.0 three; other systems send zero to nine).
[[nodiscard]] Result<SimTime> parse_iso8601(std::string_view text);

}  // namespace cosiva
