#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/zone/check/check.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// Crossings so near to each other that no vehicle can stop between them are reserved together, over at most this many
/// stretches from waypoint to waypoint. Behind a longer row of them a vehicle proceeds from node to node.
inline constexpr std::size_t reserved_at_once_max = 16;

/// The positions where vehicles may come to wait for each other in a cycle, found before a run; no finding is an error,
/// all are notices. In time near linear in sections, waypoints and crossings.
///
/// - "deadlock.loop": the number of vehicles that a loop has room for; with one more no vehicle in it could move. Of
///   each named loop; where a zone names none, of every part of the circuit that contains a round trip.
/// - "deadlock.no_room": a round trip through crossings without a waiting position between them, and a row of them
///   longer than is reserved at once: vehicles are stopped in crossings there, and each may hold what the next needs.
/// - "deadlock.single_track": a track driven both ways, with a position in it where a vehicle may stop while another
///   comes.
/// - "deadlock.dead_end": sections that can only be left in the direction of entry: a vehicle that waits to enter must
///   leave the exit free.
[[nodiscard]] std::vector<Problem> deadlock_spots(const TrafficZone& zone);

/// For each section the one on the same path in the opposite direction; no_section: none is.
[[nodiscard]] std::vector<SectionId> opposites(const TrafficZone& zone);

/// The number of vehicles that can circulate at once: with one more, all of them are stopped one behind the other at
/// waypoints, none with room before it. 0: not even one can wait anywhere on the loop.
/// @param sections  a loop, in order
[[nodiscard]] std::size_t vehicles_going_round(const TrafficZone& zone, const std::vector<SectionId>& sections);

}  // namespace cosiva::zone
