#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/right_of_way/test_straight_zone.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

/// For tests: three roads, each a loop of 26 m, of which the second one crosses the other two. Every vehicle is 0.20 m
/// long, so that a vehicle needs 0.35 m beyond a crossing.
namespace cosiva::virtual_side::fixture {

[[nodiscard]] inline const Traffic::Leader& leader_of(const Traffic& traffic, VehicleIndex vehicle) {
  return traffic.ahead(vehicle);
}

struct Roads {
  static constexpr zone::SectionId first = 0;  ///< 6 m, then 20 m on section 1
  static constexpr zone::SectionId second = 2;
  static constexpr zone::SectionId third = 4;
  static constexpr CrossingIndex x = 0;  ///< of the first and the second road, on both from 0.8 m to 1.2 m
  static constexpr CrossingIndex y = 1;  ///< of the second road from 1.6 m to 2.0 m, of the third from 0.8 m to 1.2 m
  static constexpr double stop_s_m = 0.5;

  Roads() { begin(); }
  void begin(const TrafficRules& rules = {}) {
    traffic = Traffic{rules};
    traffic.set_map(&map);
    traffic.resize(6);
  }
  [[nodiscard]] WaypointIndex waypoint(zone::SectionId section, double s_m) const {
    for (WaypointIndex i = 0; i < map.size(); ++i)
      if (map.waypoint(i).position == zone::TrackPosition{section, s_m}) return i;
    COSIVA_EXPECT(false);
    return no_waypoint;
  }
  void put(VehicleIndex vehicle, zone::SectionId section, double s_m) {
    traffic.set_position(vehicle, zone::TrackPosition{section, s_m});
    traffic.update();
  }
  void end_base(VehicleIndex vehicle, zone::SectionId section, double s_m) {
    traffic.set_base_end(vehicle, waypoint(section, s_m));
    traffic.update();
  }
  /// Requests the crossings up to this position of the vehicle's own section.
  Traffic::Response request(VehicleIndex vehicle, double exit_s_m) {
    const double s_m = traffic.track_position(vehicle)->s_m;
    return traffic.request(vehicle, exit_s_m - s_m, stop_s_m - s_m);
  }
  [[nodiscard]] bool may_join(VehicleIndex vehicle, double exit_s_m) {
    const double s_m = traffic.track_position(vehicle)->s_m;
    return traffic.may_join(vehicle, exit_s_m - s_m, stop_s_m - s_m);
  }

  WaypointGraph map{std::make_shared<const zone::TrafficZone>(
      straight_zone({{6.0, {1}}, {20.0, {0}}, {6.0, {3}}, {20.0, {2}}, {6.0, {5}}, {20.0, {4}}},
                    {{"A1", {0, 0.5}},
                     {"A2", {0, 1.22}},
                     {"A3", {0, 1.5}},
                     {"A4", {0, 1.56}},
                     {"A5", {0, 1.58}},
                     {"A6", {0, 1.91}},
                     {"A7", {0, 1.93}},
                     {"A8", {0, 5.0}},
                     {"A9", {1, 10.0}},
                     {"B1", {2, 0.5}},
                     {"B2", {2, 1.5}},
                     {"B3", {2, 2.5}},
                     {"C1", {4, 0.5}},
                     {"C2", {4, 1.5}}},
                    {{"x", {}, {{0, 0.8, 1.2}, {2, 0.8, 1.2}}}, {"y", {}, {{2, 1.6, 2.0}, {4, 0.8, 1.2}}}}))};
  Traffic traffic;
};

}  // namespace cosiva::virtual_side::fixture
