#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/trial.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// A vehicle that follows its track in virtual time, with noise of which all is known: figures 16 and 17 where the
/// physical side is a model.
struct Simulation {
  std::shared_ptr<const estimation::Track> track;
  double distance_m{100.0};  ///< TDTmax: how far it goes
  double speed_mps{0.5};
  double odometry_hz{50.0};
  /// Beacons: every so many metres along the unrolled way, or where `fiducials` lie.
  double pitch_m{0.5};
  struct Fiducial {
    std::uint32_t number;
    double along_m;  ///< where the track passes it, within one round
    Point2 position_M;
  };
  std::vector<Fiducial> fiducials{};  ///< sorted by along_m; empty: by pitch
  bool fiducials_only{false};         ///< `fiducials` are all there are, even where there are none
  double read_ratio{1.0};             ///< of beacons passed, those that are read
  double survey_sigma_m{0.0};         ///< how far off a beacon lies from where it is said to lie: the same every time
  double scale_sigma{0.0};            ///< of the odometer's scale, one draw per run
  bool turns{true};                   ///< odometry tells turns too; who follows a line needs none
  estimation::SensorModel sensors{};  ///< true of the vehicle, and told to the algorithms
  double start_sigma_m{0.01};
  double start_heading_sigma_rad{0.02};
};

/// Fails ("simulation.…") naming what is not a possible number.
[[nodiscard]] Result<void> check(const Simulation& simulation);

/// One run of it. Same seed, same run.
/// @param run  what was in it goes, its memory is used again
void simulate(const Simulation& simulation, std::uint64_t seed, Trial& run);

/// The zone's beacons that the track passes within `reach_m`, at the place nearest to each.
[[nodiscard]] std::vector<Simulation::Fiducial> fiducials_of(const estimation::Track& track,
                                                             const zone::BeaconGrid& grid, double reach_m);
/// Likewise its tags, which lie on the line.
[[nodiscard]] std::vector<Simulation::Fiducial> fiducials_of(const estimation::Track& track,
                                                             const zone::TrafficZone& zone);

}  // namespace cosiva::experiments
