// Writes a zone in the form that its readers require, so that they read the same zone, to the last bit.
#include "cosiva/zone/toml/toml_write.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_fields.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::zone {
namespace {

/// A decimal near `guess` that `read` converts to `wanted`: rounding costs at most a few last digits.
template <typename Read>
std::optional<double> reads_as(double wanted, double guess, const Read& read) {
  double above = guess;
  double below = guess;
  for (int i = 0; i < 4; ++i) {
    if (read(above) == wanted) return above;
    if (read(below) == wanted) return below;
    above = std::nextafter(above, std::numeric_limits<double>::infinity());
    below = std::nextafter(below, -std::numeric_limits<double>::infinity());
  }
  return std::nullopt;
}

/// "heading_deg = 90", or in radians where no number of degrees is the very same angle.
std::string angle_text(std::string_view key, double angle_rad) {
  const auto wrapped = [](double deg) { return wrap_angle(deg * rad_per_deg); };
  // 90 rather than 90.00000000000001, where both do.
  const double round_deg = std::nearbyint(angle_rad / rad_per_deg * 1e6) / 1e6;
  const auto degrees =
      wrapped(round_deg) == angle_rad ? round_deg : reads_as(angle_rad, angle_rad / rad_per_deg, wrapped);
  if (degrees) return std::string(key) + "_deg = " + toml_number(*degrees);
  return std::string(key) + "_rad = " + toml_number(angle_rad);
}

std::string pose_text(const Pose2& pose) {
  return "{ x = " + toml_number(pose.x_m) + ", y = " + toml_number(pose.y_m) + ", " +
         angle_text("heading", pose.heading_rad) + " }";
}

class Writer {
 public:
  explicit Writer(const TrafficZone& zone) : zone_{zone} {}

  [[nodiscard]] std::string take() { return std::move(out_); }

  void head() {
    line("name", toml_quoted(zone_.name));
    line("format_version", "1");
  }

  void basics() {
    table("vehicle");
    number("length_m", zone_.vehicle.length_m);
    number("width_m", zone_.vehicle.width_m);
    profile("slow", zone_.profiles.slow);
    profile("medium", zone_.profiles.medium);
    profile("fast", zone_.profiles.fast);
    table("crossings");
    number("clearance_m", zone_.clearance_m);
    table("waypoints");
    number("spacing_m", zone_.spacing_m);
    if (zone_.nodes_only) line("nodes_only", "true");
    if (zone_.edges_are_sections) line("edges_are_sections", "true");
  }

  void sections();

  void limits() {
    for (SectionId id = 0; id < zone_.circuit.size(); ++id) {
      const Circuit::Part& part = zone_.circuit.part(id);
      if (!part.speed_mps_max) continue;
      entry("limit");
      line("section", toml_quoted(part.name));
      number("speed_mps_max", *part.speed_mps_max);
    }
  }

  void beacons() {
    if (!zone_.beacons) return;
    const BeaconGrid& grid = *zone_.beacons;
    const Point2 origin = grid.covers_through.value_or(grid.origin);
    table("beacons");
    number("pitch_m", grid.pitch_m);
    line("origin", "[" + toml_number(origin.x_m) + ", " + toml_number(origin.y_m) + "]");
    rotation(grid.rotation_rad);
    if (grid.covers_through) {
      line("cover", "\"zone\"");
    } else {
      line("columns", std::to_string(grid.columns));
      line("rows", std::to_string(grid.rows));
    }
    line("first_number", std::to_string(grid.first_number));
  }

  void tags() {
    for (const Tag& tag : zone_.tags) {
      entry("tag");
      line("number", std::to_string(tag.number));
      write_position(tag.position);
    }
  }

  void stations() {
    for (const Station& station : zone_.stations) {
      entry("station");
      line("name", toml_quoted(station.name));
      if (station.kind == StationKind::charger) line("kind", "\"charger\"");
      write_position(station.position);
    }
  }

  void starts() {
    for (const TrackPosition& start : zone_.starts) {
      entry("start");
      write_position(start);
    }
  }

  void loops() {
    for (const Loop& loop : zone_.loops) {
      entry("loop");
      line("name", toml_quoted(loop.name));
      line("sections", names(loop.sections));
    }
  }

  void closed() {
    if (zone_.closed.empty()) return;
    table("closed");
    line("sections", names(zone_.closed));
  }

  void priorities() {
    if (zone_.priorities.empty()) return;
    table("priorities");
    for (const auto& [vehicle, priority] : zone_.priorities) line(toml_quoted(vehicle), std::to_string(priority));
  }

 private:
  void table(std::string_view name) { out_.append(out_.empty() ? "[" : "\n[").append(name).append("]\n"); }
  void entry(std::string_view name) { out_.append(out_.empty() ? "[[" : "\n[[").append(name).append("]]\n"); }
  void line(std::string_view key, std::string_view value) { out_.append(key).append(" = ").append(value).append("\n"); }
  void number(std::string_view key, double value) { line(key, toml_number(value)); }

  void profile(const std::string& name, const SpeedProfile& profile) {
    table("profiles." + name);
    number("speed_mps", profile.speed_mps);
    number("acceleration_mps2", profile.acceleration_mps2);
    number("braking_mps2", profile.braking_mps2);
  }

  void write_position(const TrackPosition& position) {
    line("section", toml_quoted(zone_.circuit.part(position.section).name));
    number("s_m", position.s_m);
  }

  void rotation(double rotation_rad) {
    if (rotation_rad == 0.0) return;
    const auto degrees =
        reads_as(rotation_rad, rotation_rad / rad_per_deg, [](double deg) { return deg * rad_per_deg; });
    number(degrees ? "rotation_deg" : "rotation_rad", degrees.value_or(rotation_rad));
  }

  [[nodiscard]] std::string names(std::span<const SectionId> sections) const {
    std::string text = "[";
    for (const SectionId id : sections)
      text.append(text.size() > 1 ? ", " : "").append(toml_quoted(zone_.circuit.part(id).name));
    return text + "]";
  }

  void shape(const Section& section);
  void waypoint_ids(SectionId id);

  const TrafficZone& zone_;
  std::string out_;
};

void Writer::sections() {
  const Circuit& circuit = zone_.circuit;
  Pose2 follows;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const Circuit::Part& part = circuit.part(id);
    entry("section");
    line("name", toml_quoted(part.name));
    if (part.section.start() != follows) line("start", pose_text(part.section.start()));
    follows = part.section.end();
    shape(part.section);
    if (part.speed_mps_max) number("speed_mps_max", *part.speed_mps_max);
    if (part.pivots) line("pivots", "true");
    waypoint_ids(id);
    // The next section in the file follows by default, and nothing follows the last.
    const bool as_read = id + 1 < circuit.size() ? part.next == std::vector<SectionId>{id + 1} : part.next.empty();
    if (!as_read) line("next", names(part.next));
  }
}

void Writer::shape(const Section& section) {
  const double length_m = section.length_m();
  const double curvature_per_m = section.curvature_at(0.0);
  const double rate_per_m2 = section.curvature_rate_per_m2();
  line("kind", "\"" + std::string(kind_name(section)) + "\"");
  if (section.shape()) {
    for (const auto& [key, value] : section.shape()->fields()) number(key, value);
    return;
  }
  if (section.kind() == SectionKind::arc) {
    // In the usual form, where that is the very same arc.
    const double side = curvature_per_m < 0.0 ? -1.0 : 1.0;
    const auto radius_m = reads_as(curvature_per_m, side / curvature_per_m, [&](double r) { return side / r; });
    const double guess_deg = radius_m ? length_m / *radius_m / rad_per_deg : 0.0;
    const auto length_of = [&](double deg) { return *radius_m * (deg * rad_per_deg); };
    const double round_deg = std::nearbyint(guess_deg * 1e6) / 1e6;
    const auto angle_deg = !radius_m                          ? std::nullopt
                           : length_of(round_deg) == length_m ? std::optional{round_deg}
                                                              : reads_as(length_m, guess_deg, length_of);
    if (angle_deg && *angle_deg <= 572957.0 && *radius_m <= 1e5) {
      number("radius_m", *radius_m);
      return number("angle_deg", side * *angle_deg);
    }
  }
  number("length_m", length_m);
  if (section.kind() == SectionKind::arc) number("curvature_per_m", curvature_per_m);
  if (section.kind() != SectionKind::clothoid) return;
  number("curvature_start_per_m", curvature_per_m);
  const auto end =
      reads_as(rate_per_m2, section.curvature_at(length_m), [&](double k) { return (k - curvature_per_m) / length_m; });
  number(end ? "curvature_end_per_m" : "curvature_rate_per_m2", end.value_or(rate_per_m2));
}

void Writer::waypoint_ids(SectionId id) {
  // Generated ids contain their position; any other is the format's, and must be written.
  const std::string& name = zone_.circuit.part(id).name;
  const double length_m = zone_.circuit.section(id).length_m();
  const auto [first, last] =
      std::equal_range(zone_.waypoints.begin(), zone_.waypoints.end(), Waypoint{{}, {id, 0.0}},
                       [](const Waypoint& a, const Waypoint& b) { return a.position.section < b.position.section; });
  for (auto at = first; at != last; ++at) {
    const bool at_start = at->position.s_m == 0.0;
    const bool at_end = at->position.s_m == length_m;
    if ((at_start || at_end) && !at->id.starts_with(name + "@"))
      line(at_start ? "start_node" : "end_node", toml_quoted(at->id));
  }
}

/// The first value that cannot be written.
std::optional<Error> unwritable(const TrafficZone& zone) {
  std::vector<std::string_view> names{zone.name};
  for (SectionId id = 0; id < zone.circuit.size(); ++id) names.push_back(zone.circuit.part(id).name);
  for (const Station& station : zone.stations) names.push_back(station.name);
  for (const Loop& loop : zone.loops) names.push_back(loop.name);
  for (const Waypoint& waypoint : zone.waypoints) names.push_back(waypoint.id);
  const auto bad = std::find_if(names.begin(), names.end(), [](std::string_view name) { return !is_toml_name(name); });
  if (bad == names.end()) return std::nullopt;
  return Error{"zone.write", "a name must have 1 to 256 bytes without control characters; this one has not",
               std::string(bad->substr(0, 64))};
}

}  // namespace

Result<std::string> native_text(const TrafficZone& zone) {
  if (auto error = unwritable(zone)) return tl::unexpected(std::move(*error));
  Writer writer{zone};
  writer.head();
  writer.basics();
  writer.sections();
  writer.beacons();
  writer.tags();
  writer.stations();
  writer.starts();
  writer.loops();
  writer.closed();
  writer.priorities();
  return writer.take();
}

std::string sidecar_text(const TrafficZone& zone, SidecarParts parts) {
  Writer writer{zone};
  writer.basics();
  if (parts.limits) writer.limits();
  writer.beacons();
  writer.tags();
  if (parts.stations) writer.stations();
  writer.starts();
  writer.loops();
  if (parts.closed) writer.closed();
  writer.priorities();
  return writer.take();
}

}  // namespace cosiva::zone
