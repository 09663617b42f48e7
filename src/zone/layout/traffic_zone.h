#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/circuit/listed.h"

namespace cosiva::zone {

using TagNumber = std::uint32_t;
inline constexpr TagNumber tag_number_max = 4'000'000'000;

/// An RFID tag under a section (A11, A15).
struct Tag {
  TagNumber number;
  TrackPosition position;
};

/// Beacons in a matrix over the zone, independent of the circuit (A21). Beacon (i, j) is at origin + (i·pitch,
/// j·pitch), and is read as tag number first_number + j·columns + i.
struct BeaconGrid {
  double pitch_m;
  Point2 origin;
  std::uint32_t columns;
  std::uint32_t rows;
  TagNumber first_number{1'000'000};
  /// Given: the grid passes through this point and has as many beacons as necessary to cover every section, so that
  /// another pitch makes another number of them.
  std::optional<Point2> covers_through{};
  /// The matrix is turned by this angle about its origin, left positive: column i, row j is at origin + pitch·(i·(cos,
  /// sin) + j·(−sin, cos)).
  double rotation_rad{0.0};

  [[nodiscard]] Point2 at(std::uint32_t column, std::uint32_t row) const;
  [[nodiscard]] std::optional<Point2> find(TagNumber number) const;
  /// The beacon nearest to p and its number; nothing further than half a pitch beyond the edge.
  struct Near {
    TagNumber number;
    Point2 position;
  };
  [[nodiscard]] std::optional<Near> nearest(Point2 p) const;
};

enum class StationKind { stop, charger };
struct Station {
  std::string name;
  TrackPosition position;
  StationKind kind{StationKind::stop};
};

/// A named loop: each section follows the one before it, the first the last.
struct Loop {
  std::string name;
  std::vector<SectionId> sections;
};

/// A diagnostic of a reader about its file, without refusal.
struct Diagnostic {
  enum class Kind {
    mended,  ///< the file broke its format's rules; the text states the interpretation
    lost,    ///< data that a zone cannot express, or that is not read from this format
    notice,  ///< worth knowing, such as the worst error of a fit
  };
  Kind kind;
  std::string location;  ///< in the file: "road 12", "layouts[0].edges[3].trajectory"
  std::string text;      ///< a sentence
};
[[nodiscard]] std::string_view to_string(Diagnostic::Kind kind);

/// The body that crossings and gaps are computed for. The body frame's origin is its centre.
struct VehicleShape {
  double length_m{0.20};
  double width_m{0.12};
};

/// One of the three profiles that fix the kinematics (A12).
struct SpeedProfile {
  double speed_mps;
  double acceleration_mps2;
  double braking_mps2;
};
struct SpeedProfiles {
  SpeedProfile slow;
  SpeedProfile medium;
  SpeedProfile fast;
};

/// An area where sections meet: while a vehicle's body origin is in one span, a vehicle in another span may touch it.
struct CrossingSpan {
  SectionId section;
  double from_m;
  double to_m;
};
struct Crossing {
  std::string name;
  Point2 centre;
  std::vector<CrossingSpan> spans;
};

/// A node of the VDA 5050 graph: a position where an order may start, turn, or end. None lies inside a crossing except
/// those that the zone's format or its stations put there: a vehicle goes to such a node only as a destination.
struct Waypoint {
  std::string id;  ///< several may have one in common where sections part or meet: the same point, on several sections
  TrackPosition position;
};

/// The keys of tags, waypoints and crossings: their numbers, their ids, the begin of their spans.
struct TagKeys {
  static std::size_t count(const Tag&) { return 1; }
  static TagNumber key(const Tag& tag, std::size_t) { return tag.number; }
};
struct WaypointKeys {
  static std::size_t count(const Waypoint&) { return 1; }
  static std::string_view key(const Waypoint& waypoint, std::size_t) { return waypoint.id; }
};
struct CrossingKeys {
  static std::size_t count(const Crossing& crossing) { return crossing.spans.size(); }
  static std::pair<SectionId, double> key(const Crossing& crossing, std::size_t i) {
    return {crossing.spans[i].section, crossing.spans[i].from_m};
  }
};

/// The priority of an AIV at a crossing: 0…999, higher goes first.
inline constexpr std::int32_t priority_max = 999;

/// All data of the traffic zone. A value: built once, then only read.
struct TrafficZone {
  std::string name;
  Circuit circuit;
  VehicleShape vehicle;
  SpeedProfiles profiles;
  Listed<Tag, TagKeys> tags;
  std::optional<BeaconGrid> beacons;
  std::vector<Station> stations;
  Listed<Crossing, CrossingKeys> crossings;  ///< found by find_crossings
  Listed<Waypoint, WaypointKeys> waypoints;  ///< laid by lay_waypoints; sorted by (section, s)
  std::vector<TrackPosition>
      starts;  ///< where vehicle 1, 2, … of an emulated fleet begin; may be shorter than the fleet
  /// "CoSiVA/AIV1" → 1…999, sorted by name; a vehicle without an entry has 0.
  std::vector<std::pair<std::string, std::int32_t>> priorities{};
  std::vector<Loop> loops{};        ///< the first is where idle vehicles circulate; none: along default successors
  std::vector<SectionId> closed{};  ///< closed from the beginning; sorted
  std::vector<Diagnostic> diagnostics{};
  /// The format names its edges: a stretch that is one whole section has that section's name as its edge's id.
  bool edges_are_sections{false};
  /// The rules for crossings and waypoints, for the writers of the zone.
  double clearance_m{0.04};
  double spacing_m{0.30};
  bool nodes_only{false};

  /// Of "manufacturer/serial"; 0 where none is given.
  [[nodiscard]] std::int32_t priority_of(std::string_view vehicle_name) const;
  [[nodiscard]] const Tag* find_tag(TagNumber number) const;
  /// The first of this id.
  [[nodiscard]] const Waypoint* find_waypoint(std::string_view id) const;
  /// Indices of all of this id, ascending.
  [[nodiscard]] std::vector<std::size_t> find_waypoints(std::string_view id) const;
  [[nodiscard]] const Station* find_station(std::string_view name) const;
  [[nodiscard]] const Loop* find_loop(std::string_view name) const;
  /// The crossing that has a span over this position, if any; the first of several.
  [[nodiscard]] const Crossing* crossing_at(TrackPosition track_position) const;

  /// Index of the first waypoint at or after `place`, following default successors from its section; waypoints.size()
  /// where the path ends first. Likewise for the next two functions.
  [[nodiscard]] std::size_t waypoint_ahead(TrackPosition track_position) const;
  /// Index of the last waypoint at or before `place` (following `previous` backwards).
  [[nodiscard]] std::size_t waypoint_behind(TrackPosition track_position) const;
  /// The waypoint that follows waypoints[index] along default successors.
  [[nodiscard]] std::size_t next_waypoint(std::size_t index) const;
  /// Whether a vehicle may stop here: outside every crossing, and not between two too close together to stop between.
  [[nodiscard]] bool may_stop(TrackPosition track_position) const;
  /// Positions for `count` vehicles: `starts` first, then spread evenly; all where a vehicle may stop, and with room
  /// between them. Where that does not suffice, waypoints inside crossings serve, in each crossing one vehicle. Fewer
  /// than `count` when the zone cannot hold them.
  [[nodiscard]] std::vector<TrackPosition> start_positions(std::size_t count) const;
};

/// X_MB of a body whose travel frame, with the x axis in the direction of travel, has the pose X_MT; and the inverse.
[[nodiscard]] inline Pose2 body_pose(const TrafficZone& zone, const Pose2& X_MT) {
  return zone.circuit.indirect() ? turned_round(X_MT) : X_MT;
}
[[nodiscard]] inline Pose2 travel_pose(const TrafficZone& zone, const Pose2& X_MB) { return body_pose(zone, X_MB); }

/// The length of path that a stopped vehicle occupies: its length and 0.1 m.
[[nodiscard]] constexpr double stopping_room_m(const VehicleShape& shape) { return shape.length_m + 0.1; }

}  // namespace cosiva::zone
