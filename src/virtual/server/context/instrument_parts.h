#pragma once

#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/view/battery_test_relay.h"
#include "cosiva/virtual/server/view/crossing_units.h"
#include "cosiva/virtual/server/view/ground_truth_comparator.h"
#include "cosiva/virtual/server/view/physical_presence.h"
#include "cosiva/virtual/server/view/report_watch.h"

namespace cosiva::virtual_side {

/// What other programs measure and the server shows: battery tests, the camera over the zone, which vehicles are
/// present, what their reports show, and crossing units.
struct InstrumentParts {
  ServerContext& observed;
  BatteryTestRelay batteries{};
  GroundTruthComparator gvs{observed.registry, observed.simulator};
  PhysicalPresence presence{observed.registry, observed.simulator.monitor(), gvs, observed.options.lost_after};
  ReportWatch reports{observed.registry, observed.simulator};
  CrossingUnits units{};  ///< not archived: known again after their next message
};

}  // namespace cosiva::virtual_side
