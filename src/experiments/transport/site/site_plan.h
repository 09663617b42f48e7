#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::experiments {

/// Zones and the transfer points between them, by name, as written by a user.
struct SitePlan {
  struct Zone {
    std::string name;  ///< in the site; two zones may use one file
    std::string file;  ///< name of a ready zone, or a file
    std::size_t aivs{12};
    friend bool operator==(const Zone&, const Zone&) = default;
  };
  /// One direction: a vehicle at a station of one zone is placed, some time later, at a station of another.
  struct TransferPoint {
    std::string from_zone;
    std::string from_station;  ///< empty: the zone's first stop
    std::string to_zone;
    std::string to_station;  ///< empty: the zone's second stop, or its only one
    double takes_s{10.0};
    friend bool operator==(const TransferPoint&, const TransferPoint&) = default;
  };
  std::vector<Zone> zones;
  std::vector<TransferPoint> transfer_points;
};

inline constexpr std::size_t site_zones_max = 100'000;

/// From a TOML file of [[zone]] (name, file, aivs) and [[transfer_point]] (from, to: "zone" or "zone/station"; takes_s;
/// bidirectional). Fails ("site.file", "site.value", "site.key") with file, line and what is wrong.
[[nodiscard]] Result<SitePlan> read_site_plan(std::string_view toml, std::string_view origin);

/// Reads "lacet4,indus8" or "8*lacet4,plant1000": a sequence of zones, each joined with the next, and the last with the
/// first, by a transfer point in each direction. Fails ("site.list").
[[nodiscard]] Result<SitePlan> site_plan_of_list(std::string_view list, std::size_t aivs, double takes_s);

}  // namespace cosiva::experiments
