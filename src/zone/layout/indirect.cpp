#include "cosiva/zone/layout/indirect.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

const std::string& id_of(const std::vector<std::string>& ids, SectionId section) {
  static const std::string none;
  return section < ids.size() ? ids[section] : none;
}

/// By section the id of the waypoint at its end: its own, or the one at the start of its successor.
std::vector<std::string> ids_at_ends(const Circuit& circuit, const WaypointRules& rules) {
  std::vector<std::string> ids(circuit.size());
  for (SectionId section = 0; section < circuit.size(); ++section) {
    const auto next = circuit.next(section);
    ids[section] = next.empty() ? id_of(rules.end_ids, section) : id_of(rules.start_ids, next.front());
  }
  return ids;
}

}  // namespace

void make_indirect(TrafficZone& zone, WaypointRules& rules) {
  COSIVA_EXPECT(!zone.circuit.indirect() && zone.crossings.empty() && zone.waypoints.empty() && zone.tags.empty() &&
                zone.starts.empty());
  std::vector<std::string> start_ids = ids_at_ends(zone.circuit, rules);
  rules.end_ids = std::exchange(rules.start_ids, std::move(start_ids));
  for (TrackPosition& position : rules.at) position = reversed(zone.circuit, position);
  for (Station& station : zone.stations) station.position = reversed(zone.circuit, station.position);
  for (Loop& loop : zone.loops) std::reverse(loop.sections.begin(), loop.sections.end());
  zone.name += "-indirect";
  zone.circuit = reversed(zone.circuit, zone.name);
}

}  // namespace cosiva::zone
