#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// Shapes that a display can draw without interpreting them (A19): on named layers, in map metres.
struct Primitive {
  enum class Shape { polyline, polygon, disc, text };
  Shape shape;
  /// "road", "line", "crossing", "pivot", "tag", "beacon", "station", "section" (names and arrows), "label"
  std::string layer;
  std::vector<Point2> points;
  double size_m{};    ///< stroke width, disc radius or text height
  std::string label;  ///< text to draw or to show on hover; may be empty
  double heading_rad{};
  /// Of a layer with several kinds: "straight", "arc", "clothoid" or another kind of section; "stop", "charger"; else
  /// empty.
  std::string kind{};
};

/// A circuit of any kind, with what lies on it, as a factory makes it (A23): it is drawn by requesting its drawing.
class DrawableCircuit {
 public:
  DrawableCircuit() = default;
  DrawableCircuit(const DrawableCircuit&) = delete;
  DrawableCircuit& operator=(const DrawableCircuit&) = delete;
  virtual ~DrawableCircuit() = default;

  [[nodiscard]] virtual const std::shared_ptr<const TrafficZone>& zone() const = 0;  ///< not null
  [[nodiscard]] virtual std::vector<Primitive> draw() const = 0;
};

}  // namespace cosiva::zone
