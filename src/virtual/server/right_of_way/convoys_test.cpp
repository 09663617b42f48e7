// Convoys through the clover's crossings: vehicles form one when this saves time, and no vehicle starves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/right_of_way/test_roads.h"
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
  VehicleIndex leader = 0;
  for (const VehicleIndex last : {1U, 3U}) {
    traffic.set_position(leader, std::nullopt);
    give_leave(last);
    put_stopped(last, east, -half_path_m);
    const VehicleIndex next = last == 1U ? 3U : 4U;
    put_stopped(next, east, 0.0);
    EXPECT_EQ(may_join(next), next == 3U) << next;
    if (next == 3U) {
      EXPECT_EQ(join(next).size, 3U);
    }
    leader = last;
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

/// Vehicle 0 has been granted the first road's chain, 0.72 m long, and has a base far beyond it; vehicle 1 is at its
/// stop line behind it. While vehicle 0 is `d` before the exit, it has left after 0.3 s + d / 0.4 m/s. A vehicle that
/// joins has left after 0.3 s + 0.72 m / 0.4 m/s + 0.4 s from standstill = 2.5 s, and vehicle 2 can begin 0.3 s later.
class RoadConvoy : public testing::Test {
 protected:
  static constexpr zone::SectionId first = Roads::first;
  static constexpr zone::SectionId second = Roads::second;
  static constexpr double exit_s_m = 1.22;

  void begin(double leader_s_m, const TrafficRules& rules = {}) {
    roads.begin(rules);
    roads.put(0, first, 0.5);
    ASSERT_TRUE(roads.request(0, exit_s_m).granted);
    roads.end_base(0, first, 5.0);
    roads.put(0, first, leader_s_m);
    roads.put(1, first, 0.5);
  }
  /// Vehicle 2 requests the crossing on the other road, as far before its stop line.
  void refuse_other(double before_m = 0.0) {
    roads.put(2, second, 0.5 - before_m);
    ASSERT_FALSE(roads.request(2, exit_s_m).granted);
  }
  [[nodiscard]] bool may_join(VehicleIndex vehicle) { return roads.may_join(vehicle, exit_s_m); }
  [[nodiscard]] double lost_s() const { return roads.traffic.requests().at(0).lost_s; }

  Roads roads;
};

TEST_F(RoadConvoy, has_to_save_a_tenth_of_a_second) {
  // d = 0.03 m: 2 loses 2.8 s − 0.375 s = 2.425 s. Without the convoy, 1 would have left after
  // 0.375 s + 2.2 s + 0.3 s + 2.2 s = 5.075 s instead of 2.5 s.
  begin(1.19);
  refuse_other();
  EXPECT_TRUE(may_join(1)) << "2.575 s against 2.425 s";
  begin(1.205);
  refuse_other();
  EXPECT_FALSE(may_join(1)) << "2.5375 s against 2.4625 s";
}

TEST_F(RoadConvoy, counts_followers_nearer_than_seventy_centimetres) {
  begin(1.205);
  refuse_other();
  roads.put(3, 1, 19.79);
  EXPECT_FALSE(may_join(1)) << "0.71 m behind";
  roads.put(3, 1, 19.81);
  EXPECT_TRUE(may_join(1));
}

TEST_F(RoadConvoy, counts_no_followers_beyond_the_maximum_length) {
  begin(1.205, {.convoy_max = 2});
  refuse_other();
  roads.put(3, 1, 19.81);
  EXPECT_FALSE(may_join(1));
}

TEST_F(RoadConvoy, charges_waiting_vehicles_the_time_that_they_lose) {
  begin(1.19);
  refuse_other();
  ASSERT_TRUE(may_join(1));
  const Traffic::Convoy convoy = roads.traffic.join(1);
  EXPECT_EQ(convoy.size, 2U);
  EXPECT_THAT(convoy.crossings, testing::ElementsAre(Roads::x));
  EXPECT_NEAR(lost_s(), 2.425, 1e-9);
  roads.end_base(1, first, 5.0);
  roads.traffic.set_position(0, std::nullopt);
  roads.put(1, first, 1.19);
  roads.put(3, first, 0.5);
  ASSERT_TRUE(may_join(3));
  EXPECT_EQ(roads.traffic.join(3).size, 3U);
  EXPECT_NEAR(lost_s(), 2.0 * 2.425, 1e-9);
  EXPECT_EQ(roads.traffic.convoys(), 2U);
}

TEST_F(RoadConvoy, charges_less_to_a_vehicle_that_has_not_arrived_at_its_stop_line) {
  begin(1.19);
  refuse_other(0.4);
  ASSERT_TRUE(may_join(1));
  (void)roads.traffic.join(1);
  EXPECT_NEAR(lost_s(), 2.8 - 0.4 / 0.4, 1e-9);
}

TEST_F(RoadConvoy, charges_nothing_to_a_vehicle_that_arrives_later) {
  begin(1.19);
  roads.put(2, 3, 19.3);
  ASSERT_FALSE(roads.traffic.request(2, 1.92, 1.2).granted);
  ASSERT_TRUE(may_join(1));
  (void)roads.traffic.join(1);
  EXPECT_EQ(lost_s(), 0.0) << "it arrives after 3 s";
}

TEST_F(RoadConvoy, costs_no_vehicle_more_than_the_limit) {
  for (const double lost_s_max : {2.42, 2.43}) {
    begin(1.19, {.lost_s_max = lost_s_max});
    refuse_other();
    EXPECT_EQ(may_join(1), lost_s_max > 2.425);
  }
}

TEST_F(RoadConvoy, ignores_vehicles_without_room_beyond_the_crossing) {
  begin(1.205);
  roads.put(5, second, 1.56);
  refuse_other();
  EXPECT_TRUE(may_join(1)) << "2 would need 0.35 m beyond its exit";
  roads.put(5, second, 1.58);
  refuse_other();
  EXPECT_FALSE(may_join(1));
}

TEST_F(RoadConvoy, is_joined_at_most_as_far_before_the_stop_line_as_a_crossing_is_requested) {
  begin(0.6);
  roads.put(1, 1, 19.8);
  EXPECT_TRUE(roads.traffic.may_join(1, 0.7 + 0.72, 0.7));
  roads.put(1, 1, 19.79);
  EXPECT_FALSE(roads.traffic.may_join(1, 0.71 + 0.72, 0.71));
}

TEST_F(RoadConvoy, is_joined_behind_a_leader_between_its_stop_line_and_the_room_beyond_the_exit) {
  begin(0.5);
  roads.put(1, first, 0.25);
  EXPECT_TRUE(may_join(1)) << "the leader is at its stop line";
  roads.put(0, first, 0.49);
  EXPECT_FALSE(may_join(1));
  begin(1.56);
  EXPECT_TRUE(may_join(1)) << "0.34 m beyond the exit";
  roads.put(0, first, 1.58);
  EXPECT_FALSE(may_join(1));
}

TEST_F(RoadConvoy, needs_room_between_the_exit_and_the_end_of_the_leader_s_base) {
  begin(1.0);
  roads.end_base(0, first, 1.56);
  EXPECT_FALSE(may_join(1));
  roads.end_base(0, first, 1.58);
  EXPECT_TRUE(may_join(1)) << "0.36 m";
}

TEST_F(RoadConvoy, needs_room_where_its_leader_s_obstacle_sensor_stops_the_leader) {
  begin(1.0);
  roads.put(4, first, 1.91);
  EXPECT_FALSE(may_join(1));
  roads.put(4, first, 1.93);
  EXPECT_TRUE(may_join(1)) << "twice 0.35 m, and 1 cm";
}

TEST_F(RoadConvoy, needs_room_for_all_members_between_the_exit_and_the_ends_of_their_bases) {
  struct Bases {
    double front_s_m;
    double rear_s_m;
    bool joins;
  };
  for (const Bases& bases : {Bases{1.93, 1.58, true}, Bases{1.91, 1.58, false}, Bases{1.93, 1.56, false}}) {
    begin(1.0);
    ASSERT_TRUE(may_join(1));
    (void)roads.traffic.join(1);
    roads.end_base(1, first, bases.rear_s_m);
    roads.put(0, first, 1.4);
    roads.put(1, first, 1.0);
    roads.put(3, first, 0.5);
    roads.end_base(0, first, bases.front_s_m);
    EXPECT_EQ(may_join(3), bases.joins) << bases.front_s_m << " " << bases.rear_s_m;
  }
}

TEST_F(RoadConvoy, is_not_formed_while_a_vehicle_is_in_the_crossing_without_holding_it) {
  begin(1.0);
  roads.put(2, second, 1.0);
  EXPECT_EQ(roads.traffic.holder(Roads::x), 0U);
  EXPECT_FALSE(may_join(1));
  roads.put(2, second, 1.3);
  EXPECT_TRUE(may_join(1));
}

TEST_F(RoadConvoy, folds_its_last_member_and_its_length_into_the_digest) {
  begin(1.0);
  ASSERT_TRUE(may_join(1));
  (void)roads.traffic.join(1);
  Digest expected;
  expected.add(std::uint64_t{0});  // the holder of x
  expected.add(std::uint64_t{no_vehicle});
  expected.add(std::uint64_t{1});
  expected.add(std::uint64_t{2});
  Digest digest;
  roads.traffic.fold(digest);
  EXPECT_EQ(digest, expected);
}

TEST(Intersection, of_two_lists_needs_an_element_in_common) {
  EXPECT_TRUE(intersect({1, 2}, {3, 2}));
  EXPECT_FALSE(intersect({1, 2}, {3, 4}));
  EXPECT_FALSE(intersect({}, {1}));
  EXPECT_FALSE(intersect({1}, {}));
}

}  // namespace
}  // namespace cosiva::virtual_side
