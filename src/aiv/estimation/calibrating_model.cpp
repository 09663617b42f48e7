#include "cosiva/aiv/estimation/calibrating_model.h"

#include <cmath>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/math.h"

namespace cosiva::estimation::model {
namespace {

using State = CalibratedState;
constexpr double freedom = 4.0;  ///< of Student's t
double squared(double v) { return v * v; }

}  // namespace

State start_state(const Setting& setting, double heading_rad, double heading_sigma_rad) {
  const SensorModel& sensors = setting.sensors;
  State state;
  state.mean = State::Vector::Zero(State::size_max);
  state.mean(State::x) = setting.start.x_m;
  state.mean(State::y) = setting.start.y_m;
  state.mean(State::heading) = heading_rad;
  State::Vector variances = State::Vector::Constant(State::size_max, squared(sensors.range_station_sigma_m));
  variances(State::x) = variances(State::y) = squared(setting.start_sigma_m);
  variances(State::heading) = squared(heading_sigma_rad);
  variances(State::distance_scale) = squared(sensors.distance_scale_sigma);
  variances(State::turn_scale) = squared(sensors.turn_scale_sigma);
  variances(State::range_scale) = squared(sensors.range_scale_sigma);
  variances(State::range_common) = squared(sensors.range_common_sigma_m);
  variances(State::turn_drift) = squared(sensors.turn_drift_sigma_radps);
  state.covariance = variances.asDiagonal();
  return state;
}

Motion motion_of(const SensorModel& sensors, const State::Vector& about, const Odometry& odometry) {
  const Eigen::Index n = about.size();
  // A gyroscope's offset drifts whether the vehicle moves or not. Stopped wheels count exactly zero, without an error.
  const double drifts_s = odometry.turn_rad != 0.0 ? odometry.duration_s : 0.0;
  // Counted = (1 + scale)·true + drift, to first order.
  const Odometry truly{odometry.distance_m * (1.0 - about(State::distance_scale)),
                       odometry.turn_rad * (1.0 - about(State::turn_scale)) - drifts_s * about(State::turn_drift),
                       odometry.duration_s,
                       odometry.distance_variance_m2,
                       odometry.turn_variance_rad2,
                       odometry.left_m * (1.0 - about(State::distance_scale))};
  const Pose2 step = step_of(truly);
  const SinCos h = sincos(about(State::heading));
  const double dx = h.cos * step.x_m - h.sin * step.y_m;
  const double dy = h.sin * step.x_m + h.cos * step.y_m;

  Motion motion{about, State::Matrix::Identity(n, n), State::Matrix::Zero(n, n)};
  motion.offset(State::x) += dx;
  motion.offset(State::y) += dy;
  motion.offset(State::heading) += truly.turn_rad;

  const StepCourse course = course_of(truly);
  const SinCos centre = sincos(about(State::heading) + 0.5 * truly.turn_rad + course.aside_rad);
  const double d = course.distance_m;
  const double counted_m = course_of(odometry).distance_m;
  State::Matrix& f = motion.slope;
  f(State::x, State::heading) = -dy;
  f(State::y, State::heading) = dx;
  f(State::x, State::distance_scale) = -counted_m * centre.cos;
  f(State::y, State::distance_scale) = -counted_m * centre.sin;
  f(State::x, State::turn_scale) = 0.5 * d * centre.sin * odometry.turn_rad;
  f(State::y, State::turn_scale) = -0.5 * d * centre.cos * odometry.turn_rad;
  f(State::heading, State::turn_scale) = -odometry.turn_rad;
  f(State::x, State::turn_drift) = 0.5 * d * centre.sin * drifts_s;
  f(State::y, State::turn_drift) = -0.5 * d * centre.cos * drifts_s;
  f(State::heading, State::turn_drift) = -drifts_s;

  const Pose2 from{about(State::x), about(State::y), about(State::heading)};
  motion.noise.topLeftCorner<3, 3>() = spread(sensors, from, truly, Matrix3::Zero());

  // A station's bias decays with the distance, towards zero.
  const double keeps = det_exp(-std::fabs(d) / sensors.range_station_length_m);
  for (Eigen::Index i = State::common_size; i < State::turn_drift; ++i) {
    motion.offset(i) *= keeps;
    f(i, i) = keeps;
    motion.noise(i, i) = squared(sensors.range_station_sigma_m) * (1.0 - keeps * keeps);
  }
  return motion;
}

void move(State& state, const Motion& motion) {
  state.mean = motion.offset;
  const State::Matrix fp = motion.slope.lazyProduct(state.covariance);
  const State::Matrix transposed = motion.slope.transpose();
  state.covariance = motion.noise + fp.lazyProduct(transposed);
  make_symmetric(state.covariance);
}

void carry(State& state, const State::Vector& before) {
  const double dx = state.mean(State::x) - before(State::x);
  const double dy = state.mean(State::y) - before(State::y);
  State::Matrix& p = state.covariance;
  p.row(State::x) -= dy * p.row(State::heading);
  p.row(State::y) += dx * p.row(State::heading);
  p.col(State::x) -= dy * p.col(State::heading);
  p.col(State::y) += dx * p.col(State::heading);
}

PredictedReading predicted_reading(const SensorModel& sensors, Stations&, const State::Vector& about,
                                   const Reading& reading) {
  const SinCos h = sincos(about(State::heading));
  const double dx = reading.fiducial_M.x_m - about(State::x);
  const double dy = reading.fiducial_M.y_m - about(State::y);
  const double ahead = h.cos * dx + h.sin * dy;
  const double left = -h.sin * dx + h.cos * dy;
  PredictedReading predicted;
  predicted.count = 2;
  for (Measured& measured : predicted.measured) measured.slope = State::Vector::Zero(about.size());
  Measured& along = predicted.measured[0];
  along.slope.head<3>() = Vector3(-h.cos, -h.sin, left);
  along.residual = reading.detected_B.x_m - ahead;
  along.variance = squared(sensors.fiducial_along_sigma_m);
  Measured& across = predicted.measured[1];
  across.slope.head<3>() = Vector3(h.sin, -h.cos, -ahead);
  across.residual = reading.detected_B.y_m - left;
  across.variance = squared(sensors.fiducial_across_sigma_m);
  return predicted;
}

PredictedReading predicted_reading(const SensorModel& sensors, Stations& stations, const State::Vector& about,
                                   const Range& range) {
  const double dx = about(State::x) - range.station_M.x_m;
  const double dy = about(State::y) - range.station_M.y_m;
  const double distance_m = norm(dx, dy);
  PredictedReading predicted;
  if (distance_m < 1e-6) return predicted;
  predicted.count = 1;
  Measured& measured = predicted.measured[0];
  measured.slope = State::Vector::Zero(about.size());
  const double scale = 1.0 + about(State::range_scale);
  measured.slope(State::x) = scale * dx / distance_m;
  measured.slope(State::y) = scale * dy / distance_m;
  measured.slope(State::range_scale) = distance_m;
  measured.slope(State::range_common) = 1.0;
  double expected = scale * distance_m + about(State::range_common);
  if (const int own = stations.index(range.station); own >= 0) {
    measured.slope(own) = 1.0;
    expected += about(own);
  }
  measured.residual = range.range_m - expected;
  measured.variance = squared(sensors.range_sigma_m);
  return predicted;
}

double credit(double squared_residual, double variance) {
  return (freedom + 1.0) / (freedom + squared_residual / variance);
}

Update update(State& state, const Measured& measured, bool as_set) {
  const State::Vector ph = state.covariance.lazyProduct(measured.slope);
  const double known = measured.slope.dot(ph);
  const double expected = known + measured.variance;
  const double nis = measured.residual * measured.residual / expected;
  // Student's t as a Gaussian with the variance that the innovation makes likely; near values keep the stated variance.
  double variance = measured.variance;
  if (!as_set) variance /= std::fmin(1.0, credit(measured.residual * measured.residual, expected));
  const double s = known + variance;
  const State::Vector gain = ph / s;
  state.mean += gain * measured.residual;
  // Joseph's form for a scalar: P − g·(Ph)ᵀ − (Ph)·gᵀ + g·s·gᵀ.
  for (Eigen::Index i = 0; i < state.mean.size(); ++i) {
    for (Eigen::Index j = 0; j < state.mean.size(); ++j)
      state.covariance(i, j) += gain(i) * s * gain(j) - gain(i) * ph(j) - ph(i) * gain(j);
  }
  make_symmetric(state.covariance);
  return {nis, -0.5 * (freedom + 1.0) * det_log(1.0 + nis / freedom) - 0.5 * det_log(expected), variance};
}

void back_through(const State::Matrix& before, std::span<const Measured> measured, State::Vector& lambda,
                  State::Matrix& big) {
  // The covariances between the measurements are computed again, then used backwards.
  std::array<State::Matrix, 2> at{before, before};
  if (measured.size() == 2) {
    const State::Vector ph = before.lazyProduct(measured[0].slope);
    const double s = measured[0].slope.dot(ph) + measured[0].variance;
    for (Eigen::Index i = 0; i < ph.size(); ++i) {
      for (Eigen::Index j = 0; j < ph.size(); ++j) at[1](i, j) -= ph(i) * ph(j) / s;
    }
  }
  for (std::size_t k = measured.size(); k-- > 0;) {
    const Measured& one = measured[k];
    const State::Vector ph = at[k].lazyProduct(one.slope);
    const double s = one.slope.dot(ph) + one.variance;
    const State::Vector gain = ph / s;
    // λ ← −hν/s + (I − g·hᵀ)ᵀ·λ;  Λ ← h·hᵀ/s + (I − g·hᵀ)ᵀ·Λ·(I − g·hᵀ).
    const double gl = gain.dot(lambda);
    lambda -= one.slope * (gl + one.residual / s);
    const State::Vector bg = big.lazyProduct(gain);
    const double gbg = gain.dot(bg);
    for (Eigen::Index i = 0; i < ph.size(); ++i) {
      for (Eigen::Index j = 0; j < ph.size(); ++j) {
        big(i, j) += one.slope(i) * one.slope(j) * (1.0 / s + gbg) - one.slope(i) * bg(j) - bg(i) * one.slope(j);
      }
    }
  }
}

}  // namespace cosiva::estimation::model
