#pragma once

#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// Small circuits with forks, merges and bends on the spot.
namespace cosiva::aiv::test {

struct GraphPart {
  std::string name;
  Pose2 start;
  double length_m;
  double curvature_per_m;
  std::vector<zone::SectionId> next;
  bool pivots{false};
};

inline zone::TrafficZone graph(std::string name, const std::vector<GraphPart>& parts,
                               std::vector<zone::Waypoint> waypoints) {
  std::vector<zone::Circuit::Part> sections;
  for (const GraphPart& part : parts) {
    auto section = zone::Section::make(part.start, part.length_m, part.curvature_per_m);
    if (!section) std::abort();
    sections.push_back({part.name, std::move(*section), std::nullopt, part.next, part.pivots});
  }
  auto circuit = zone::Circuit::make("graph", std::move(sections));
  if (!circuit) std::abort();
  zone::TrafficZone zone = lacet4();
  zone.name = std::move(name);
  zone.circuit = std::move(*circuit);
  zone.tags.clear();
  zone.beacons.reset();
  zone.stations.clear();
  zone.crossings.clear();
  zone.starts.clear();
  zone.waypoints = std::move(waypoints);
  return zone;
}

/// A trunk that forks into two branches, `l_…` and `r_…`, which merge again before the tail. The node "F" lies at the
/// fork, "M" at the merge. All radii are 1 m; the left branch is the default.
inline const zone::TrafficZone& diamond() {
  static const zone::TrafficZone zone = [] {
    constexpr double eighth = pi / 4.0;
    const Pose2 fork{2.0, 0.0, 0.0};
    const auto end = [](const Pose2& start, double length_m, double curvature_per_m) {
      return zone::Section::make(start, length_m, curvature_per_m)->end();
    };
    const Pose2 l_over = end(fork, eighth, 1.0);
    const Pose2 l_down = end(l_over, 2.0 * eighth, -1.0);
    const Pose2 r_over = end(fork, eighth, -1.0);
    const Pose2 r_down = end(r_over, 2.0 * eighth, 1.0);
    const Pose2 merge = end(l_down, eighth, 1.0);
    return graph("diamond",
                 {{"trunk", {}, 2.0, 0.0, {1, 4}},
                  {"l_up", fork, eighth, 1.0, {2}},
                  {"l_over", l_over, 2.0 * eighth, -1.0, {3}},
                  {"l_down", l_down, eighth, 1.0, {7}},
                  {"r_up", fork, eighth, -1.0, {5}},
                  {"r_over", r_over, 2.0 * eighth, 1.0, {6}},
                  {"r_down", r_down, eighth, -1.0, {7}},
                  {"tail", merge, 2.0, 0.0, {}}},
                 {{"T", {0, 0.0}},
                  {"T1", {0, 1.0}},
                  {"F", {1, 0.0}},
                  {"lo", {2, 0.0}},
                  {"ld", {3, 0.0}},
                  {"F", {4, 0.0}},
                  {"ro", {5, 0.0}},
                  {"rd", {6, 0.0}},
                  {"M", {7, 0.0}},
                  {"M1", {7, 1.0}},
                  {"E", {7, 2.0}}});
  }();
  return zone;
}

/// A square of 1 m, driven anticlockwise with a turn of a quarter at each corner; at the first corner a spur leads
/// straight on, which is the default. Next to the first side a bow leads from corner to corner.
inline const zone::TrafficZone& square() {
  static const zone::TrafficZone zone = [] {
    auto made = graph("square",
                      {{"south", {0.0, 0.0, 0.0}, 1.0, 0.0, {4, 1}, true},
                       {"east", {1.0, 0.0, pi / 2.0}, 1.0, 0.0, {2}, true},
                       {"north", {1.0, 1.0, pi}, 1.0, 0.0, {3}, true},
                       {"west", {0.0, 1.0, -pi / 2.0}, 1.0, 0.0, {0, 5}, true},
                       {"spur", {1.0, 0.0, 0.0}, 1.0, 0.0, {}, true},
                       {"bow", {0.0, 0.0, -pi / 6.0}, pi / 3.0, 1.0, {1}, true}},
                      {{"A", {0, 0.0}},
                       {"B", {1, 0.0}},
                       {"C", {2, 0.0}},
                       {"D", {3, 0.0}},
                       {"B", {4, 0.0}},
                       {"S", {4, 1.0}},
                       {"A", {5, 0.0}}});
    made.edges_are_sections = true;
    return made;
  }();
  return zone;
}

/// A lane of 1 m that is driven in both directions, with a turn round at either end; another section coincides with the
/// outward lane. Nodes "W" and "E".
inline const zone::TrafficZone& there_and_back() {
  static const zone::TrafficZone zone = [] {
    auto made = graph("there_and_back",
                      {{"there", {}, 1.0, 0.0, {1}, true},
                       {"back", {1.0, 0.0, pi}, 1.0, 0.0, {0, 2}, true},
                       {"there_too", {}, 1.0, 0.0, {1}, true}},
                      {{"W", {0, 0.0}}, {"t", {0, 0.5}}, {"E", {1, 0.0}}, {"W", {2, 0.0}}, {"tt", {2, 0.5}}});
    made.edges_are_sections = true;
    return made;
  }();
  return zone;
}

}  // namespace cosiva::aiv::test
