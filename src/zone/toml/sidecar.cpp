#include "cosiva/zone/toml/sidecar.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_tables.h"

namespace cosiva::zone {
namespace {

constexpr std::size_t limits_max = 200'000;
constexpr std::int64_t stations_max = 20'000;
constexpr std::size_t tight_bends_logged = 20;

void read_import(const TomlFields& root, Sidecar& sidecar) {
  const auto fields = root.table("import");
  if (!fields) return;
  fields->expect_only({"scale", "layout", "vehicle_type", "lane_types", "tolerance_m", "tolerance_rad", "stations"});
  sidecar.scale = fields->number("scale", {"metres per unit of the file, 0.000001 to 1000000", 1e-6, 1e6}, 1.0);
  sidecar.tolerance_m = fields->number("tolerance_m", {"metres from 0.000001 to 1", 1e-6, 1.0}, 1e-3);
  sidecar.tolerance_rad = fields->number("tolerance_rad", {"radians from 0.000001 to 0.2", 1e-6, 0.2}, 1e-3);
  if (fields->has("stations"))
    sidecar.stations = static_cast<std::uint32_t>(fields->whole("stations", 0, stations_max));
  sidecar.layout = fields->optional_name("layout");
  sidecar.vehicle_type = fields->optional_name("vehicle_type");
  sidecar.lane_types = fields->names("lane_types");
}

void read_limits(const TomlFields& root, Sidecar& sidecar) {
  const auto entries = root.tables("limit");
  if (entries.size() > limits_max)
    return root.fault("limit", "zone.size", "expected at most 200000 limits, found " + std::to_string(entries.size()));
  for (const TomlFields& fields : entries) {
    fields.expect_only({"section", "speed_mps_max"});
    sidecar.limits.push_back({fields.name("section"), fields.number("speed_mps_max", speed_range), fields.location()});
  }
}

void read_text(const ZoneConfiguration& configuration, TomlFaults& faults,
               const std::function<void(const TomlFields& root)>& read) {
  if (configuration.sidecar.size() > toml_bytes_max) {
    faults.add({"zone.size",
                "expected at most 64 MiB, found " + std::to_string(configuration.sidecar.size()) + " bytes",
                sidecar_file(configuration.origin)});
    return;
  }
  parse_toml(configuration.sidecar, faults, read);
}

/// The circuit with these limits on its sections; the circuit was joined already, so its joints are not checked again.
Result<Circuit> limited(const Circuit& circuit, const std::vector<Sidecar::Limit>& limits) {
  std::vector<Circuit::Part> parts;
  parts.reserve(circuit.size());
  for (SectionId id = 0; id < circuit.size(); ++id) parts.push_back(circuit.part(id));
  for (const Sidecar::Limit& limit : limits) {
    const auto id = circuit.find(limit.section);
    if (!id)
      return fail("zone.reference",
                  "expected the name of a section, found \"" + limit.section.substr(0, 64) + "\", which is none",
                  limit.location + ".section");
    parts[*id].speed_mps_max = limit.speed_mps_max;
  }
  constexpr double any = std::numeric_limits<double>::infinity();
  return Circuit::make(circuit.name(), std::move(parts), any, any);
}

void record_tight_bends(TrafficZone& zone) {
  std::size_t found = 0;
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    const double bend = zone.circuit.section(id).curvature_max_per_m();
    if (0.5 * zone.vehicle.width_m * bend < 1.0 || ++found > tight_bends_logged) continue;
    zone.diagnostics.push_back({Diagnostic::Kind::notice, "section '" + zone.circuit.part(id).name + "'",
                                "bends with a radius of " + metres_text(1.0 / bend) +
                                    " m, less than half the vehicle's " + metres_text(zone.vehicle.width_m) +
                                    " m of width: its inner side drives backwards here"});
  }
  if (found > tight_bends_logged)
    zone.diagnostics.push_back({Diagnostic::Kind::notice, "sections",
                                std::to_string(found - tight_bends_logged) + " more bend as tightly as those above"});
}

}  // namespace

Result<Sidecar> read_sidecar(const ZoneConfiguration& configuration) {
  Sidecar sidecar;
  TomlFaults faults{sidecar_file(configuration.origin)};
  read_text(configuration, faults, [&](const TomlFields& root) {
    root.expect_only({"name", "format_version", "travel_direction", "import", "vehicle", "profiles", "crossings",
                      "waypoints", "limit", "tag", "beacons", "station", "start", "priorities", "loop", "closed"});
    if (root.whole("format_version", 1, tag_number_max, 1) != 1 && !faults.any())
      root.fault("format_version", "zone.version", "this program reads version 1 of the format");
    sidecar.name = root.optional_name("name");
    read_import(root, sidecar);
    read_basics(root, sidecar);
    read_limits(root, sidecar);
  });
  if (faults.any()) return tl::unexpected(faults.first());
  return sidecar;
}

Result<void> furnish(TrafficZone& zone, const ZoneConfiguration& configuration, const Sidecar& sidecar,
                     WaypointRules rules) {
  zone.vehicle = sidecar.vehicle.value_or(VehicleShape{});
  zone.profiles = sidecar.profiles.value_or(default_profiles);
  if (sidecar.edges_are_sections) zone.edges_are_sections = true;
  if (!sidecar.limits.empty()) {
    auto circuit = limited(zone.circuit, sidecar.limits);
    if (!circuit) return tl::unexpected(circuit.error());
    zone.circuit = std::move(*circuit);
  }
  record_tight_bends(zone);
  TomlFaults faults{sidecar_file(configuration.origin)};
  read_text(configuration, faults, [&](const TomlFields& root) {
    TomlTables{faults, root, zone, sidecar, std::move(rules), configuration.origin}.read();
  });
  if (faults.any()) return tl::unexpected(faults.first());
  return {};
}

std::string sidecar_file(std::string_view file_name) {
  const auto slash = file_name.rfind('/');
  const auto dot = file_name.rfind('.');
  if (dot != std::string_view::npos && (slash == std::string_view::npos || dot > slash + 1))
    file_name = file_name.substr(0, dot);
  // "plant.lif.json" has two endings that name its format.
  if (file_name.ends_with(".lif")) file_name.remove_suffix(4);
  return std::string(file_name) + ".zone.toml";
}

}  // namespace cosiva::zone
