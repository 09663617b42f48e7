#include "cosiva/zone/opendrive/opendrive_factory.h"

#include <cmath>

#include "cosiva/base/digest.h"
#include "cosiva/zone/drawing/zone_circuit.h"
#include "cosiva/zone/opendrive/joints.h"
#include "cosiva/zone/opendrive/links.h"
#include "cosiva/zone/opendrive/reader.h"
#include "cosiva/zone/opendrive/sections.h"
#include "cosiva/zone/opendrive/short_sections.h"
#include "cosiva/zone/opendrive/tracks.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_edit.h"

namespace cosiva::zone {
namespace opendrive {
namespace {

/// Lanes for vehicles, by the terms of versions 1.1 to 1.8.
const std::vector<std::string>& driven_lane_types() {
  static const std::vector<std::string> types{"driving",  "entry",   "exit",          "onRamp",   "offRamp",
                                              "taxi",     "bus",     "HOV",           "slipLane", "bidirectional",
                                              "mwyEntry", "mwyExit", "connectingRamp"};
  return types;
}

/// Coordinates of a national grid leave a double too few digits behind the point: such a network is moved near to 0.
void move_near(Network& network, Report& report) {
  constexpr double far_m = 1e5;
  const Geometry* first = nullptr;
  for (const Road& road : network.roads) {
    if (first == nullptr && !road.plan.empty()) first = &road.plan.front();
  }
  if (first == nullptr || (std::fabs(first->start.x_m) < far_m && std::fabs(first->start.y_m) < far_m)) return;
  const Point2 by{1e3 * std::floor(1e-3 * first->start.x_m), 1e3 * std::floor(1e-3 * first->start.y_m)};
  for (Road& road : network.roads) {
    for (Geometry& geometry : road.plan) {
      geometry.start.x_m -= by.x_m;
      geometry.start.y_m -= by.y_m;
    }
  }
  report.add(Diagnostic::Kind::notice, "origins", "file",
             "lies far from its origin: everything is moved by (" + std::to_string(-by.x_m) + ", " +
                 std::to_string(-by.y_m) + ") of its metres");
}

void record_what_is_not_taken(Report& report) {
  const auto add_diagnostic = [&](Diagnostic::Kind kind, std::string_view what, std::string_view text) {
    const std::size_t count = report.counted(what);
    if (count == 0) return;
    std::string sentence = std::to_string(count) + ' ';
    sentence += text;
    report.add(kind, what, "file", std::move(sentence));
  };
  add_diagnostic(Diagnostic::Kind::notice, "elevation", "records of elevation are not taken: the zone is flat");
  add_diagnostic(Diagnostic::Kind::notice, "superelevation",
                 "records of superelevation are not taken: the zone is flat");
  add_diagnostic(Diagnostic::Kind::notice, "crossfall", "records of crossfall are not taken: the zone is flat");
  add_diagnostic(Diagnostic::Kind::notice, "shape", "records of road shape are not taken: the zone is flat");
  add_diagnostic(Diagnostic::Kind::lost, "signals", "signals are not taken: vehicles do not stop at lights and signs");
  add_diagnostic(Diagnostic::Kind::lost, "objects", "objects are not taken");
  add_diagnostic(Diagnostic::Kind::lost, "controller", "controllers of signals are not taken");
  add_diagnostic(Diagnostic::Kind::lost, "junctionGroup", "groups of junctions are not taken");
  add_diagnostic(Diagnostic::Kind::lost, "railroad", "railroads are not taken");
  add_diagnostic(Diagnostic::Kind::lost, "station",
                 "stations of railways and buses are not taken; the sidecar file can name stations");
  add_diagnostic(Diagnostic::Kind::lost, "direction both",
                 "lanes are driven both ways in the file; here only in their side's direction");
  add_diagnostic(Diagnostic::Kind::lost, "links to lanes not driven on", "links lead to lanes that are not driven on");
  std::string types;
  for (const auto& [type, count] : report.counted_under("lane type ")) {
    if (types.size() > 300) continue;
    types += (types.empty() ? "" : ", ") + std::to_string(count) + ' ' + type;
  }
  if (!types.empty())
    report.add(Diagnostic::Kind::notice, "lane types", "file", "lanes that are not driven on: " + types);
}

/// The header's name, or one derived from the text alone: vehicles identify the map by it, and a file's name may differ
/// on every machine.
std::string name_of(const Network& network, std::string_view text) {
  std::string name;
  for (const char c : network.name.substr(0, 64)) {
    if (static_cast<unsigned char>(c) >= 0x20) name += c;
  }
  if (name.find_first_not_of(' ') != std::string::npos) return name;
  Digest digest;
  digest.add(text);
  return "roads-" + digest.hex().substr(0, 6);
}

}  // namespace
}  // namespace opendrive

Result<std::shared_ptr<const DrawableCircuit>> OpenDriveCircuitFactory::make_circuit(
    const ZoneConfiguration& configuration) const {
  return circuit_of(make_zone(configuration));
}

Result<TrafficZone> OpenDriveCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  using namespace opendrive;
  const auto sidecar = read_sidecar(configuration);
  if (!sidecar) return tl::unexpected(sidecar.error());
  auto file = XmlFile::parse(configuration.origin, configuration.text);
  if (!file) return tl::unexpected(file.error());
  Report report;
  auto network = read_network(**file, report);
  if (!network) return tl::unexpected(network.error());
  file->reset();
  move_near(*network, report);
  drop_short_sections(*network, report);

  Tracks tracks = find_tracks(*network, sidecar->lane_types.value_or(driven_lane_types()), report);
  link_tracks(*network, tracks, report);
  join_tracks(*network, tracks, report);
  auto parts = lay_sections(*network, tracks, sidecar->scale, {sidecar->tolerance_m, sidecar->tolerance_rad}, report);
  if (!parts) return fail(parts.error().code, parts.error().message, configuration.origin);
  const std::string name = sidecar->name.value_or(name_of(*network, configuration.text));
  auto circuit = Circuit::make(name, std::move(*parts));
  if (!circuit) return fail(circuit.error().code, circuit.error().message, configuration.origin);

  record_what_is_not_taken(report);
  TrafficZone zone{name, std::move(*circuit), {}, default_profiles, {}, {}, {}, {}, {}, {}};
  zone.diagnostics = report.diagnostics();
  if (auto furnished = furnish(zone, configuration, *sidecar); !furnished) return tl::unexpected(furnished.error());
  return zone;
}

Result<ZoneConfiguration> OpenDriveCircuitFactory::edited(const ZoneConfiguration& configuration,
                                                          const ZoneEdit& edit) const {
  return edited_sidecar(*this, configuration, edit);
}

}  // namespace cosiva::zone
