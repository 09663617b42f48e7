#include "cosiva/zone/layout/beacons.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace cosiva::zone {
namespace {

/// The map's point in a frame whose axes run along the matrix and whose origin is `origin`.
Point2 unturned(Point2 origin, const SinCos& turn, Point2 p) {
  const double x_m = p.x_m - origin.x_m;
  const double y_m = p.y_m - origin.y_m;
  return {x_m * turn.cos + y_m * turn.sin, y_m * turn.cos - x_m * turn.sin};
}

Point2 turned(Point2 origin, const SinCos& turn, Point2 p) {
  return {origin.x_m + p.x_m * turn.cos - p.y_m * turn.sin, origin.y_m + p.x_m * turn.sin + p.y_m * turn.cos};
}

}  // namespace

Point2 BeaconGrid::at(std::uint32_t column, std::uint32_t row) const {
  if (rotation_rad == 0.0) return {origin.x_m + column * pitch_m, origin.y_m + row * pitch_m};
  return turned(origin, sincos(rotation_rad), {column * pitch_m, row * pitch_m});
}

std::optional<Point2> BeaconGrid::find(TagNumber number) const {
  if (number < first_number || columns == 0) return std::nullopt;
  const TagNumber index = number - first_number;
  if (index / columns >= rows) return std::nullopt;
  return at(index % columns, index / columns);
}

std::optional<BeaconGrid::Near> BeaconGrid::nearest(Point2 p) const {
  if (columns == 0 || rows == 0) return std::nullopt;
  // An upright matrix, the usual case, is queried with every move of every vehicle: no sine for it.
  const Point2 p_G =
      rotation_rad == 0.0 ? Point2{p.x_m - origin.x_m, p.y_m - origin.y_m} : unturned(origin, sincos(rotation_rad), p);
  const double i = p_G.x_m / pitch_m;
  const double j = p_G.y_m / pitch_m;
  // Half a pitch beyond the edge is still the edge beacon's cell. Written so that a NaN is outside.
  if (!(i >= -0.5 && i <= columns - 0.5 && j >= -0.5 && j <= rows - 0.5)) return std::nullopt;
  const auto column = std::min(static_cast<std::uint32_t>(std::floor(i + 0.5)), columns - 1);
  const auto row = std::min(static_cast<std::uint32_t>(std::floor(j + 0.5)), rows - 1);
  return Near{first_number + row * columns + column, at(column, row)};
}

namespace {

struct Extent {
  Point2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point2 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

  void hold(Point2 p, double margin_m) {
    low = {std::min(low.x_m, p.x_m - margin_m), std::min(low.y_m, p.y_m - margin_m)};
    high = {std::max(high.x_m, p.x_m + margin_m), std::max(high.y_m, p.y_m + margin_m)};
  }
};

/// Of all sections, in the frame of a matrix that passes through `through`; of an upright one, in the map's.
Extent extent(const Circuit& circuit, Point2 through, double rotation_rad) {
  Extent all;
  const SinCos turn = sincos(rotation_rad);
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const Section& section = circuit.section(id);
    if (rotation_rad == 0.0) {
      all.hold(section.box().low, 0.0);
      all.hold(section.box().high, 0.0);
      continue;
    }
    // Between points h apart with a turn of at most 0.25 rad the curve strays at most 0.25·h/8 from its chord.
    const double parts = std::max(1.0, std::ceil(section.curvature_max_per_m() * section.length_m() / 0.25));
    const double part_m = section.length_m() / parts;
    const double margin_m = section.kind() == SectionKind::straight ? 0.0 : part_m * (0.25 / 8.0);
    for (double i = 0.0; i <= parts; i += 1.0)
      all.hold(unturned(through, turn, position(section.pose_at(i * part_m))), margin_m);
  }
  return all;
}

}  // namespace

std::optional<BeaconGrid> covering_grid(const Circuit& circuit, const VehicleShape& shape, double pitch_m,
                                        Point2 through, std::uint32_t beacons_max, double rotation_rad) {
  const Extent box = extent(circuit, through, rotation_rad);
  const Point2 from = rotation_rad == 0.0 ? through : Point2{};  // in the extent's frame
  const double margin_m = 0.5 * shape.width_m;
  const auto below = [&](double low, double at) { return std::floor((low - margin_m - at) / pitch_m); };
  const auto above = [&](double high, double at) { return std::ceil((high + margin_m - at) / pitch_m); };
  const double i0 = below(box.low.x_m, from.x_m);
  const double j0 = below(box.low.y_m, from.y_m);
  const double columns = above(box.high.x_m, from.x_m) - i0 + 1.0;
  const double rows = above(box.high.y_m, from.y_m) - j0 + 1.0;
  if (!(columns * rows <= beacons_max)) return std::nullopt;
  BeaconGrid grid{};
  grid.pitch_m = pitch_m;
  grid.rotation_rad = rotation_rad;
  grid.origin = rotation_rad == 0.0 ? Point2{through.x_m + i0 * pitch_m, through.y_m + j0 * pitch_m}
                                    : turned(through, sincos(rotation_rad), {i0 * pitch_m, j0 * pitch_m});
  grid.columns = static_cast<std::uint32_t>(columns);
  grid.rows = static_cast<std::uint32_t>(rows);
  grid.covers_through = through;
  return grid;
}

}  // namespace cosiva::zone
