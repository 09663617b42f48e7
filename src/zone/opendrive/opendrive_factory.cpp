#include "zone/opendrive/opendrive_factory.h"

namespace cosiva::zone {

Result<TrafficZone> OpenDriveCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  return fail("zone.format", "not read yet", configuration.origin);
}

}  // namespace cosiva::zone
