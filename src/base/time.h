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

/// Rounds to the nearest nanosecond, halves away from zero.
[[nodiscard]] constexpr SimDuration from_seconds(double seconds) noexcept {
  return SimDuration{static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5))};
}

/// ISO 8601 in UTC with milliseconds, as required by VDA 5050: 2023-07-11T00:00:00.000Z.
[[nodiscard]] std::string to_iso8601(SimTime time);

/// Reads ISO 8601 in UTC with any number of decimals (2.1 §6.4 shows two, 3.0 three; other systems send zero to nine).
[[nodiscard]] Result<SimTime> parse_iso8601(std::string_view text);

}  // namespace cosiva
