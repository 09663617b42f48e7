#include "cosiva/virtual/server/augmented/virtual_object_commands.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t id_bytes_max = 32;

std::string metres(double m) {
  std::string text = std::to_string(m);
  return text.substr(0, text.find('.') + 3) + " m";
}

std::string at_text(Point2 p) { return "(" + metres(p.x_m) + ", " + metres(p.y_m) + ")"; }

std::string cut(std::string_view text) { return std::string(text.substr(0, 80)); }

/// Reads a number in [low, high] into `out`; leaves `out` unchanged if the field is missing.
Result<void> read_number(OptionalNumber given, std::string_view field, double low, double high, std::string_view unit,
                         double& out) {
  if (!given) return {};
  if (!(*given >= low && *given <= high)) {
    return fail("virtual_object.number",
                "give a number from " + metres(low) + " to " + metres(high) + std::string(unit), std::string(field));
  }
  out = *given;
  return {};
}

std::string_view letter_of(std::string_view kind) {
  if (kind == "aiv") return "V";
  return kind == "person" ? "P" : "O";
}

/// "S1", "S2" … are the twins of physical obstacles.
bool is_detected_id(std::string_view id) {
  return id.size() > 1 && id.front() == 'S' &&
         std::ranges::all_of(id.substr(1), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

const VirtualFleet::Host* VirtualObjectCommands::find_aiv(std::string_view id) const {
  for (const VirtualFleet::Host& host : fleet_.hosts()) {
    const AivProxy& proxy = registry_[host.vehicle];
    if (proxy.id().serial_number == id || proxy.name() == id) return &host;
  }
  return nullptr;
}

bool VirtualObjectCommands::in_use(std::string_view id) const {
  return simulator_.augmented().find(id) != nullptr || find_aiv(id) != nullptr || restored_.find(id) != nullptr;
}

std::string VirtualObjectCommands::next_id(std::string_view kind) const {
  for (std::uint32_t n = 1;; ++n) {
    std::string id = std::string(letter_of(kind)) + std::to_string(n);
    if (!in_use(id)) return id;
  }
}

std::string VirtualObjectCommands::known_virtual_objects() const {
  std::string names;
  const auto add = [&names](std::string_view id) {
    if (names.size() < 200) names += (names.empty() ? "" : ", ") + std::string(id);
  };
  for (const VirtualObject& virtual_object : simulator_.augmented().virtual_objects()) add(virtual_object.id);
  for (const VirtualFleet::Host& host : fleet_.hosts()) add(registry_[host.vehicle].id().serial_number);
  for (const RestoredAivs::Aiv& aiv : restored_.aivs()) add(aiv.serial);
  return names.empty() ? "there is none yet; add one first" : "there are " + names;
}

Result<void> VirtualObjectCommands::check_zone() const {
  if (simulator_.zone() != nullptr) return {};
  return fail("virtual_object.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
}

Result<VirtualObjectCommand> VirtualObjectCommands::read(const RemoveCommand& command) const {
  VirtualObjectCommand requested;
  requested.act = VirtualObjectCommand::Act::remove;
  requested.id = command.id;
  if (requested.id == "*" || simulator_.augmented().find(requested.id) != nullptr) return requested;
  if (in_use(requested.id)) {
    requested.is_aiv = true;
    return requested;
  }
  return fail("virtual_object.unknown",
              "no virtual object is called '" + cut(requested.id) + "'; " + known_virtual_objects(), "id");
}

Result<void> VirtualObjectCommands::check_id(std::string_view id) const {
  if (id.empty() || id.size() > id_bytes_max || !wire::valid_serial_number(id)) {
    return fail("virtual_object.id",
                "'" + cut(id) + "' is not a valid id; use 1 to 32 of A-Z a-z 0-9 _ . : - or leave it out", "id");
  }
  if (is_detected_id(id))
    return fail("virtual_object.id", "S1, S2 … are the ids of obstacles that vehicles detect; choose another id", "id");
  if (in_use(id)) {
    return fail("virtual_object.taken",
                "the id '" + cut(id) + "' is in use; choose another id, move that object, or remove it", "id");
  }
  return {};
}

Result<VirtualObjectCommand> VirtualObjectCommands::read(const AddCommand& command) const {
  if (auto zone = check_zone(); !zone) return tl::unexpected(zone.error());
  const VirtualObjectFields& virtual_object = command.object;
  VirtualObjectCommand requested;
  requested.act = VirtualObjectCommand::Act::add;
  const std::string& kind = virtual_object.kind;
  requested.is_aiv = kind == "aiv";
  const auto known = parse_virtual_object_kind(kind);
  if (!requested.is_aiv && !known) {
    return fail("virtual_object.kind", "there is no kind '" + cut(kind) + "'; add an aiv, a person or an obstacle",
                "kind");
  }
  if (virtual_object.id) {
    requested.id = *virtual_object.id;
    if (auto checked = check_id(requested.id); !checked) return tl::unexpected(checked.error());
  } else {
    requested.id = next_id(kind);
  }
  if (simulator_.augmented().virtual_objects().size() + fleet_.hosts().size() + restored_.aivs().size() >=
      Augmented::virtual_objects_max) {
    return fail("virtual_object.many",
                "there are " + std::to_string(Augmented::virtual_objects_max) +
                    " virtual objects already; remove one that is no longer needed, then try again");
  }
  if (requested.is_aiv && !fleet_.open())
    return fail(
        "virtual_object.negotiate",
        "the vehicles agree on crossings among themselves (--autonomy negotiate), in which a virtual AIV takes no "
        "part; add a person or an obstacle",
        "kind");
  if (requested.is_aiv) {
    const wire::VehicleId vehicle{std::string(wire::virtual_manufacturer), requested.id};
    if (!registry_.find(wire::to_string(vehicle)) && registry_.full() && !registry_.removable())
      return fail("virtual_object.many",
                  "this server knows " + std::to_string(registry_.vehicles_max()) +
                      " vehicles already and accepts no more; add it under a name that was used before");
    auto track_position = read_aiv_position(virtual_object);
    if (!track_position) return tl::unexpected(track_position.error());
    requested.position = *track_position;
    return requested;
  }
  requested.kind = *known;
  requested.radius_m = std::clamp(0.5 * simulator_.zone()->vehicle.width_m, radius_m_min, radius_m_max);
  if (auto read = read_number(virtual_object.radius_m, "radius", radius_m_min, radius_m_max, "", requested.radius_m);
      !read)
    return tl::unexpected(read.error());
  const Walk usual({Point2{}}, simulator_.zone()->profiles.slow.speed_mps, Repeat::once);
  auto walk = read_walk(virtual_object, requested.kind == VirtualObjectKind::person, usual);
  if (!walk) return tl::unexpected(walk.error());
  requested.walk = std::move(*walk);
  return requested;
}

Result<VirtualObjectCommand> VirtualObjectCommands::read(const MoveCommand& command) const {
  if (auto zone = check_zone(); !zone) return tl::unexpected(zone.error());
  const VirtualObjectFields& virtual_object = command.object;
  VirtualObjectCommand requested;
  requested.act = VirtualObjectCommand::Act::move;
  if (!virtual_object.id) return fail("virtual_object.id", "give the id of the virtual object to move", "id");
  requested.id = *virtual_object.id;
  if (find_aiv(requested.id) != nullptr || restored_.find(requested.id) != nullptr) {
    return fail("virtual_object.aiv", "a virtual AIV cannot be moved; remove it and add it at the new start", "id");
  }
  const VirtualObject* known = simulator_.augmented().find(requested.id);
  if (known == nullptr)
    return fail("virtual_object.unknown",
                "no virtual object is called '" + cut(requested.id) + "'; " + known_virtual_objects(), "id");
  requested.kind = known->kind;
  const double usual_mps =
      known->walk.speed_mps() > 0.0 ? known->walk.speed_mps() : simulator_.zone()->profiles.slow.speed_mps;
  auto walk = read_walk(virtual_object, requested.kind == VirtualObjectKind::person,
                        Walk({Point2{}}, usual_mps, known->walk.repeat()));
  if (!walk) return tl::unexpected(walk.error());
  requested.walk = std::move(*walk);
  return requested;
}

Result<Point2> VirtualObjectCommands::read_point(OptionalNumber x_m, OptionalNumber y_m, std::string_view field) const {
  if (!x_m || !y_m || !std::isfinite(*x_m) || !std::isfinite(*y_m))
    return fail("virtual_object.position", "give a position as two numbers, in metres on the map", std::string(field));
  const Point2 p{*x_m, *y_m};
  const zone::Bounds& on = simulator_.drawing().bounds;
  const bool inside = p.x_m >= on.low.x_m - off_zone_m && p.x_m <= on.high.x_m + off_zone_m &&
                      p.y_m >= on.low.y_m - off_zone_m && p.y_m <= on.high.y_m + off_zone_m;
  if (!inside) {
    return fail("virtual_object.position",
                at_text(p) + " is outside the zone, which reaches from " + at_text(on.low) + " to " + at_text(on.high) +
                    "; choose a position in the zone or at most 0.5 m outside",
                std::string(field));
  }
  return p;
}

Result<std::vector<Point2>> VirtualObjectCommands::read_path(const std::vector<std::optional<Point2>>& path) const {
  if (path.empty() || path.size() > Walk::points_max) {
    return fail("virtual_object.path", "give a path as 1 to 64 points, [[x,y],[x,y],…]", "path");
  }
  std::vector<Point2> read;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string where = "path[" + std::to_string(i) + "]";
    if (!path[i]) return fail("virtual_object.path", "give each point as [x,y]", where);
    const auto point = read_point(path[i]->x_m, path[i]->y_m, where);
    if (!point) return tl::unexpected(point.error());
    read.push_back(*point);
  }
  return read;
}

Result<Walk> VirtualObjectCommands::read_walk(const VirtualObjectFields& virtual_object, bool may_walk,
                                              const Walk& usual) const {
  const bool has_point = virtual_object.x_m.has_value() && virtual_object.y_m.has_value();
  if (!virtual_object.path) {
    auto on_path = read_section(virtual_object);
    if (!on_path) return tl::unexpected(on_path.error());
    if (*on_path) return Walk({position(simulator_.circuit()->pose_at(**on_path))}, 0.0, Repeat::once);
    if (!has_point) {
      return fail("virtual_object.position",
                  may_walk ? "give a position (x, y) or a path to walk (path)" : "give a position (x, y)");
    }
    const auto point = read_point(virtual_object.x_m, virtual_object.y_m, "x, y");
    if (!point) return tl::unexpected(point.error());
    return Walk({*point}, 0.0, Repeat::once);
  }
  if (!may_walk)
    return fail("virtual_object.path", "an obstacle does not move; give a position (x, y), or add a person", "path");
  if (virtual_object.x_m || virtual_object.y_m)
    return fail("virtual_object.position", "give either a position (x, y) or a path, not both", "path");
  auto points = read_path(*virtual_object.path);
  if (!points) return tl::unexpected(points.error());
  double speed_mps = usual.speed_mps();
  if (auto read = read_number(virtual_object.speed_mps, "speed", 0.0, speed_mps_max, "/s", speed_mps); !read)
    return tl::unexpected(read.error());
  Repeat repeat = usual.repeat();
  if (virtual_object.repeat) {
    const auto known = parse_repeat(*virtual_object.repeat);
    if (!known) return fail("virtual_object.repeat", "use once, back and forth, or loop", "repeat");
    repeat = *known;
  }
  return Walk(std::move(*points), speed_mps, repeat);
}

Result<std::optional<zone::TrackPosition>> VirtualObjectCommands::read_section(
    const VirtualObjectFields& virtual_object) const {
  if (!virtual_object.section) return std::optional<zone::TrackPosition>{};
  const zone::Circuit& circuit = *simulator_.circuit();
  const auto section = virtual_object.section_is_text ? circuit.find(*virtual_object.section) : std::nullopt;
  if (!section) {
    std::string names;
    for (zone::SectionId id = 0; id < circuit.size() && names.size() < 200; ++id)
      names += (names.empty() ? "" : ", ") + circuit.part(id).name;
    return fail("virtual_object.section", "this zone has no such section; it has " + names, "section");
  }
  zone::TrackPosition track_position{*section, 0.0};
  if (auto read = read_number(virtual_object.s_m, "s", 0.0, circuit.section(*section).length_m(), " along the section",
                              track_position.s_m);
      !read)
    return tl::unexpected(read.error());
  return std::optional{track_position};
}

Result<zone::TrackPosition> VirtualObjectCommands::read_aiv_position(const VirtualObjectFields& virtual_object) const {
  auto named = read_section(virtual_object);
  if (!named) return tl::unexpected(named.error());
  zone::TrackPosition track_position;
  if (*named) {
    track_position = **named;
  } else if (!virtual_object.x_m && !virtual_object.y_m) {
    const auto free = roomiest();
    if (!free)
      return fail("virtual_object.room", "no section has room for another vehicle; remove one, then try again");
    return *free;
  } else {
    const auto point = read_point(virtual_object.x_m, virtual_object.y_m, "x, y");
    if (!point) return tl::unexpected(point.error());
    const auto located = simulator_.circuit()->locate(*point);
    if (located.distance_m > off_circuit_m) {
      return fail("virtual_object.off", at_text(*point) + " is " + metres(located.distance_m) +
                                            " from the circuit; a virtual AIV must be added within " +
                                            metres(off_circuit_m) + " of a section");
    }
    track_position = located.position;
  }
  if (auto checked = check_position(track_position); !checked) return tl::unexpected(checked.error());
  return track_position;
}

std::vector<VirtualObjectCommands::NearbyVehicle> VirtualObjectCommands::nearby_vehicles() const {
  std::vector<NearbyVehicle> all;
  for (VehicleIndex v = 0; v < registry_.size(); ++v) {
    const AivProxy& proxy = registry_[v];
    if (const VirtualFleet::Host* host = fleet_.find(v)) {
      all.push_back(
          {proxy.name(), position(host->aiv.X_MB()), VirtualFleet::position_of(*host, *simulator_.circuit())});
    } else if (proxy.here()) {
      const Twin::Image image = simulator_.image(*proxy.twin(), publisher_.now());
      all.push_back({proxy.name(), position(image.X_MB), image.position});
    }
  }
  return all;
}

bool VirtualObjectCommands::has_room(zone::TrackPosition track_position, Point2 at, const NearbyVehicle& other) const {
  const zone::TrafficZone& zone = *simulator_.zone();
  const double room_m = zone::stopping_room_m(zone.vehicle);
  const double apart_m = distance(at, other.at);
  if (apart_m >= room_m) return true;
  // Between tracks that do not follow each other, only the bodies count.
  return other.position && apart_m > norm(zone.vehicle.length_m, zone.vehicle.width_m) &&
         !zone.circuit.distance_ahead(track_position, *other.position, room_m) &&
         !zone.circuit.distance_ahead(*other.position, track_position, room_m);
}

bool VirtualObjectCommands::has_room(zone::TrackPosition track_position) const {
  const Point2 at = position(simulator_.circuit()->pose_at(track_position));
  return std::ranges::all_of(nearby_vehicles(),
                             [&](const NearbyVehicle& other) { return has_room(track_position, at, other); });
}

Result<void> VirtualObjectCommands::check_position(zone::TrackPosition track_position) const {
  const zone::TrafficZone& zone = *simulator_.zone();
  const Point2 at = position(zone.circuit.pose_at(track_position));
  if (!zone.may_stop(track_position)) {
    const zone::Crossing* crossing = zone.crossing_at(track_position);
    return fail("virtual_object.crossing",
                "no vehicle may stop " +
                    (crossing == nullptr ? std::string("between crossings this close together")
                                         : "in crossing " + crossing->name) +
                    "; choose a position before or behind it");
  }
  for (const NearbyVehicle& other : nearby_vehicles()) {
    if (has_room(track_position, at, other)) continue;
    return fail("virtual_object.room", other.name + " is only " + metres(distance(at, other.at)) + " away; leave " +
                                           metres(zone::stopping_room_m(zone.vehicle)) + " between two vehicles");
  }
  return {};
}

std::optional<zone::TrackPosition> VirtualObjectCommands::roomiest() const {
  const zone::TrafficZone& zone = *simulator_.zone();
  const auto others = nearby_vehicles();
  const double step_m = std::max(0.05, zone.circuit.total_length_m() / 5'000.0);
  std::optional<zone::TrackPosition> best;
  double best_m = 0.0;
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    for (double i = 0.0; i * step_m < zone.circuit.section(id).length_m(); i += 1.0) {
      const zone::TrackPosition track_position{id, i * step_m};
      const Point2 at = position(zone.circuit.pose_at(track_position));
      double room_m = 1e9;
      bool fits = true;
      for (const NearbyVehicle& other : others) {
        room_m = std::min(room_m, distance(at, other.at));
        fits = fits && has_room(track_position, at, other);
      }
      for (const VirtualObject& virtual_object : simulator_.augmented().virtual_objects())
        room_m = std::min(room_m, distance(at, virtual_object.walk.path().front()) - virtual_object.radius_m);
      for (const DetectedObstacle& detected : simulator_.detected().obstacles())
        room_m = std::min(room_m, distance(at, detected.at) - detected.radius_m);
      if (!fits || (best && room_m <= best_m) || !zone.may_stop(track_position)) continue;
      best = track_position;
      best_m = room_m;
    }
  }
  return best;
}

}  // namespace cosiva::virtual_side
