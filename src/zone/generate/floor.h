#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The least distance between two nodes at which vehicles may turn on the spot at the same time.
[[nodiscard]] double node_room_m(const VehicleShape& vehicle);

/// Nodes joined by tracks, and the text of their zone. At a node vehicles turn on the spot onto every track that leaves
/// the node: straight on by default, back as the last choice. A node is one waypoint id, and orders may lead from node
/// to node. A track with room for it has nodes between its ends, where vehicles wait and turn back.
///
/// Invariant: every track joins two different nodes; a node has at most one start.
class Floor {
 public:
  using Node = std::size_t;
  enum class Directions : std::uint8_t { one, both };

  explicit Floor(const VehicleShape& vehicle) : vehicle_{vehicle} {}

  /// @param id  of the node's waypoints; none occurs twice
  Node add_node(std::string id, Point2 at);
  /// @param turn_rad  by which the track bends to the left, as one arc; 0: straight
  void add_track(Node from, Node to, Directions directions, double turn_rad = 0.0);
  /// A dead end of one vehicle's depth, with a station of this name at its end, driven both ways.
  Node add_bay(Node from, std::string name, double heading_rad, bool charger = false);
  void add_station(Node node, std::string name, bool charger = false);
  /// A start of an emulated vehicle. False: the node has one, or another vehicle starts on each of its tracks.
  bool add_start(Node node);

  /// The number of sections of a track of this length.
  [[nodiscard]] std::size_t parts_of(double length_m) const;
  /// The zone's file.
  /// @param comment  its first lines, each with a # at its beginning
  [[nodiscard]] std::string text(std::string_view name, std::string_view comment) const;

 private:
  struct Section {
    Node from;
    Node to;
    Pose2 start;
    double end_heading_rad;
    double length_m;
    double curvature_per_m;
    std::size_t track;  ///< the same in both directions
    bool bay;
  };
  struct Junction {
    std::string id;
    Point2 at;
    std::vector<std::size_t> leaving{};  ///< sections
    bool started{false};
  };
  struct Stop {
    std::string name;
    Node node;
    bool charger;
  };

  void add_part(Node from, Node to, Directions directions, double turn_rad, bool bay);
  void add_section(Section section);
  [[nodiscard]] std::string name_of(const Section& section) const;
  [[nodiscard]] std::vector<std::size_t> successors(const Section& section) const;
  void write_section(std::string& out, const Section& section) const;

  VehicleShape vehicle_;
  std::vector<Junction> nodes_;
  std::vector<Section> sections_;
  std::vector<Stop> stops_;
  std::vector<std::size_t> starts_;  ///< sections at whose beginning vehicles start
  std::vector<bool> track_started_;
};

}  // namespace cosiva::zone
