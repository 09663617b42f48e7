#include "cosiva/aiv/estimation/planar.h"

#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/base/math_inline.h"

namespace cosiva::estimation {
namespace {

/// sin(x)/x and (1 − cos x)/x, without dividing by zero.
struct ArcShape {
  double ahead;
  double aside;
};
ArcShape arc_shape(double x) {
  if (std::fabs(x) < 1e-4) return {1.0 - x * x / 6.0, 0.5 * x};
  const SinCos turn = sincos(x);
  return {turn.sin / x, (1.0 - turn.cos) / x};
}

Matrix2 rotation(double angle_rad) {
  const SinCos r = sincos(angle_rad);
  Matrix2 m;
  m << r.cos, -r.sin, r.sin, r.cos;
  return m;
}

Vector2 vector(Point2 p) { return {p.x_m, p.y_m}; }

/// Position of a fiducial in the body's frame, for a given pose.
Vector2 detected_from(double x_m, double y_m, double heading_rad, Point2 fiducial_M) {
  const SinCos h = sincos(heading_rad);
  const double dx = fiducial_M.x_m - x_m;
  const double dy = fiducial_M.y_m - y_m;
  return {h.cos * dx + h.sin * dy, -h.sin * dx + h.cos * dy};
}

double squared_over(const Vector2& v, const Matrix2& s) {
  const double det = s(0, 0) * s(1, 1) - s(0, 1) * s(1, 0);
  return (s(1, 1) * v(0) * v(0) - (s(0, 1) + s(1, 0)) * v(0) * v(1) + s(0, 0) * v(1) * v(1)) / det;
}

Matrix2 inverse_of(const Matrix2& s) {
  const double det = s(0, 0) * s(1, 1) - s(0, 1) * s(1, 0);
  Matrix2 m;
  m << s(1, 1), -s(0, 1), -s(1, 0), s(0, 0);
  return m / det;
}

void add_to(Pose2& pose, const Vector3& d) {
  pose = {pose.x_m + d(0), pose.y_m + d(1), wrap_angle(pose.heading_rad + d(2))};
}

}  // namespace

Pose2 step_of(const Odometry& odometry) {
  const ArcShape shape = arc_shape(odometry.turn_rad);
  Pose2 step{odometry.distance_m * shape.ahead, odometry.distance_m * shape.aside, wrap_angle(odometry.turn_rad)};
  if (odometry.left_m != 0.0) {
    step.x_m -= odometry.left_m * shape.aside;
    step.y_m += odometry.left_m * shape.ahead;
  }
  return step;
}

StepCourse course_of(const Odometry& odometry) {
  if (odometry.left_m == 0.0) return {odometry.distance_m, 0.0};
  return {norm(odometry.distance_m, odometry.left_m), det_atan2(odometry.left_m, odometry.distance_m)};
}

Pose2 moved(const Pose2& X_MB, const Odometry& odometry) { return X_MB * step_of(odometry); }

Matrix3 start_covariance(const Setting& setting) {
  const double p = setting.start_sigma_m * setting.start_sigma_m;
  const double h = setting.start_heading_sigma_rad * setting.start_heading_sigma_rad;
  return Vector3(p, p, h).asDiagonal();
}

Vector2 step_variances(const SensorModel& sensors, const Odometry& odometry) {
  const double distance_m = std::fabs(course_of(odometry).distance_m);
  return {sensors.distance_variance_per_m * distance_m + odometry.distance_variance_m2,
          sensors.turn_variance_per_m * distance_m + sensors.turn_variance_per_rad * std::fabs(odometry.turn_rad) +
              odometry.turn_variance_rad2};
}

Matrix3 spread(const SensorModel& sensors, const Pose2& X_MB, const Odometry& odometry, const Matrix3& covariance) {
  const StepCourse course = course_of(odometry);
  const SinCos centre = sincos(X_MB.heading_rad + 0.5 * odometry.turn_rad + course.aside_rad);
  const double d = course.distance_m;
  Matrix3 f = Matrix3::Identity();
  f(0, 2) = -d * centre.sin;
  f(1, 2) = d * centre.cos;
  Eigen::Matrix<double, 3, 2> g;
  g << centre.cos, -0.5 * d * centre.sin, centre.sin, 0.5 * d * centre.cos, 0.0, 1.0;
  Matrix3 after =
      f * covariance * f.transpose() + g * Matrix2(step_variances(sensors, odometry).asDiagonal()) * g.transpose();
  make_symmetric(after);
  return after;
}

double range_variance(const SensorModel& sensors, double range_m) {
  const double scale_m = sensors.range_scale_sigma * range_m;
  return sensors.range_sigma_m * sensors.range_sigma_m + sensors.range_common_sigma_m * sensors.range_common_sigma_m +
         sensors.range_station_sigma_m * sensors.range_station_sigma_m + scale_m * scale_m;
}

Matrix2 fiducial_covariance(const SensorModel& sensors) {
  return Vector2(sensors.fiducial_along_sigma_m * sensors.fiducial_along_sigma_m,
                 sensors.fiducial_across_sigma_m * sensors.fiducial_across_sigma_m)
      .asDiagonal();
}

Estimate on_track(const Track& track, const SensorModel& sensors, double along_m, double variance_m2) {
  const zone::TrackPosition position = track.position_at(along_m);
  const zone::Section& section = track.circuit().section(position.section);
  Estimate estimate{section.pose_at(position.s_m), Matrix3::Zero(), along_m};
  const SinCos h = plain::sincos(estimate.pose.heading_rad);
  const double across = sensors.line_sigma_m * sensors.line_sigma_m;
  const double curvature = section.curvature_at(position.s_m);
  Matrix3& c = estimate.covariance;
  c(0, 0) = variance_m2 * h.cos * h.cos + across * h.sin * h.sin;
  c(1, 1) = variance_m2 * h.sin * h.sin + across * h.cos * h.cos;
  c(0, 1) = c(1, 0) = (variance_m2 - across) * h.sin * h.cos;
  // In a bend an error of the arc length is an error of the heading.
  c(0, 2) = c(2, 0) = variance_m2 * curvature * h.cos;
  c(1, 2) = c(2, 1) = variance_m2 * curvature * h.sin;
  c(2, 2) = variance_m2 * curvature * curvature + sensors.line_heading_sigma_rad * sensors.line_heading_sigma_rad;
  return estimate;
}

namespace {

/// A sum of positive terms less another one is exact to this; NaN passes, and the estimate then shows it.
constexpr double covariance_rounding = 1e-9;
bool has_variances(const Matrix3& covariance) { return !(covariance.diagonal().minCoeff() < -covariance_rounding); }
/// After a correction: removes what rounding has left of asymmetry.
void finish_correction(Matrix3& covariance) {
  make_symmetric(covariance);
  COSIVA_EXPECT(has_variances(covariance));
}

}  // namespace

// ---- EKF -----------------------------------------------------------------------------------------------------------

Ekf::Ekf(Setting setting)
    : configured{std::move(setting)}, current_estimate{configured.start}, doubt{start_covariance(configured)} {
  COSIVA_EXPECT(has_variances(doubt));
}

void Ekf::predict(const Odometry& odometry) {
  doubt = spread(configured.sensors, current_estimate, odometry, doubt);
  current_estimate = moved(current_estimate, odometry);
}

Rectified Ekf::rectify(const Reading& reading) {
  const Vector2 expected =
      detected_from(current_estimate.x_m, current_estimate.y_m, current_estimate.heading_rad, reading.fiducial_M);
  const Matrix2 r = rotation(current_estimate.heading_rad);
  Eigen::Matrix<double, 2, 3> h;
  h.leftCols<2>() = -r.transpose();
  h.col(2) = Vector2(expected(1), -expected(0));
  const Vector2 innovation = vector(reading.detected_B) - expected;
  const Matrix2 s = h * doubt * h.transpose() + fiducial_covariance(configured.sensors);
  const double nis = squared_over(innovation, s);
  if (!(nis <= gate_2)) return {false, nis, 2};
  const Eigen::Matrix<double, 3, 2> gain = doubt * h.transpose() * inverse_of(s);
  add_to(current_estimate, gain * innovation);
  // Joseph's form: stays positive despite rounding.
  const Matrix3 rest = Matrix3::Identity() - gain * h;
  doubt = rest * doubt * rest.transpose() + gain * fiducial_covariance(configured.sensors) * gain.transpose();
  finish_correction(doubt);
  return {true, nis, 2};
}

Rectified Ekf::rectify(const Range& range) {
  const double dx = current_estimate.x_m - range.station_M.x_m;
  const double dy = current_estimate.y_m - range.station_M.y_m;
  const double expected = norm(dx, dy);
  if (expected < 1e-6) return {};
  const Vector3 h(dx / expected, dy / expected, 0.0);
  const double r = range_variance(configured.sensors, expected);
  const Vector3 ph = doubt * h;
  const double s = h.dot(ph) + r;
  const double innovation = range.range_m - expected;
  const double nis = innovation * innovation / s;
  if (!(nis <= gate_1)) return {false, nis, 1};
  const Vector3 gain = ph / s;
  add_to(current_estimate, gain * innovation);
  doubt -= gain * ph.transpose();
  finish_correction(doubt);
  return {true, nis, 1};
}

// ---- UKF -----------------------------------------------------------------------------------------------------------

namespace {

constexpr int points = 7;
using Sigma = Eigen::Matrix<double, 3, points>;

/// The mean and three pairs about it, as deviations; all but the first have equal weights.
Sigma deviations(const Matrix3& covariance) {
  const Eigen::LLT<Matrix3> root(covariance + 1e-18 * Matrix3::Identity());
  const Matrix3 l = root.matrixL();
  Sigma all;
  all.col(0).setZero();
  for (int i = 0; i < 3; ++i) {
    all.col(1 + 2 * i) = std::sqrt(3.0) * l.col(i);
    all.col(2 + 2 * i) = -std::sqrt(3.0) * l.col(i);
  }
  return all;
}
/// κ = 0, for which the central point has no weight: n = 3 directions of √3 standard deviations.
double weight(int i) { return i == 0 ? 0.0 : 1.0 / 6.0; }

}  // namespace

void Ukf::predict(const Odometry& odometry) {
  const Sigma about = deviations(doubt);
  const Pose2 centre = moved(current_estimate, odometry);
  Sigma after;
  Vector3 mean = Vector3::Zero();
  for (int i = 0; i < points; ++i) {
    const Pose2 from{current_estimate.x_m + about(0, i), current_estimate.y_m + about(1, i),
                     current_estimate.heading_rad + about(2, i)};
    const Pose2 to = moved(from, odometry);
    // Deviations from the central point, so that headings need no wrapping.
    after.col(i) = Vector3(to.x_m - centre.x_m, to.y_m - centre.y_m, about(2, i));
    mean += weight(i) * after.col(i);
  }
  Matrix3 covariance = spread(configured.sensors, current_estimate, odometry, Matrix3::Zero());
  for (int i = 0; i < points; ++i) covariance += weight(i) * (after.col(i) - mean) * (after.col(i) - mean).transpose();
  make_symmetric(covariance);
  doubt = covariance;
  current_estimate = centre;
  add_to(current_estimate, mean);
}

Rectified Ukf::rectify(const Reading& reading) {
  const Sigma about = deviations(doubt);
  Eigen::Matrix<double, 2, points> z;
  Vector2 mean = Vector2::Zero();
  for (int i = 0; i < points; ++i) {
    z.col(i) = detected_from(current_estimate.x_m + about(0, i), current_estimate.y_m + about(1, i),
                             current_estimate.heading_rad + about(2, i), reading.fiducial_M);
    mean += weight(i) * z.col(i);
  }
  Matrix2 s = fiducial_covariance(configured.sensors);
  Eigen::Matrix<double, 3, 2> cross = Eigen::Matrix<double, 3, 2>::Zero();
  for (int i = 0; i < points; ++i) {
    s += weight(i) * (z.col(i) - mean) * (z.col(i) - mean).transpose();
    cross += weight(i) * about.col(i) * (z.col(i) - mean).transpose();
  }
  const Vector2 innovation = vector(reading.detected_B) - mean;
  const double nis = squared_over(innovation, s);
  if (!(nis <= gate_2)) return {false, nis, 2};
  const Eigen::Matrix<double, 3, 2> gain = cross * inverse_of(s);
  add_to(current_estimate, gain * innovation);
  doubt -= gain * s * gain.transpose();
  finish_correction(doubt);
  return {true, nis, 2};
}

Rectified Ukf::rectify(const Range& range) {
  const Sigma about = deviations(doubt);
  Eigen::Matrix<double, 1, points> z;
  double mean = 0.0;
  for (int i = 0; i < points; ++i) {
    z(i) = norm(current_estimate.x_m + about(0, i) - range.station_M.x_m,
                current_estimate.y_m + about(1, i) - range.station_M.y_m);
    mean += weight(i) * z(i);
  }
  double s = range_variance(configured.sensors, mean);
  Vector3 cross = Vector3::Zero();
  for (int i = 0; i < points; ++i) {
    s += weight(i) * (z(i) - mean) * (z(i) - mean);
    cross += weight(i) * (z(i) - mean) * about.col(i);
  }
  const double innovation = range.range_m - mean;
  const double nis = innovation * innovation / s;
  if (!(nis <= gate_1)) return {false, nis, 1};
  const Vector3 gain = cross / s;
  add_to(current_estimate, gain * innovation);
  doubt -= gain * s * gain.transpose();
  finish_correction(doubt);
  return {true, nis, 1};
}

// ---- invariant EKF -------------------------------------------------------------------------------------------------

namespace {

/// Of X = exp(ξ)·X̂ to first order: the pose moves by ξ, and with the heading the position turns about the map's origin.
Matrix3 to_pose(const Pose2& pose) {
  Matrix3 m = Matrix3::Identity();
  m(0, 2) = -pose.y_m;
  m(1, 2) = pose.x_m;
  return m;
}
Matrix3 from_pose(const Pose2& pose) {
  Matrix3 m = Matrix3::Identity();
  m(0, 2) = pose.y_m;
  m(1, 2) = -pose.x_m;
  return m;
}

}  // namespace

InvariantEkf::InvariantEkf(Setting setting) : setting_{std::move(setting)}, pose_{setting_.start} {
  const Matrix3 t = from_pose(pose_);
  covariance_ = t * start_covariance(setting_) * t.transpose();
  COSIVA_EXPECT(has_variances(covariance_));
}

Estimate InvariantEkf::estimate() const {
  const Matrix3 t = to_pose(pose_);
  return {pose_, t * covariance_ * t.transpose(), std::nullopt};
}

void InvariantEkf::predict(const Odometry& odometry) {
  // The error itself does not change; the step's noise is added, transformed into the map.
  const Matrix3 noise = spread(setting_.sensors, pose_, odometry, Matrix3::Zero());
  pose_ = moved(pose_, odometry);
  const Matrix3 t = from_pose(pose_);
  covariance_ += t * noise * t.transpose();
  finish_correction(covariance_);
}

void InvariantEkf::correct(const Vector3& xi) {
  const ArcShape shape = arc_shape(xi(2));
  const Pose2 exp_xi{xi(0) * shape.ahead - xi(1) * shape.aside, xi(0) * shape.aside + xi(1) * shape.ahead, xi(2)};
  pose_ = exp_xi * pose_;
}

Rectified InvariantEkf::rectify(const Reading& reading) {
  const Point2 estimated_M = pose_ * reading.detected_B;
  Eigen::Matrix<double, 2, 3> h;
  h << 1.0, 0.0, -reading.fiducial_M.y_m, 0.0, 1.0, reading.fiducial_M.x_m;
  const Vector2 innovation = vector(reading.fiducial_M) - vector(estimated_M);
  const Matrix2 r = rotation(pose_.heading_rad);
  const Matrix2 noise = r * fiducial_covariance(setting_.sensors) * r.transpose();
  const Matrix2 s = h * covariance_ * h.transpose() + noise;
  const double nis = squared_over(innovation, s);
  if (!(nis <= gate_2)) return {false, nis, 2};
  const Eigen::Matrix<double, 3, 2> gain = covariance_ * h.transpose() * inverse_of(s);
  const Matrix3 rest = Matrix3::Identity() - gain * h;
  covariance_ = rest * covariance_ * rest.transpose() + gain * noise * gain.transpose();
  finish_correction(covariance_);
  correct(gain * innovation);
  return {true, nis, 2};
}

Rectified InvariantEkf::rectify(const Range& range) {
  const double dx = pose_.x_m - range.station_M.x_m;
  const double dy = pose_.y_m - range.station_M.y_m;
  const double expected = norm(dx, dy);
  if (expected < 1e-6) return {};
  const Vector3 h = to_pose(pose_).transpose() * Vector3(dx / expected, dy / expected, 0.0);
  const Vector3 ph = covariance_ * h;
  const double s = h.dot(ph) + range_variance(setting_.sensors, expected);
  const double innovation = range.range_m - expected;
  const double nis = innovation * innovation / s;
  if (!(nis <= gate_1)) return {false, nis, 1};
  const Vector3 gain = ph / s;
  covariance_ -= gain * ph.transpose();
  finish_correction(covariance_);
  correct(gain * innovation);
  return {true, nis, 1};
}

}  // namespace cosiva::estimation
