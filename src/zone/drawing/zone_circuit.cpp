#include "cosiva/zone/drawing/zone_circuit.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/zone/drawing/draw.h"

namespace cosiva::zone {

ZoneCircuit::ZoneCircuit(std::shared_ptr<const TrafficZone> zone) : zone_{std::move(zone)} {
  COSIVA_EXPECT(zone_ != nullptr);
}

std::vector<Primitive> ZoneCircuit::draw() const { return zone::draw(*zone_); }

Result<std::shared_ptr<const DrawableCircuit>> circuit_of(Result<TrafficZone> zone) {
  if (!zone) return tl::unexpected(std::move(zone).error());
  return std::make_shared<const ZoneCircuit>(std::make_shared<const TrafficZone>(std::move(*zone)));
}

}  // namespace cosiva::zone
