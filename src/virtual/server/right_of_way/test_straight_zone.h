#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/vehicle_fixture.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/rtm/rtm.h"

/// For tests: zones of straight sections with chosen lengths, successors, waypoints and crossings. All sections begin
/// at the origin: only distances along the sections count.
namespace cosiva::virtual_side::fixture {

struct Straight {
  double length_m;
  std::vector<zone::SectionId> next;
  std::optional<double> speed_mps_max{};
};

/// Vehicles of 0.20 m that drive at 0.4 m/s and accelerate with 0.5 m/s².
/// @param waypoints  sorted by section and s
inline zone::TrafficZone straight_zone(const std::vector<Straight>& straights, std::vector<zone::Waypoint> waypoints,
                                       std::vector<zone::Crossing> crossings = {}) {
  std::vector<zone::Circuit::Part> parts;
  for (const Straight& straight : straights)
    parts.push_back({"s" + std::to_string(parts.size()), *zone::Section::make({}, straight.length_m),
                     straight.speed_mps_max, straight.next, false});
  zone::TrafficZone made = *zone::Rtm::initialise(oval())->shared_zone();
  constexpr double any_gap_m = 1000.0;
  made.circuit = *zone::Circuit::make("straights", std::move(parts), any_gap_m);
  made.vehicle = {0.20, 0.12};
  made.profiles.medium = {0.4, 0.5, 0.8};
  made.waypoints = std::move(waypoints);
  made.crossings = std::move(crossings);
  return made;
}

}  // namespace cosiva::virtual_side::fixture
