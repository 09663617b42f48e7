#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// The antenna under the body origin of a virtual AIV: reads each tag and beacon once, when it enters the field, and
/// misses none. Invariant: the tags of each section of the zone are known.
class Antenna {
 public:
  static constexpr double range_m = 0.020;  ///< the on-board program uses the same value

  struct Reading {
    zone::TagNumber number;
    double before_end_m;  ///< distance along the path from entering the field to the end of the move
  };

  /// Puts the antenna at p, with the tags of this zone from now on. A tag in the field at this time is not read.
  void put(const zone::TrafficZone& zone, zone::TrackPosition track_position, Point2 p);

  /// The tags are this zone's from now on; what is in the field stays there.
  void know(const zone::TrafficZone& zone);

  /// Moves the antenna straight from one track position to another a few centimetres away. Appends the tags that
  /// entered the field.
  void move(const zone::TrafficZone& zone, zone::TrackPosition from, zone::TrackPosition to, Point2 p_from, Point2 p_to,
            std::vector<Reading>& readings);
  void archive(Archive& archive);  ///< the state without the tags of the zone, for a snapshot

 private:
  struct InReach {
    zone::TagNumber number;
    Point2 position;
  };
  void enter(const InReach& tag, Point2 p_from, Point2 p_to, std::vector<Reading>& readings);
  void read_section(zone::SectionId section, Point2 p_from, Point2 p_to, std::vector<Reading>& readings);
  void read_beacon(const zone::TrafficZone& zone, Point2 p_from, Point2 p_to, std::vector<Reading>& readings);

  std::vector<std::vector<InReach>> by_section_;  ///< tags that an antenna on the section can read
  std::vector<InReach> in_field_;
};

}  // namespace cosiva::virtual_side
