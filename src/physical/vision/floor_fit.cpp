#include "cosiva/physical/vision/floor_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "cosiva/base/expect.h"
#include "cosiva/base/least_squares.h"
#include "cosiva/base/math.h"

namespace cosiva::vision {
namespace {

constexpr const char* no_camera = "no camera maps these positions to these pixels: check the names of the columns";

/// The points' spread across their longest direction, as a ratio of the spread along it.
template <class Get>
double thinness(const std::vector<FloorPoint>& points, const Get& get) {
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (const FloorPoint& point : points) {
    mean_x += get(point)[0];
    mean_y += get(point)[1];
  }
  mean_x /= static_cast<double>(points.size());
  mean_y /= static_cast<double>(points.size());
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (const FloorPoint& point : points) {
    const double x = get(point)[0] - mean_x;
    const double y = get(point)[1] - mean_y;
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  // The eigenvalues of the spread; their product is its determinant.
  const double along = 0.5 * (xx + yy) + norm(0.5 * (xx - yy), xy);
  const double across = along > 0.0 ? (xx * yy - xy * xy) / along : 0.0;
  return along > 0.0 ? std::sqrt(std::max(0.0, across) / along) : 0.0;
}

std::array<double, 2> floor_of(const FloorPoint& point) { return {point.floor.x_m, point.floor.y_m}; }
std::array<double, 2> pixel_of(const FloorPoint& point) { return {point.pixel.u, point.pixel.v}; }

Result<void> check(const std::vector<FloorPoint>& points, const FitOptions& options) {
  if (points.size() < points_needed(options)) {
    return fail("gvs.points", "holds " + std::to_string(points.size()) + " points, and the model '" +
                                  std::string(name_of(options.model)) + "' needs " +
                                  std::to_string(points_needed(options)));
  }
  constexpr double line = 0.02;
  if (thinness(points, floor_of) < line || thinness(points, pixel_of) < line)
    return fail("gvs.points", "all points lie on or near one line: nothing is known across it");
  return {};
}

/// Floor coordinates brought to about −1 … 1, so that all columns are of one size.
struct Scaled {
  Point2 centre;
  double size_m;
};
Scaled scale_of(const std::vector<FloorPoint>& points) {
  Point2 low = points[0].floor;
  Point2 high = low;
  for (const FloorPoint& point : points) {
    low = {std::min(low.x_m, point.floor.x_m), std::min(low.y_m, point.floor.y_m)};
    high = {std::max(high.x_m, point.floor.x_m), std::max(high.y_m, point.floor.y_m)};
  }
  return {{0.5 * (low.x_m + high.x_m), 0.5 * (low.y_m + high.y_m)},
          0.5 * std::max(high.x_m - low.x_m, high.y_m - low.y_m)};
}

/// A homography, row by row.
using Homography = std::array<double, 9>;

/// Hartley's direct linear transform. Source: Hartley, Zisserman, Multiple View Geometry, algorithm 4.2.
Homography homography_of(const std::vector<FloorPoint>& points, const FloorMap& map, const Scaled& scaled) {
  Matrix equations{2 * points.size(), 9};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [x, y] = map.undistorted(points[i].pixel);
    const double qx = (points[i].floor.x_m - scaled.centre.x_m) / scaled.size_m;
    const double qy = (points[i].floor.y_m - scaled.centre.y_m) / scaled.size_m;
    const Homography first{x, y, 1.0, 0.0, 0.0, 0.0, -qx * x, -qx * y, -qx};
    const Homography second{0.0, 0.0, 0.0, x, y, 1.0, -qy * x, -qy * y, -qy};
    for (std::size_t j = 0; j < 9; ++j) {
      equations(2 * i, j) = first[j];
      equations(2 * i + 1, j) = second[j];
    }
  }
  return homogeneous_least_squares(equations);
}

/// All unknowns of homography and lens in one row: H without its last entry, k1 k2 k3 p1 p2, centre in scales.
constexpr std::size_t unknowns_max = 15;
constexpr std::size_t unknowns_plane = 8;

class Bundle {
 public:
  Bundle(const std::vector<FloorPoint>& points, FloorMap& map, const Scaled& scaled, bool with_lens)
      : points_{points}, map_{map}, scaled_{scaled}, unknowns_{with_lens ? unknowns_max : unknowns_plane} {}

  [[nodiscard]] std::vector<double> start(const Homography& h) const {
    std::vector<double> at(unknowns_, 0.0);
    for (std::size_t i = 0; i < unknowns_plane; ++i) at[i] = h[i] / h[8];
    return at;
  }
  /// The unknowns of a map of nearly the same points.
  [[nodiscard]] std::vector<double> start(const FloorMap& near) const {
    Homography h{};
    for (std::size_t j = 0; j < 3; ++j) {
      const double w = near.homography[6 + j];
      h[j] = near.homography[j] - scaled_.centre.x_m * w;
      h[3 + j] = near.homography[3 + j] - scaled_.centre.y_m * w;
      h[6 + j] = scaled_.size_m * w;
    }
    std::vector<double> at = start(h);
    if (unknowns_ == unknowns_plane) return at;
    for (std::size_t i = 0; i < 5; ++i) at[8 + i] = near.lens[i];
    at[13] = near.centre.u / near.scale_px - 0.5 * static_cast<double>(near.frame.width) / near.scale_px;
    at[14] = near.centre.v / near.scale_px - 0.5 * static_cast<double>(near.frame.height) / near.scale_px;
    return at;
  }
  /// Writes the unknowns into the map, whose homography then gives metres.
  void put(std::span<const double> at) const {
    for (std::size_t j = 0; j < 3; ++j) {
      const double w = j == 2 ? 1.0 : at[6 + j];
      map_.homography[j] = scaled_.size_m * at[j] + scaled_.centre.x_m * w;
      map_.homography[3 + j] = scaled_.size_m * at[3 + j] + scaled_.centre.y_m * w;
      map_.homography[6 + j] = w;
    }
    if (unknowns_ == unknowns_plane) return;
    for (std::size_t i = 0; i < 5; ++i) map_.lens[i] = at[8 + i];
    const double width = static_cast<double>(map_.frame.width);
    const double height = static_cast<double>(map_.frame.height);
    map_.centre = {0.5 * width + at[13] * map_.scale_px, 0.5 * height + at[14] * map_.scale_px};
  }
  /// The residual of each point, in scales of the floor.
  void residuals(std::span<const double> at, std::span<double> out) const {
    put(at);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto floor = map_.floor_at(points_[i].pixel);
      // Behind the horizon: so large that no step leads there.
      out[2 * i] = floor ? (floor->x_m - points_[i].floor.x_m) / scaled_.size_m : 1e3;
      out[2 * i + 1] = floor ? (floor->y_m - points_[i].floor.y_m) / scaled_.size_m : 1e3;
    }
  }

  /// The best unknowns near these ones; the map then has them.
  [[nodiscard]] std::vector<double> solve(std::span<const double> near) const {
    std::vector<double> at = levenberg_marquardt(
        near, 2 * points_.size(), [this](std::span<const double> x, std::span<double> out) { residuals(x, out); });
    put(at);
    return at;
  }

 private:
  const std::vector<FloorPoint>& points_;
  FloorMap& map_;
  const Scaled& scaled_;
  std::size_t unknowns_;
};

/// The residuals, as a polynomial over the image.
void fit_polynomial(const std::vector<FloorPoint>& points, std::size_t degree, FloorMap& map) {
  const std::size_t count = terms_of(degree);
  Matrix terms{points.size(), count};
  Matrix left{points.size(), 2};
  std::array<double, terms_of(degree_max)> row{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double u = points[i].pixel.u - 0.5 * static_cast<double>(map.frame.width);
    const double v = points[i].pixel.v - 0.5 * static_cast<double>(map.frame.height);
    terms_at(u / map.scale_px, v / map.scale_px, degree, row.data());
    for (std::size_t j = 0; j < count; ++j) terms(i, j) = row[j];
    const auto floor = map.floor_at(points[i].pixel);
    left(i, 0) = floor ? points[i].floor.x_m - floor->x_m : 0.0;
    left(i, 1) = floor ? points[i].floor.y_m - floor->y_m : 0.0;
  }
  const Matrix solution = least_squares(terms, left);
  map.degree = degree;
  map.polynomial.assign(solution.values().begin(), solution.values().end());
}

}  // namespace

std::string_view name_of(FloorModel model) {
  switch (model) {
    case FloorModel::homography: return "homography";
    case FloorModel::lens: return "lens";
    case FloorModel::polynomial: return "polynomial";
    case FloorModel::lens_polynomial: return "lens_polynomial";
  }
  return "";
}

std::size_t points_needed(const FitOptions& options) {
  switch (options.model) {
    case FloorModel::homography: return 6;
    case FloorModel::lens: return 24;
    case FloorModel::polynomial:
    case FloorModel::lens_polynomial: return 4 * terms_of(options.degree);
  }
  return 0;
}

Result<FloorMap> fit_floor(const std::vector<FloorPoint>& points, ImageSize frame, const FitOptions& options,
                           const FloorMap* near) {
  COSIVA_EXPECT(options.degree >= 2 && options.degree <= degree_max);
  if (auto fine = check(points, options); !fine) return tl::unexpected(fine.error());
  const bool with_lens = options.model == FloorModel::lens || options.model == FloorModel::lens_polynomial;
  FloorMap map;
  map.frame = frame;
  map.centre = {0.5 * static_cast<double>(frame.width), 0.5 * static_cast<double>(frame.height)};
  map.scale_px = 0.5 * static_cast<double>(std::max(frame.width, frame.height));
  const Scaled scaled = scale_of(points);
  std::vector<double> at;
  if (near != nullptr) {
    at = Bundle{points, map, scaled, with_lens}.start(*near);
  } else {
    const Homography h = homography_of(points, map, scaled);
    if (!(std::fabs(h[8]) > 1e-9)) return fail("gvs.fit", no_camera);
    const Bundle plane{points, map, scaled, false};
    at = plane.solve(plane.start(h));
    if (with_lens) at.resize(unknowns_max, 0.0);
  }
  at = Bundle{points, map, scaled, with_lens}.solve(at);
  if (!std::ranges::all_of(at, [](double x) { return std::isfinite(x); })) return fail("gvs.fit", no_camera);
  for (const FloorPoint& point : points)
    if (!map.floor_at(point.pixel)) return fail("gvs.fit", no_camera);
  if (options.model == FloorModel::polynomial || options.model == FloorModel::lens_polynomial)
    fit_polynomial(points, options.degree, map);
  return map;
}

}  // namespace cosiva::vision
