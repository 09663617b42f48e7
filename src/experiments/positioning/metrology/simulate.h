#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/trial.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// A vehicle that follows its track in virtual time, with completely known noise: figures 16 and 17 with a model as the
/// physical side.
struct Simulation {
  std::shared_ptr<const estimation::Track> track;
  double distance_m{100.0};  ///< TDTmax: length of the run
  double speed_mps{0.5};
  double odometry_hz{50.0};
  /// Beacons: at a fixed pitch along the unrolled path, or at `fiducials`.
  double pitch_m{0.5};
  struct Fiducial {
    std::uint32_t number;
    double along_m;  ///< where the track passes the fiducial, within one loop
    Point2 position_M;
  };
  std::vector<Fiducial> fiducials{};  ///< sorted by along_m; empty: by pitch
  bool fiducials_only{false};         ///< `fiducials` are complete, even if empty
  double read_ratio{1.0};             ///< ratio of passed beacons that are read
  double survey_sigma_m{0.0};         ///< error of a beacon's surveyed position: the same every time
  double scale_sigma{0.0};            ///< of the odometer's scale, one draw per run
  bool turns{true};                   ///< odometry measures turns too; an algorithm that follows a path needs none
  estimation::SensorModel sensors{};  ///< true of the vehicle, and given to the algorithms
  double start_sigma_m{0.01};
  double start_heading_sigma_rad{0.02};
};

/// Fails ("simulation.…") naming the invalid number.
[[nodiscard]] Result<void> check(const Simulation& simulation);

/// Makes one run. Same seed, same run.
/// @param run  its content is replaced, its memory reused
void simulate(const Simulation& simulation, std::uint64_t seed, Trial& run);

/// The zone's beacons that the track passes within `reach_m`, at the nearest position to each.
[[nodiscard]] std::vector<Simulation::Fiducial> fiducials_of(const estimation::Track& track,
                                                             const zone::BeaconGrid& grid, double reach_m);
/// Likewise its tags, which are on the path.
[[nodiscard]] std::vector<Simulation::Fiducial> fiducials_of(const estimation::Track& track,
                                                             const zone::TrafficZone& zone);

}  // namespace cosiva::experiments
