#pragma once

#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {

/// Removes lane sections of less than 5 cm: the one before, or at a road's beginning the one behind, replaces them, and
/// links lead through them.
void drop_short_sections(Network& network, Report& report);

}  // namespace cosiva::zone::opendrive
