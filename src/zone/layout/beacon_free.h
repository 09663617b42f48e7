#pragma once

#include <optional>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The article's reader detects a tag within this distance of its antenna, which moves over the path (A21).
inline constexpr double beacon_reach_m = 0.02;

/// A distance that a vehicle can drive without a position reference.
struct Stretch {
  double length_m{};
  TrackPosition from;  ///< where the last beacon was read, or where a path begins
  TrackPosition to;
  bool endless{false};  ///< a loop without a read: a vehicle can drive on it for ever; `length_m` is one lap
};

/// The longest distance along the circuit, over joints and all branches, from one beacon to the next; a beacon counts
/// where the path passes within `reach_m` of it, at the position nearest to it. Curves are taken to 0.1 mm.
[[nodiscard]] Stretch longest_beacon_free(const TrafficZone& zone, double reach_m = beacon_reach_m);
/// Likewise of tags, which lie on the path.
[[nodiscard]] Stretch longest_tag_free(const TrafficZone& zone);

/// Of both together.
[[nodiscard]] Stretch longest_unread(const TrafficZone& zone, double reach_m = beacon_reach_m);

/// Better positions for the beacons, with the same pitch and rotation.
struct OriginSuggestion {
  Point2 origin;      ///< as [beacons] origin gives it: within one pitch of the present one, to 0.1 mm
  double before_m{};  ///< the longest stretch at present; infinite where a loop has no beacon
  double after_m{};   ///< with the origin suggested
};
/// The origin with the shortest longest stretch: offsets are tried in a matrix, then finer about the best. The same
/// zone gives the same result on every machine. The present origin where none is better. Nothing where the zone has no
/// beacons, or is so large that the search would take seconds.
[[nodiscard]] std::optional<OriginSuggestion> suggest_origin(const TrafficZone& zone, double reach_m = beacon_reach_m);

}  // namespace cosiva::zone
