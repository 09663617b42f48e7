#include "cosiva/zone/toml/toml_factory.h"

#include "cosiva/zone/drawing/zone_circuit.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/toml/toml_circuit.h"
#include "cosiva/zone/toml/toml_edit.h"
#include "cosiva/zone/toml/toml_tables.h"
#include "cosiva/zone/toml/toml_write.h"

namespace cosiva::zone {
namespace {

/// Leaves faults where there is no zone.
std::optional<TrafficZone> read_zone(TomlFaults& faults, const TomlFields& root) {
  root.expect_only({"name", "format_version", "travel_direction", "vehicle", "profiles", "circuit", "section", "tag",
                    "beacons", "station", "start", "loop", "crossings", "waypoints", "priorities", "closed"});
  if (root.whole("format_version", 1, tag_number_max) != 1 && !faults.any())
    root.fault("format_version", "zone.version", "this program reads version 1 of the format");
  const std::string name = root.name("name");
  Sidecar basics;
  read_basics(root, basics);
  if (faults.any()) return std::nullopt;

  const VehicleShape vehicle = basics.vehicle.value_or(VehicleShape{});
  TomlTracks tracks{faults, root, name, vehicle};
  auto circuit = tracks.read();
  if (!circuit) return std::nullopt;
  auto loops = tracks.loops(*circuit);
  if (faults.any()) return std::nullopt;
  TrafficZone zone{name, std::move(*circuit), vehicle, basics.profiles.value_or(default_profiles), {}, {}, {}, {}, {},
                   {}};
  zone.loops = std::move(loops);
  zone.edges_are_sections = basics.edges_are_sections;
  const std::string location = faults.location(root.line("section"), "section");
  TomlTables{faults, root, zone, basics, tracks.rules(), location}.read();
  if (faults.any()) return std::nullopt;
  return zone;
}

std::optional<TrafficZone> read_text(const ZoneConfiguration& configuration, TomlFaults& faults) {
  std::optional<TrafficZone> zone;
  if (configuration.text.size() > toml_bytes_max) {
    faults.add({"zone.size", "expected at most 64 MiB, found " + std::to_string(configuration.text.size()) + " bytes",
                configuration.origin});
    return zone;
  }
  parse_toml(configuration.text, faults, [&](const TomlFields& root) { zone = read_zone(faults, root); });
  return zone;
}

}  // namespace

Result<std::shared_ptr<const DrawableCircuit>> TomlCircuitFactory::make_circuit(
    const ZoneConfiguration& configuration) const {
  return circuit_of(make_zone(configuration));
}

Result<TrafficZone> TomlCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  TomlFaults faults{configuration.origin};
  auto zone = read_text(configuration, faults);
  if (!zone || faults.any()) return tl::unexpected(faults.first());
  return std::move(*zone);
}

std::vector<Error> TomlCircuitFactory::faults(const ZoneConfiguration& configuration) const {
  TomlFaults faults{configuration.origin};
  (void)read_text(configuration, faults);
  return faults.all();
}

Result<ZoneConfiguration> TomlCircuitFactory::written(const TrafficZone& zone, std::vector<Diagnostic>& lost) const {
  auto text = native_text(zone);
  if (!text) return tl::unexpected(std::move(text.error()));
  ZoneConfiguration configuration{std::string(format()), zone.name + ".toml", std::move(*text), {}};
  const auto back = make_zone(configuration);
  if (!back)
    return tl::unexpected(Error{"zone.write", "what was written is refused: " + back.error().message, zone.name});
  if (const auto other = difference(zone, *back))
    lost.push_back({Diagnostic::Kind::lost, zone.name, "what was written is not quite the zone: " + *other});
  return configuration;
}

Result<ZoneConfiguration> TomlCircuitFactory::edited(const ZoneConfiguration& configuration,
                                                     const ZoneEdit& edit) const {
  return edited_file(*this, configuration, edit);
}

}  // namespace cosiva::zone
