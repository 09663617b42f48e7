#include "cosiva/zone/movingai/movingai_factory.h"

#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/math.h"
#include "cosiva/zone/drawing/zone_circuit.h"
#include "cosiva/zone/grid/grid.h"
#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/movingai/grid_tracks.h"
#include "cosiva/zone/movingai/stops.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_edit.h"

namespace cosiva::zone {
namespace {

/// The least pitch at which vehicles may turn on the spot in neighbouring squares at the same time.
double least_pitch_m(const VehicleShape& vehicle, double clearance_m) {
  return norm(vehicle.length_m, vehicle.width_m) + clearance_m;
}

Result<void> check_pitch(const Sidecar& sidecar, const std::string& location) {
  const VehicleShape vehicle = sidecar.vehicle.value_or(VehicleShape{});
  const double least_m = least_pitch_m(vehicle, sidecar.clearance_m);
  if (sidecar.scale >= least_m) return {};
  return fail("zone.vehicle",
              "vehicles of " + metres_text(vehicle.length_m) + " m by " + metres_text(vehicle.width_m) +
                  " m touch when they turn on the spot in neighbouring squares of " + metres_text(sidecar.scale) +
                  " m; expected [import] scale to be at least " + metres_text(least_m) + " m per square",
              location);
}

/// From the text alone: vehicles identify the map by it, and a file's name may differ on every machine.
std::string name_of(std::string_view text) {
  Digest digest;
  digest.add(text);
  return "map-" + digest.hex().substr(0, 6);
}

}  // namespace

Result<std::shared_ptr<const DrawableCircuit>> MovingAiCircuitFactory::make_circuit(
    const ZoneConfiguration& configuration) const {
  return circuit_of(make_zone(configuration));
}

Result<TrafficZone> MovingAiCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  const auto sidecar = read_sidecar(configuration);
  if (!sidecar) return tl::unexpected(sidecar.error());
  const auto failed = [&](Error error) {
    error.location = configuration.origin + (error.location.empty() ? "" : ": ") + error.location;
    return tl::unexpected(std::move(error));
  };
  auto grid = read_grid(configuration.text);
  if (!grid) return failed(grid.error());
  if (sidecar->stations) grid->stops = distributed_stops(*grid, *sidecar->stations);
  if (auto good = check_pitch(*sidecar, sidecar_file(configuration.origin)); !good) return tl::unexpected(good.error());
  auto tracks = lay_grid_tracks(*grid, sidecar->scale);
  if (!tracks) return failed(tracks.error());
  std::string name = sidecar->name.value_or(name_of(configuration.text));
  auto circuit = Circuit::make(name, std::move(tracks->parts));
  if (!circuit) return failed(circuit.error());

  TrafficZone zone{.name = std::move(name),
                   .circuit = std::move(*circuit),
                   .vehicle = {},
                   .profiles = default_profiles,
                   .tags = {},
                   .beacons = tracks->beacons,
                   .stations = std::move(tracks->stations),
                   .crossings = {},
                   .waypoints = {},
                   .starts = {},
                   .diagnostics = std::move(tracks->diagnostics),
                   .edges_are_sections = true};
  if (sidecar->stations.value_or(0) > zone.stations.size())
    zone.diagnostics.push_back({Diagnostic::Kind::notice, "map",
                                "[import] stations is " + std::to_string(*sidecar->stations) + ", but only " +
                                    std::to_string(zone.stations.size()) + " leave all others connected"});
  WaypointRules rules;
  rules.nodes_only = true;
  rules.start_ids = std::move(tracks->start_ids);
  if (auto furnished = furnish(zone, configuration, *sidecar, std::move(rules)); !furnished)
    return tl::unexpected(furnished.error());
  return zone;
}

Result<ZoneConfiguration> MovingAiCircuitFactory::edited(const ZoneConfiguration& configuration,
                                                         const ZoneEdit& edit) const {
  return edited_sidecar(*this, configuration, edit);
}

}  // namespace cosiva::zone
