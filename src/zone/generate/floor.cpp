#include "cosiva/zone/generate/floor.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/generate/generated_text.h"

namespace cosiva::zone {
namespace {

constexpr double deg_per_rad = 180.0 / pi;
constexpr double straight_on_rad = 1e-3;  // a smaller turn is none: the limit of a joint
constexpr double fast_mps = 1.5;          // as in the head of generated zones

double half_diagonal_m(const VehicleShape& vehicle) { return 0.5 * norm(vehicle.length_m, vehicle.width_m); }

Point2 beyond(Point2 from, double heading_rad, double distance_m) {
  const SinCos direction = sincos(heading_rad);
  return {from.x_m + distance_m * direction.cos, from.y_m + distance_m * direction.sin};
}

}  // namespace

double node_room_m(const VehicleShape& vehicle) { return 2.0 * half_diagonal_m(vehicle) + generated_clearance_m; }

Floor::Node Floor::add_node(std::string id, Point2 at) {
  nodes_.push_back({std::move(id), {rounded(at.x_m), rounded(at.y_m)}});
  return nodes_.size() - 1;
}

// Twice the room: a node between two others is where a vehicle lets another one pass at either of them, and closer
// nodes would only divide the track into more steps.
std::size_t Floor::parts_of(double length_m) const {
  return static_cast<std::size_t>(std::max(1.0, std::floor(length_m / (2.0 * node_room_m(vehicle_)))));
}

void Floor::add_track(Node from, Node to, Directions directions, double turn_rad) {
  COSIVA_EXPECT(from < nodes_.size() && to < nodes_.size() && from != to);
  const Point2 start = nodes_[from].at;
  const Point2 end = nodes_[to].at;
  const double chord_m = distance(start, end);
  const double chord_rad = det_atan2(end.y_m - start.y_m, end.x_m - start.x_m);
  const double length_m = turn_rad == 0.0 ? chord_m : chord_m * 0.5 * turn_rad / det_sin(0.5 * turn_rad);
  const auto parts = static_cast<double>(parts_of(length_m));
  Node last = from;
  for (double part = 1.0; part < parts; part += 1.0) {
    // A part of an arc is an arc: its chord leads half of its turn to the left of its beginning.
    const double done_rad = turn_rad * part / parts;
    const double done_m =
        turn_rad == 0.0 ? chord_m * part / parts : chord_m * det_sin(0.5 * done_rad) / det_sin(0.5 * turn_rad);
    const Point2 at = beyond(start, chord_rad - 0.5 * turn_rad + 0.5 * done_rad, done_m);
    const Node between =
        add_node(nodes_[from].id + "." + nodes_[to].id + "." + std::to_string(static_cast<int>(part)), at);
    add_part(last, between, directions, turn_rad / parts, false);
    last = between;
  }
  add_part(last, to, directions, turn_rad / parts, false);
}

Floor::Node Floor::add_bay(Node from, std::string name, double heading_rad, bool charger) {
  COSIVA_EXPECT(from < nodes_.size());
  // In whole centimetres.
  const double depth_m = std::ceil(100.0 * node_room_m(vehicle_)) / 100.0;
  const Node end = add_node(name, beyond(nodes_[from].at, heading_rad, depth_m));
  add_part(from, end, Directions::both, 0.0, true);
  add_station(end, std::move(name), charger);
  return end;
}

void Floor::add_station(Node node, std::string name, bool charger) {
  COSIVA_EXPECT(node < nodes_.size());
  stops_.push_back({std::move(name), node, charger});
}

bool Floor::add_start(Node node) {
  COSIVA_EXPECT(node < nodes_.size());
  Junction& junction = nodes_[node];
  if (junction.started) return false;
  // From the last: of a node's tracks those that were laid from there come last, so that neighbours rarely use one.
  for (auto section = junction.leaving.rbegin(); section != junction.leaving.rend(); ++section) {
    if (sections_[*section].bay || track_started_[sections_[*section].track]) continue;
    track_started_[sections_[*section].track] = true;
    junction.started = true;
    starts_.push_back(*section);
    return true;
  }
  return false;
}

void Floor::add_part(Node from, Node to, Directions directions, double turn_rad, bool bay) {
  const Point2 start = nodes_[from].at;
  const Point2 end = nodes_[to].at;
  const double chord_m = distance(start, end);
  const double chord_rad = det_atan2(end.y_m - start.y_m, end.x_m - start.x_m);
  const double length_m = turn_rad == 0.0 ? chord_m : chord_m * 0.5 * turn_rad / det_sin(0.5 * turn_rad);
  const double from_rad = wrap_angle(chord_rad - 0.5 * turn_rad);
  const double to_rad = wrap_angle(chord_rad + 0.5 * turn_rad);
  const std::size_t track = track_started_.size();
  track_started_.push_back(false);
  add_section({from, to, {start.x_m, start.y_m, from_rad}, to_rad, length_m, turn_rad / length_m, track, bay});
  if (directions == Directions::one) return;
  const Pose2 back{end.x_m, end.y_m, wrap_angle(to_rad + pi)};
  add_section({to, from, back, wrap_angle(from_rad + pi), length_m, -turn_rad / length_m, track, bay});
}

void Floor::add_section(Section section) {
  nodes_[section.from].leaving.push_back(sections_.size());
  sections_.push_back(section);
}

std::string Floor::name_of(const Section& section) const {
  return nodes_[section.from].id + "-" + nodes_[section.to].id;
}

/// The straightest first, and back on the same track last: the order in which a LIF reader has them, too.
std::vector<std::size_t> Floor::successors(const Section& section) const {
  std::vector<std::size_t> next = nodes_[section.to].leaving;
  const auto order = [&](std::size_t id) {
    const Section& after = sections_[id];
    const double turn_rad = std::fabs(wrap_angle(after.start.heading_rad - section.end_heading_rad));
    return std::tuple{after.track == section.track, rounded(turn_rad), id};
  };
  std::ranges::sort(next, {}, order);
  return next;
}

void Floor::write_section(std::string& out, const Section& section) const {
  out.append("\n[[section]]\nname = \"").append(name_of(section));
  out.append(section.curvature_per_m == 0.0 ? "\"\nkind = \"straight\"" : "\"\nkind = \"arc\"");
  out.append("\nlength_m = ").append(text_of(section.length_m)).append("\n");
  if (section.curvature_per_m != 0.0) {
    out.append("curvature_per_m = ").append(text_of(section.curvature_per_m)).append("\n");
    const double borne_mps = std::sqrt(CheckLimits{}.lateral_mps2 / std::fabs(section.curvature_per_m));
    if (borne_mps < fast_mps)
      out.append("speed_mps_max = ").append(text_of(std::floor(100.0 * borne_mps) / 100.0)).append("\n");
  }
  out.append("start = { x = ").append(text_of(section.start.x_m)).append(", y = ").append(text_of(section.start.y_m));
  out.append(", heading_deg = ").append(text_of(section.start.heading_rad * deg_per_rad)).append(" }\n");
  out.append("start_node = \"").append(nodes_[section.from].id).append("\"\n");
  const auto next = successors(section);
  const bool turns = std::ranges::any_of(next, [&](std::size_t id) {
    return std::fabs(wrap_angle(sections_[id].start.heading_rad - section.end_heading_rad)) > straight_on_rad;
  });
  if (turns) out.append("pivots = true\n");
  out.append("next = [");
  for (std::size_t i = 0; i < next.size(); ++i)
    out.append(i == 0 ? "\"" : ", \"").append(name_of(sections_[next[i]])).append("\"");
  out.append("]\n");
}

std::string Floor::text(std::string_view name, std::string_view comment) const {
  std::string out{comment};
  out.reserve(400 * sections_.size());
  write_head(out, name, vehicle_);
  out.append("# Vehicles are granted from node to node.\n[waypoints]\nnodes_only = true\nedges_are_sections = true\n");
  for (const Section& section : sections_) write_section(out, section);

  // Of a track's two directions each has tags of its own, apart from those of the other one, which are read as well.
  const double pitch_m = 0.8 * CheckLimits{}.unread_max_m;
  std::size_t number = 0;
  for (const Section& section : sections_) {
    const double tags = std::ceil(section.length_m / pitch_m);
    for (double i = 0.4; i < tags; i += 1.0) {
      out.append("\n[[tag]]\nnumber = ").append(std::to_string(++number)).append("\nsection = \"");
      out.append(name_of(section)).append("\"\ns_m = ").append(text_of(i * section.length_m / tags)).append("\n");
    }
  }
  for (const Stop& stop : stops_) {
    COSIVA_EXPECT(!nodes_[stop.node].leaving.empty());
    out.append("\n[[station]]\nname = \"").append(stop.name);
    out.append(stop.charger ? "\"\nkind = \"charger\"\n" : "\"\nkind = \"stop\"\n");
    out.append("section = \"").append(name_of(sections_[nodes_[stop.node].leaving.front()])).append("\"\ns_m = 0\n");
  }
  for (const std::size_t section : starts_)
    out.append("\n[[start]]\nsection = \"").append(name_of(sections_[section])).append("\"\ns_m = 0\n");
  return out;
}

}  // namespace cosiva::zone
