#include "cosiva/virtual/fleet/spacing.h"

#include <algorithm>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {
namespace {

/// Minimum gap between inner corners in the tightest bend of a zone.
constexpr double least_gap_m = 0.01;

}  // namespace

double bodies_apart_m(const zone::VehicleShape& shape, double curvature_per_m) {
  if (curvature_per_m == 0.0) return shape.length_m;
  return 2.0 / curvature_per_m * det_atan2(shape.length_m * curvature_per_m, 2.0 - shape.width_m * curvature_per_m);
}

double occupied_m(const zone::TrafficZone& zone) {
  double curvature_per_m = 0.0;
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id)
    curvature_per_m = std::max(curvature_per_m, zone.circuit.section(id).curvature_max_per_m());
  const double apart_m = bodies_apart_m(zone.vehicle, curvature_per_m) + least_gap_m;
  return std::max(zone.vehicle.length_m, apart_m - aiv::clearance_m);
}

}  // namespace cosiva::virtual_side
