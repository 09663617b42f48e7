#pragma once

#include <array>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/random.h"
#include "cosiva/physical/boards/boards.h"
#include "cosiva/physical/plant/body.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {

/// One scan: per beam the range [m] from the sensor, negative without an echo.
using Scan = std::array<double, DobsBoard::beams>;

/// What DOBS measures, before noise: per beam the nearest point of any body inside the beam's sector, within reach. The
/// sensor is in the centre of the body's front. Invariant: an echo's range is not negative and within reach.
class RangeFan {
 public:
  explicit RangeFan(const zone::VehicleShape& shape);

  /// Starts a scan from this body.
  void aim(const BodyPose& body);
  void see(const BodyPose& other);  ///< another vehicle
  void see(const Disc& disc);
  [[nodiscard]] const Scan& ranges() const { return scan_; }

  /// Adds the properties of ultrasound to the scan: noise on each echo, and missing echoes.
  [[nodiscard]] static Scan measured(const Scan& exact, double sd_m, double dropout, Random& random);

 private:
  void see_edge(Point2 from, Point2 to);
  void take(std::size_t beam, double range_m);
  [[nodiscard]] Point2 to_sensor(Point2 p_M) const;

  double half_length_m_;
  double half_width_m_;
  double half_diagonal_m_;
  /// Unit vectors along the beams' borders, from the rightmost to the leftmost: beam i lies between i and i + 1.
  std::array<Point2, DobsBoard::beams + 1> border_;
  BodyPose body_;
  Scan scan_{};
};

}  // namespace cosiva::physical
