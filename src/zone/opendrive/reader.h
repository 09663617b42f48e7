#pragma once

#include "cosiva/base/result.h"
#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"
#include "cosiva/zone/opendrive/xml.h"

namespace cosiva::zone::opendrive {

/// The file's roads and junctions, each number checked. Fails with the first fault, which names line and element.
[[nodiscard]] Result<Network> read_network(XmlFile& file, Report& report);

}  // namespace cosiva::zone::opendrive
