#pragma once

#include <string>

#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_fields.h"

/// The tables that a native file and the sidecar file of another format have in common.
namespace cosiva::zone {

/// Parses and reads: any fault in the text becomes a reported fault, and no exception leaves the function.
/// @param read  called with the root table, unless the text is no TOML
void parse_toml(std::string_view text, TomlFaults& faults, const std::function<void(const TomlFields& root)>& read);

/// travel_direction [vehicle] [profiles] [crossings] [waypoints]
void read_basics(const TomlFields& root, Sidecar& basics);

/// All elements on a circuit and the data derived from it. Each step may leave a fault, which ends the reading.
class TomlTables {
 public:
  /// @param rules  of the format's own waypoints; spacing, room and stations come from here
  /// @param tracks location of faults in the sections themselves, for messages
  TomlTables(TomlFaults& faults, const TomlFields& root, TrafficZone& zone, const Sidecar& basics, WaypointRules rules,
             std::string tracks)
      : faults_{faults},
        root_{root},
        zone_{zone},
        basics_{basics},
        rules_{std::move(rules)},
        tracks_{std::move(tracks)} {}

  void read();

 private:
  [[nodiscard]] std::optional<TrackPosition> read_position(const TomlFields& fields) const;
  [[nodiscard]] std::optional<SectionId> find(const TomlFields& fields, std::string_view key,
                                              std::string_view name) const;
  [[nodiscard]] bool too_many(std::string_view key, std::size_t found, std::size_t most) const;
  void read_beacons();
  void read_tags();
  void read_stations();
  void read_loops();
  void read_closed();
  void read_priorities();
  void derive();
  void read_starts();

  TomlFaults& faults_;
  const TomlFields& root_;
  TrafficZone& zone_;
  const Sidecar& basics_;
  WaypointRules rules_;
  std::string tracks_;
};

inline constexpr NumberRange positive_m{"a positive number of metres, at most 100000", 0.0, 1e5, false};
inline constexpr NumberRange speed_range{"a positive speed in metres per second, at most 100", 0.0, 100.0, false};

}  // namespace cosiva::zone
