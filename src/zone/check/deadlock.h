#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/zone/check/check.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// Crossings that lie so near to each other that nobody can stand between them are reserved together, over so many
/// stretches from waypoint to waypoint at most. Behind a longer row of them one goes from node to node.
inline constexpr std::size_t reserved_at_once_max = 16;

/// Where vehicles may come to wait for each other in a ring, found before anything runs; nothing of it is an error, all
/// are notices. In time near linear in sections, waypoints and crossings.
///
/// - "deadlock.loop": how many vehicles a way round has room for; with one more nobody in it could move. Of each named
///   loop; where a zone names none, of every part of the circuit that one can go round in.
/// - "deadlock.no_room": a way round through crossings without a place to wait between them, and a row of them longer
///   than is reserved at once: vehicles stand in crossings there, and each may hold what the next one needs.
/// - "deadlock.single_track": a track driven both ways, and in it a place where one may stand while another comes.
/// - "deadlock.dead_end": sections that can only be left the way one came in: who waits to get in must leave the way
///   out free.
[[nodiscard]] std::vector<Problem> deadlock_spots(const TrafficZone& zone);

/// For each section the one that is the same line driven the other way; no_section: none is.
[[nodiscard]] std::vector<SectionId> opposites(const TrafficZone& zone);

/// How many vehicles can go round at once: one more, and all of them stand one behind the other at waypoints, none with
/// room before it. 0: not even one can wait anywhere on it.
/// @param sections  a way round, in order
[[nodiscard]] std::size_t vehicles_going_round(const TrafficZone& zone, const std::vector<SectionId>& sections);

}  // namespace cosiva::zone
