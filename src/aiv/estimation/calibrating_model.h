#pragma once

#include <array>
#include <span>

#include "cosiva/aiv/estimation/calibrating.h"

/// The model behind the calibrating filter and smoother: motion of the state, and measurement by readings and ranges.
namespace cosiva::estimation::model {

[[nodiscard]] CalibratedState start_state(const Setting& setting, double heading_rad, double heading_sigma_rad);

/// A step of odometry, linear about a state: new = offset + slope·(old − about), plus noise.
struct Motion {
  CalibratedState::Vector offset;
  CalibratedState::Matrix slope;
  CalibratedState::Matrix noise;
};
[[nodiscard]] Motion motion_of(const SensorModel& sensors, const CalibratedState::Vector& about,
                               const Odometry& odometry);
/// Of a state whose mean is already in motion.offset.
void move(CalibratedState& state, const Motion& motion);

/// After a correction: the covariance represents the error as a motion of the plane, (x, y) and the turn about the
/// map's origin, rather than as x and y with a separate heading. Otherwise directions without any information, such as
/// the angle about a single station, seem to gain information from each correction. Source: A. Barrau, S. Bonnabel, The
/// Invariant Extended Kalman Filter as a Stable Observer, IEEE TAC 62 (2017).
void carry(CalibratedState& state, const CalibratedState::Vector& before);

struct PredictedReading {
  std::array<Measured, 2> measured;
  int count{0};
};
[[nodiscard]] PredictedReading predicted_reading(const SensorModel& sensors, Stations& stations,
                                                 const CalibratedState::Vector& about, const Reading& reading);
[[nodiscard]] PredictedReading predicted_reading(const SensorModel& sensors, Stations& stations,
                                                 const CalibratedState::Vector& about, const Range& range);

/// The weight of a squared residual by Student's t: 1.25 where it is zero, less the larger it is.
[[nodiscard]] double credit(double squared, double variance);

struct Update {
  double nis;
  double log_likelihood;
  double variance;  ///< of the noise, as it was used
};
/// @param as_set  the noise is used as stated; otherwise it is enlarged for outliers
Update update(CalibratedState& state, const Measured& measured, bool as_set);

/// The backward pass through measurements taken one after the other from a state of this covariance: λ and Λ after them
/// become λ and Λ before. `residual` is against the state before each.
void back_through(const CalibratedState::Matrix& before, std::span<const Measured> measured,
                  CalibratedState::Vector& lambda, CalibratedState::Matrix& big);

}  // namespace cosiva::estimation::model
