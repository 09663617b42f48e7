#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/pose.h"

/// The content of a road network file, as plain values: in its own units (metres of the file, before any scale), in its
/// own terms, checked number by number, not yet as a whole.
namespace cosiva::zone::opendrive {

/// a + b·ds + c·ds² + d·ds³ from s on.
struct Polynomial {
  double s{};
  double a{};
  double b{};
  double c{};
  double d{};

  [[nodiscard]] double at(double ds) const { return a + ds * (b + ds * (c + ds * d)); }
  [[nodiscard]] double slope_at(double ds) const { return b + ds * (2.0 * c + ds * 3.0 * d); }
  [[nodiscard]] double bend_at(double ds) const { return 2.0 * c + 6.0 * d * ds; }
};
/// The same cubic from another s on.
[[nodiscard]] inline Polynomial moved(const Polynomial& polynomial, double to_s) {
  const double ds = to_s - polynomial.s;
  return {to_s, polynomial.at(ds), polynomial.slope_at(ds), 0.5 * polynomial.bend_at(ds), polynomial.d};
}

struct Clothoid {  ///< a line, an arc, a spiral
  double curvature_start{};
  double curvature_end{};
};
/// Both coordinates as cubics of p, in the frame of the record's start. poly3 is u = p.
struct Cubics {
  Polynomial u;
  Polynomial v;
  enum class Range { arc_length, normalized, along_u } range{Range::normalized};
};

struct Geometry {
  double s{};
  Pose2 start;
  double length{};
  std::variant<Clothoid, Cubics> shape;
  std::string location;
};

struct SpeedFrom {
  double s{};
  std::optional<double> mps{};  ///< nothing: no limit from here on
};

struct Lane {
  int id{};
  std::string type;
  bool reversed{false};  ///< driven against the direction given by its side and the road's rule
  std::vector<Polynomial> widths{};
  std::vector<Polynomial> borders{};
  std::vector<SpeedFrom> speeds{};
  std::vector<int> predecessors{};
  std::vector<int> successors{};
};

struct LaneSection {
  double s{};
  std::vector<Lane> left{};   ///< 1, 2, … outwards
  std::vector<Lane> right{};  ///< −1, −2, … outwards
};

struct RoadLink {
  bool junction{false};  ///< to a junction; else to a road
  std::string id;
  bool at_start{true};  ///< of that road
};

struct Road {
  std::string id;
  double length{};
  std::string junction{};  ///< the junction whose connecting road it is; empty: none
  bool left_hand{false};   ///< traffic keeps left
  std::optional<RoadLink> predecessor{};
  std::optional<RoadLink> successor{};
  std::vector<SpeedFrom> speeds{};
  std::vector<Geometry> plan{};
  std::vector<Polynomial> offsets{};
  std::vector<LaneSection> sections{};
  /// Where its first (last) lane sections are not taken: the lanes of the remaining sections that replace the ids at
  /// its ends.
  std::vector<std::pair<int, int>> first_names{};
  std::vector<std::pair<int, int>> last_names{};
  std::string location;

  [[nodiscard]] int lane_at(bool start, int lane) const {
    for (const auto& [from, to] : start ? first_names : last_names) {
      if (from == lane) return to;
    }
    return lane;
  }
};

struct Connection {
  std::string incoming;
  std::string connecting;
  bool at_start{true};  ///< of the connecting road
  std::vector<std::pair<int, int>> lanes{};
  std::string location;
};
struct Junction {
  std::string id;
  std::vector<Connection> connections{};
};

struct Network {
  std::string name;
  std::vector<Road> roads{};
  std::vector<Junction> junctions{};
};

}  // namespace cosiva::zone::opendrive
