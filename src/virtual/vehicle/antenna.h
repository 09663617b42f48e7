#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// The antenna under a virtual AIV's middle: reads each tag and beacon once, when it enters the field, and misses none.
class Antenna {
 public:
  static constexpr double range_m = 0.020;  ///< the on-board program counts with it

  struct Reading {
    zone::TagNumber number;
    double before_end_m;  ///< so far before the end of the move it entered the field, along the way
  };

  /// The antenna stands at p, and the zone's tags are (from now on) these. What lies in the field now does not enter
  /// it.
  void put(const zone::TrafficZone& zone, zone::TrackPosition track_position, Point2 p);

  /// The antenna moved straight from one place of the circuit to another a few centimetres away. Appends what entered.
  void move(const zone::TrafficZone& zone, zone::TrackPosition from, zone::TrackPosition to, Point2 p_from, Point2 p_to,
            std::vector<Reading>& readings);

 private:
  struct InReach {
    zone::TagNumber number;
    Point2 position;
  };
  void enter(const InReach& tag, Point2 p_from, Point2 p_to, std::vector<Reading>& readings);
  void read_section(zone::SectionId section, Point2 p_from, Point2 p_to, std::vector<Reading>& readings);
  void read_beacon(const zone::TrafficZone& zone, Point2 p_from, Point2 p_to, std::vector<Reading>& readings);

  std::vector<std::vector<InReach>> by_section_;  ///< tags that an antenna on the section's line can read
  std::vector<InReach> in_field_;
};

}  // namespace cosiva::virtual_side
