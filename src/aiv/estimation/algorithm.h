#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "cosiva/aiv/estimation/linear.h"
#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// Position estimation (A33): what the article calls an Algorithm, and those that come with the platform. Sans-IO and
/// deterministic: the same object runs on board and in experiments.
namespace cosiva::estimation {

/// Increments of the wheels, or of another counter, since the last call.
struct Odometry {
  double distance_m{};  ///< travelled, forwards positive
  double turn_rad{};    ///< of the body, left positive
  double duration_s{};  ///< of this step, > 0
  /// Variances beyond those of the sensor model, for instance where counts were lost for a while.
  double distance_variance_m2{0.0};
  double turn_variance_rad2{0.0};
  double left_m{0.0};  ///< moved sideways meanwhile, left positive: of a vehicle with omnidirectional wheels
};

/// A tag or a beacon under the reader (A15, A21).
struct Reading {
  std::uint32_t fiducial{};
  Point2 fiducial_M;  ///< surveyed position, in the map
  Point2 detected_B;  ///< measured position, in the body's frame; (0, 0) from a reader that measures the number alone
};

/// The distance of the body origin to a fixed station.
struct Range {
  std::uint32_t station{};
  Point2 station_M;
  double range_m{};
};

struct Estimate {
  Pose2 pose;          ///< X_MB
  Matrix3 covariance;  ///< of (x [m], y [m], heading [rad]), in the map; NaN where none is stated
  /// Travelled along the track since its beginning; nothing without a track.
  std::optional<double> along_m;
};

/// Result of a reading or a range.
struct Rectified {
  bool accepted{false};
  /// Squared innovation over its expected variance, chi-squared with `dimensions` where the stated covariance is
  /// correct (NIS); nothing where none is stated.
  std::optional<double> nis;
  int dimensions{0};
};

/// Quality of the sensors, from their data sheets or a calibration. Every algorithm gets the same model and uses what
/// it can; none is tuned by the ground truth that evaluates it.
struct SensorModel {
  double distance_variance_per_m{1e-4};  ///< q: odometry's random walk, (1 cm)² per metre by default
  double turn_variance_per_m{4e-5};      ///< likewise of the heading [rad²/m]
  double turn_variance_per_rad{1e-4};    ///< and of the turned angle [rad²/rad]
  double distance_scale_sigma{0.02};     ///< wheel wear: error of the odometer's scale
  double turn_scale_sigma{0.02};         ///< likewise of turns, for instance by the track's width
  double turn_drift_sigma_radps{0.0};    ///< turn rate that is counted without a turn: a gyroscope's offset
  double fiducial_along_sigma_m{0.01};   ///< σ_b: of a reading, along the vehicle
  double fiducial_across_sigma_m{0.01};  ///< and across it
  double line_sigma_m{0.002};            ///< lateral offset of a vehicle that follows its path
  double line_heading_sigma_rad{0.02};   ///< and its heading error
  double range_sigma_m{0.1};             ///< of one range, without the errors common to others
  double range_scale_sigma{0.05};        ///< of all ranges: antenna height, clock, speed of the wave
  double range_common_sigma_m{0.15};     ///< of all ranges: delays in the devices
  double range_station_sigma_m{0.1};     ///< of one station's ranges near one position: reflections
  double range_station_length_m{5.0};    ///< the distance over which that error changes
};

/// The settings of an algorithm before it starts.
struct Setting {
  std::shared_ptr<const Track> track;  ///< the track that the vehicle follows; null in the open
  bool start_known{true};              ///< false: `start` has no meaning, the vehicle is anywhere on the circuit
  Pose2 start;
  double start_along_m{};  ///< of `start` on the track
  double start_sigma_m{0.01};
  double start_heading_sigma_rad{0.02};  ///< beyond 1: the heading is not known
  SensorModel sensors;
  std::uint64_t seed{1};  ///< for algorithms that draw random numbers
  std::size_t particles{500};
  std::size_t horizon{4};  ///< number of readings in the unbiased FIR filter
};

/// One algorithm on one vehicle. Inputs come in the order of time; each acts on the result of all inputs before.
class Algorithm {
 public:
  Algorithm() = default;
  Algorithm(const Algorithm&) = delete;
  Algorithm& operator=(const Algorithm&) = delete;
  virtual ~Algorithm() = default;

  virtual void predict(const Odometry& odometry) = 0;
  virtual Rectified rectify(const Reading& reading) = 0;
  virtual Rectified rectify(const Range& range) = 0;
  /// Of the present time.
  [[nodiscard]] virtual Estimate estimate() const = 0;

  /// Of a smoother: its present estimates after each predict() and all rectifications before the next one, first to
  /// last, as many as there were calls of predict(). Empty: there are no estimates but those of estimate() at the time.
  [[nodiscard]] virtual std::vector<Estimate> revised() { return {}; }

  /// Why the algorithm has failed, for an algorithm in another program; its later estimates have no meaning.
  [[nodiscard]] virtual const Error* fault() const { return nullptr; }
};

}  // namespace cosiva::estimation
