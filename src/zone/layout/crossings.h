#pragma once

#include <optional>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// Pairs of sections whose vehicles could touch, from the geometry and the vehicle's shape plus `clearance_m` on each
/// side; touching pairs at one place are one crossing. Ways that run along one another, such as one way and the way
/// back, are one crossing of their own, apart from those at their ends. Consecutive sections do not cross each other at
/// their joint, but where vehicles turn sharply on the spot; whoever turns sweeps a disc of half its diagonal.
/// Names are "X1", "X2", … in the order in which the sections come to them. Not for a circuit that is too_crowded.
[[nodiscard]] std::vector<Crossing> find_crossings(const Circuit& circuit, const VehicleShape& shape,
                                                   double clearance_m = 0.04);

/// Whether the ways lie so densely on one another that find_crossings would take minutes; it must not be asked then. No
/// zone that anybody could drive in comes near this; a hostile file may.
[[nodiscard]] bool too_crowded(const Circuit& circuit, const VehicleShape& shape, double clearance_m = 0.04);

/// Both in one: nothing where it is too crowded.
[[nodiscard]] std::optional<std::vector<Crossing>> find_crossings_unless_crowded(const Circuit& circuit,
                                                                                 const VehicleShape& shape,
                                                                                 double clearance_m = 0.04);

}  // namespace cosiva::zone
