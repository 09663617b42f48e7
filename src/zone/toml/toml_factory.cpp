#include "zone/toml/toml_factory.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "zone/edit_rules.h"
#include "zone/toml/toml_fields.h"

namespace cosiva::zone {
namespace {

constexpr double rad_per_deg = pi / 180.0;

// The whole zone may turn this much: it bounds the memory that a small file can ask for.
constexpr double turned_max_rad = 1e5;
constexpr double length_max_m = 1e5;
constexpr std::uint32_t beacons_max = 1'000'000;

constexpr NumberRange positive_m{"a positive number of metres, at most 100000", 0.0, 1e5, false};
constexpr NumberRange positive_size_m{"a positive number of metres, at most 100", 0.0, 100.0, false};
constexpr NumberRange heading_deg{"a heading in degrees within ±360", -360.0, 360.0};
constexpr NumberRange turn_deg{"degrees to turn, positive to the left", -572957.0, 572957.0};
constexpr NumberRange curvature{"a curvature per metre within ±1000, positive to the left", -1000.0, 1000.0};
constexpr NumberRange speed{"a positive speed in metres per second, at most 100", 0.0, 100.0, false};
constexpr NumberRange acceleration{"a positive acceleration in m/s², at most 100", 0.0, 100.0, false};

std::string shortest(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

/// Reads one file. Each step fills its part of the zone and may leave a fault, which ends the reading.
class Reader {
 public:
  Reader(TomlFaults& faults, const toml::table& root) : faults_{faults}, root_{faults, root, ""} {}

  Result<TrafficZone> read();

 private:
  void read_head();
  void read_vehicle();
  void read_profiles();
  [[nodiscard]] SpeedProfile read_profile(const TomlFields& profiles, std::string_view name,
                                          const SpeedProfile& fallback) const;
  [[nodiscard]] Pose2 read_pose(const TomlFields& fields) const;
  void read_circuit();
  [[nodiscard]] std::optional<Section> read_section(const TomlFields& fields, const Pose2& follows) const;
  void read_successors(const std::vector<TomlFields>& entries, bool closed);
  void join(std::vector<TomlFields> entries);
  void check_vehicle_fits() const;
  [[nodiscard]] std::optional<Place> read_place(const TomlFields& fields) const;
  void read_beacons();
  void read_tags();
  void read_stations();
  void read_priorities();
  void derive();
  void read_starts();

  TomlFaults& faults_;
  TomlFields root_;
  std::string name_;
  std::vector<Circuit::Part> parts_;
  std::optional<TrafficZone> zone_;
  VehicleShape vehicle_;
  SpeedProfiles profiles_{{0.15, 0.3, 0.6}, {0.30, 0.5, 0.8}, {0.50, 0.8, 1.0}};
};

Result<TrafficZone> Reader::read() {
  // In this order, because each reads what those before it made.
  constexpr void (Reader::*steps[])() = {&Reader::read_head,     &Reader::read_vehicle,    &Reader::read_profiles,
                                         &Reader::read_circuit,  &Reader::read_beacons,    &Reader::read_tags,
                                         &Reader::read_stations, &Reader::read_priorities, &Reader::derive,
                                         &Reader::read_starts};
  for (const auto step : steps) {
    (this->*step)();
    if (faults_.any()) return tl::unexpected(*faults_.first());
  }
  return std::move(*zone_);
}

void Reader::read_head() {
  root_.expect_only({"name", "format_version", "vehicle", "profiles", "circuit", "section", "tag", "beacons", "station",
                     "start", "crossings", "waypoints", "priorities"});
  if (root_.whole("format_version", 1, tag_number_max) != 1 && !faults_.any())
    root_.fault("format_version", "zone.version", "this program reads version 1 of the format");
  name_ = root_.name("name");
}

void Reader::read_vehicle() {
  const auto vehicle = root_.table("vehicle");
  if (!vehicle) return;
  vehicle->expect_only({"length_m", "width_m"});
  vehicle_.length_m = vehicle->number("length_m", positive_size_m);
  vehicle_.width_m = vehicle->number("width_m", positive_size_m);
}

void Reader::read_profiles() {
  const auto profiles = root_.table("profiles");
  if (!profiles) return;
  profiles->expect_only({"slow", "medium", "fast"});
  profiles_.slow = read_profile(*profiles, "slow", profiles_.slow);
  profiles_.medium = read_profile(*profiles, "medium", profiles_.medium);
  profiles_.fast = read_profile(*profiles, "fast", profiles_.fast);
  const auto faster = [&](std::string_view name, const SpeedProfile& one, const SpeedProfile& slower) {
    if (one.speed_mps >= slower.speed_mps) return;
    profiles->fault(name, "zone.field",
                    "expected at least the speed of the slower profile, " + shortest(slower.speed_mps) +
                        " m/s, found " + shortest(one.speed_mps) + " m/s");
  };
  faster("medium", profiles_.medium, profiles_.slow);
  faster("fast", profiles_.fast, profiles_.medium);
}

SpeedProfile Reader::read_profile(const TomlFields& profiles, std::string_view name,
                                  const SpeedProfile& fallback) const {
  const auto profile = profiles.table(name);
  if (!profile) return fallback;
  profile->expect_only({"speed_mps", "acceleration_mps2", "braking_mps2"});
  return {profile->number("speed_mps", speed), profile->number("acceleration_mps2", acceleration),
          profile->number("braking_mps2", acceleration)};
}

Pose2 Reader::read_pose(const TomlFields& fields) const {
  fields.expect_only({"x", "y", "heading_deg"});
  const double heading = fields.number("heading_deg", heading_deg);
  return {fields.number("x", coordinate_m), fields.number("y", coordinate_m), wrap_angle(heading * rad_per_deg)};
}

void Reader::read_circuit() {
  Pose2 follows;
  bool closed = false;
  if (const auto circuit = root_.table("circuit")) {
    circuit->expect_only({"start", "closed"});
    if (const auto start = circuit->table("start")) follows = read_pose(*start);
    closed = circuit->flag("closed", false);
  }
  auto entries = root_.tables("section");
  if (faults_.any()) return;
  if (entries.empty()) return root_.fault("section", "circuit.empty", "expected at least one [[section]], found none");
  if (entries.size() > toml_sections_max) {
    return root_.fault(
        "section", "zone.size",
        "expected at most " + std::to_string(toml_sections_max) + " sections, found " + std::to_string(entries.size()));
  }

  double turned_rad = 0.0;
  double length_m = 0.0;
  parts_.reserve(entries.size());
  for (const TomlFields& fields : entries) {
    const std::string name = fields.name("name");
    if (const auto start = fields.table("start")) follows = read_pose(*start);
    const auto section = read_section(fields, follows);
    if (faults_.any() || !section) return;
    turned_rad += section->curvature_max_per_m() * section->length_m();
    length_m += section->length_m();
    if (turned_rad > turned_max_rad || length_m > length_max_m) {
      return fields.fault(
          "", "zone.size",
          "a zone's sections may be 100 km long and turn 100000 rad in all; those up to here exceed it");
    }
    Circuit::Part part{name, *section, std::nullopt, {}};
    if (fields.has("speed_mps_max")) part.speed_mps_max = fields.number("speed_mps_max", speed);
    parts_.push_back(std::move(part));
    follows = section->end();
  }
  read_successors(entries, closed);
  if (!faults_.any()) join(std::move(entries));
}

std::optional<Section> Reader::read_section(const TomlFields& fields, const Pose2& follows) const {
  const std::string kind = fields.one_of("kind", {"straight", "arc", "clothoid"});
  double length_m = 0.0;
  double curvature_per_m = 0.0;
  double rate_per_m2 = 0.0;
  if (kind == "straight") {
    fields.expect_only({"name", "kind", "length_m", "speed_mps_max", "start", "next"});
    length_m = fields.number("length_m", positive_m);
  } else if (kind == "arc") {
    fields.expect_only({"name", "kind", "radius_m", "angle_deg", "speed_mps_max", "start", "next"});
    const double radius_m = fields.number("radius_m", positive_m);
    const double angle_rad = fields.number("angle_deg", turn_deg) * rad_per_deg;
    length_m = radius_m * std::fabs(angle_rad);
    curvature_per_m = (angle_rad < 0.0 ? -1.0 : 1.0) / radius_m;
    if (angle_rad == 0.0 && !faults_.any())
      fields.fault("angle_deg", "zone.field", "expected degrees to turn, positive to the left, found 0");
  } else if (kind == "clothoid") {
    fields.expect_only(
        {"name", "kind", "length_m", "curvature_start_per_m", "curvature_end_per_m", "speed_mps_max", "start", "next"});
    length_m = fields.number("length_m", positive_m);
    curvature_per_m = fields.number("curvature_start_per_m", curvature);
    rate_per_m2 = (fields.number("curvature_end_per_m", curvature) - curvature_per_m) / length_m;
  }
  if (faults_.any()) return std::nullopt;
  auto section = Section::make(follows, length_m, curvature_per_m, rate_per_m2);
  if (section) return std::move(*section);
  fields.fault("", section.error().code, section.error().message);
  return std::nullopt;
}

void Reader::read_successors(const std::vector<TomlFields>& entries, bool closed) {
  // An own index: the circuit's needs the circuit, and the circuit needs the successors.
  std::vector<std::pair<std::string_view, SectionId>> by_name;
  for (SectionId id = 0; id < parts_.size(); ++id) by_name.emplace_back(parts_[id].name, id);
  std::sort(by_name.begin(), by_name.end());

  for (SectionId id = 0; id < parts_.size(); ++id) {
    auto& next = parts_[id].next;
    if (const auto names = entries[id].names("next")) {
      for (const std::string& name : *names) {
        const auto at =
            std::lower_bound(by_name.begin(), by_name.end(), std::pair{std::string_view{name}, SectionId{0}});
        if (at == by_name.end() || at->first != name)
          return entries[id].fault("next", "zone.reference",
                                   "expected names of sections, found \"" + name.substr(0, 64) + "\", which is none");
        if (std::find(next.begin(), next.end(), at->second) != next.end())
          return entries[id].fault("next", "zone.duplicate", "\"" + name + "\" stands here twice");
        next.push_back(at->second);
      }
    } else if (id + 1 < parts_.size()) {
      next.push_back(id + 1);
    } else if (closed) {
      next.push_back(0);
    }
  }
}

void Reader::join(std::vector<TomlFields> entries) {
  std::vector<std::string> names;
  for (const auto& part : parts_) names.push_back(part.name);
  auto circuit = Circuit::make(name_, std::move(parts_));
  if (!circuit) {
    // The circuit knows the section at fault by name; the last of that name is the one that came too late.
    const Error& error = circuit.error();
    const auto found = std::find(names.rbegin(), names.rend(), error.place);
    const bool duplicate = error.code == "circuit.duplicate";
    const auto index = found == names.rend() ? std::size_t{0} : static_cast<std::size_t>(names.rend() - found) - 1;
    return entries[index].fault(duplicate ? "name" : "next", error.code, error.message);
  }
  zone_ = TrafficZone{name_, std::move(*circuit), vehicle_, profiles_, {}, {}, {}, {}, {}, {}};
  check_vehicle_fits();
}

void Reader::check_vehicle_fits() const {
  for (SectionId id = 0; id < zone_->circuit.size(); ++id) {
    const double bend = zone_->circuit.section(id).curvature_max_per_m();
    if (0.5 * vehicle_.width_m * bend < 1.0) continue;
    const auto vehicle = root_.table("vehicle");
    const std::string message = "expected less than " + shortest(2.0 / bend) + " m, because section '" +
                                zone_->circuit.part(id).name + "' bends with a radius of " + shortest(1.0 / bend) +
                                " m, found " + shortest(vehicle_.width_m);
    return vehicle ? vehicle->fault("width_m", "zone.vehicle", message)
                   : root_.fault("vehicle", "zone.vehicle", message);
  }
}

std::optional<Place> Reader::read_place(const TomlFields& fields) const {
  const std::string section = fields.name("section");
  if (faults_.any()) return std::nullopt;
  const auto id = zone_->circuit.find(section);
  if (!id) {
    fields.fault("section", "zone.reference",
                 "expected the name of a section, found \"" + section + "\", which is none");
    return std::nullopt;
  }
  const double length_m = zone_->circuit.section(*id).length_m();
  const std::string what = "metres along '" + section + "' from 0 to its length, " + shortest(length_m);
  const double s = fields.number("s_m", {what, 0.0, length_m});
  return faults_.any() ? std::nullopt : std::optional{Place{*id, s}};
}

void Reader::read_beacons() {
  const auto fields = root_.table("beacons");
  if (!fields) return;
  BeaconGrid grid{};
  grid.pitch_m = fields->number("pitch_m", positive_m);
  const auto origin = fields->point("origin");
  if (fields->has("cover")) {
    fields->expect_only({"pitch_m", "cover", "origin", "first_number"});
    (void)fields->one_of("cover", {"zone"});
    if (faults_.any()) return;
    const auto covering = covering_grid(zone_->circuit, vehicle_, grid.pitch_m, origin.value_or(Point2{}), beacons_max);
    if (!covering)
      return fields->fault("pitch_m", "zone.size",
                           "covering the zone takes more than 1000000 beacons; widen the pitch");
    grid = *covering;
  } else {
    fields->expect_only({"pitch_m", "cover", "origin", "columns", "rows", "first_number"});
    grid.origin = origin.value_or(Point2{});
    grid.columns = fields->whole("columns", 1, beacons_max);
    grid.rows = fields->whole("rows", 1, beacons_max);
    if (!faults_.any() && std::uint64_t{grid.columns} * grid.rows > beacons_max)
      return fields->fault("rows", "zone.size", "expected at most 1000000 beacons in all");
  }
  grid.first_number = fields->whole("first_number", 1, tag_number_max, BeaconGrid{}.first_number);
  zone_->beacons = grid;
}

void Reader::read_tags() {
  std::set<TagNumber> numbers;
  for (const TomlFields& fields : root_.tables("tag")) {
    fields.expect_only({"number", "section", "s_m"});
    const TagNumber number = fields.whole("number", 1, tag_number_max);
    const auto place = read_place(fields);
    if (faults_.any() || !place) return;
    if (!numbers.insert(number).second)
      return fields.fault("number", "zone.duplicate", "tag " + std::to_string(number) + " is already laid");
    if (zone_->beacons && zone_->beacons->find(number))
      return fields.fault("number", "zone.duplicate", std::to_string(number) + " is also the number of a beacon");
    zone_->tags.push_back({number, *place});
  }
}

void Reader::read_stations() {
  std::set<std::string> names;
  for (const TomlFields& fields : root_.tables("station")) {
    fields.expect_only({"name", "section", "s_m"});
    const std::string name = fields.name("name");
    const auto place = read_place(fields);
    if (faults_.any() || !place) return;
    if (!names.insert(name).second)
      return fields.fault("name", "zone.duplicate", "two stations have the name '" + name + "'");
    zone_->stations.push_back({name, *place});
  }
}

void Reader::read_priorities() {
  const auto fields = root_.table("priorities");
  if (!fields) return;
  for (const std::string& vehicle : fields->keys()) {
    if (const auto wrong = wrong_vehicle_name(vehicle)) return fields->fault(vehicle, "zone.field", *wrong);
    const std::uint32_t priority = fields->whole(vehicle, 0, priority_max);
    if (priority > 0) zone_->priorities.emplace_back(vehicle, static_cast<std::int32_t>(priority));
  }
  std::sort(zone_->priorities.begin(), zone_->priorities.end());
}

void Reader::derive() {
  double clearance_m = 0.04;
  double spacing_m = 0.30;
  if (const auto crossings = root_.table("crossings")) {
    crossings->expect_only({"clearance_m"});
    clearance_m = crossings->number("clearance_m", {"metres from 0 to 10", 0.0, 10.0});
  }
  if (const auto waypoints = root_.table("waypoints")) {
    waypoints->expect_only({"spacing_m"});
    spacing_m = waypoints->number("spacing_m", {"metres from 0.05 to 1000", 0.05, 1000.0});
  }
  if (faults_.any()) return;
  if (too_crowded(zone_->circuit, zone_->vehicle, clearance_m))
    return root_.fault("section", "zone.size",
                       "the sections lie so densely on one another that nobody could drive here");
  zone_->crossings = find_crossings(zone_->circuit, zone_->vehicle, clearance_m);
  zone_->waypoints = lay_waypoints(zone_->circuit, zone_->crossings, spacing_m, standing_room_m(zone_->vehicle));
}

void Reader::read_starts() {
  for (const TomlFields& fields : root_.tables("start")) {
    fields.expect_only({"section", "s_m"});
    const auto place = read_place(fields);
    if (faults_.any() || !place) return;
    if (const Crossing* crossing = zone_->crossing_at(*place)) {
      return fields.fault("s_m", "zone.start",
                          "expected a place outside every crossing, found one inside " + crossing->name);
    }
    if (!zone_->may_stand(*place)) {
      return fields.fault("s_m", "zone.start",
                          "expected a place where a vehicle may stand, found one between crossings too close together");
    }
    zone_->starts.push_back(*place);
  }
}

}  // namespace

Result<TrafficZone> TomlCircuitFactory::make_zone(const ZoneConfiguration& configuration) const {
  TomlFaults faults{configuration.origin};
  if (configuration.text.size() > toml_bytes_max) {
    return fail("zone.size", "expected at most 16 MiB, found " + std::to_string(configuration.text.size()) + " bytes",
                configuration.origin);
  }
  try {
    const toml::table root = toml::parse(configuration.text);
    return Reader{faults, root}.read();
  } catch (const toml::parse_error& error) {
    return fail("zone.syntax", std::string(error.description()),
                faults.place(static_cast<std::uint32_t>(error.source().begin.line), ""));
  } catch (const std::exception& error) {
    return fail("zone.syntax", std::string("cannot be read: ") + error.what(), configuration.origin);
  }
}

}  // namespace cosiva::zone
