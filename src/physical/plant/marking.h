#pragma once

#include <cstddef>

#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::physical {

/// Where the marking of the path lies at a distance from a position on it: to the left of the path's tangent at this
/// position, to second order in the curvature. Beyond a joint the marking is that of the next section under the branch;
/// where the path ends or bends sharply, the marking continues straight on over the joint.
/// @param distance_m  of the order of a vehicle's length, not negative
[[nodiscard]] double marking_before_m(const zone::Circuit& circuit, zone::TrackPosition from, double distance_m,
                                      std::size_t branch);
/// Likewise behind the position; before the section's start lies `previous` (zone::no_section: the first section that
/// leads here smoothly).
[[nodiscard]] double marking_behind_m(const zone::Circuit& circuit, zone::TrackPosition from, double behind_m,
                                      zone::SectionId previous);

}  // namespace cosiva::physical
