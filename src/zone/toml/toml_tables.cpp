#include "cosiva/zone/toml/toml_tables.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/beacons.h"
#include "cosiva/zone/layout/crossings.h"
#include "cosiva/zone/layout/indirect.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::zone {
namespace {

constexpr std::uint32_t beacons_max = 1'000'000;
// Far beyond any factory, but some functions search the elements of the zone linearly.
constexpr std::size_t tags_max = 200'000;
constexpr std::size_t stations_max = 20'000;
constexpr std::size_t starts_max = 10'000;
constexpr std::size_t loops_max = 1'000;
constexpr std::size_t loop_sections_max = 400'000;

constexpr NumberRange positive_size_m{"a positive number of metres, at most 100", 0.0, 100.0, false};
constexpr NumberRange acceleration{"a positive acceleration in m/s², at most 100", 0.0, 100.0, false};

SpeedProfile read_profile(const TomlFields& profiles, std::string_view name, const SpeedProfile& fallback) {
  const auto profile = profiles.table(name);
  if (!profile) return fallback;
  profile->expect_only({"speed_mps", "acceleration_mps2", "braking_mps2"});
  return {profile->number("speed_mps", speed_range), profile->number("acceleration_mps2", acceleration),
          profile->number("braking_mps2", acceleration)};
}

SpeedProfiles read_profiles(const TomlFields& fields) {
  fields.expect_only({"slow", "medium", "fast"});
  SpeedProfiles profiles = default_profiles;
  profiles.slow = read_profile(fields, "slow", profiles.slow);
  profiles.medium = read_profile(fields, "medium", profiles.medium);
  profiles.fast = read_profile(fields, "fast", profiles.fast);
  const auto faster = [&](std::string_view name, const SpeedProfile& one, const SpeedProfile& slower) {
    if (one.speed_mps >= slower.speed_mps) return;
    fields.fault(name, "zone.field",
                 "expected at least the speed of the slower profile, " + toml_number(slower.speed_mps) +
                     " m/s, found " + toml_number(one.speed_mps) + " m/s");
  };
  faster("medium", profiles.medium, profiles.slow);
  faster("fast", profiles.fast, profiles.medium);
  return profiles;
}

bool on_waypoint(const TrafficZone& zone, TrackPosition position) {
  constexpr double near_m = 0.02;
  return std::any_of(zone.waypoints.begin(), zone.waypoints.end(), [&](const Waypoint& waypoint) {
    return waypoint.position.section == position.section && std::fabs(waypoint.position.s_m - position.s_m) <= near_m;
  });
}

}  // namespace

void parse_toml(std::string_view text, TomlFaults& faults, const std::function<void(const TomlFields& root)>& read) {
  try {
    const toml::table root = toml::parse(text);
    read(TomlFields{faults, root, ""});
  } catch (const toml::parse_error& error) {
    faults.add("zone.syntax", static_cast<std::uint32_t>(error.source().begin.line), "",
               std::string(error.description()));
  } catch (const std::exception& error) {
    faults.add("zone.syntax", 1, "", std::string("cannot be read: ") + error.what());
  }
}

void read_basics(const TomlFields& root, Sidecar& basics) {
  if (root.has("travel_direction"))
    basics.indirect = root.one_of("travel_direction", {"direct", "indirect"}) == "indirect";
  if (const auto vehicle = root.table("vehicle")) {
    vehicle->expect_only({"length_m", "width_m"});
    basics.vehicle =
        VehicleShape{vehicle->number("length_m", positive_size_m), vehicle->number("width_m", positive_size_m)};
  }
  if (const auto profiles = root.table("profiles")) basics.profiles = read_profiles(*profiles);
  if (const auto crossings = root.table("crossings")) {
    crossings->expect_only({"clearance_m"});
    basics.clearance_m = crossings->number("clearance_m", {"metres from 0 to 10", 0.0, 10.0}, basics.clearance_m);
  }
  if (const auto waypoints = root.table("waypoints")) {
    waypoints->expect_only({"spacing_m", "nodes_only", "edges_are_sections"});
    basics.edges_are_sections = waypoints->flag("edges_are_sections", false);
    if (waypoints->has("nodes_only")) basics.nodes_only = waypoints->flag("nodes_only", false);
    basics.spacing_m = waypoints->number("spacing_m", {"metres from 0.05 to 1000", 0.05, 1000.0}, basics.spacing_m);
  }
}

void TomlTables::read() {
  if (basics_.indirect) make_indirect(zone_, rules_);
  // In this order, because each reads what those before it made.
  constexpr void (TomlTables::*steps[])() = {
      &TomlTables::read_beacons, &TomlTables::read_tags,       &TomlTables::read_stations, &TomlTables::read_loops,
      &TomlTables::read_closed,  &TomlTables::read_priorities, &TomlTables::derive,        &TomlTables::read_starts};
  for (const auto step : steps) {
    (this->*step)();
    if (faults_.any()) return;
  }
}

std::optional<SectionId> TomlTables::find(const TomlFields& fields, std::string_view key, std::string_view name) const {
  const auto id = zone_.circuit.find(name);
  if (!id) {
    fields.fault(key, "zone.reference",
                 "expected the name of a section, found \"" + std::string(name.substr(0, 64)) + "\", which is none");
  }
  return id;
}

std::optional<TrackPosition> TomlTables::read_position(const TomlFields& fields) const {
  const std::string section = fields.name("section");
  if (faults_.any()) return std::nullopt;
  const auto id = find(fields, "section", section);
  if (!id) return std::nullopt;
  const double length_m = zone_.circuit.section(*id).length_m();
  const std::string what = "metres along '" + section + "' from 0 to its length, " + toml_number(length_m);
  const double s = fields.number("s_m", {what, 0.0, length_m});
  if (faults_.any()) return std::nullopt;
  const TrackPosition position{*id, s};
  return zone_.circuit.indirect() ? reversed(zone_.circuit, position)
                                  : position;  // the file's positions are of its own direction
}

bool TomlTables::too_many(std::string_view key, std::size_t found, std::size_t most) const {
  if (found > most)
    root_.fault(key, "zone.size",
                "expected at most " + std::to_string(most) + " of these, found " + std::to_string(found));
  return found > most;
}

void TomlTables::read_beacons() {
  const auto fields = root_.table("beacons");
  if (!fields) return;
  BeaconGrid grid{};
  grid.pitch_m = fields->number("pitch_m", positive_m);
  const Point2 origin = fields->point("origin").value_or(Point2{});
  const double rotation_rad = fields->angle("rotation", 360.0, 0.0);
  if (fields->has("cover")) {
    fields->expect_only({"pitch_m", "cover", "origin", "rotation_deg", "rotation_rad", "first_number"});
    (void)fields->one_of("cover", {"zone"});
    if (faults_.any()) return;
    const auto covering = covering_grid(zone_.circuit, zone_.vehicle, grid.pitch_m, origin, beacons_max, rotation_rad);
    if (!covering)
      return fields->fault("pitch_m", "zone.size",
                           "covering the zone takes more than 1000000 beacons; widen the pitch");
    grid = *covering;
  } else {
    fields->expect_only(
        {"pitch_m", "cover", "origin", "rotation_deg", "rotation_rad", "columns", "rows", "first_number"});
    grid.origin = origin;
    grid.rotation_rad = rotation_rad;
    grid.columns = static_cast<std::uint32_t>(fields->whole("columns", 1, beacons_max));
    grid.rows = static_cast<std::uint32_t>(fields->whole("rows", 1, beacons_max));
    if (!faults_.any() && std::uint64_t{grid.columns} * grid.rows > beacons_max)
      return fields->fault("rows", "zone.size", "expected at most 1000000 beacons in all");
  }
  grid.first_number =
      static_cast<TagNumber>(fields->whole("first_number", 1, tag_number_max, BeaconGrid{}.first_number));
  zone_.beacons = grid;
}

void TomlTables::read_tags() {
  std::set<TagNumber> numbers;
  std::vector<Tag> tags;
  const auto entries = root_.tables("tag");
  if (too_many("tag", entries.size(), tags_max)) return;
  for (const TomlFields& fields : entries) {
    fields.expect_only({"number", "section", "s_m"});
    const auto number = static_cast<TagNumber>(fields.whole("number", 1, tag_number_max));
    const auto position = read_position(fields);
    if (!position) return;
    if (!numbers.insert(number).second)
      return fields.fault("number", "zone.duplicate", "tag " + std::to_string(number) + " is already laid");
    if (zone_.beacons && zone_.beacons->find(number))
      return fields.fault("number", "zone.duplicate", std::to_string(number) + " is also the number of a beacon");
    tags.push_back({number, *position});
  }
  zone_.tags = std::move(tags);
}

void TomlTables::read_stations() {
  std::set<std::string> names;
  for (const Station& station : zone_.stations) names.insert(station.name);
  const auto entries = root_.tables("station");
  if (too_many("station", entries.size(), stations_max)) return;
  for (const TomlFields& fields : entries) {
    fields.expect_only({"name", "section", "s_m", "kind"});
    Station station{fields.name("name"), {}, StationKind::stop};
    if (fields.has("kind") && fields.one_of("kind", {"stop", "charger"}) == "charger")
      station.kind = StationKind::charger;
    const auto position = read_position(fields);
    if (!position) return;
    station.position = *position;
    if (!names.insert(station.name).second)
      return fields.fault("name", "zone.duplicate", "two stations have the name '" + station.name + "'");
    zone_.stations.push_back(std::move(station));
  }
}

void TomlTables::read_loops() {
  std::set<std::string> names;
  for (const Loop& loop : zone_.loops) names.insert(loop.name);
  const auto entries = root_.tables("loop");
  if (too_many("loop", entries.size(), loops_max)) return;
  std::size_t total = 0;
  for (const TomlFields& fields : entries) {
    fields.expect_only({"name", "sections"});
    Loop loop{fields.name("name"), {}};
    const auto sections = fields.names("sections");
    if (faults_.any()) return;
    if (!names.insert(loop.name).second)
      return fields.fault("name", "zone.duplicate", "two loops have the name '" + loop.name + "'");
    if (!sections || sections->empty())
      return fields.fault("sections", "zone.missing", "expected the names of the sections that it goes through");
    total += sections->size();
    if (total > loop_sections_max)
      return fields.fault("sections", "zone.size", "expected loops of at most 400000 sections in all");
    for (const std::string& name : *sections) {
      const auto id = find(fields, "sections", name);
      if (!id) return;
      loop.sections.push_back(*id);
    }
    if (zone_.circuit.indirect()) std::reverse(loop.sections.begin(), loop.sections.end());
    for (std::size_t i = 0; i < loop.sections.size(); ++i) {
      const SectionId after = loop.sections[(i + 1) % loop.sections.size()];
      const auto next = zone_.circuit.next(loop.sections[i]);
      if (std::find(next.begin(), next.end(), after) != next.end()) continue;
      return fields.fault("sections", "zone.loop",
                          "'" + zone_.circuit.part(after).name + "' does not follow '" +
                              zone_.circuit.part(loop.sections[i]).name +
                              "'; expected a loop in which each section follows the one before, and the first the "
                              "last");
    }
    zone_.loops.push_back(std::move(loop));
  }
}

void TomlTables::read_closed() {
  const auto fields = root_.table("closed");
  if (!fields) return;
  fields->expect_only({"sections"});
  for (const std::string& name : fields->names("sections").value_or(std::vector<std::string>{})) {
    const auto id = find(*fields, "sections", name);
    if (!id) return;
    zone_.closed.push_back(*id);
  }
  std::sort(zone_.closed.begin(), zone_.closed.end());
  zone_.closed.erase(std::unique(zone_.closed.begin(), zone_.closed.end()), zone_.closed.end());
}

void TomlTables::read_priorities() {
  const auto fields = root_.table("priorities");
  if (!fields) return;
  for (const std::string& vehicle : fields->keys()) {
    if (const auto wrong = wrong_vehicle_name(vehicle)) return fields->fault(vehicle, "zone.field", *wrong);
    const std::int64_t priority = fields->whole(vehicle, 0, priority_max);
    if (priority > 0) zone_.priorities.emplace_back(vehicle, static_cast<std::int32_t>(priority));
  }
  std::sort(zone_.priorities.begin(), zone_.priorities.end());
}

void TomlTables::derive() {
  auto crossings = find_crossings_unless_crowded(zone_.circuit, zone_.vehicle, basics_.clearance_m);
  if (!crossings) {
    return faults_.add(
        {"zone.size", "the sections lie so densely on one another that no vehicle could drive here", tracks_});
  }
  zone_.clearance_m = basics_.clearance_m;
  zone_.spacing_m = basics_.spacing_m;
  zone_.nodes_only = basics_.nodes_only.value_or(rules_.nodes_only);
  rules_.spacing_m = zone_.spacing_m;
  rules_.nodes_only = zone_.nodes_only;
  rules_.room_m = stopping_room_m(zone_.vehicle);
  for (const Station& station : zone_.stations) rules_.at.push_back(station.position);
  zone_.crossings = *std::move(crossings);
  zone_.waypoints = lay_waypoints(zone_.circuit, zone_.crossings, rules_);
}

void TomlTables::read_starts() {
  const auto entries = root_.tables("start");
  if (too_many("start", entries.size(), starts_max)) return;
  for (const TomlFields& fields : entries) {
    fields.expect_only({"section", "s_m"});
    const auto position = read_position(fields);
    if (!position) return;
    const Crossing* crossing = zone_.crossing_at(*position);
    if (on_waypoint(zone_, *position)) crossing = nullptr;  // a vehicle may stop where the file has a node or a station
    if (crossing != nullptr) {
      return fields.fault("s_m", "zone.start",
                          "expected a position outside every crossing, found one inside " + crossing->name);
    }
    if (!zone_.may_stop(*position) && !on_waypoint(zone_, *position)) {
      return fields.fault(
          "s_m", "zone.start",
          "expected a position where a vehicle may stop, found one between crossings too close together");
    }
    zone_.starts.push_back(*position);
  }
}

}  // namespace cosiva::zone
