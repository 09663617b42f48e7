#pragma once

#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/random.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {

/// All tags and beacons within reach of an antenna that follows the path, by section and arc length: found once, so
/// that a tick checks only those that the antenna passes. A tag near two sections belongs to both, as for a reader at a
/// crossing.
class TagMap {
 public:
  struct Entry {
    double s_m;  ///< the nearest position on the section
    Point2 position;
    zone::TagNumber number;
  };
  /// @param reach_m  radius of the antenna's field
  TagMap(const zone::TrafficZone& zone, double reach_m);

  /// Those of a section whose nearest positions lie in [from, to].
  [[nodiscard]] std::span<const Entry> between(zone::SectionId section, double from_m, double to_m) const;
  /// A part of a section, without its ends.
  struct Stretch {
    zone::SectionId section{zone::no_section};
    double from_m{};
    double to_m{};
  };
  /// The longest stretch before, around or after a position that has no entry; at an entry, the one before it.
  [[nodiscard]] Stretch free_around(zone::TrackPosition position) const;
  [[nodiscard]] double reach_m() const { return reach_m_; }

 private:
  void add_tags(const zone::TrafficZone& zone, double near_m);
  void add_beacons(const zone::TrafficZone& zone, double near_m);

  double reach_m_;
  std::vector<std::vector<Entry>> by_section_;  ///< each sorted by s
};

/// How a reader differs from a perfect one.
struct TagReaderNoise {
  double miss;  ///< probability per passing
  SimDuration latency_min;
  SimDuration latency_max;
};

/// PRAV's RFID module: reads each tag once per passing, when the tag enters the field of the antenna under the body's
/// centre; ready for the same tag again when the tag has left the field. Invariant: a tag in the field counts once, and
/// no tag of the map lies within `free_`.
class TagReader {
 public:
  struct Reading {
    SimTime read_at;  ///< when the reader has the number: entry and latency
    zone::TagNumber number;
  };

  /// @param map  must outlive this
  TagReader(const TagMap& map, TagReaderNoise noise, Random random) : map_{&map}, noise_{noise}, random_{random} {}

  /// The floor is replaced from now on, and the field is empty.
  /// @param map  must outlive this
  void set_zone(const TagMap& map) {
    map_ = &map;
    free_ = {};
    in_field_.clear();
  }
  /// The map has other tags than before.
  void on_tags_changed() { free_ = {}; }
  /// The antenna moved from `from` to `to`, which lies next to `place`. Appends the tags read.
  void move(SimTime now, zone::TrackPosition track_position, Point2 from, Point2 to, std::vector<Reading>& readings);
  void archive(Archive& archive);  ///< the tags in the field, for a restart of the emulation

 private:
  struct InField {
    zone::TagNumber number;
    Point2 position;
  };
  void enter(SimTime now, zone::TagNumber number, std::vector<Reading>& readings);

  const TagMap* map_;
  TagReaderNoise noise_;
  Random random_;
  std::vector<InField> in_field_;
  TagMap::Stretch free_;  ///< of tags, around an earlier position: nothing is searched for there
};

}  // namespace cosiva::physical
