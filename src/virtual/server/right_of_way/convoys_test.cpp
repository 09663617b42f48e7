// Convoys through the clover's crossings: vehicles form one when this saves time, and no vehicle starves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

/// Vehicle 0 is in the crossings of the eastward straight (section 0), and vehicle 1 is stopped at the stop line behind
/// it. Vehicle 2 approaches on the northward straight (section 2), and vehicle 4 on the southward one (section 6). The
/// distance from stop line to exit is 0.74 m: 1.85 s at the medium speed, and 0.4 s more for a vehicle that has to
/// accelerate.
class ConvoyFixture : public testing::Test {
 protected:
  static constexpr zone::SectionId east = 0;
  static constexpr zone::SectionId north = 2;
  static constexpr zone::SectionId south = 6;

  /// @param inside_m  distance of vehicle 0 beyond the stop line
  void begin(double inside_m, const TrafficRules& rules = {}) {
    traffic = Traffic{rules};
    traffic.set_map(&map);
    traffic.resize(6);
    traffic.set_time(now);
    put_stopped(0, east, 0.0);
    ASSERT_TRUE(request_crossing(0, east, 0.0).granted);
    give_leave(0);
    put_stopped(0, east, -inside_m);
    put_stopped(1, east, 0.0);
  }
  [[nodiscard]] WaypointIndex stop_on(zone::SectionId section) const {
    for (WaypointIndex i = 0; i < map.size(); ++i)
      if (map.waypoint(i).position.section == section && map.stretch(i).crosses) return i;
    return no_waypoint;
  }
  [[nodiscard]] WaypointIndex exit_of(zone::SectionId section) const { return map.chain(stop_on(section)).exit; }
  void put_stopped(VehicleIndex vehicle, zone::SectionId section, double before_m) {
    const zone::TrackPosition stop = map.waypoint(stop_on(section)).position;
    traffic.set_position(vehicle, map.circuit().advance(stop, -before_m));
    traffic.update();
  }
  /// Gives a base that ends this number of waypoints beyond the exit.
  void give_leave(VehicleIndex vehicle, int waypoints = 4) {
    WaypointIndex end = exit_of(east);
    for (int i = 0; i < waypoints; ++i) end = map.stretch(end).to;
    traffic.set_base_end(vehicle, end);
    traffic.update();
  }
  Traffic::Response request_crossing(VehicleIndex vehicle, zone::SectionId section, double before_m) {
    return traffic.request(vehicle, before_m + map.chain(stop_on(section)).length_m, before_m);
  }
  bool may_join(VehicleIndex vehicle, double before_m = 0.0) {
    return traffic.may_join(vehicle, before_m + map.chain(stop_on(east)).length_m, before_m);
  }
  Traffic::Convoy join(VehicleIndex vehicle) {
    Traffic::Convoy convoy = traffic.join(vehicle);
    give_leave(vehicle, 0);
    return convoy;
  }
  Traffic::Response come_up(VehicleIndex vehicle, zone::SectionId section, double before_m) {
    put_stopped(vehicle, section, before_m);
    return request_crossing(vehicle, section, before_m);
  }
  void pass_time(SimDuration duration) {
    now += duration;
    traffic.set_time(now);
  }

  static constexpr double chain_m = 0.74;
  static constexpr double half_path_m = 0.35;
  static constexpr double at_exit_m = 0.728;  // almost out

  WaypointGraph map{zone::Rtm::initialise(zone_file("lacet4.toml"))->shared_zone()};
  Traffic traffic;
  SimTime now{virtual_epoch};
};

TEST_F(ConvoyFixture, has_the_chain_lengths_that_the_expected_times_are_based_on) {
  EXPECT_NEAR(map.chain(stop_on(east)).length_m, chain_m, 5e-4);
  EXPECT_NEAR(map.chain(stop_on(north)).length_m, chain_m, 5e-4);
}

TEST_F(ConvoyFixture, passes_the_crossing_without_releasing_it_in_between) {
  begin(half_path_m);
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  EXPECT_FALSE(request_crossing(1, east, 0.0).granted) << "without a convoy it waits until 0 has left";
  ASSERT_TRUE(may_join(1));
  const Traffic::Convoy convoy = join(1);
  EXPECT_EQ(convoy.size, 2U);
  EXPECT_EQ(convoy.crossings.size(), 2U);
  EXPECT_EQ(traffic.convoys(), 1U);

  put_stopped(0, east, -1.0);
  const auto response = request_crossing(2, north, 0.0);
  EXPECT_FALSE(response.granted) << "although 2 requested first";
  EXPECT_EQ(response.blocked_by, 1U);
  put_stopped(1, east, -1.0);
  EXPECT_TRUE(request_crossing(2, north, 0.0).granted) << "both have left";
}

TEST_F(ConvoyFixture, lets_cross_traffic_go_first_where_the_leader_has_almost_left) {
  begin(at_exit_m);
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  EXPECT_FALSE(may_join(1)) << "1 would save no more than 2 would lose: 2.5 s";
}

TEST_F(ConvoyFixture, counts_all_vehicles_that_follow) {
  begin(at_exit_m);
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  put_stopped(3, east, 0.35);
  EXPECT_TRUE(may_join(1)) << "two save 2.5 s each, 2 loses it once";
}

TEST_F(ConvoyFixture, counts_all_vehicles_that_wait) {
  begin(0.42);
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  EXPECT_TRUE(may_join(1)) << "1 saves 3.35 s, 2 loses 1.75 s";
  EXPECT_FALSE(come_up(4, south, 0.0).granted);
  EXPECT_FALSE(may_join(1)) << "and 4 as much";
}

TEST_F(ConvoyFixture, is_formed_where_no_vehicle_waits) {
  begin(half_path_m);
  EXPECT_TRUE(may_join(1));
  EXPECT_TRUE(may_join(1)) << "the query changes nothing";
  put_stopped(1, east, 0.8);
  EXPECT_FALSE(may_join(1, 0.8)) << "too far from the stop line to request";
}

TEST_F(ConvoyFixture, is_not_formed_when_convoys_are_disabled) {
  begin(half_path_m, {.convoys = false});
  EXPECT_FALSE(may_join(1));
}

TEST_F(ConvoyFixture, never_goes_before_a_higher_priority) {
  begin(half_path_m);
  traffic.set_priority(2, 1);
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  EXPECT_FALSE(may_join(1));
  traffic.set_priority(1, 1);
  EXPECT_TRUE(may_join(1)) << "equal priorities";
}

TEST_F(ConvoyFixture, never_goes_before_a_vehicle_that_has_waited_ten_seconds) {
  begin(half_path_m);
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  pass_time(9900ms);
  EXPECT_TRUE(may_join(1));
  pass_time(100ms);
  EXPECT_FALSE(may_join(1));
}

TEST_F(ConvoyFixture, has_at_most_three_members) {
  begin(half_path_m);
  ASSERT_TRUE(may_join(1));
  join(1);
  VehicleIndex ahead = 0;
  for (const VehicleIndex last : {1U, 3U}) {
    traffic.set_position(ahead, std::nullopt);
    give_leave(last);
    put_stopped(last, east, -half_path_m);
    const VehicleIndex next = last == 1U ? 3U : 4U;
    put_stopped(next, east, 0.0);
    EXPECT_EQ(may_join(next), next == 3U) << next;
    if (next == 3U) {
      EXPECT_EQ(join(next).size, 3U);
    }
    ahead = last;
  }
}

TEST_F(ConvoyFixture, does_not_follow_a_leader_whose_base_leaves_no_room) {
  begin(half_path_m);
  give_leave(0, 0);
  EXPECT_FALSE(may_join(1)) << "it would stop in the crossing";
  give_leave(0, 4);
  EXPECT_TRUE(may_join(1));
}

TEST_F(ConvoyFixture, relies_only_on_bases_that_its_members_already_have) {
  begin(at_exit_m);
  ASSERT_TRUE(may_join(1));
  join(1);
  put_stopped(0, east, -1.0);
  put_stopped(1, east, -0.45);
  put_stopped(3, east, 0.0);
  EXPECT_FALSE(may_join(3)) << "1 may stop at the exit, whatever 0 does";
  give_leave(1, 2);
  EXPECT_TRUE(may_join(3));
  put_stopped(0, east, -0.85);
  give_leave(0, 1);
  EXPECT_FALSE(may_join(3)) << "where 0 finally stops there is no room for 1 and 3";
}

TEST_F(ConvoyFixture, accounts_for_the_obstacle_sensor_that_stops_the_leader) {
  begin(half_path_m);
  give_leave(0, 2);  // 0.38 m beyond the exit
  put_stopped(5, east, -chain_m - 0.68);
  EXPECT_FALSE(may_join(1)) << "the base ends behind 5, but 0 stops slightly earlier";
  put_stopped(5, east, -chain_m - 0.75);
  EXPECT_TRUE(may_join(1));
}

TEST_F(ConvoyFixture, costs_no_vehicle_more_than_the_total_loss_limit) {
  begin(half_path_m, {.lost_s_max = 1.5});
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  EXPECT_FALSE(may_join(1)) << "2 would lose 1.58 s";
  begin(half_path_m, {.lost_s_max = 2.0});
  EXPECT_FALSE(come_up(2, north, 0.0).granted);
  ASSERT_TRUE(may_join(1));
  join(1);
  traffic.set_position(0, std::nullopt);
  give_leave(1);
  put_stopped(1, east, -half_path_m);
  put_stopped(3, east, 0.0);
  EXPECT_FALSE(may_join(3)) << "2 would lose the same time again";
}

TEST_F(ConvoyFixture, is_interrupted_by_a_vehicle_granted_the_crossing_in_between) {
  begin(half_path_m);
  put_stopped(0, east, -0.65);  // out of the first crossing, still in the second one
  ASSERT_TRUE(come_up(4, south, 0.0).granted);
  EXPECT_FALSE(may_join(1));
}

TEST_F(ConvoyFixture, is_not_formed_behind_a_leader_still_before_its_stop_line) {
  begin(half_path_m);
  put_stopped(1, east, 0.35);
  EXPECT_TRUE(may_join(1, 0.35));
  put_stopped(0, east, 0.01);
  EXPECT_FALSE(may_join(1, 0.35));
}

/// What may_join() has to decide by the rules in traffic.h, for vehicle 1 `stop_m` before its stop line behind vehicle
/// 0, `inside_m` beyond it, while vehicle 2 waits `other_m` before its own stop line: the time gained minus the time
/// lost.
class ConvoyBalance : public ConvoyFixture {
 protected:
  [[nodiscard]] double gain_s(double stop_m, double inside_m, double other_m) const {
    constexpr double reaction_s = 0.3;
    const zone::SpeedProfile& pace = map.zone().profiles.medium;
    const auto drive_s = [&](double length_m) { return length_m / pace.speed_mps; };
    const auto pass_s = [&](double before_m) {
      const double from_rest_s = before_m < 0.10 ? pace.speed_mps / pace.acceleration_mps2 / 2.0 : 0.0;
      return drive_s(map.chain(stop_on(east)).length_m) + from_rest_s;
    };
    const double leader_left_s = reaction_s + drive_s(std::max(0.0, map.chain(stop_on(east)).length_m - inside_m));
    const double convoy_left_s = reaction_s + drive_s(stop_m) + pass_s(stop_m);
    const double other_begins_s = std::max(drive_s(other_m), leader_left_s);
    const double other_loses_s = std::max(0.0, convoy_left_s + reaction_s - other_begins_s);
    const double room_s = drive_s(map.zone().vehicle.length_m + 0.15);
    const double turn_s =
        std::max({drive_s(stop_m), leader_left_s + room_s, other_begins_s + pass_s(other_m) + reaction_s});
    const double saved_s = turn_s + pass_s(stop_m) - convoy_left_s;
    return saved_s - other_loses_s - 0.1;
  }
};

TEST_F(ConvoyBalance, decides_wherever_the_three_vehicles_are) {
  int joined = 0;
  int refused = 0;
  for (const double stop_m : {0.0, 0.08, 0.12, 0.3, 0.5, 0.69}) {
    for (const double inside_m : {0.05, 0.25, 0.45, 0.6, 0.7}) {
      for (const double other_m : {0.0, 0.09, 0.15, 0.4, 0.65}) {
        const double gain = gain_s(stop_m, inside_m, other_m);
        if (std::fabs(gain) < 0.01) continue;
        begin(inside_m);
        put_stopped(1, east, stop_m);
        EXPECT_FALSE(come_up(2, north, other_m).granted);
        EXPECT_EQ(may_join(1, stop_m), gain > 0.0) << stop_m << " " << inside_m << " " << other_m << ": " << gain;
        ++(gain > 0.0 ? joined : refused);
      }
    }
  }
  EXPECT_GT(joined, 20);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace cosiva::virtual_side
