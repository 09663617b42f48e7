#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/geometry/fit.h"
#include "cosiva/zone/opendrive/report.h"
#include "cosiva/zone/opendrive/tracks.h"

namespace cosiva::zone::opendrive {

/// The tracks as sections, joined as the tracks are: "12.0.-1", and "12.0.-1.2" for the second piece. `scale` turns the
/// file's lengths into metres; the tolerance is of the result. Fails ("zone.size") beyond 100 000 sections,
/// ("circuit.empty") where nothing can be driven on.
[[nodiscard]] Result<std::vector<Circuit::Part>> lay_sections(const Network& network, const Tracks& tracks,
                                                              double scale, FitTolerance tolerance, Report& report);

}  // namespace cosiva::zone::opendrive
