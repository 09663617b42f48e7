#include "cosiva/physical/vision/floor_map.h"

#include <cmath>

namespace cosiva::vision {

void terms_at(double x, double y, std::size_t degree, double* terms) {
  // Each order from the one before: all of them times x, and the last one times y.
  terms[0] = 1.0;
  std::size_t before = 0;
  std::size_t at = 1;
  for (std::size_t order = 1; order <= degree; ++order) {
    for (std::size_t i = 0; i < order; ++i) terms[at + i] = terms[before + i] * x;
    terms[at + order] = terms[before + order - 1] * y;
    before = at;
    at += order + 1;
  }
}

std::array<double, 2> FloorMap::undistorted(PixelPoint pixel) const {
  const double x = (pixel.u - centre.u) / scale_px;
  const double y = (pixel.v - centre.v) / scale_px;
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (lens[0] + r2 * (lens[1] + r2 * lens[2]));
  return {x * radial + 2.0 * lens[3] * x * y + lens[4] * (r2 + 2.0 * x * x),
          y * radial + lens[3] * (r2 + 2.0 * y * y) + 2.0 * lens[4] * x * y};
}

std::optional<Point2> FloorMap::floor_at(PixelPoint pixel) const {
  const auto [x, y] = undistorted(pixel);
  const auto& h = homography;
  const double w = h[6] * x + h[7] * y + h[8];
  // Behind the horizon: the homography is scaled so that w is about one in the image's centre.
  if (!(w > 1e-6)) return std::nullopt;
  Point2 floor{(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w};
  if (degree > 0) {
    std::array<double, terms_of(degree_max)> terms{};
    const double centre_u = 0.5 * static_cast<double>(frame.width);
    const double centre_v = 0.5 * static_cast<double>(frame.height);
    terms_at((pixel.u - centre_u) / scale_px, (pixel.v - centre_v) / scale_px, degree, terms.data());
    const std::size_t count = terms_of(degree);
    for (std::size_t i = 0; i < count; ++i) {
      floor.x_m += polynomial[i] * terms[i];
      floor.y_m += polynomial[count + i] * terms[i];
    }
  }
  if (!std::isfinite(floor.x_m) || !std::isfinite(floor.y_m)) return std::nullopt;
  return floor;
}

std::optional<PixelPoint> FloorMap::pixel_at(Point2 floor) const {
  const double width = static_cast<double>(frame.width);
  const double height = static_cast<double>(frame.height);
  PixelPoint pixel{0.5 * width, 0.5 * height};
  constexpr int rounds = 30;
  for (int round = 0; round < rounds; ++round) {
    const auto here = floor_at(pixel);
    const auto right = floor_at({pixel.u + 0.5, pixel.v});
    const auto below = floor_at({pixel.u, pixel.v + 0.5});
    if (!here || !right || !below) return std::nullopt;
    const double a = 2.0 * (right->x_m - here->x_m);
    const double b = 2.0 * (below->x_m - here->x_m);
    const double c = 2.0 * (right->y_m - here->y_m);
    const double d = 2.0 * (below->y_m - here->y_m);
    const double determinant = a * d - b * c;
    if (determinant == 0.0) return std::nullopt;
    const double ex = floor.x_m - here->x_m;
    const double ey = floor.y_m - here->y_m;
    const double du = (d * ex - b * ey) / determinant;
    const double dv = (a * ey - c * ex) / determinant;
    // Strong distortion makes the first step too long: a step is limited to a quarter of the image.
    const double step = norm(du, dv);
    const double shorter = step > 0.25 * width ? 0.25 * width / step : 1.0;
    pixel.u += shorter * du;
    pixel.v += shorter * dv;
    if (std::fabs(du) + std::fabs(dv) < 1e-7) break;
    if (pixel.u < -0.5 * width || pixel.u > 1.5 * width || pixel.v < -0.5 * height || pixel.v > 1.5 * height)
      return std::nullopt;
  }
  constexpr double margin = 0.1;
  if (pixel.u < -margin * width || pixel.u > (1.0 + margin) * width || pixel.v < -margin * height ||
      pixel.v > (1.0 + margin) * height)
    return std::nullopt;
  const auto there = floor_at(pixel);
  if (!there || distance(*there, floor) > 1e-6) return std::nullopt;
  return pixel;
}

}  // namespace cosiva::vision
