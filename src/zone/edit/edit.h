#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// What an operator may change of a zone while it runs (A5): its tags, where its beacons lie (A21), the priorities
/// between AIVs. Never the ways themselves.
struct ZoneEdit {
  struct TagPosition {
    TagNumber number;
    TrackPosition position;
  };
  std::vector<TagPosition> set_tags;  ///< puts a new tag, or moves the one with this number
  std::vector<TagNumber> remove_tags;
  std::optional<double> beacon_pitch_m;
  std::vector<std::pair<std::string, std::int32_t>> set_priorities;  ///< "CoSiVA/AIV1" → 0…999; 0 takes it out
  std::optional<Point2> beacon_origin{};  ///< of a grid that covers the zone: a point that it passes through
  std::optional<double> beacon_rotation_rad{};
};

/// The zone as it is after the edit: new tags stand last, places, pitch and origin are rounded to 0.1 mm, the rotation
/// to 0.0001°, as they are written. Fails as zone_edit_from_json (edit_json.h) does.
[[nodiscard]] Result<TrafficZone> with_edit(TrafficZone zone, const ZoneEdit& edit);

/// Whether the ways, the vehicle's shape and the profiles are the same, so that running vehicles may take `b` for `a`
/// without stopping: only tags, beacons, stations and priorities differ.
[[nodiscard]] bool same_geometry(const TrafficZone& a, const TrafficZone& b);

/// What is wrong with the name of a vehicle that a priority is for; nothing when it is "manufacturer/serial".
[[nodiscard]] std::optional<std::string> wrong_vehicle_name(std::string_view name);

/// What an edit may have left other than wanted, as a sentence; nothing when all of the zone is the same.
[[nodiscard]] std::optional<std::string> difference(const TrafficZone& wanted, const TrafficZone& found);

}  // namespace cosiva::zone
