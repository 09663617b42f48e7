#pragma once

#include <optional>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The article's reader sees a tag within this of its antenna, which rides over the line (A21).
inline constexpr double beacon_reach_m = 0.02;

/// A way that a vehicle can take without news of where it is.
struct Stretch {
  double length_m{};
  TrackPosition from;  ///< where the last beacon was read, or where a way begins
  TrackPosition to;
  bool endless{false};  ///< it is a round, and one can drive on it for ever; `length_m` is once round
};

/// The longest way along the circuit, over joints and all branches, from one beacon to the next; a beacon counts where
/// the line passes within `reach_m` of it, at the place nearest to it. Curves are taken to 0.1 mm.
[[nodiscard]] Stretch longest_beacon_free(const TrafficZone& zone, double reach_m = beacon_reach_m);
/// Likewise of tags, which lie on the line.
[[nodiscard]] Stretch longest_tag_free(const TrafficZone& zone);

/// Of both together.
[[nodiscard]] Stretch longest_unread(const TrafficZone& zone, double reach_m = beacon_reach_m);

/// Where else the beacons could lie, with the same pitch and rotation.
struct OriginSuggestion {
  Point2 origin;      ///< as [beacons] origin says it: within one pitch of the present one, to 0.1 mm
  double before_m{};  ///< the longest stretch as it is; infinite where a round has no beacon
  double after_m{};   ///< with the origin suggested
};
/// The origin that leaves the shortest longest stretch: offsets are tried in a matrix, then finer about the best. The
/// same zone gets the same answer everywhere. The present origin where none is better.
/// Nothing where the zone has no beacons, or is so large that it would take seconds.
[[nodiscard]] std::optional<OriginSuggestion> suggest_origin(const TrafficZone& zone, double reach_m = beacon_reach_m);

}  // namespace cosiva::zone
