#include "zone/lif/lif_factory.h"

namespace cosiva::zone {

Result<TrafficZone> LifCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  return fail("zone.format", "not read yet", configuration.origin);
}

}  // namespace cosiva::zone
