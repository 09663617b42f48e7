#pragma once

#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/view/battery_desk.h"
#include "cosiva/virtual/server/view/gvs_desk.h"

namespace cosiva::virtual_side {

/// What other programs measure and the server shows: battery tests, and the camera over the zone.
struct InstrumentParts {
  ServerContext& observed;
  BatteryDesk batteries{};
  GvsDesk gvs{observed.registry, observed.simulator};
};

}  // namespace cosiva::virtual_side
