#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"

namespace cosiva::experiments {

/// The metrics of a site's run, the same on every rank.
struct SiteMetrics {
  struct Zone {
    std::string name;
    std::size_t aivs{};  ///< in the zone at the end
    std::size_t jobs_due{};
    std::size_t jobs_done{};
    std::size_t came{};  ///< vehicles from other zones
    std::size_t left{};
    double distance_m{};
    double waiting_ratio{};
    double energy_wh{};
    std::uint64_t near_misses{};
    std::uint64_t collisions{};
    std::size_t stuck{};
    std::uint64_t digest{};
  };
  std::vector<Zone> zones;
  std::size_t aivs{};         ///< in all zones
  std::size_t in_transfer{};  ///< between two zones, at the end
  std::uint64_t vehicle_steps{};
  std::string digest;  ///< of all zones; does not depend on ranks and workers

  [[nodiscard]] bool good() const;
  /// The sums over all zones: jobs, transfers, distance, energy, near misses, collisions, vehicles stuck.
  [[nodiscard]] Zone total() const;
};

/// One JSON object: the totals, and "zones" with one object for each.
void write_json(JsonWriter& json, const SiteMetrics& metrics);
/// A short text for a terminal.
[[nodiscard]] std::string to_text(const SiteMetrics& metrics);

}  // namespace cosiva::experiments
