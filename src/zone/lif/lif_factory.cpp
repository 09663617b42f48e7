#include "cosiva/zone/lif/lif_factory.h"

#include <algorithm>
#include <utility>

#include "cosiva/zone/drawing/zone_circuit.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/lif/json_fault.h"
#include "cosiva/zone/lif/lif_circuit.h"
#include "cosiva/zone/lif/lif_document.h"
#include "cosiva/zone/lif/lif_writer.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_edit.h"

namespace cosiva::zone {
namespace {

/// Values in one file: bounds the memory that a small hostile file can request. A hundred thousand edges have four
/// million.
constexpr std::ptrdiff_t values_max = 12'000'000;

Error at_file(const ZoneConfiguration& configuration, Error error) {
  error.location = error.location.empty() ? configuration.origin : configuration.origin + ": " + error.location;
  return error;
}

Result<JsonValue> parse(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.size() > lif_bytes_max)
    return fail("zone.size", "expected at most 64 MiB, found " + std::to_string(text.size()) + " bytes");
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    return fail("zone.syntax", "expected UTF-8, found UTF-16; save the file as UTF-8");
  const auto values = std::count_if(text.begin(), text.end(), [](char c) { return c == ',' || c == '[' || c == '{'; });
  if (values > values_max) return fail("zone.size", "expected at most 12 million values, found more");
  auto json = JsonValue::parse(text, lif_bytes_max);
  if (json) return json;
  if (const auto fault = lif::find_json_fault(text)) {
    return fail("zone.syntax", "not JSON: " + fault->what,
                "line " + std::to_string(fault->line) + ", column " + std::to_string(fault->column));
  }
  return fail("zone.syntax", json.error().message);
}

std::string zone_name(const std::optional<std::string>& requested, std::string project) {
  if (requested) return *requested;
  constexpr std::size_t bytes_max = 64;
  if (project.size() > bytes_max) {
    std::size_t end = bytes_max;
    while (end > 0 && (static_cast<unsigned char>(project[end]) & 0xC0U) == 0x80U) --end;
    project.resize(end);
  }
  const bool blank = project.find_first_not_of(' ') == std::string::npos;
  return blank ? "lif" : project;
}

}  // namespace

Result<std::shared_ptr<const DrawableCircuit>> LifCircuitFactory::make_circuit(
    const ZoneConfiguration& configuration) const {
  return circuit_of(make_zone(configuration));
}

Result<TrafficZone> LifCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  const auto failed = [&](Error error) { return tl::unexpected(at_file(configuration, std::move(error))); };
  auto sidecar = read_sidecar(configuration);
  if (!sidecar) return tl::unexpected(sidecar.error());
  const auto json = parse(configuration.text);
  if (!json) return failed(json.error());

  lif::LifDiagnostics diagnostics;
  auto document = lif::read_document(*json, {sidecar->vehicle_type, sidecar->layout, sidecar->scale}, diagnostics);
  if (!document) return failed(document.error());
  auto tracks = lif::make_tracks(*document, {sidecar->tolerance_m, sidecar->tolerance_rad}, diagnostics);
  if (!tracks) {
    // The items lost before explain why nothing is left; an ignored field does not, and begins with its name.
    Error error = tracks.error();
    for (const Diagnostic& diagnostic : diagnostics.take()) {
      if (error.code == "circuit.empty" && diagnostic.kind == Diagnostic::Kind::lost &&
          !diagnostic.text.starts_with('\'')) {
        error.message += "; " + diagnostic.location + ": " + diagnostic.text;
        break;
      }
    }
    return failed(std::move(error));
  }

  std::string name = zone_name(sidecar->name, document->project);
  auto circuit = Circuit::make(name, std::move(tracks->parts));
  if (!circuit) return failed(circuit.error());
  TrafficZone zone{.name = std::move(name),
                   .circuit = std::move(*circuit),
                   .vehicle = {},
                   .profiles = default_profiles,
                   .tags = {},
                   .beacons = {},
                   .stations = std::move(tracks->stations),
                   .crossings = {},
                   .waypoints = {},
                   .starts = {}};
  zone.edges_are_sections = true;
  WaypointRules rules;
  rules.start_ids = std::move(tracks->start_ids);
  rules.end_ids = std::move(tracks->end_ids);
  if (auto furnished = furnish(zone, configuration, *sidecar, std::move(rules)); !furnished)
    return tl::unexpected(furnished.error());
  auto published = diagnostics.take();
  zone.diagnostics.insert(zone.diagnostics.begin(), std::make_move_iterator(published.begin()),
                          std::make_move_iterator(published.end()));
  return zone;
}

Result<ZoneConfiguration> LifCircuitFactory::written(const TrafficZone& zone, std::vector<Diagnostic>& lost) const {
  return lif::write_zone(zone, lost);
}

Result<ZoneConfiguration> LifCircuitFactory::edited(const ZoneConfiguration& configuration,
                                                    const ZoneEdit& edit) const {
  return edited_sidecar(*this, configuration, edit);
}

}  // namespace cosiva::zone
