#pragma once

#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/drawable_circuit.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The drawing of a zone: road bands, centre lines, crossings, tags, beacons, stations, pivots; curves to within 0.5
/// mm. In a zone so large that names would be illegible they are left out, and its curves are as fine as some hundred
/// thousand points allow.
[[nodiscard]] std::vector<Primitive> draw(const TrafficZone& zone);

struct Bounds {
  Point2 low;
  Point2 high;
};
[[nodiscard]] Bounds bounds(const std::vector<Primitive>& primitives);

/// {"name":…, "bounds":[x0,y0,x1,y1], "vehicle":{"length_m","width_m"},
/// "primitives":[{"shape","layer","kind"?,"points":[[x,y]…],"size_m","label","heading"}…] to 0.01 mm,
/// "sections":[{"name","length_m"}…],"tags":[{"number","section","s","x","y"}…],
/// "beacons":{"pitch_m","origin":[x,y],"rotation","columns","rows"} or null,
/// "stations":[{"name","kind","x","y","section","s"}…],"loops":[name…],"diagnostics":[{"kind","location","text"}…]}
/// The beacons' origin is their first one, about which they are turned.
void write_json(JsonWriter& json, const TrafficZone& zone, const std::vector<Primitive>& primitives);

}  // namespace cosiva::zone
