#include "cosiva/physical/vision/calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cosiva/base/expect.h"
#include "cosiva/physical/vision/floor_fit.h"

namespace cosiva::vision {
namespace {

Residuals metrics_of(const std::vector<Point2>& residuals) {
  Residuals metrics{residuals.size(), 0.0, 0.0};
  double squares = 0.0;
  for (const Point2& residual : residuals) {
    const double off = norm(residual.x_m, residual.y_m);
    squares += off * off;
    metrics.max_m = std::max(metrics.max_m, off);
  }
  if (!residuals.empty()) metrics.rms_m = std::sqrt(squares / static_cast<double>(residuals.size()));
  return metrics;
}

std::optional<Point2> residual_of(const FloorMap& map, const FloorPoint& point) {
  const auto floor = map.floor_at(point.pixel);
  if (!floor) return std::nullopt;
  return Point2{floor->x_m - point.floor.x_m, floor->y_m - point.floor.y_m};
}

struct Extent {
  Point2 low;
  Point2 high;
};
Extent extent_of(const std::vector<FloorPoint>& points) {
  Extent extent{points[0].floor, points[0].floor};
  for (const FloorPoint& point : points) {
    extent.low = {std::min(extent.low.x_m, point.floor.x_m), std::min(extent.low.y_m, point.floor.y_m)};
    extent.high = {std::max(extent.high.x_m, point.floor.x_m), std::max(extent.high.y_m, point.floor.y_m)};
  }
  return extent;
}

/// The smallest step between different values, where nearly all are whole steps apart; otherwise nothing: no grid.
std::optional<double> pitch_of(std::vector<double> values) {
  std::ranges::sort(values);
  constexpr double same_m = 1e-4;
  double pitch = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = values[i] - values[i - 1];
    if (step > same_m && (pitch == 0.0 || step < pitch)) pitch = step;
  }
  if (pitch == 0.0) return std::nullopt;
  for (const double value : values) {
    const double steps = (value - values[0]) / pitch;
    if (std::fabs(steps - std::nearbyint(steps)) > 0.1) return std::nullopt;
  }
  return pitch;
}

std::size_t cell(double at_m, double from_m, double side_m, std::size_t count) {
  const double index = std::floor((at_m - from_m) / side_m + 1e-9);
  return index <= 0.0 ? 0 : std::min(count - 1, static_cast<std::size_t>(index));
}

Result<Tried> try_model(const std::vector<FloorPoint>& points, ImageSize frame, const FitOptions& options,
                        double block_m) {
  const auto map = fit_floor(points, frame, options);
  if (!map) return tl::unexpected(map.error());
  auto colour = cross_validate(points, frame, options, colours(points));
  if (!colour) return tl::unexpected(colour.error());
  auto block = cross_validate(points, frame, options, blocks(points, block_m));
  if (!block) return tl::unexpected(block.error());
  std::vector<Point2> left;
  for (const FloorPoint& point : points)
    if (const auto residual = residual_of(*map, point)) left.push_back(*residual);
  return Tried{options, metrics_of(left), std::move(*colour), std::move(*block)};
}

}  // namespace

Groups colours(const std::vector<FloorPoint>& points) {
  std::vector<double> xs;
  std::vector<double> ys;
  for (const FloorPoint& point : points) {
    xs.push_back(point.floor.x_m);
    ys.push_back(point.floor.y_m);
  }
  const auto pitch_x = pitch_of(xs);
  const auto pitch_y = pitch_of(ys);
  Groups groups(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::size_t at = i;
    if (pitch_x && pitch_y) {
      at = static_cast<std::size_t>(std::nearbyint((xs[i] - *std::ranges::min_element(xs)) / *pitch_x)) +
           static_cast<std::size_t>(std::nearbyint((ys[i] - *std::ranges::min_element(ys)) / *pitch_y));
    }
    groups[i] = at % 2;
  }
  return groups;
}

Groups blocks(const std::vector<FloorPoint>& points, double side_m) {
  COSIVA_EXPECT(side_m > 0.0 && !points.empty());
  const Extent extent = extent_of(points);
  constexpr double least_a_side = 4.0;
  const double width = extent.high.x_m - extent.low.x_m;
  const double height = extent.high.y_m - extent.low.y_m;
  const double side = std::max(1e-6, std::min({side_m, width / least_a_side, height / least_a_side}));
  constexpr std::size_t most = 1000;
  Groups groups;
  for (const FloorPoint& point : points)
    groups.push_back(cell(point.floor.y_m, extent.low.y_m, side, most) * most +
                     cell(point.floor.x_m, extent.low.x_m, side, most));
  return groups;
}

Result<LeftOut> cross_validate(const std::vector<FloorPoint>& points, ImageSize frame, const FitOptions& options,
                               const Groups& groups) {
  COSIVA_EXPECT(groups.size() == points.size());
  const auto all = fit_floor(points, frame, options);
  if (!all) return tl::unexpected(all.error());
  Groups names = groups;
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  LeftOut left_out;
  left_out.residuals.resize(points.size());
  for (const std::size_t name : names) {
    std::vector<FloorPoint> others;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (groups[i] != name) others.push_back(points[i]);
    const auto map = fit_floor(others, frame, options, &*all);
    if (!map) return tl::unexpected(map.error());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (groups[i] != name) continue;
      const auto residual = residual_of(*map, points[i]);
      if (!residual) return fail("gvs.fit", "does not hold together: without some of its points, others are nowhere");
      left_out.residuals[i] = *residual;
    }
  }
  left_out.metrics = metrics_of(left_out.residuals);
  return left_out;
}

double ResidualMap::at(Point2 floor) const {
  if (columns == 0 || rows == 0) return 0.0;
  return rms_m[cell(floor.y_m, y0_m, side_m, rows) * columns + cell(floor.x_m, x0_m, side_m, columns)];
}

ResidualMap residual_map(const std::vector<FloorPoint>& points, const std::vector<const LeftOut*>& left_out,
                         double side_m) {
  COSIVA_EXPECT(!points.empty() && side_m > 0.0);
  const Extent extent = extent_of(points);
  constexpr double most = 200.0;
  const double longest = std::max(extent.high.x_m - extent.low.x_m, extent.high.y_m - extent.low.y_m);
  ResidualMap map{extent.low.x_m, extent.low.y_m, std::max(side_m, longest / most), 0, 0, {}, {}};
  map.columns = 1 + static_cast<std::size_t>((extent.high.x_m - extent.low.x_m) / map.side_m);
  map.rows = 1 + static_cast<std::size_t>((extent.high.y_m - extent.low.y_m) / map.side_m);
  map.rms_m.assign(map.columns * map.rows, 0.0);
  map.points.assign(map.columns * map.rows, 0);
  std::vector<std::vector<double>> squares(left_out.size(), map.rms_m);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t at = cell(points[i].floor.y_m, map.y0_m, map.side_m, map.rows) * map.columns +
                           cell(points[i].floor.x_m, map.x0_m, map.side_m, map.columns);
    ++map.points[at];
    for (std::size_t solution = 0; solution < left_out.size(); ++solution) {
      const Point2& off = left_out[solution]->residuals[i];
      squares[solution][at] += off.x_m * off.x_m + off.y_m * off.y_m;
    }
  }
  for (std::size_t at = 0; at < map.rms_m.size(); ++at)
    for (const auto& solution : squares)
      if (map.points[at] > 0)
        map.rms_m[at] = std::max(map.rms_m[at], std::sqrt(solution[at] / static_cast<double>(map.points[at])));
  // A square without points takes the value of its nearest neighbour that has some.
  const std::vector<double> known = map.rms_m;
  for (std::size_t at = 0; at < known.size(); ++at) {
    if (map.points[at] > 0) continue;
    double nearest = 1e300;
    for (std::size_t other = 0; other < known.size(); ++other) {
      if (map.points[other] == 0) continue;
      const std::size_t row = at / map.columns;
      const std::size_t other_row = other / map.columns;
      const double dx = static_cast<double>(at % map.columns) - static_cast<double>(other % map.columns);
      const double dy = static_cast<double>(row) - static_cast<double>(other_row);
      if (dx * dx + dy * dy >= nearest) continue;
      nearest = dx * dx + dy * dy;
      map.rms_m[at] = known[other];
    }
  }
  return map;
}

Result<Calibrated> calibrate(const std::vector<FloorPoint>& points, ImageSize frame,
                             const CalibrationOptions& options) {
  std::vector<FitOptions> models = options.models;
  const bool all = models.empty();
  for (const FloorModel model : floor_models)
    if (all) models.push_back({model, FitOptions{}.degree});
  Calibrated result;
  std::optional<Error> refused;
  for (const FitOptions& model : models) {
    // Enough for a fit, and for fits that leave half of the points out.
    if (all && model.model != FloorModel::homography && points.size() < 2 * points_needed(model)) continue;
    auto tried = try_model(points, frame, model, options.block_m);
    if (tried)
      result.tried.push_back(std::move(*tried));
    else if (!refused)
      refused = tried.error();
  }
  if (result.tried.empty()) return tl::unexpected(*refused);
  for (std::size_t i = 1; i < result.tried.size(); ++i)
    if (result.tried[i].block.metrics.rms_m < result.tried[result.chosen].block.metrics.rms_m) result.chosen = i;
  const Tried& best = result.tried[result.chosen];
  Calibration& made = result.calibration;
  made.model = best.options.model;
  made.map = *fit_floor(points, frame, best.options);
  made.fitted = best.fitted;
  made.colour = best.colour.metrics;
  made.block = best.block.metrics;
  made.uncertainty = residual_map(points, {&best.colour, &best.block}, options.cell_m);
  if (options.camera_height_m > 0.0) {
    // The camera's position is derived from the homography, which must be free of lens distortion.
    const auto lens = fit_floor(points, frame, {FloorModel::lens, FitOptions{}.degree});
    const auto camera = camera_over(lens ? *lens : made.map, options.camera_height_m);
    if (!camera) return fail("gvs.height", "no camera so high above this floor has such an image");
    made.camera = *camera;
  }
  return result;
}

}  // namespace cosiva::vision
