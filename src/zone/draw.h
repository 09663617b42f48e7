#pragma once

#include <string>
#include <vector>

#include "base/json_writer.h"
#include "base/pose.h"
#include "zone/traffic_zone.h"

namespace cosiva::zone {

/// What a blind display can draw without knowing what it shows (A19): shapes on named layers, in map metres.
struct Primitive {
  enum class Shape { polyline, polygon, disc, text };
  Shape shape;
  std::string layer;  ///< "road", "line", "crossing", "tag", "beacon", "station", "section" (names and arrows), "label"
  std::vector<Point2> points;
  double size_m{};    ///< stroke width, disc radius or text height
  std::string label;  ///< text to write or to show on hover; may be empty
  double heading_rad{};
};

/// The zone draws itself: road bands, centre lines, crossings, tags, beacons, stations; curves to within 0.5 mm.
[[nodiscard]] std::vector<Primitive> draw(const TrafficZone& zone);

struct Bounds {
  Point2 low;
  Point2 high;
};
[[nodiscard]] Bounds bounds(const std::vector<Primitive>& primitives);

/// {"name":…, "bounds":[x0,y0,x1,y1], "vehicle":{"length_m","width_m"},
/// "primitives":[{"shape","layer","points":[[x,y]…],"size_m","label","heading"}…],"sections":[{"name","length_m"}…],
/// "tags":[{"number","section","s","x","y"}…],"beacons":{"pitch_m","origin":[x,y],"columns","rows"} or null}
void write_json(JsonWriter& json, const TrafficZone& zone, const std::vector<Primitive>& primitives);

/// A self-contained SVG picture, y up, with a scale bar.
[[nodiscard]] std::string to_svg(const TrafficZone& zone, const std::vector<Primitive>& primitives);

}  // namespace cosiva::zone
