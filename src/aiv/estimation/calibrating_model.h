#pragma once

#include <array>
#include <span>

#include "cosiva/aiv/estimation/calibrating.h"

/// The model behind the calibrating filter and smoother: how the state moves, and what readings and ranges say of it.
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

/// What a correction has moved: the covariance keeps what it knows of the error as a motion of the plane, (x, y) and
/// the turn about the map's origin, rather than of x and y with the heading apart. Else directions that nothing has
/// told, such as round the only station, seem to be told by each correction along the way. Source: A. Barrau, S.
/// Bonnabel, The Invariant Extended Kalman Filter as a Stable Observer, IEEE TAC 62 (2017).
void carry(CalibratedState& state, const CalibratedState::Vector& before);

struct PredictedReading {
  std::array<Measured, 2> measured;
  int count{0};
};
[[nodiscard]] PredictedReading predicted_reading(const SensorModel& sensors, Stations& stations,
                                                 const CalibratedState::Vector& about, const Reading& reading);
[[nodiscard]] PredictedReading predicted_reading(const SensorModel& sensors, Stations& stations,
                                                 const CalibratedState::Vector& about, const Range& range);

/// What a squared residual is worth by Student's t: 1.25 where it is nothing, less the further off it is.
[[nodiscard]] double credit(double squared, double variance);

struct Update {
  double nis;
  double log_likelihood;
  double variance;  ///< of the noise, as it was believed
};
/// @param as_set  the noise is believed as it is; else it is larger for what is far off
Update update(CalibratedState& state, const Measured& measured, bool as_set);

/// The backward pass through measurements taken one after the other from a state of this covariance: λ and Λ after them
/// become λ and Λ before. `residual` is against the state before each.
void back_through(const CalibratedState::Matrix& before, std::span<const Measured> measured,
                  CalibratedState::Vector& lambda, CalibratedState::Matrix& big);

}  // namespace cosiva::estimation::model
