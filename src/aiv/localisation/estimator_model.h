#pragma once

namespace cosiva::aiv {

/// The vehicle's model of its own sensors, with gates against wrong measurements.
struct EstimatorModel {
  double sigma_start_m{0.01};        ///< standard deviation of a position that was given
  double sigma_fix_m{0.004};         ///< after a tag or beacon
  double variance_per_m{1e-4};       ///< of odometry: 1 cm per √m
  double antenna_range_m{0.020};     ///< a tag is reported when it enters the field: this far before the antenna is
                                     ///< over it
  double reading_latency_s{0.020};   ///< from the field to the age stamp of the frame, and the transfer of the frame
  double beacon_gate_m{0.30};        ///< a beacon further from the estimate than this contradicts it
  double tag_gate_m{0.60};           ///< likewise a tag
  double sigma_reset_m{0.05};        ///< added when the odometer restarts
  double odometry_step_m_max{0.50};  ///< a larger step between two readings means that the board counts from zero again
  double bend_gate_m{0.15};          ///< a vehicle that turns on the spot, or stops at a fork, is at the joint this
                                     ///< near ahead; after a long distance without a fix the search extends further
  double landed_m{0.06};             ///< a manoeuvre that ends this near to a path,
  double landed_rad{0.30};           ///< and with this heading error, has brought the vehicle onto the path
};

}  // namespace cosiva::aiv
