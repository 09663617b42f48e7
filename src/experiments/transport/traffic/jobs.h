#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// The load stays in its zone.
inline constexpr std::uint32_t no_exit = std::numeric_limits<std::uint32_t>::max();

/// A load to be carried from one station to another.
struct Job {
  double due_s{};               ///< since the start: not served before
  std::size_t from{};           ///< of zone.stations
  std::size_t to{};             ///< likewise; one with an exit: of the next zone's
  std::int32_t priority{0};     ///< 0…999, higher first
  std::uint32_t exit{no_exit};  ///< through which the load leaves the zone
  friend bool operator==(const Job&, const Job&) = default;
};

/// The stations where vehicles stop for loads, by index.
[[nodiscard]] std::vector<std::size_t> stops_of(const zone::TrafficZone& zone);

/// Random jobs: on average `per_hour`, as a Poisson process, between any two different stations that are stops. The
/// same seed gives the same jobs on every machine. Fails ("jobs.stations") on a zone with fewer than two stops,
/// ("jobs.rate") on a rate that is not positive or makes over ten million jobs.
[[nodiscard]] Result<std::vector<Job>> poisson_jobs(const zone::TrafficZone& zone, double per_hour, double duration_s,
                                                    std::uint64_t seed);

/// Reads a CSV file with a first line that names its columns: time_s, from, to and, if wanted, priority, in any order;
/// stations by name. The result is sorted by time. Fails ("jobs.csv") with the line and its error.
[[nodiscard]] Result<std::vector<Job>> jobs_from_csv(const zone::TrafficZone& zone, std::string_view csv,
                                                     std::string_view origin);

}  // namespace cosiva::experiments
