#include "cosiva/virtual/vehicle/antenna.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void Antenna::know(const zone::TrafficZone& zone) {
  by_section_.assign(zone.circuit.size(), {});
  for (const zone::Tag& tag : zone.tags) {
    const Point2 position = cosiva::position(zone.circuit.pose_at(tag.position));
    for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
      const zone::Section& section = zone.circuit.section(id);
      if (distance(section.box(), position) > range_m || section.nearest(position).distance_m > range_m) continue;
      by_section_[id].push_back({tag.number, position});
    }
  }
}

void Antenna::put(const zone::TrafficZone& zone, zone::TrackPosition track_position, Point2 p) {
  know(zone);
  in_field_.clear();
  std::vector<Reading> unread;
  move(zone, track_position, track_position, p, p, unread);
}

void Antenna::move(const zone::TrafficZone& zone, zone::TrackPosition from, zone::TrackPosition to, Point2 p_from,
                   Point2 p_to, std::vector<Reading>& readings) {
  read_section(to.section, p_from, p_to, readings);
  if (from.section != to.section) read_section(from.section, p_from, p_to, readings);
  if (zone.beacons) read_beacon(zone, p_from, p_to, readings);
  std::erase_if(in_field_, [&](const InReach& tag) { return distance(tag.position, p_to) > range_m; });
}

void Antenna::read_section(zone::SectionId section, Point2 p_from, Point2 p_to, std::vector<Reading>& readings) {
  COSIVA_EXPECT(section < by_section_.size());
  for (const InReach& tag : by_section_[section]) enter(tag, p_from, p_to, readings);
}

void Antenna::read_beacon(const zone::TrafficZone& zone, Point2 p_from, Point2 p_to, std::vector<Reading>& readings) {
  // Beacons are at least 5 cm apart, so that at most one can be read at a time.
  if (const auto beacon = zone.beacons->nearest(p_to))
    enter({beacon->number, beacon->position}, p_from, p_to, readings);
}

void Antenna::enter(const InReach& tag, Point2 p_from, Point2 p_to, std::vector<Reading>& readings) {
  // The parameter t in [0, 1] of the move at which the distance becomes `range_m`: |w·t − d|² = range², d from its
  // start.
  const double wx = p_to.x_m - p_from.x_m;
  const double wy = p_to.y_m - p_from.y_m;
  const double dx = tag.position.x_m - p_from.x_m;
  const double dy = tag.position.y_m - p_from.y_m;
  const double outside = dx * dx + dy * dy - range_m * range_m;
  const double way2 = wx * wx + wy * wy;
  double t = 0.0;
  if (outside > 0.0) {
    const double towards = wx * dx + wy * dy;
    const double root2 = towards * towards - way2 * outside;
    if (towards <= 0.0 || root2 < 0.0) return;
    t = outside / (towards + std::sqrt(root2));  // the smaller root, without a difference
    if (!(t <= 1.0)) return;
  }
  const bool known =
      std::any_of(in_field_.begin(), in_field_.end(), [&](const InReach& in) { return in.number == tag.number; });
  if (known) return;
  in_field_.push_back(tag);
  readings.push_back({tag.number, (1.0 - t) * std::sqrt(way2)});
}

void Antenna::archive(Archive& archive) { archive(in_field_); }

}  // namespace cosiva::virtual_side
