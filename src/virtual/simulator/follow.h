#pragma once

#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// Takes a course to the section where its vehicle now is: one that it can have come to since it was at course.here(),
/// else the nearest behind, since near a joint a place may fall back. False, and nothing changed: it is off its course.
bool follow(zone::Course& course, const zone::Circuit& circuit, zone::SectionId section);

}  // namespace cosiva::virtual_side
