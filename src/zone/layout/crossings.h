#pragma once

#include <optional>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// Pairs of sections whose vehicles could touch, from the geometry and the vehicle's shape plus `clearance_m` on each
/// side; touching pairs at one position are one crossing. Sections that run along one another, such as the two
/// directions of a track, are one crossing of their own, apart from those at their ends. Consecutive sections do not
/// cross each other at their joint, except where vehicles turn sharply on the spot; a turning vehicle sweeps a disc of
/// half its diagonal. Names are "X1", "X2", … in the order in which the sections reach them. Not for a circuit
/// that is too crowded.
[[nodiscard]] std::vector<Crossing> find_crossings(const Circuit& circuit, const VehicleShape& shape,
                                                   double clearance_m = 0.04);

/// The same, and nothing where the circuit is too crowded: its sections lie so densely on one another that the search
/// would take minutes. No zone for real vehicles comes near this; a hostile file may.
[[nodiscard]] std::optional<std::vector<Crossing>> find_crossings_unless_crowded(const Circuit& circuit,
                                                                                 const VehicleShape& shape,
                                                                                 double clearance_m = 0.04);

}  // namespace cosiva::zone
