#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/layout/waypoints.h"

namespace cosiva::zone {

/// Of vehicles without a description.
inline constexpr SpeedProfiles default_profiles{{0.15, 0.3, 0.6}, {0.30, 0.5, 0.8}, {0.50, 0.8, 1.0}};

/// The content of the sidecar file that is read before the geometry. Missing values: the defaults.
struct Sidecar {
  std::optional<std::string> name;  ///< the zone's, instead of the one that the format gives
  std::optional<VehicleShape> vehicle;
  std::optional<SpeedProfiles> profiles;
  double clearance_m{0.04};        ///< [crossings]
  double spacing_m{0.30};          ///< [waypoints]
  std::optional<bool> nodes_only;  ///< [waypoints]; no value: as the format requires

  bool edges_are_sections{false};  ///< [waypoints]
  bool indirect{false};            ///< travel_direction

  // [[limit]]
  struct Limit {
    std::string section;
    double speed_mps_max;
    std::string location;  ///< in the sidecar file, for messages
  };
  std::vector<Limit> limits;  ///< put on the circuit by furnish

  // [import]
  double scale{1.0};                                   ///< metres per unit of the file
  double tolerance_m{1e-3};                            ///< of fits
  double tolerance_rad{1e-3};                          ///< of fits
  std::optional<std::uint32_t> stations;               ///< to be distributed over a map that has none
  std::optional<std::string> layout;                   ///< the selected one of a file that holds several
  std::optional<std::string> vehicle_type;             ///< the type whose edges and properties are taken
  std::optional<std::vector<std::string>> lane_types;  ///< the types of a road's lanes that vehicles drive on
};

/// Reads the data for the geometry from `configuration.sidecar`; an empty text is valid. Errors are those of a native
/// file, at the sidecar file's name (sidecar_file) and line.
[[nodiscard]] Result<Sidecar> read_sidecar(const ZoneConfiguration& configuration);

/// The rest of the sidecar file, once `zone` has its name and circuit: gives the zone vehicle and profiles (the
/// defaults where `sidecar` has none), then [[limit]] [beacons] [[tag]] [[station]] [[loop]] [closed] [priorities],
/// crossings, waypoints, [[start]]. Stations, loops, closed sections and diagnostics that the format has put there
/// itself stay, first. A bend that is too tight for the vehicle leaves a diagnostic, and is not refused: the file may
/// be a third party's.
/// @param sidecar    as it was read, completed by the values of the file itself where the sidecar file has none
/// @param rules      of the waypoints that the format declares (start_ids, end_ids, at); the rest of it comes from here
/// Fails as make_zone does: "zone.reference", "zone.duplicate", "zone.size", "zone.vehicle" …
[[nodiscard]] Result<void> furnish(TrafficZone& zone, const ZoneConfiguration& configuration, const Sidecar& sidecar,
                                   WaypointRules rules = {});

/// The sidecar file's name beside a file: "plant.lif.json" and "plant.xodr" have "plant.zone.toml".
[[nodiscard]] std::string sidecar_file(std::string_view file_name);

}  // namespace cosiva::zone
