#include "cosiva/physical/plant/tag_reader.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

/// The greatest lateral offset of the antenna that is considered: twice what line following leaves.
constexpr double off_line_m = 0.005;

double distance_to_path(Point2 p, Point2 from, Point2 to) {
  const double path_x = to.x_m - from.x_m;
  const double path_y = to.y_m - from.y_m;
  const double length_sq = path_x * path_x + path_y * path_y;
  const double along = (p.x_m - from.x_m) * path_x + (p.y_m - from.y_m) * path_y;
  const double ratio = length_sq > 0.0 ? std::clamp(along / length_sq, 0.0, 1.0) : 0.0;
  return distance(p, {from.x_m + ratio * path_x, from.y_m + ratio * path_y});
}

}  // namespace

TagMap::TagMap(const zone::TrafficZone& zone, double reach_m) : reach_m_{reach_m}, by_section_(zone.circuit.size()) {
  if (reach_m <= 0.0) return;
  add_tags(zone, reach_m + off_line_m);
  if (zone.beacons) add_beacons(zone, reach_m + off_line_m);
  for (auto& entries : by_section_) {
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.s_m != b.s_m ? a.s_m < b.s_m : a.number < b.number; });
  }
}

void TagMap::add_tags(const zone::TrafficZone& zone, double near_m) {
  for (const zone::Tag& tag : zone.tags) {
    const Point2 position = cosiva::position(zone.circuit.pose_at(tag.position));
    for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
      const zone::Section& section = zone.circuit.section(id);
      if (distance(section.box(), position) > near_m) continue;
      const auto nearest = section.nearest(position);
      if (nearest.distance_m <= near_m) by_section_[id].push_back({nearest.s_m, position, tag.number});
    }
  }
}

void TagMap::add_beacons(const zone::TrafficZone& zone, double near_m) {
  // Querying the grid along the path costs its length, not its number of beacons times sections.
  const double step_m = std::max(near_m / 4.0, 1e-3);
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    const zone::Section& section = zone.circuit.section(id);
    auto& entries = by_section_[id];
    const auto known = [&](zone::TagNumber number) {
      return std::any_of(entries.begin(), entries.end(), [&](const Entry& entry) { return entry.number == number; });
    };
    const auto steps = static_cast<std::size_t>(std::ceil(section.length_m() / step_m));
    for (std::size_t i = 0; i <= steps; ++i) {
      const Point2 on_line = position(section.pose_at(std::min(static_cast<double>(i) * step_m, section.length_m())));
      const auto beacon = zone.beacons->nearest(on_line);
      if (!beacon || distance(on_line, beacon->position) > near_m + step_m || known(beacon->number)) continue;
      const auto nearest = section.nearest(beacon->position);
      if (nearest.distance_m <= near_m) entries.push_back({nearest.s_m, beacon->position, beacon->number});
    }
  }
}

std::span<const TagMap::Entry> TagMap::between(zone::SectionId section, double from_m, double to_m) const {
  const auto& entries = by_section_[section];
  const auto first =
      std::partition_point(entries.begin(), entries.end(), [&](const Entry& entry) { return entry.s_m < from_m; });
  const auto last = std::partition_point(first, entries.end(), [&](const Entry& entry) { return entry.s_m <= to_m; });
  return {first, last};
}

TagMap::Stretch TagMap::free_around(zone::TrackPosition position) const {
  constexpr double endless_m = std::numeric_limits<double>::infinity();
  const auto& entries = by_section_[position.section];
  const auto after = std::ranges::lower_bound(entries, position.s_m, {}, &Entry::s_m);
  const double from_m = after == entries.begin() ? -endless_m : std::prev(after)->s_m;
  return {position.section, from_m, after == entries.end() ? endless_m : after->s_m};
}

void TagReader::move(SimTime now, zone::TrackPosition track_position, Point2 from, Point2 to,
                     std::vector<Reading>& readings) {
  const double reach_m = map_->reach_m();
  const double window_m = reach_m + off_line_m + distance(from, to);
  const auto is_free = [&] {
    return free_.section == track_position.section && free_.from_m < track_position.s_m - window_m &&
           free_.to_m > track_position.s_m + window_m;
  };
  if (in_field_.empty()) {
    if (!is_free()) free_ = map_->free_around(track_position);
    if (is_free()) return;
  }
  for (const TagMap::Entry& entry :
       map_->between(track_position.section, track_position.s_m - window_m, track_position.s_m + window_m)) {
    if (distance_to_path(entry.position, from, to) > reach_m) continue;
    const bool known =
        std::any_of(in_field_.begin(), in_field_.end(), [&](const InField& tag) { return tag.number == entry.number; });
    if (known) continue;
    enter(now, entry.number, readings);
    in_field_.push_back({entry.number, entry.position});
    COSIVA_EXPECT(std::ranges::count(in_field_, entry.number, &InField::number) == 1);
  }
  std::erase_if(in_field_, [&](const InField& tag) { return distance(tag.position, to) > reach_m; });
}

void TagReader::enter(SimTime now, zone::TagNumber number, std::vector<Reading>& readings) {
  const double latency_s = random_.uniform(to_seconds(noise_.latency_min), to_seconds(noise_.latency_max));
  if (!random_.chance(noise_.miss)) readings.push_back({now + from_seconds(latency_s), number});
}

void TagReader::archive(Archive& archive) { archive(in_field_); }

}  // namespace cosiva::physical
