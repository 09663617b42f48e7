#pragma once

#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/view/battery_test_relay.h"
#include "cosiva/virtual/server/view/ground_truth_comparator.h"

namespace cosiva::virtual_side {

/// What other programs measure and the server shows: battery tests, and the camera over the zone.
struct InstrumentParts {
  ServerContext& observed;
  BatteryTestRelay batteries{};
  GroundTruthComparator gvs{observed.registry, observed.simulator};
};

}  // namespace cosiva::virtual_side
