#pragma once

#include <string>

#include "cosiva/physical/boards/line_tracker.h"
#include "cosiva/physical/plant/vehicle_dynamics.h"

namespace cosiva::physical {

/// A body with the line tracking of its PILS, for tests without boards.
class TrackedVehicle : public LineVehicle {
 public:
  TrackedVehicle(const zone::Circuit& circuit, zone::TrackPosition start, double line_offset_sd_m, Random line_noise,
                 const std::string& algorithm = line_tracking_names().front())
      : LineVehicle{circuit, start, line_offset_sd_m, line_noise}, pils{algorithm} {}

  void step(const DriveCommand* command, double dt_s) { LineVehicle::step(command, pils, dt_s); }

  LineTracker pils;
};

}  // namespace cosiva::physical
