#pragma once

#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::zone {

/// {"addTags":[{"number","x","y"}|{"number","section","s"}…],"moveTags":[…],"removeTags":[n…],
/// "beacons":{"pitch":0.2,"origin":[0.15,0.15],"rotation":0.26},"priorities":{"CoSiVA/AIV1":3}}. A position given as x,
/// y is the nearest one on the circuit; of "beacons" any part may be left out; "beaconPitch":0.2 is its pitch alone.
/// Fails ("edit.…") with a sentence that states the remedy: a tag further than 0.30 m from every section, an added
/// number that exists already, a moved or removed one that does not exist, a number among the beacons', a pitch outside
/// 0.05…10 m or that makes more than 20 000 beacons, an origin beyond ±1000 km, a rotation beyond ±2π, a zone without
/// beacons.
[[nodiscard]] Result<ZoneEdit> zone_edit_from_json(const JsonValue& json, const TrafficZone& zone);

}  // namespace cosiva::zone
