#include "cosiva/physical/vision/floor_fit.h"

// squares.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "cosiva/base/expect.h"

namespace cosiva::vision {
namespace {

constexpr const char* no_camera = "no camera maps these positions to these pixels: check the names of the columns";

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// The points' spread across their longest direction, as a ratio of the spread along it.
template <class Get>
double thinness(const std::vector<FloorPoint>& points, const Get& get) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const FloorPoint& point : points) mean += get(point);
  mean /= static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const FloorPoint& point : points) spread += (get(point) - mean) * (get(point) - mean).transpose();
  const Eigen::Vector2d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues();
  return values[1] > 0.0 ? std::sqrt(std::max(0.0, values[0]) / values[1]) : 0.0;
}

Eigen::Vector2d floor_of(const FloorPoint& point) { return {point.floor.x_m, point.floor.y_m}; }
Eigen::Vector2d pixel_of(const FloorPoint& point) { return {point.pixel.u, point.pixel.v}; }

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
  Eigen::Vector2d centre;
  double size;
};
Scaled scale_of(const std::vector<FloorPoint>& points) {
  Eigen::Vector2d low = floor_of(points[0]);
  Eigen::Vector2d high = low;
  for (const FloorPoint& point : points) {
    low = low.cwiseMin(floor_of(point));
    high = high.cwiseMax(floor_of(point));
  }
  return {0.5 * (low + high), 0.5 * (high - low).maxCoeff()};
}

/// Hartley's direct linear transform. Source: Hartley, Zisserman, Multiple View Geometry, algorithm 4.2.
Eigen::Matrix3d homography_of(const std::vector<FloorPoint>& points, const FloorMap& map, const Scaled& scaled) {
  Matrix rows(2 * static_cast<Eigen::Index>(points.size()), 9);
  rows.setZero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [x, y] = map.undistorted(points[i].pixel);
    const Eigen::Vector2d q = (floor_of(points[i]) - scaled.centre) / scaled.size;
    const auto k = 2 * static_cast<Eigen::Index>(i);
    rows.row(k) << x, y, 1.0, 0.0, 0.0, 0.0, -q[0] * x, -q[0] * y, -q[0];
    rows.row(k + 1) << 0.0, 0.0, 0.0, x, y, 1.0, -q[1] * x, -q[1] * y, -q[1];
  }
  const Eigen::Matrix<double, 9, 9> squares = rows.transpose() * rows;
  const Eigen::Matrix<double, 9, 1> least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>>(squares).eigenvectors().col(0);
  Eigen::Matrix3d h;
  h << least[0], least[1], least[2], least[3], least[4], least[5], least[6], least[7], least[8];
  return h;
}

/// All unknowns of homography and lens in one row: H without its last entry, k1 k2 k3 p1 p2, centre in scales.
constexpr int unknowns_max = 15;

class Bundle {
 public:
  Bundle(const std::vector<FloorPoint>& points, FloorMap& map, const Scaled& scaled, bool with_lens)
      : points_{points}, map_{map}, scaled_{scaled}, unknowns_{with_lens ? unknowns_max : 8} {}

  [[nodiscard]] Vector start(const Eigen::Matrix3d& h) const {
    Vector at = Vector::Zero(unknowns_);
    for (int i = 0; i < 8; ++i) at[i] = h(i / 3, i % 3) / h(2, 2);
    return at;
  }
  /// The unknowns of a map of nearly the same points.
  [[nodiscard]] Vector start(const FloorMap& near) const {
    Eigen::Matrix3d h;
    for (int i = 0; i < 9; ++i) h(i / 3, i % 3) = near.homography[static_cast<std::size_t>(i)];
    Eigen::Matrix3d there;
    there << 1.0, 0.0, -scaled_.centre[0], 0.0, 1.0, -scaled_.centre[1], 0.0, 0.0, scaled_.size;
    Vector at = start(Eigen::Matrix3d(there * h));
    if (unknowns_ == 8) return at;
    for (int i = 0; i < 5; ++i) at[8 + i] = near.lens[static_cast<std::size_t>(i)];
    at[13] = near.centre.u / near.scale_px - 0.5 * static_cast<double>(near.frame.width) / near.scale_px;
    at[14] = near.centre.v / near.scale_px - 0.5 * static_cast<double>(near.frame.height) / near.scale_px;
    return at;
  }
  /// Writes the unknowns into the map, whose homography then gives metres.
  void put(const Vector& at) const {
    Eigen::Matrix3d h;
    h << at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7], 1.0;
    Eigen::Matrix3d back;
    back << scaled_.size, 0.0, scaled_.centre[0], 0.0, scaled_.size, scaled_.centre[1], 0.0, 0.0, 1.0;
    h = back * h;
    for (int i = 0; i < 9; ++i) map_.homography[static_cast<std::size_t>(i)] = h(i / 3, i % 3);
    if (unknowns_ == 8) return;
    for (int i = 0; i < 5; ++i) map_.lens[static_cast<std::size_t>(i)] = at[8 + i];
    const double width = static_cast<double>(map_.frame.width);
    const double height = static_cast<double>(map_.frame.height);
    map_.centre = {0.5 * width + at[13] * map_.scale_px, 0.5 * height + at[14] * map_.scale_px};
  }
  /// The residual of each point, in scales of the floor.
  void residuals(const Vector& at, Vector& out) const {
    put(at);
    out.resize(2 * static_cast<Eigen::Index>(points_.size()));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto k = 2 * static_cast<Eigen::Index>(i);
      const auto floor = map_.floor_at(points_[i].pixel);
      // Behind the horizon: so large that no step leads there.
      out[k] = floor ? (floor->x_m - points_[i].floor.x_m) / scaled_.size : 1e3;
      out[k + 1] = floor ? (floor->y_m - points_[i].floor.y_m) / scaled_.size : 1e3;
    }
  }

  /// Levenberg and Marquardt with differences for derivatives: everything is smooth and of size one.
  [[nodiscard]] Vector solve(Vector at) const {
    Vector here;
    Vector moved;
    residuals(at, here);
    Matrix slopes(here.size(), unknowns_);
    double damping = 1e-3;
    constexpr int rounds = 60;
    for (int round = 0; round < rounds; ++round) {
      for (int i = 0; i < unknowns_; ++i) {
        constexpr double step = 1e-6;
        Vector neighbour = at;
        neighbour[i] += step;
        residuals(neighbour, moved);
        slopes.col(i) = (moved - here) / step;
      }
      const Matrix squares = slopes.transpose() * slopes;
      const Vector pull = slopes.transpose() * here;
      const double before = here.squaredNorm();
      bool better = false;
      while (!better && damping < 1e9) {
        Matrix damped = squares;
        damped.diagonal() *= 1.0 + damping;
        damped.diagonal().array() += 1e-12;
        const Vector next = at - Vector(damped.ldlt().solve(pull));
        residuals(next, moved);
        better = moved.allFinite() && moved.squaredNorm() < before;
        if (better) {
          at = next;
          here = moved;
        }
        damping = better ? std::max(1e-9, 0.2 * damping) : 5.0 * damping;
      }
      if (!better || before - here.squaredNorm() < 1e-13 * before) break;
    }
    put(at);
    return at;
  }

 private:
  const std::vector<FloorPoint>& points_;
  FloorMap& map_;
  const Scaled& scaled_;
  int unknowns_;
};

/// The residuals, as a polynomial over the image.
void fit_polynomial(const std::vector<FloorPoint>& points, std::size_t degree, FloorMap& map) {
  const std::size_t count = terms_of(degree);
  const auto rows = static_cast<Eigen::Index>(points.size());
  Matrix terms(rows, static_cast<Eigen::Index>(count));
  Matrix left(rows, 2);
  std::array<double, terms_of(degree_max)> row{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double u = points[i].pixel.u - 0.5 * static_cast<double>(map.frame.width);
    const double v = points[i].pixel.v - 0.5 * static_cast<double>(map.frame.height);
    terms_at(u / map.scale_px, v / map.scale_px, degree, row.data());
    const auto k = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < count; ++j) terms(k, static_cast<Eigen::Index>(j)) = row[j];
    const auto floor = map.floor_at(points[i].pixel);
    left(k, 0) = floor ? points[i].floor.x_m - floor->x_m : 0.0;
    left(k, 1) = floor ? points[i].floor.y_m - floor->y_m : 0.0;
  }
  const Matrix solution = terms.colPivHouseholderQr().solve(left);
  map.degree = degree;
  map.polynomial.assign(2 * count, 0.0);
  for (std::size_t j = 0; j < count; ++j) {
    map.polynomial[j] = solution(static_cast<Eigen::Index>(j), 0);
    map.polynomial[count + j] = solution(static_cast<Eigen::Index>(j), 1);
  }
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
  Vector at;
  if (near != nullptr) {
    at = Bundle{points, map, scaled, with_lens}.start(*near);
  } else {
    const Eigen::Matrix3d h = homography_of(points, map, scaled);
    if (!(std::fabs(h(2, 2)) > 1e-9)) return fail("gvs.fit", no_camera);
    const Bundle plane{points, map, scaled, false};
    at = plane.solve(plane.start(h));
    if (with_lens) {
      const Vector eight = at;
      at = Vector::Zero(unknowns_max);
      at.head(8) = eight;
    }
  }
  at = Bundle{points, map, scaled, with_lens}.solve(at);
  if (!at.allFinite()) return fail("gvs.fit", no_camera);
  for (const FloorPoint& point : points)
    if (!map.floor_at(point.pixel)) return fail("gvs.fit", no_camera);
  if (options.model == FloorModel::polynomial || options.model == FloorModel::lens_polynomial)
    fit_polynomial(points, options.degree, map);
  return map;
}

}  // namespace cosiva::vision
