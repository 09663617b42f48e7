#include "cosiva/zone/layout/traffic_zone.h"

#include <algorithm>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/zone/layout/waypoints.h"

namespace cosiva::zone {
namespace {

bool before(const Waypoint& waypoint, const TrackPosition& track_position) {
  return waypoint.position.section != track_position.section ? waypoint.position.section < track_position.section
                                                             : waypoint.position.s_m < track_position.s_m;
}

// Two positions this near on one section are the same position: the rounding of adding and subtracting a few lengths.
constexpr double same_position_m = 1e-9;

/// The first waypoint of the default route after section `id`, none of whose own is left.
std::size_t first_after(const TrafficZone& zone, SectionId id) {
  for (std::size_t steps = 0; steps < zone.circuit.size(); ++steps) {
    if (zone.circuit.next(id).empty()) break;
    id = zone.circuit.next(id).front();
    const auto at = std::lower_bound(zone.waypoints.begin(), zone.waypoints.end(), TrackPosition{id, 0.0}, before);
    if (at != zone.waypoints.end() && at->position.section == id)
      return static_cast<std::size_t>(at - zone.waypoints.begin());
  }
  return zone.waypoints.size();
}

}  // namespace

std::int32_t TrafficZone::priority_of(std::string_view vehicle_name) const {
  const auto at = std::lower_bound(priorities.begin(), priorities.end(), vehicle_name,
                                   [](const auto& entry, std::string_view key) { return entry.first < key; });
  return at == priorities.end() || at->first != vehicle_name ? 0 : at->second;
}

const Tag* TrafficZone::find_tag(TagNumber number) const {
  const auto found = tags.from(number);
  return found.empty() || tags.key_of(found.front()) != number ? nullptr : &tags[found.front().position];
}

const Waypoint* TrafficZone::find_waypoint(std::string_view id) const {
  const auto found = waypoints.from(id);
  return found.empty() || waypoints.key_of(found.front()) != id ? nullptr : &waypoints[found.front().position];
}

std::vector<std::size_t> TrafficZone::find_waypoints(std::string_view id) const {
  std::vector<std::size_t> found;
  for (const auto& entry : waypoints.from(id)) {
    if (waypoints.key_of(entry) != id) break;
    found.push_back(entry.position);
  }
  return found;
}

const Station* TrafficZone::find_station(std::string_view station_name) const {
  const auto at =
      std::find_if(stations.begin(), stations.end(), [&](const Station& s) { return s.name == station_name; });
  return at == stations.end() ? nullptr : &*at;
}

const Loop* TrafficZone::find_loop(std::string_view loop_name) const {
  const auto at = std::find_if(loops.begin(), loops.end(), [&](const Loop& loop) { return loop.name == loop_name; });
  return at == loops.end() ? nullptr : &*at;
}

std::string_view to_string(Diagnostic::Kind kind) {
  switch (kind) {
    case Diagnostic::Kind::mended: return "mended";
    case Diagnostic::Kind::lost: return "lost";
    case Diagnostic::Kind::notice: return "notice";
  }
  return "?";
}

const Crossing* TrafficZone::crossing_at(TrackPosition track_position) const {
  const Crossing* first = nullptr;
  for (const auto& entry : crossings.from(std::pair{track_position.section, -same_position_m})) {
    const Crossing& crossing = crossings[entry.position];
    const CrossingSpan& span = crossing.spans[entry.part];
    if (span.section != track_position.section || span.from_m > track_position.s_m) break;
    if (track_position.s_m <= span.to_m && (first == nullptr || &crossing < first)) first = &crossing;
  }
  return first;
}

std::size_t TrafficZone::waypoint_ahead(TrackPosition track_position) const {
  COSIVA_EXPECT(track_position.section < circuit.size());
  const TrackPosition from{track_position.section, track_position.s_m - same_position_m};
  const auto at = std::lower_bound(waypoints.begin(), waypoints.end(), from, before);
  if (at != waypoints.end() && at->position.section == track_position.section)
    return static_cast<std::size_t>(at - waypoints.begin());
  return first_after(*this, track_position.section);
}

std::size_t TrafficZone::waypoint_behind(TrackPosition track_position) const {
  COSIVA_EXPECT(track_position.section < circuit.size());
  SectionId id = track_position.section;
  double s = track_position.s_m + same_position_m;
  for (std::size_t steps = 0; steps <= circuit.size(); ++steps) {
    // One past the last waypoint of `id` at or before s.
    const auto at = std::partition_point(waypoints.begin(), waypoints.end(), [&](const Waypoint& waypoint) {
      return waypoint.position.section != id ? waypoint.position.section < id : waypoint.position.s_m <= s;
    });
    if (at != waypoints.begin() && (at - 1)->position.section == id)
      return static_cast<std::size_t>(at - waypoints.begin()) - 1;
    if (circuit.previous(id).empty()) break;
    id = circuit.previous(id).front();
    s = circuit.section(id).length_m();
  }
  return waypoints.size();
}

std::size_t TrafficZone::next_waypoint(std::size_t index) const {
  COSIVA_EXPECT(index < waypoints.size());
  const SectionId section = waypoints[index].position.section;
  if (index + 1 < waypoints.size() && waypoints[index + 1].position.section == section) return index + 1;
  return first_after(*this, section);
}

bool TrafficZone::may_stop(TrackPosition track_position) const {
  COSIVA_EXPECT(track_position.section < circuit.size());
  // A vehicle may stop between a waypoint behind it and no crossing since.
  SectionId id = track_position.section;
  double s = track_position.s_m;
  for (std::size_t steps = 0; steps <= circuit.size(); ++steps) {
    double span_m = -1.0;
    for (const auto& entry : crossings.from(std::pair{id, -same_position_m})) {
      const CrossingSpan& span = crossings[entry.position].spans[entry.part];
      if (span.section != id || span.from_m > s) break;
      span_m = std::max(span_m, std::min(span.to_m, s));
    }
    double waypoint_m = -1.0;
    for (auto at = std::lower_bound(waypoints.begin(), waypoints.end(), TrackPosition{id, 0.0}, before);
         at != waypoints.end() && at->position.section == id && at->position.s_m <= s + same_position_m; ++at)
      waypoint_m = at->position.s_m;
    if (span_m >= 0.0 || waypoint_m >= 0.0) return waypoint_m > span_m;
    if (circuit.previous(id).empty()) return true;
    id = circuit.previous(id).front();
    s = circuit.section(id).length_m();
  }
  return true;
}

namespace {

struct Spot {
  TrackPosition position;
  Point2 p;
};

/// Whether two vehicles have room: apart in a straight line, or side by side on sections that do not follow each other.
bool apart(const TrafficZone& zone, const Spot& a, const Spot& b) {
  const double room_m = stopping_room_m(zone.vehicle);
  const double apart_m = distance(a.p, b.p);
  if (apart_m >= room_m) return true;
  return apart_m > norm(zone.vehicle.length_m, zone.vehicle.width_m) &&
         !zone.circuit.distance_ahead(a.position, b.position, room_m) &&
         !zone.circuit.distance_ahead(b.position, a.position, room_m);
}

bool fits(const TrafficZone& zone, const Spot& spot, const std::vector<Spot>& taken) {
  return std::all_of(taken.begin(), taken.end(), [&](const Spot& other) { return apart(zone, spot, other); });
}

/// All positions where a vehicle may stop, every 5 cm (coarser on large zones).
std::vector<Spot> spots(const TrafficZone& zone) {
  const double step_m = std::max(0.05, zone.circuit.total_length_m() / 20'000.0);
  std::vector<Spot> found;
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    for (double i = 0.0; i * step_m < zone.circuit.section(id).length_m(); i += 1.0) {
      const TrackPosition track_position{id, i * step_m};
      if (zone.may_stop(track_position))
        found.push_back({track_position, position(zone.circuit.pose_at(track_position))});
    }
  }
  return found;
}

/// Takes the spot farthest from all taken so far, again and again.
void spread(const TrafficZone& zone, const std::vector<Spot>& free, std::size_t count, std::vector<Spot>& taken) {
  std::vector<double> nearest_m(free.size(), std::numeric_limits<double>::infinity());
  const auto record = [&](const Spot& spot) {
    for (std::size_t i = 0; i < free.size(); ++i) nearest_m[i] = std::min(nearest_m[i], distance(free[i].p, spot.p));
  };
  for (const Spot& spot : taken) record(spot);
  while (taken.size() < count) {
    std::size_t best = free.size();
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (nearest_m[i] > 0.0 && (best == free.size() || nearest_m[i] > nearest_m[best]) && fits(zone, free[i], taken))
        best = i;
    }
    if (best == free.size()) return;
    taken.push_back(free[best]);
    record(free[best]);
  }
}

/// Whether a vehicle may begin where it may not stop otherwise: on a waypoint inside a crossing that no other is in.
bool may_begin(const TrafficZone& zone, const Spot& spot, const std::vector<Spot>& taken) {
  if (!is_at_waypoint(zone, spot.position)) return false;
  const auto covers = [](const Crossing& crossing, const TrackPosition& track_position) {
    return std::any_of(crossing.spans.begin(), crossing.spans.end(), [&](const CrossingSpan& span) {
      return span.section == track_position.section && span.from_m <= track_position.s_m &&
             track_position.s_m <= span.to_m;
    });
  };
  for (const auto& entry : zone.crossings.from(std::pair{spot.position.section, -same_position_m})) {
    const Crossing& crossing = zone.crossings[entry.position];
    if (crossing.spans[entry.part].section != spot.position.section) break;
    if (covers(crossing, spot.position) &&
        std::any_of(taken.begin(), taken.end(), [&](const Spot& other) { return covers(crossing, other.position); }))
      return false;
  }
  return fits(zone, spot, taken);
}

}  // namespace

std::vector<TrackPosition> TrafficZone::start_positions(std::size_t count) const {
  std::vector<Spot> fixed;
  for (const TrackPosition& track_position : starts) {
    const Spot spot{track_position, position(circuit.pose_at(track_position))};
    if (fixed.size() < count && (may_stop(track_position) ? fits(*this, spot, fixed) : may_begin(*this, spot, fixed)))
      fixed.push_back(spot);
  }
  std::vector<Spot> taken = fixed;
  if (taken.size() < count) {
    const auto free = spots(*this);
    spread(*this, free, count, taken);
    if (taken.size() < count) {
      // Spreading wastes room when there is little: then one behind the other, as close as possible.
      std::vector<Spot> packed = fixed;
      for (const Spot& spot : free) {
        if (packed.size() < count && fits(*this, spot, packed)) packed.push_back(spot);
      }
      if (packed.size() > taken.size()) taken = std::move(packed);
    }
    // In a net of two-way roads every position lies in some crossing, and its nodes are where vehicles begin.
    for (std::size_t i = 0; i < waypoints.size() && taken.size() < count; ++i) {
      const Spot spot{waypoints[i].position, position(circuit.pose_at(waypoints[i].position))};
      if (!may_stop(spot.position) && may_begin(*this, spot, taken)) taken.push_back(spot);
    }
  }
  std::vector<TrackPosition> positions;
  positions.reserve(taken.size());
  for (const Spot& spot : taken) positions.push_back(spot.position);
  return positions;
}

}  // namespace cosiva::zone
