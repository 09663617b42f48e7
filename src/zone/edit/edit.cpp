#include "cosiva/zone/edit/edit.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cosiva/zone/layout/beacons.h"
#include "cosiva/zone/layout/rounding.h"

namespace cosiva::zone {
namespace {

constexpr double pitch_min_m = 0.05;
constexpr double pitch_max_m = 10.0;
constexpr std::uint32_t beacons_edited_max = 20'000;
constexpr double origin_max_m = 1e6;

std::string name_of(TagNumber number) { return "tag " + std::to_string(number); }

bool same(const TrackPosition& a, const TrackPosition& b) { return a.section == b.section && a.s_m == b.s_m; }

std::optional<Error> remove_tag(TrafficZone& zone, TagNumber number) {
  if (zone.tags.erase_if([&](const Tag& tag) { return tag.number == number; }) > 0) return std::nullopt;
  return Error{"edit.tag", "there is no " + name_of(number) + " to take away", name_of(number)};
}

std::optional<Error> set_tag(TrafficZone& zone, const ZoneEdit::TagPosition& set) {
  if (set.number < 1 || set.number > tag_number_max)
    return Error{"edit.number", "a tag's number is from 1 to 4000000000", name_of(set.number)};
  if (set.position.section >= zone.circuit.size())
    return Error{"edit.section", "name a section of this zone for the tag", name_of(set.number)};
  const double length_m = zone.circuit.section(set.position.section).length_m();
  if (!(set.position.s_m >= 0.0 && set.position.s_m <= length_m))
    return Error{"edit.position",
                 "give the metres along '" + zone.circuit.part(set.position.section).name + "' from 0 to its length, " +
                     metres_text(length_m),
                 name_of(set.number)};
  const TrackPosition position = position_as_written(zone.circuit, set.position);
  if (const Tag* tag = zone.find_tag(set.number))
    zone.tags.replace(static_cast<std::size_t>(tag - zone.tags.data()), {set.number, position});
  else
    zone.tags.push_back({set.number, position});
  return std::nullopt;
}

/// The beacons' position after the edit; missing values stay.
std::optional<Error> set_beacons(TrafficZone& zone, const ZoneEdit& edit) {
  if (!edit.beacon_pitch_m && !edit.beacon_origin && !edit.beacon_rotation_rad) return std::nullopt;
  if (!zone.beacons)
    return Error{"edit.beacons", "this zone has no beacons; give its file a [beacons] table first", "beacons"};
  BeaconGrid grid = *zone.beacons;
  if (edit.beacon_pitch_m) grid.pitch_m = rounded_m(*edit.beacon_pitch_m);
  if (edit.beacon_pitch_m && !(grid.pitch_m >= pitch_min_m && grid.pitch_m <= pitch_max_m))
    return Error{"edit.pitch", "beacons may be 0.05 m to 10 m apart; choose a pitch between", "beacons"};
  if (edit.beacon_origin) {
    const Point2 origin{rounded_m(edit.beacon_origin->x_m), rounded_m(edit.beacon_origin->y_m)};
    if (!(std::fabs(origin.x_m) <= origin_max_m && std::fabs(origin.y_m) <= origin_max_m))
      return Error{"edit.origin", "the beacons' origin may lie within 1000 km; choose one near the sections",
                   "beacons"};
    (grid.covers_through ? *grid.covers_through : grid.origin) = origin;
  }
  if (edit.beacon_rotation_rad) {
    if (!(std::fabs(*edit.beacon_rotation_rad) <= 2.0 * pi))
      return Error{"edit.rotation", "turn the beacons by at most one full turn, 2π in either direction", "beacons"};
    grid.rotation_rad = rounded_rad(*edit.beacon_rotation_rad);
  }
  if (grid.covers_through) {
    const auto covering = covering_grid(zone.circuit, zone.vehicle, grid.pitch_m, *grid.covers_through,
                                        beacons_edited_max, grid.rotation_rad);
    if (!covering)
      return Error{"edit.pitch",
                   "so near to each other it takes more than 20000 beacons to cover the zone; widen the pitch",
                   "beacons"};
    const TagNumber first_number = grid.first_number;
    grid = *covering;
    grid.first_number = first_number;
  }
  zone.beacons = grid;
  return std::nullopt;
}

std::optional<Error> set_priority(TrafficZone& zone, const std::string& vehicle, std::int32_t priority) {
  if (const auto wrong = wrong_vehicle_name(vehicle)) return Error{"edit.priority", *wrong, vehicle.substr(0, 64)};
  if (priority < 0 || priority > priority_max)
    return Error{"edit.priority", "a priority is a whole number from 0 to 999", vehicle};
  auto& all = zone.priorities;
  const auto at = std::lower_bound(all.begin(), all.end(), vehicle,
                                   [](const auto& entry, const std::string& name) { return entry.first < name; });
  const bool found = at != all.end() && at->first == vehicle;
  if (priority == 0) {
    if (found) all.erase(at);
  } else if (found) {
    at->second = priority;
  } else {
    all.emplace(at, vehicle, priority);
  }
  return std::nullopt;
}

/// Duplicates in the edit, sets and removals together.
std::optional<std::string> named_twice(const ZoneEdit& edit) {
  std::vector<std::string> names;
  for (const TagNumber number : edit.remove_tags) names.push_back(name_of(number));
  for (const auto& set : edit.set_tags) names.push_back(name_of(set.number));
  for (const auto& [vehicle, priority] : edit.set_priorities) names.push_back(vehicle);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  return twice == names.end() ? std::nullopt : std::optional{*twice};
}

bool same_section(const Circuit::Part& a, const Circuit::Part& b) {
  const double length_m = a.section.length_m();
  return a.name == b.name && a.section.start() == b.section.start() && length_m == b.section.length_m() &&
         a.section.curvature_at(0.0) == b.section.curvature_at(0.0) &&
         a.section.curvature_at(length_m) == b.section.curvature_at(length_m) && a.speed_mps_max == b.speed_mps_max &&
         a.section.curvature_rate_per_m2() == b.section.curvature_rate_per_m2() &&
         same_shape(a.section.shape().get(), b.section.shape().get()) && a.next == b.next && a.pivots == b.pivots;
}

bool same_profile(const SpeedProfile& a, const SpeedProfile& b) {
  return a.speed_mps == b.speed_mps && a.acceleration_mps2 == b.acceleration_mps2 && a.braking_mps2 == b.braking_mps2;
}

bool same_crossing(const Crossing& a, const Crossing& b) {
  return a.name == b.name && std::equal(a.spans.begin(), a.spans.end(), b.spans.begin(), b.spans.end(),
                                        [](const CrossingSpan& x, const CrossingSpan& y) {
                                          return x.section == y.section && x.from_m == y.from_m && x.to_m == y.to_m;
                                        });
}

}  // namespace

std::optional<std::string> wrong_vehicle_name(std::string_view name) {
  const auto slash = name.find('/');
  const bool whole = slash != std::string_view::npos && slash > 0 && slash + 1 < name.size() && name.size() <= 128 &&
                     name.find('/', slash + 1) == std::string_view::npos;
  const bool clean = std::none_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F || c == '+' || c == '#';
  });
  if (whole && clean) return std::nullopt;
  return "name a vehicle as manufacturer/serial number, such as CoSiVA/AIV1, in at most 128 bytes";
}

Result<TrafficZone> with_edit(TrafficZone zone, const ZoneEdit& edit) {
  if (const auto name = named_twice(edit))
    return fail("edit.twice", *name + " occurs in this edit twice; give it once", *name);
  std::optional<Error> error;
  for (const TagNumber number : edit.remove_tags)
    if (!error) error = remove_tag(zone, number);
  for (const auto& set : edit.set_tags)
    if (!error) error = set_tag(zone, set);
  if (!error) error = set_beacons(zone, edit);
  for (const auto& [vehicle, priority] : edit.set_priorities)
    if (!error) error = set_priority(zone, vehicle, priority);
  if (error) return tl::unexpected(std::move(*error));
  // Last, because another pitch gives the beacons other numbers.
  for (const Tag& tag : zone.tags) {
    if (zone.beacons && zone.beacons->find(tag.number))
      return fail("edit.number",
                  std::to_string(tag.number) + " is also the number of a beacon; give the tag one below " +
                      std::to_string(zone.beacons->first_number),
                  name_of(tag.number));
  }
  return zone;
}

bool same_geometry(const TrafficZone& a, const TrafficZone& b) {
  if (a.name != b.name || a.circuit.size() != b.circuit.size()) return false;
  for (SectionId id = 0; id < a.circuit.size(); ++id)
    if (!same_section(a.circuit.part(id), b.circuit.part(id))) return false;
  // Crossings and waypoints also follow from the clearance and the spacing that the file requests.
  return a.vehicle.length_m == b.vehicle.length_m && a.vehicle.width_m == b.vehicle.width_m &&
         same_profile(a.profiles.slow, b.profiles.slow) && same_profile(a.profiles.medium, b.profiles.medium) &&
         same_profile(a.profiles.fast, b.profiles.fast) &&
         std::equal(a.crossings.begin(), a.crossings.end(), b.crossings.begin(), b.crossings.end(), same_crossing) &&
         std::equal(a.waypoints.begin(), a.waypoints.end(), b.waypoints.begin(), b.waypoints.end(),
                    [](const Waypoint& x, const Waypoint& y) { return x.id == y.id && same(x.position, y.position); });
}

std::optional<std::string> difference(const TrafficZone& wanted, const TrafficZone& found) {
  const auto same_tag = [](const Tag& x, const Tag& y) { return x.number == y.number && same(x.position, y.position); };
  const auto same_station = [](const Station& x, const Station& y) {
    return x.name == y.name && x.kind == y.kind && same(x.position, y.position);
  };
  const auto same_loop = [](const Loop& x, const Loop& y) { return x.name == y.name && x.sections == y.sections; };
  if (!same_geometry(wanted, found)) return "its sections differ";
  if (!std::equal(wanted.tags.begin(), wanted.tags.end(), found.tags.begin(), found.tags.end(), same_tag))
    return "its tags differ";
  if (wanted.beacons.has_value() != found.beacons.has_value()) return "its beacons differ";
  if (wanted.beacons) {
    const BeaconGrid& x = *wanted.beacons;
    const BeaconGrid& y = *found.beacons;
    if (x.pitch_m != y.pitch_m || x.origin != y.origin || x.columns != y.columns || x.rows != y.rows ||
        x.first_number != y.first_number || x.rotation_rad != y.rotation_rad || x.covers_through != y.covers_through)
      return "its beacons differ";
  }
  if (!std::equal(wanted.stations.begin(), wanted.stations.end(), found.stations.begin(), found.stations.end(),
                  same_station) ||
      wanted.starts != found.starts)
    return "its stations or starts differ";
  if (!std::equal(wanted.loops.begin(), wanted.loops.end(), found.loops.begin(), found.loops.end(), same_loop) ||
      wanted.closed != found.closed)
    return "its loops or closed sections differ";
  if (wanted.edges_are_sections != found.edges_are_sections) return "its edges' names differ";
  if (wanted.priorities != found.priorities) return "its priorities differ";
  return std::nullopt;
}

}  // namespace cosiva::zone
