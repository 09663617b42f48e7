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

/// The changes that an operator may make to a zone while it runs (A5): its tags, the position of its beacons (A21), the
/// priorities between AIVs. Never the sections themselves.
struct ZoneEdit {
  struct TagPosition {
    TagNumber number;
    TrackPosition position;
  };
  std::vector<TagPosition> set_tags;  ///< adds a new tag, or moves the one with this number
  std::vector<TagNumber> remove_tags;
  std::optional<double> beacon_pitch_m;
  std::vector<std::pair<std::string, std::int32_t>> set_priorities;  ///< "CoSiVA/AIV1" → 0…999; 0 removes the entry
  std::optional<Point2> beacon_origin{};  ///< of a grid that covers the zone: a point that it passes through
  std::optional<double> beacon_rotation_rad{};
};

/// The zone after the edit: new tags come last; positions, pitch and origin are rounded to 0.1 mm, the rotation to
/// 0.0001°, as they are written. Fails as zone_edit_from_json (edit_json.h) does.
[[nodiscard]] Result<TrafficZone> with_edit(TrafficZone zone, const ZoneEdit& edit);

/// Whether the sections, the vehicle's shape and the profiles are the same, so that running vehicles may take `b` for
/// `a` without stopping: only tags, beacons, stations and priorities differ.
[[nodiscard]] bool same_geometry(const TrafficZone& a, const TrafficZone& b);

/// The fault in the name of a vehicle with a priority; nothing when the name is "manufacturer/serial".
[[nodiscard]] std::optional<std::string> wrong_vehicle_name(std::string_view name);

/// The difference between an edit's result and the wanted zone, as a sentence; nothing when all of the zone is the
/// same.
[[nodiscard]] std::optional<std::string> difference(const TrafficZone& wanted, const TrafficZone& found);

}  // namespace cosiva::zone
