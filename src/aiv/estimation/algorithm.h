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

/// What the wheels, or whatever counts, say since the last time.
struct Odometry {
  double distance_m{};  ///< travelled, forwards positive
  double turn_rad{};    ///< of the body, left positive
  double duration_s{};  ///< that it took, > 0
  /// What it may be off by beyond the sensors' figures, as where nothing was counted for a while.
  double distance_variance_m2{0.0};
  double turn_variance_rad2{0.0};
  double left_m{0.0};  ///< gone sideways meanwhile, left positive: of whose wheels roll every way
};

/// A tag or a beacon under the reader (A15, A21).
struct Reading {
  std::uint32_t fiducial{};
  Point2 fiducial_M;  ///< where it was surveyed, in the map
  Point2 detected_B;  ///< where the reader has it, in the body's frame; a reader that only names it: (0, 0)
};

/// The distance to a fixed station, from the body's middle.
struct Range {
  std::uint32_t station{};
  Point2 station_M;
  double range_m{};
};

struct Estimate {
  Pose2 pose;          ///< X_MB
  Matrix3 covariance;  ///< of (x [m], y [m], heading [rad]), in the map; NaN from who states none
  /// Travelled along the track since its beginning, for who is on one.
  std::optional<double> along_m;
};

/// What came of a reading or a range.
struct Rectified {
  bool accepted{false};
  /// Squared innovation over its own expected variance, chi-squared with `dimensions` where the stated covariance is
  /// honest (NIS); nothing from who states none.
  std::optional<double> nis;
  int dimensions{0};
};

/// How good the sensors are, from their data sheets or a calibration. Every algorithm gets the same, uses what it can,
/// and none is tuned by the truth that it is judged by.
struct SensorModel {
  double distance_variance_per_m{1e-4};  ///< q: odometry's random walk, (1 cm)² per metre by default
  double turn_variance_per_m{4e-5};      ///< likewise of the heading [rad²/m]
  double turn_variance_per_rad{1e-4};    ///< and of what it turns [rad²/rad]
  double distance_scale_sigma{0.02};     ///< wheel wear: what the odometer's scale may be off by
  double turn_scale_sigma{0.02};         ///< likewise of turns, for instance by the track's width
  double turn_drift_sigma_radps{0.0};    ///< what it counts as turning that is none: a gyroscope's offset
  double fiducial_along_sigma_m{0.01};   ///< σ_b: of a reading, along the vehicle
  double fiducial_across_sigma_m{0.01};  ///< and across it
  double line_sigma_m{0.002};            ///< how far from its line a vehicle is that follows one
  double line_heading_sigma_rad{0.02};   ///< and how far off the line's heading
  double range_sigma_m{0.1};             ///< of one range, without what it has in common with others
  double range_scale_sigma{0.05};        ///< of all ranges: antenna height, clock, speed of the wave
  double range_common_sigma_m{0.15};     ///< of all ranges: delays in the devices
  double range_station_sigma_m{0.1};     ///< of one station's ranges near one place: reflections
  double range_station_length_m{5.0};    ///< the way over which that becomes another
};

/// What an algorithm is told before it starts.
struct Setting {
  std::shared_ptr<const Track> track;  ///< the line that it follows; none in the open
  bool start_known{true};              ///< false: `start` means nothing, it is somewhere on the circuit
  Pose2 start;
  double start_along_m{};  ///< of `start` on the track
  double start_sigma_m{0.01};
  double start_heading_sigma_rad{0.02};  ///< beyond 1: the heading is not known
  SensorModel sensors;
  std::uint64_t seed{1};  ///< for who draws random numbers
  std::size_t particles{500};
  std::size_t horizon{4};  ///< readings that the unbiased FIR filter looks back
};

/// One algorithm on one vehicle. Told in the order of time; each input has the effect of all that came before.
class Algorithm {
 public:
  Algorithm() = default;
  Algorithm(const Algorithm&) = delete;
  Algorithm& operator=(const Algorithm&) = delete;
  virtual ~Algorithm() = default;

  virtual void predict(const Odometry& odometry) = 0;
  virtual Rectified rectify(const Reading& reading) = 0;
  virtual Rectified rectify(const Range& range) = 0;
  /// Of now.
  [[nodiscard]] virtual Estimate estimate() const = 0;

  /// For who looks back: what it now says of the vehicle after each predict() and all rectifications before the next
  /// one, first to last, as many as there were predict(). Empty: nothing but what estimate() said at the time.
  [[nodiscard]] virtual std::vector<Estimate> revised() { return {}; }

  /// Why it can say no more, for one that lives in another program; what it says after that means nothing.
  [[nodiscard]] virtual const Error* fault() const { return nullptr; }
};

}  // namespace cosiva::estimation
