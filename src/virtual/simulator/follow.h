#pragma once

#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// Advances a course to the section where its vehicle is now: a section that the vehicle can have reached since it was
/// at course.here(), else the nearest section behind, since near a joint a reported position may fall back. Returns
/// false and changes nothing if the vehicle is off its course.
bool follow(zone::Course& course, const zone::Circuit& circuit, zone::SectionId section);

}  // namespace cosiva::virtual_side
