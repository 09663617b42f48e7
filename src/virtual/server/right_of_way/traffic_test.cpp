#include "cosiva/virtual/server/right_of_way/traffic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/right_of_way/test_roads.h"
#include "cosiva/virtual/server/right_of_way/test_straight_zone.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;

/// The clover has four straights of 1.5 m that cross pairwise 0.6 m and 0.9 m from their starts; sections 0, 2, 4, 6.
/// No vehicle lets another pass out of turn, and there are no convoys.
class CloverTraffic : public testing::Test {
 protected:
  CloverTraffic() {
    traffic.set_map(&map);
    traffic.resize(3);
  }
  /// The last waypoint before the crossings of a straight.
  [[nodiscard]] WaypointIndex stop_on(zone::SectionId section) const {
    for (WaypointIndex i = 0; i < map.size(); ++i)
      if (map.waypoint(i).position.section == section && map.stretch(i).crosses) return i;
    return no_waypoint;
  }
  [[nodiscard]] double stop_s(zone::SectionId section) const { return map.waypoint(stop_on(section)).position.s_m; }
  void stop_before(VehicleIndex vehicle, zone::SectionId section, double before_m = 0.0) {
    traffic.set_position(vehicle, zone::TrackPosition{section, stop_s(section) - before_m});
    traffic.update();
  }
  Traffic::Response request_crossing(VehicleIndex vehicle, zone::SectionId section, double before_m = 0.0) {
    return traffic.request(vehicle, before_m + map.chain(stop_on(section)).length_m);
  }
  void drive_to_exit(VehicleIndex vehicle, zone::SectionId section) {
    traffic.set_base_end(vehicle, map.chain(stop_on(section)).exit);
    traffic.update();
  }
  [[nodiscard]] std::size_t held_by(VehicleIndex vehicle) const {
    std::size_t count = 0;
    for (CrossingIndex x = 0; x < map.crossing_count(); ++x) count += traffic.holder(x) == vehicle ? 1U : 0U;
    return count;
  }

  WaypointGraph map{zone::Rtm::initialise(zone_file("lacet4.toml"))->shared_zone()};
  Traffic traffic{{.convoys = false}};
};

TEST_F(CloverTraffic, finds_two_crossings_behind_each_stop_line_and_treats_them_as_one) {
  ASSERT_EQ(map.crossing_count(), 4U);
  for (const zone::SectionId straight : {0U, 2U, 4U, 6U}) {
    const WaypointIndex stop = stop_on(straight);
    ASSERT_NE(stop, no_waypoint);
    std::vector<CrossingIndex> met;
    map.crossings_on(map.waypoint(stop).position, map.chain(stop).length_m, met);
    EXPECT_EQ(met.size(), 2U);
    // Bodies 0.20 m × 0.12 m touch within 0.16 m of the centre of a crossing, plus clearance: 0.6 − 0.20 > s > 0.9 +
    // 0.20.
    EXPECT_LT(map.waypoint(stop).position.s_m, 0.44);
    EXPECT_GT(map.waypoint(map.chain(stop).exit).position.s_m, 1.06);
  }
}

TEST_F(CloverTraffic, grants_a_free_chain_as_a_whole) {
  stop_before(0, 0);
  EXPECT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_EQ(held_by(0), 2U);
}

TEST_F(CloverTraffic, grants_nothing_when_one_crossing_of_the_chain_is_held) {
  stop_before(0, 0);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  stop_before(1, 2);  // crosses the first straight and the third
  const auto response = request_crossing(1, 2);
  EXPECT_FALSE(response.granted);
  EXPECT_EQ(response.blocked_by, 0U);
  EXPECT_EQ(held_by(1), 0U) << "all or nothing";
}

TEST_F(CloverTraffic, lets_opposite_straights_go_together) {
  stop_before(0, 0);
  stop_before(1, 4);
  EXPECT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_TRUE(request_crossing(1, 4).granted);
}

TEST_F(CloverTraffic, revokes_a_grant_that_no_base_followed) {
  stop_before(0, 0);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  traffic.update();
  EXPECT_EQ(held_by(0), 0U);
}

TEST_F(CloverTraffic, releases_a_crossing_as_soon_as_the_vehicle_reports_a_position_beyond_it) {
  stop_before(0, 0);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  double first_span_end_m = 10.0;
  for (const zone::Crossing& crossing : map.zone().crossings)
    for (const zone::CrossingSpan& span : crossing.spans)
      if (span.section == 0) first_span_end_m = std::min(first_span_end_m, span.to_m);
  traffic.set_position(0, zone::TrackPosition{0, first_span_end_m});
  traffic.update();
  EXPECT_EQ(held_by(0), 2U) << "left only 1 cm beyond its end";
  traffic.set_position(0, zone::TrackPosition{0, first_span_end_m + 0.03});
  traffic.update();
  EXPECT_EQ(held_by(0), 1U);
  traffic.set_position(0, zone::TrackPosition{0, 1.3});
  traffic.update();
  EXPECT_EQ(held_by(0), 0U);
}

// The vehicle stops at a crossing's exit, and no vehicle stops with an accuracy of a micrometre.
TEST_F(CloverTraffic, counts_a_vehicle_stopped_slightly_before_the_exit_as_beyond_the_crossing) {
  stop_before(0, 0);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  const double exit_s = map.waypoint(map.chain(stop_on(0)).exit).position.s_m;
  traffic.set_position(0, zone::TrackPosition{0, exit_s - 0.015});
  traffic.update();
  EXPECT_EQ(held_by(0), 1U);
  traffic.set_position(0, zone::TrackPosition{0, exit_s - 0.009});
  traffic.update();
  EXPECT_EQ(held_by(0), 0U);
  stop_before(1, 2);
  EXPECT_TRUE(request_crossing(1, 2).granted);
}

/// Vehicle 0 is in the crossings of the eastward straight. The northward straight needs the second of these crossings,
/// the southward straight the first; the westward straight needs neither, but one crossing of each of the other two.
class CloverTurns : public CloverTraffic {
 protected:
  void begin(const TrafficRules& rules = {}) {
    traffic = Traffic{rules};
    traffic.set_map(&map);
    traffic.resize(3);
    stop_before(0, east);
    ASSERT_TRUE(request_crossing(0, east).granted);
    drive_to_exit(0, east);
  }
  void refuse(VehicleIndex vehicle, zone::SectionId section, VehicleIndex because_of) {
    stop_before(vehicle, section);
    const auto response = request_crossing(vehicle, section);
    EXPECT_FALSE(response.granted);
    EXPECT_EQ(response.blocked_by, because_of);
  }
  static constexpr zone::SectionId east = 0;
  static constexpr zone::SectionId north = 2;
  static constexpr zone::SectionId west = 4;
  static constexpr zone::SectionId south = 6;
};

TEST_F(CloverTurns, are_yielded_to_a_vehicle_that_will_have_left_before_they_can_be_used) {
  begin();
  refuse(1, north, 0);
  stop_before(2, west);
  EXPECT_TRUE(request_crossing(2, west).granted) << "it has cleared north's path when 0 has";
}

TEST_F(CloverTurns, are_retained_where_yielding_would_exceed_the_loss_limit) {
  begin({.lost_s_max = 1.0});
  refuse(1, south, 0);
  refuse(2, west, 1);  // south could begin 1.45 s before west has cleared its path
  begin({.lost_s_max = 1.5});
  refuse(1, south, 0);
  stop_before(2, west);
  EXPECT_TRUE(request_crossing(2, west).granted);
}

TEST_F(CloverTurns, are_yielded_up_to_the_loss_limit_in_total) {
  begin({.lost_s_max = 2.0});
  refuse(1, south, 0);
  stop_before(2, west);
  ASSERT_TRUE(request_crossing(2, west).granted);
  traffic.update();  // no base follows: as if the vehicle had left and the next had arrived
  refuse(2, west, 1);
}

TEST_F(CloverTurns, are_not_yielded_to_lower_priorities_nor_after_ten_seconds) {
  begin();
  traffic.set_priority(1, 1);
  refuse(1, north, 0);
  refuse(2, west, 1);
  begin();
  traffic.set_priority(1, 0);
  refuse(1, north, 0);
  traffic.set_time(SimTime{} + traffic.rules().overtaken_at_most);
  refuse(2, west, 1);
}

TEST_F(CloverTurns, are_retained_while_the_crossing_is_free) {
  begin();
  traffic.set_position(0, std::nullopt);
  traffic.update();
  stop_before(2, west);
  ASSERT_TRUE(request_crossing(2, west).granted);
  drive_to_exit(2, west);
  refuse(1, north, 2);
  traffic.set_position(2, std::nullopt);
  traffic.set_base_end(0, no_waypoint);
  traffic.update();
  refuse(0, east, 1);
}

TEST_F(CloverTraffic, lets_a_vehicle_stopped_in_a_crossing_leave_although_another_requested_it_earlier) {
  stop_before(0, 2);
  traffic.set_position(1, zone::TrackPosition{4, 0.6});
  traffic.update();
  traffic.set_time(SimTime{1s});
  const auto first = request_crossing(0, 2);
  ASSERT_FALSE(first.granted) << "it requests the crossing that the other is stopped in";
  EXPECT_EQ(first.blocked_by, 1U);
  traffic.set_time(SimTime{20s});
  // Long after `overtaken_at_most`: the vehicle that requested first still cannot go before the other has left.
  EXPECT_TRUE(traffic.request(1, 1.2 - 0.6).granted);
}

TEST_F(CloverTraffic, always_holds_the_crossing_for_a_vehicle_that_is_stopped_in_it) {
  traffic.set_position(0, zone::TrackPosition{0, 0.6});
  traffic.update();
  EXPECT_GE(held_by(0), 1U);
  stop_before(1, 2);
  stop_before(2, 6);
  EXPECT_FALSE(request_crossing(1, 2).granted && request_crossing(2, 6).granted);
}

TEST_F(CloverTraffic, does_not_count_a_vehicle_that_stopped_a_centimetre_late_as_in_the_crossing) {
  traffic.set_position(0, zone::TrackPosition{0, stop_s(0) + 0.03});
  traffic.update();
  EXPECT_EQ(held_by(0), 0U);
}

TEST_F(CloverTraffic, serves_the_first_request_first) {
  stop_before(0, 0);
  stop_before(1, 2);
  stop_before(2, 4);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_FALSE(request_crossing(1, 2).granted) << "1 requested before 2 and has a crossing in common with it";
  EXPECT_FALSE(request_crossing(2, 4).granted);
  EXPECT_EQ(request_crossing(2, 4).blocked_by, 1U);
  traffic.set_position(0, zone::TrackPosition{0, 1.3});
  traffic.set_base_end(0, no_waypoint);
  traffic.update();
  EXPECT_FALSE(request_crossing(2, 4).granted) << "still after 1";
  EXPECT_TRUE(request_crossing(1, 2).granted);
}

TEST_F(CloverTraffic, serves_the_higher_priority_before_an_earlier_request) {
  stop_before(0, 0);
  stop_before(1, 2);
  stop_before(2, 4);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_FALSE(request_crossing(1, 2).granted);
  EXPECT_FALSE(request_crossing(2, 4).granted) << "it requested later";
  traffic.set_priority(2, 5);
  EXPECT_TRUE(request_crossing(2, 4).granted);
}

TEST_F(CloverTraffic, lets_no_vehicle_overtake_one_that_has_waited_ten_seconds) {
  stop_before(0, 0);
  stop_before(1, 2);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  traffic.set_time(virtual_epoch);
  EXPECT_FALSE(request_crossing(1, 2).granted);
  traffic.set_time(virtual_epoch + 9s);
  stop_before(2, 4, 0.3);
  request_crossing(2, 4, 0.3);
  std::optional<CrossingIndex> both_want;
  for (CrossingIndex x = 0; x < map.crossing_count(); ++x)
    if (traffic.waiting(x).size() == 2) both_want = x;
  ASSERT_TRUE(both_want.has_value());
  EXPECT_THAT(traffic.waiting(*both_want), ElementsAre(1U, 2U));
  traffic.set_priority(2, 999);
  EXPECT_THAT(traffic.waiting(*both_want), ElementsAre(2U, 1U));
  traffic.set_time(virtual_epoch + 10s);
  EXPECT_THAT(traffic.waiting(*both_want), ElementsAre(1U, 2U));
  const auto later = request_crossing(2, 4, 0.3);
  EXPECT_FALSE(later.granted);
  EXPECT_EQ(later.blocked_by, 1U);
}

TEST_F(CloverTraffic, starves_no_vehicle_next_to_a_stream_of_higher_priority) {
  traffic.set_priority(1, 999);
  traffic.set_priority(2, 999);
  stop_before(0, 2);  // without priority; straights 0 and 4 cross its path
  SimTime now = virtual_epoch;
  SimDuration waited{};
  bool served = false;
  // Two other vehicles alternate: as one leaves the crossings, the next one requests them.
  for (int turn = 0; turn < 60 && !served; ++turn, now += 1s, waited += 1s) {
    const VehicleIndex other = 1 + static_cast<VehicleIndex>(turn % 2);
    const zone::SectionId from = turn % 2 == 0 ? 0U : 4U;
    traffic.set_time(now);
    stop_before(other, from);
    const bool taken = request_crossing(other, from).granted;
    if (taken) drive_to_exit(other, from);
    served = request_crossing(0, 2).granted;
    if (taken) {
      traffic.set_position(other, std::nullopt);
      traffic.set_base_end(other, no_waypoint);
      traffic.update();
    }
  }
  EXPECT_TRUE(served);
  EXPECT_LE(waited, 12s);
}

TEST_F(CloverTraffic, lets_a_vehicle_placed_in_front_of_the_holder_go_first) {
  stop_before(0, 0, 0.5);
  ASSERT_TRUE(request_crossing(0, 0, 0.5).granted);
  drive_to_exit(0, 0);
  ASSERT_EQ(held_by(0), 2U);
  stop_before(1, 0);  // a virtual AIV, added on its path
  EXPECT_TRUE(request_crossing(1, 0).granted) << "the holder can only follow it";
  drive_to_exit(1, 0);
  EXPECT_EQ(held_by(1), 2U);
  stop_before(2, 2);
  EXPECT_FALSE(request_crossing(2, 2).granted);
  traffic.forget(1);
  traffic.update();
  EXPECT_EQ(held_by(0), 2U) << "its base still leads through them";
}

TEST_F(CloverTraffic, does_not_let_a_vehicle_go_before_a_holder_that_reaches_the_crossing_first) {
  // On the loop every vehicle is ahead of every other; but the path from 0 to 1 leads through the crossings that 1
  // requests.
  stop_before(0, 0);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  stop_before(1, 2);
  EXPECT_FALSE(request_crossing(1, 2).granted);
}

TEST_F(CloverTraffic, preserves_priorities_over_a_change_of_the_zone) {
  traffic.set_priority(2, 7);
  traffic.set_map(nullptr);
  traffic.set_map(&map);
  stop_before(0, 0);
  stop_before(1, 2);
  stop_before(2, 4);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_FALSE(request_crossing(1, 2).granted);
  EXPECT_TRUE(request_crossing(2, 4).granted);
}

TEST_F(CloverTraffic, lets_others_pass_while_there_is_no_room_beyond_and_retains_the_turn) {
  // A vehicle is stopped just beyond the exit of the northward straight.
  traffic.set_position(2, zone::TrackPosition{2, 1.25});
  stop_before(0, 2);
  stop_before(1, 0);
  const auto no_room = request_crossing(0, 2);
  EXPECT_FALSE(no_room.granted);
  EXPECT_EQ(no_room.blocked_by, 2U);
  EXPECT_TRUE(request_crossing(1, 0).granted);
}

TEST_F(CloverTraffic, removes_a_withdrawn_request) {
  stop_before(0, 0);
  stop_before(1, 2);
  stop_before(2, 4);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_FALSE(request_crossing(1, 2).granted);
  traffic.withdraw(1);
  EXPECT_TRUE(request_crossing(2, 4).granted);
}

TEST_F(CloverTraffic, lists_the_waiting_vehicles_of_each_crossing) {
  stop_before(0, 0);
  stop_before(1, 2);
  stop_before(2, 6);
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  (void)request_crossing(2, 6);
  (void)request_crossing(1, 2);
  std::vector<VehicleIndex> all;
  for (CrossingIndex x = 0; x < map.crossing_count(); ++x)
    for (const VehicleIndex v : traffic.waiting(x)) all.push_back(v);
  EXPECT_THAT(all, testing::UnorderedElementsAre(1, 1, 2, 2));
}

TEST_F(CloverTraffic, lets_a_base_reach_no_nearer_than_a_gap_behind_the_leader) {
  traffic.set_position(0, zone::TrackPosition{1, 0.5});
  traffic.set_position(1, zone::TrackPosition{1, 1.5});
  traffic.update();
  EXPECT_EQ(traffic.ahead(0).vehicle, 1U);
  EXPECT_NEAR(leader_of(traffic, 0).distance_m, 1.0, 1e-12);
  EXPECT_NEAR(traffic.reach_m(0), 1.0 - 0.20 - 0.10, 1e-12);
}

/// Vehicle 0 on the first road, 1 on the second, 2 on the third.
class RoadTraffic : public testing::Test {
 protected:
  static constexpr zone::SectionId first = Roads::first;
  static constexpr zone::SectionId second = Roads::second;
  static constexpr zone::SectionId third = Roads::third;

  /// Vehicle 0 is granted the first road's crossing from there on, and has a base through it.
  void hold_first(zone::SectionId section, double s_m, double exit_m) {
    roads.put(0, section, s_m);
    ASSERT_TRUE(traffic.request(0, exit_m).granted);
    roads.end_base(0, first, 1.5);
  }
  /// Vehicle 1 requests both crossings of its road, in vain.
  void refuse_second() {
    roads.put(1, second, 0.5);
    ASSERT_FALSE(roads.request(1, 2.5).granted);
  }
  [[nodiscard]] Traffic::Leader leader_within(double limit_m) const { return traffic.ahead_within(0, limit_m); }

  Roads roads;
  Traffic& traffic{roads.traffic};
};

TEST_F(RoadTraffic, states_the_crossing_and_its_holder_where_a_crossing_is_held) {
  roads.put(0, first, 0.5);
  const auto granted = roads.request(0, 1.5);
  EXPECT_TRUE(granted.granted);
  EXPECT_EQ(granted.blocked_by, no_vehicle);
  EXPECT_EQ(traffic.holder(Roads::x), 0U);
  EXPECT_EQ(traffic.holder(Roads::y), no_vehicle);
  roads.end_base(0, first, 1.5);
  roads.put(2, third, 0.5);
  ASSERT_TRUE(roads.request(2, 1.5).granted);
  roads.end_base(2, third, 1.5);
  roads.put(0, first, 3.0);
  roads.put(1, second, 0.5);
  const auto refused = roads.request(1, 2.5);
  EXPECT_FALSE(refused.granted);
  EXPECT_EQ(refused.waits_for, Roads::y) << "the first that is not free";
  EXPECT_EQ(refused.blocked_by, 2U);
  EXPECT_EQ(refused.why, WaitReason::crossing);
  EXPECT_EQ(traffic.holder(Roads::x), no_vehicle);
}

TEST_F(RoadTraffic, states_whose_turn_it_is) {
  roads.begin({.convoys = false});
  hold_first(first, 0.5, 1.0);
  refuse_second();
  roads.put(2, third, 0.5);
  const auto refused = roads.request(2, 1.5);
  EXPECT_FALSE(refused.granted);
  EXPECT_EQ(refused.waits_for, Roads::y);
  EXPECT_EQ(refused.blocked_by, 1U);
  EXPECT_EQ(refused.why, WaitReason::turn);
}

TEST_F(RoadTraffic, needs_a_vehicle_s_length_and_room_beyond_a_crossing) {
  roads.put(0, first, 0.5);
  roads.put(3, first, 1.849);
  const auto refused = roads.request(0, 1.5);
  EXPECT_FALSE(refused.granted);
  EXPECT_EQ(refused.waits_for, Roads::x);
  EXPECT_EQ(refused.blocked_by, 3U);
  EXPECT_EQ(refused.why, WaitReason::ahead);
  ASSERT_EQ(traffic.requests().size(), 1U);
  EXPECT_FALSE(traffic.requests()[0].has_room);
  roads.put(3, first, 1.851);
  EXPECT_TRUE(roads.request(0, 1.5).granted);
}

TEST_F(RoadTraffic, grants_a_vehicle_without_a_position_nothing) {
  EXPECT_FALSE(traffic.request(0, 1.0).granted);
  EXPECT_THAT(traffic.requests(), IsEmpty());
  EXPECT_FALSE(traffic.holds_all(0, 0.0));
  EXPECT_FALSE(is_in_others_crossing(traffic, 0));
  EXPECT_EQ(leader_within(20.0).vehicle, no_vehicle);
}

TEST_F(RoadTraffic, retains_the_time_of_the_first_request_and_the_distances_of_the_last) {
  hold_first(first, 0.5, 1.0);
  traffic.set_time(virtual_epoch);
  refuse_second();
  traffic.set_time(virtual_epoch + 2s);
  roads.put(1, second, 0.45);
  EXPECT_FALSE(traffic.request(1, 2.05, 0.05).granted);
  ASSERT_EQ(traffic.requests().size(), 1U);
  const Traffic::Request& request = traffic.requests()[0];
  EXPECT_EQ(request.vehicle, 1U);
  EXPECT_EQ(request.since, virtual_epoch);
  EXPECT_EQ(request.exit_m, 2.05);
  EXPECT_EQ(request.stop_m, 0.05);
  EXPECT_TRUE(request.has_room);
  EXPECT_THAT(request.crossings, ElementsAre(Roads::x, Roads::y));
}

TEST_F(RoadTraffic, lists_requests_and_waiting_vehicles_by_crossing) {
  hold_first(first, 0.5, 1.0);
  refuse_second();
  EXPECT_TRUE(requests(traffic, 1, Roads::x));
  EXPECT_TRUE(requests(traffic, 1, Roads::y));
  EXPECT_FALSE(requests(traffic, 0, Roads::x)) << "granted";
  EXPECT_THAT(traffic.waiting(Roads::y), ElementsAre(1));
  traffic.withdraw(2);
  EXPECT_TRUE(requests(traffic, 1, Roads::x)) << "another vehicle's request";
  traffic.withdraw(1);
  EXPECT_FALSE(requests(traffic, 1, Roads::x));
  EXPECT_THAT(traffic.waiting(Roads::y), IsEmpty());
}

TEST_F(RoadTraffic, holds_all_crossings_within_a_distance_once_they_are_granted) {
  roads.put(0, first, 0.5);
  EXPECT_TRUE(traffic.holds_all(0, 0.2)) << "there is none";
  EXPECT_FALSE(traffic.holds_all(0, 1.0));
  ASSERT_TRUE(roads.request(0, 1.5).granted);
  EXPECT_TRUE(traffic.holds_all(0, 1.0));
}

TEST_F(RoadTraffic, takes_longer_for_a_distance_from_less_than_ten_centimetres_before_the_stop_line) {
  EXPECT_DOUBLE_EQ(traffic.run_s(0.10, 0.8), 2.0);
  EXPECT_DOUBLE_EQ(traffic.run_s(0.099, 0.8), 2.4) << "half of 0.4 m/s by 0.5 m/s²";
  EXPECT_DOUBLE_EQ(traffic.stopped_m(), 0.3);
}

/// The time that vehicle 1, which waits for vehicle 0, loses to vehicle 2, which starts `before_m` before its stop
/// line. Both cross at 1.2 m, and a crossing is left 1 cm behind it; all drive at 0.4 m/s.
class YieldedTurn : public RoadTraffic {
 protected:
  Traffic::Response let_by(double before_m) {
    refuse_second();
    roads.put(2, third, 0.5 - before_m);
    return roads.request(2, 1.5);
  }
  [[nodiscard]] double lost_s() const { return traffic.requests().at(0).lost_s; }
};

TEST_F(YieldedTurn, costs_the_time_from_the_holder_s_exit_to_the_exit_of_the_vehicle_let_by) {
  hold_first(first, 0.5, 1.0);
  EXPECT_TRUE(let_by(0.0).granted);
  // 0.3 s + 0.71 m / 0.4 m/s + 0.4 s from standstill − 0.71 m / 0.4 m/s
  EXPECT_NEAR(lost_s(), 0.7, 1e-9);
}

TEST_F(YieldedTurn, costs_more_the_nearer_the_holder_is_to_its_exit) {
  hold_first(first, 0.5, 1.0);
  roads.put(0, first, 0.9);
  EXPECT_TRUE(let_by(0.0).granted);
  EXPECT_NEAR(lost_s(), 0.3 + 0.71 / 0.4 + 0.4 - 0.31 / 0.4, 1e-9);
}

TEST_F(YieldedTurn, costs_the_time_up_to_the_stop_line_but_no_acceleration_from_there) {
  hold_first(first, 0.5, 1.0);
  roads.put(0, first, 0.9);
  EXPECT_TRUE(let_by(0.2).granted);
  EXPECT_NEAR(lost_s(), 0.3 + 0.91 / 0.4 - 0.31 / 0.4, 1e-9);
}

TEST_F(YieldedTurn, costs_nothing_where_the_holder_needs_longer) {
  hold_first(1, 19.5, 2.0);
  EXPECT_TRUE(let_by(0.0).granted);
  EXPECT_EQ(lost_s(), 0.0) << "the holder needs 1.71 m / 0.4 m/s = 4.3 s, the other 2.5 s";
}

TEST_F(YieldedTurn, is_limited_by_the_time_lost_in_total) {
  for (const double lost_s_max : {1.39, 1.41}) {
    roads.begin({.lost_s_max = lost_s_max});
    hold_first(first, 0.5, 1.0);
    ASSERT_TRUE(let_by(0.0).granted);
    traffic.update();  // without a base, the grant is revoked
    const auto second_time = roads.request(2, 1.5);
    EXPECT_EQ(second_time.granted, lost_s_max > 1.4) << lost_s_max;
    EXPECT_NEAR(lost_s(), lost_s_max > 1.4 ? 1.4 : 0.7, 1e-9);
  }
}

TEST_F(YieldedTurn, ends_when_the_request_has_waited_ten_seconds) {
  for (const SimDuration waited : {SimDuration{9999ms}, SimDuration{10s}}) {
    roads.begin();
    hold_first(first, 0.5, 1.0);
    traffic.set_time(virtual_epoch);
    refuse_second();
    traffic.set_time(virtual_epoch + waited);
    roads.put(2, third, 0.5);
    EXPECT_EQ(roads.request(2, 1.5).granted, waited < 10s);
  }
}

TEST_F(RoadTraffic, lets_the_holder_leave_a_crossing_in_which_another_vehicle_is_stopped) {
  roads.put(0, first, 1.0);
  roads.put(1, second, 1.0);
  EXPECT_EQ(traffic.holder(Roads::x), 0U);
  EXPECT_FALSE(is_in_others_crossing(traffic, 0));
  EXPECT_TRUE(is_in_others_crossing(traffic, 1));
  const auto refused = roads.request(1, 1.5);
  EXPECT_EQ(refused.blocked_by, 0U);
  EXPECT_EQ(refused.why, WaitReason::crossing);
  EXPECT_TRUE(roads.request(0, 1.5).granted);
}

TEST_F(RoadTraffic, lets_no_holder_leave_a_crossing_in_which_another_vehicle_has_a_base) {
  roads.put(0, first, 1.0);
  roads.put(1, second, 1.0);
  roads.end_base(1, second, 1.5);
  EXPECT_FALSE(is_in_others_crossing(traffic, 1)) << "it is not stopped";
  const auto refused = roads.request(0, 1.5);
  EXPECT_FALSE(refused.granted);
  EXPECT_EQ(refused.waits_for, Roads::x);
  EXPECT_EQ(refused.blocked_by, 1U);
}

TEST_F(RoadTraffic, has_leaders_within_six_metres_unless_they_are_searched_for_further_on) {
  roads.put(0, first, 0.0);
  roads.put(1, 1, 0.0);
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 1U);
  EXPECT_EQ(leader_of(traffic, 0).distance_m, 6.0);
  roads.put(1, 1, 0.001);
  EXPECT_EQ(leader_of(traffic, 0).vehicle, no_vehicle);
  roads.put(1, 1, 1.0);
  EXPECT_EQ(leader_within(6.0).vehicle, no_vehicle);
  EXPECT_EQ(leader_within(6.9).vehicle, no_vehicle);
  EXPECT_EQ(leader_within(7.0).vehicle, 1U);
  EXPECT_EQ(leader_within(7.0).distance_m, 7.0);
  EXPECT_NEAR(traffic.reach_m(0, 6.8), 6.7, 1e-12) << "a base may end 0.3 m behind the leader";
  EXPECT_GT(traffic.reach_m(0, 6.6), 1e6) << "no vehicle within 6.9 m";
}

TEST_F(RoadTraffic, has_a_leader_nearly_one_lap_further_on_the_same_section) {
  roads.begin({.look_ahead_m = 30.0});
  roads.put(0, first, 1.0);
  roads.put(1, first, 0.5);
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 1U);
  EXPECT_DOUBLE_EQ(leader_of(traffic, 0).distance_m, 25.5);
  EXPECT_DOUBLE_EQ(leader_of(traffic, 1).distance_m, 0.5);
}

TEST_F(RoadTraffic, lets_the_lower_number_of_two_vehicles_at_one_position_lead) {
  roads.put(0, first, 1.0);
  roads.put(1, first, 2.0);
  roads.put(2, first, 2.0);
  EXPECT_EQ(leader_of(traffic, 2).vehicle, 1U);
  EXPECT_EQ(leader_of(traffic, 2).distance_m, 0.0);
  EXPECT_EQ(leader_of(traffic, 1).vehicle, no_vehicle);
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 2U) << "the last of the two";
}

TEST_F(RoadTraffic, measures_a_base_of_more_than_eight_metres) {
  roads.put(0, first, 0.5);
  roads.end_base(0, 1, 10.0);
  EXPECT_DOUBLE_EQ(traffic.base_m_max(0), 5.5 + 10.0 + 0.5);
  EXPECT_EQ(traffic.base_left_m(0, {first, 0.5}), 15.5);
  EXPECT_EQ(traffic.base_left_m(0, {1, 10.2}), 0.0) << "a little beyond its end";
  EXPECT_EQ(traffic.base_left_m(0, {1, 10.3}), std::nullopt) << "nearly a lap before its end";
  roads.end_base(0, first, 1.5);
  EXPECT_EQ(traffic.base_m_max(0), 8.0);
  roads.end_base(3, 1, 10.0);
  EXPECT_EQ(traffic.base_m_max(3), 8.0) << "its position is unknown";
  traffic.set_base_end(0, no_waypoint);
  EXPECT_EQ(traffic.base_left_m(0, {first, 0.5}), std::nullopt);
}

TEST_F(RoadTraffic, does_not_take_the_end_of_a_base_that_was_passed_for_that_of_another_lap) {
  roads.put(0, first, 2.0);
  roads.end_base(0, first, 1.5);
  EXPECT_GT(traffic.base_left_m(0, {first, 2.0}).value_or(0.0), 8.0) << "nearly a lap before its end";
  traffic.set_base_passed(0, true);
  EXPECT_EQ(traffic.base_left_m(0, {first, 2.0}), std::nullopt) << "half a metre beyond its end";
  EXPECT_EQ(traffic.base_left_m(0, {first, 1.7}), 0.0);
  traffic.set_base_passed(0, false);
  EXPECT_GT(traffic.base_left_m(0, {first, 2.0}).value_or(0.0), 8.0);
}

TEST_F(CloverTraffic, reserves_crossings_for_a_vehicle_whether_or_not_it_has_a_position) {
  stop_before(1, 2);
  const std::vector<CrossingIndex> all = [&] {
    std::vector<CrossingIndex> crossings;
    for (CrossingIndex x = 0; x < map.crossing_count(); ++x) crossings.push_back(x);
    return crossings;
  }();
  traffic.reserve(0, all);
  traffic.update();
  EXPECT_EQ(held_by(0), all.size());
  const Traffic::Response response = request_crossing(1, 2);
  EXPECT_FALSE(response.granted);
  EXPECT_EQ(response.blocked_by, 0U);
  EXPECT_EQ(response.why, WaitReason::crossing);
  stop_before(0, 6);
  EXPECT_EQ(held_by(0), all.size()) << "its position is known, its base is not";
  EXPECT_FALSE(request_crossing(1, 2).granted);
  traffic.reserve(0, {});
  traffic.update();
  EXPECT_EQ(held_by(0), 0U);
  EXPECT_TRUE(request_crossing(1, 2).granted);
  traffic.forget(0);
  traffic.reserve(0, all);
  traffic.forget(0);
  traffic.update();
  EXPECT_EQ(held_by(0), 0U);
}

TEST_F(CloverTraffic, counts_how_often_a_crossing_gets_a_holder) {
  stop_before(0, 0);
  const std::uint64_t before = traffic.holds();
  ASSERT_TRUE(request_crossing(0, 0).granted);
  drive_to_exit(0, 0);
  EXPECT_EQ(traffic.holds(), before + held_by(0));
  traffic.update();
  traffic.set_base_end(0, no_waypoint);
  traffic.update();
  EXPECT_EQ(traffic.holds(), before + 2) << "giving back is not counted";
}

TEST_F(RoadTraffic, discards_everything_of_a_vehicle_that_was_removed) {
  hold_first(first, 0.5, 1.0);
  refuse_second();
  traffic.set_course(1, zone::Course{{second, 3}});
  roads.end_base(1, second, 1.5);
  traffic.set_base_passed(1, true);
  traffic.forget(1);
  EXPECT_EQ(traffic.track_position(1), std::nullopt);
  EXPECT_EQ(traffic.base_end(1), no_waypoint);
  EXPECT_FALSE(traffic.base_passed(1));
  EXPECT_TRUE(traffic.course(1).empty());
  EXPECT_FALSE(traffic.on_course(1));
  EXPECT_THAT(traffic.requests(), IsEmpty());
  EXPECT_EQ(traffic.base_end(0), roads.waypoint(first, 1.5));
}

TEST_F(RoadTraffic, discards_positions_holds_and_requests_with_the_map) {
  hold_first(first, 0.5, 1.0);
  refuse_second();
  traffic.set_map(&roads.map);
  EXPECT_EQ(traffic.track_position(0), std::nullopt);
  EXPECT_EQ(traffic.base_end(0), no_waypoint);
  EXPECT_EQ(traffic.holder(Roads::x), no_vehicle);
  EXPECT_THAT(traffic.requests(), IsEmpty());
  Digest digest;
  traffic.fold(digest);
  Digest empty;
  empty.add(std::uint64_t{no_vehicle});
  empty.add(std::uint64_t{no_vehicle});
  EXPECT_EQ(digest, empty) << "nor is any pass known";
}

TEST_F(RoadTraffic, folds_holders_requests_and_passes_into_the_digest) {
  hold_first(first, 0.5, 1.0);
  traffic.set_time(virtual_epoch);
  refuse_second();
  Digest expected;
  expected.add(std::uint64_t{0});  // the holder of x
  expected.add(std::uint64_t{no_vehicle});
  expected.add(std::uint64_t{1});  // its request
  expected.add(virtual_epoch);
  expected.add(std::uint64_t{0});  // the last vehicle of the pass, and their number
  expected.add(std::uint64_t{1});
  Digest digest;
  traffic.fold(digest);
  EXPECT_EQ(digest, expected);
  roads.put(0, first, 3.0);
  ASSERT_TRUE(roads.request(1, 2.5).granted);
  Digest later;
  for (const unsigned number : {1U, 1U, 1U, 1U}) later.add(std::uint64_t{number});  // two holders, one pass
  Digest folded;
  traffic.fold(folded);
  EXPECT_EQ(folded, later) << "a pass of the same crossing replaces the earlier one";
}

/// Section 0 forks into the sections 1 and 2, of 4 m each, which merge into section 3. A crossing is on section 2.
/// Vehicle 0 is 0.5 m before the fork.
class ForkTraffic : public testing::Test {
 protected:
  ForkTraffic() {
    traffic.set_map(&map);
    traffic.resize(2);
    put(0, {0, 0.5});
  }
  void put(VehicleIndex vehicle, zone::TrackPosition position) {
    traffic.set_position(vehicle, position);
    traffic.update();
  }
  static constexpr WaypointIndex on_branch = 2;
  WaypointGraph map{std::make_shared<const zone::TrafficZone>(
      straight_zone({{1.0, {1, 2}}, {4.0, {3}}, {4.0, {3}}, {1.0, {0}}},
                    {{"A", {0, 0.5}}, {"B", {1, 2.0}}, {"C", {2, 2.0}}, {"D", {3, 0.5}}},
                    {{"x", {}, {{2, 0.8, 1.2}, {2, 1.3, 1.4}}}}))};
  Traffic traffic;
};

TEST_F(ForkTraffic, counts_a_body_on_another_branch_for_half_a_length) {
  put(1, {2, 0.1});
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 1U);
  EXPECT_DOUBLE_EQ(leader_of(traffic, 0).distance_m, 0.6);
  put(1, {2, 0.101});
  EXPECT_EQ(leader_of(traffic, 0).vehicle, no_vehicle);
}

TEST_F(ForkTraffic, finds_the_leader_anew_whenever_the_course_changes) {
  put(1, {2, 1.0});
  EXPECT_EQ(leader_of(traffic, 0).vehicle, no_vehicle);
  traffic.set_course(0, zone::Course{{0, 2}});
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 1U);
  EXPECT_DOUBLE_EQ(leader_of(traffic, 0).distance_m, 1.5);
  traffic.cut_course(0, 0);
  EXPECT_EQ(leader_of(traffic, 0).vehicle, no_vehicle);
  traffic.extend_course(0, std::vector<zone::SectionId>{2});
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 1U);
  traffic.follow(0, {1, 0.1});
  EXPECT_FALSE(traffic.on_course(0));
  EXPECT_EQ(leader_of(traffic, 0).vehicle, no_vehicle);
  traffic.follow(0, {0, 0.5});
  EXPECT_TRUE(traffic.on_course(0));
  EXPECT_EQ(leader_of(traffic, 0).vehicle, 1U);
}

TEST_F(ForkTraffic, holds_crossings_along_the_course_to_the_end_of_the_base) {
  traffic.set_base_end(0, on_branch);
  traffic.update();
  EXPECT_EQ(traffic.base_left_m(0, {0, 0.5}), std::nullopt) << "the default leads elsewhere";
  EXPECT_EQ(traffic.holder(0), no_vehicle);
  traffic.set_course(0, zone::Course{{0, 2}});
  traffic.update();
  EXPECT_EQ(traffic.base_left_m(0, {0, 0.5}), 2.5);
  EXPECT_EQ(traffic.base_left_m(0, {2, 0.5}), 1.5) << "from another section than the course's present one";
  EXPECT_THAT(traffic.needs(0), ElementsAre(0U));
  EXPECT_EQ(traffic.holder(0), 0U);
  traffic.cut_course(0, 0);
  traffic.update();
  EXPECT_EQ(traffic.holder(0), no_vehicle);
  traffic.extend_course(0, std::vector<zone::SectionId>{2});
  traffic.update();
  EXPECT_EQ(traffic.holder(0), 0U);
}

TEST_F(ForkTraffic, has_a_course_only_while_it_leads_over_the_vehicle_s_section) {
  traffic.set_course(0, zone::Course{{0, 2, 3}});
  EXPECT_TRUE(traffic.on_course(0));
  EXPECT_THAT(traffic.remaining(0), ElementsAre(2U, 3U));
  EXPECT_THAT(traffic.traversed(0), IsEmpty());
  put(0, {2, 0.5});
  EXPECT_THAT(traffic.remaining(0), ElementsAre(3U));
  EXPECT_THAT(traffic.traversed(0), ElementsAre(0U));
  put(0, {1, 0.5});
  EXPECT_FALSE(traffic.on_course(0));
  EXPECT_THAT(traffic.remaining(0), IsEmpty());
  EXPECT_THAT(traffic.traversed(0), IsEmpty());
  traffic.set_course(0, zone::Course{});
  EXPECT_FALSE(traffic.on_course(0));
  traffic.set_position(1, std::nullopt);
  traffic.set_course(1, zone::Course{{0, 2}});
  EXPECT_TRUE(traffic.on_course(1)) << "without a position";
}

/// A loop of six metres, shorter than the longest base that is not measured.
TEST(ShortLoop, is_driven_round_again_unless_the_end_of_the_base_was_passed) {
  const WaypointGraph map{std::make_shared<const zone::TrafficZone>(straight_zone(
      {{3.0, {1}}, {3.0, {0}}}, {{"A", {0, 0.5}}, {"B", {1, 0.5}}}, {{"x", {}, {{1, 0.8, 1.2}, {1, 1.3, 1.4}}}}))};
  Traffic traffic;
  traffic.set_map(&map);
  traffic.resize(1);
  traffic.set_position(0, zone::TrackPosition{0, 0.6});
  traffic.set_base_end(0, 0);
  traffic.update();
  EXPECT_NEAR(*traffic.base_left_m(0, {0, 0.6}), 5.9, 1e-9);
  EXPECT_EQ(traffic.holder(0), 0U);
  traffic.set_base_passed(0, true);
  traffic.update();
  EXPECT_EQ(traffic.base_left_m(0, {0, 0.6}), 0.0);
  EXPECT_EQ(traffic.holder(0), no_vehicle);
  traffic.set_base_end(0, 1);
  EXPECT_FALSE(traffic.base_passed(0)) << "another base";
  EXPECT_NEAR(*traffic.base_left_m(0, {0, 0.6}), 2.9, 1e-9);
}

/// A loop of four sections of 1 m, and a course round it.
class BeyondBase : public testing::Test {
 protected:
  BeyondBase() {
    traffic.set_map(&map);
    traffic.resize(1);
    traffic.set_position(0, zone::TrackPosition{0, 0.5});
    traffic.set_course(0, zone::Course{{0, 1, 2, 3}});
  }
  WaypointGraph map{std::make_shared<const zone::TrafficZone>(straight_zone(
      {{1.0, {1}}, {1.0, {2}}, {1.0, {3}}, {1.0, {0}}}, {{"A", {0, 0.75}}, {"B", {0, 0.9}}, {"C", {2, 0.5}}}))};
  Traffic traffic;
};

TEST_F(BeyondBase, are_the_sections_after_the_one_that_the_base_ends_on) {
  traffic.set_base_end(0, 2);
  const auto beyond = beyond_base(traffic, 0, {0, 0.5});
  EXPECT_EQ(beyond.keep, 2U);
  EXPECT_THAT(beyond.sections, ElementsAre(3U));
}

TEST_F(BeyondBase, are_all_remaining_sections_where_the_base_ends_on_the_present_one) {
  traffic.set_base_end(0, 0);
  for (const double s_m : {0.5, 0.75}) {
    const auto beyond = beyond_base(traffic, 0, {0, s_m});
    EXPECT_EQ(beyond.keep, 0U);
    EXPECT_THAT(beyond.sections, ElementsAre(1U, 2U, 3U));
  }
}

TEST_F(BeyondBase, begin_with_the_sections_that_the_vehicle_went_onto) {
  traffic.set_base_end(0, 1);
  traffic.set_position(0, zone::TrackPosition{1, 0.14});
  for (const bool passed : {false, true}) {
    traffic.set_base_passed(0, passed);
    const auto beyond = beyond_base(traffic, 0, {1, 0.14});
    EXPECT_EQ(beyond.keep, 0U);
    EXPECT_THAT(beyond.sections, ElementsAre(1U, 2U, 3U)) << passed;
  }
}

TEST_F(BeyondBase, are_none_where_the_vehicle_is_far_beyond_its_base) {
  traffic.set_base_end(0, 1);
  traffic.set_position(0, zone::TrackPosition{1, 0.16});
  for (const bool passed : {false, true}) {
    traffic.set_base_passed(0, passed);
    const auto beyond = beyond_base(traffic, 0, {1, 0.16});
    EXPECT_EQ(beyond.keep, 0U);
    EXPECT_THAT(beyond.sections, IsEmpty()) << passed;
  }
}

// ---- whole fleets ----

struct Fleet {
  explicit Fleet(std::size_t count, double loss = 0.0) {
    fixture.loss = loss;
    std::size_t number = 0;
    for (const zone::TrackPosition position : fixture.zone->start_positions(count))
      fixture.add("AIV" + std::to_string(++number), position);
    fixture.each_step = [this] {
      for (std::size_t i = 0; i < fixture.vehicles.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          if (touch(fixture.vehicles[i]->pose(), fixture.vehicles[j]->pose(), fixture.zone->vehicle)) ++touches;
    };
  }
  ServerFixture fixture{zone_file("lacet4.toml")};
  int touches{0};
};

TEST(Fleet, of_twelve_vehicles_circulates_without_contact_on_a_lossy_link) {
  Fleet fleet{12, 0.02};
  ASSERT_EQ(fleet.fixture.vehicles.size(), 12U);
  fleet.fixture.run_for(120s);
  EXPECT_EQ(fleet.touches, 0);
  for (const auto& aiv : fleet.fixture.vehicles) {
    EXPECT_THAT(aiv->refusals, IsEmpty()) << aiv->id.serial_number;
    EXPECT_GT(aiv->driven_m, 5.0) << aiv->id.serial_number;
  }
}

TEST(Fleet, waits_behind_a_vehicle_that_failed_on_a_loop_and_continues_when_it_returns) {
  Fleet fleet{4};
  fleet.fixture.run_for(10s);
  FixtureVehicle& dead = *fleet.fixture.vehicles[0];
  while (dead.track_position().section % 2 == 0) fleet.fixture.run_for(100ms);
  fleet.fixture.kill(dead);
  fleet.fixture.run_for(60s);
  EXPECT_EQ(fleet.touches, 0);
  dead.alive = true;
  dead.book.emplace(*fleet.fixture.zone);
  fleet.fixture.connection(dead, wire::ConnectionState::online);
  std::vector<double> driven;
  for (const auto& aiv : fleet.fixture.vehicles) driven.push_back(aiv->driven_m);
  fleet.fixture.run_for(40s);
  EXPECT_EQ(fleet.touches, 0);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_GT(fleet.fixture.vehicles[i]->driven_m, driven[i] + 3.0);
}

TEST(Fleet, continues_after_the_server_restarts_with_vehicles_in_the_crossings) {
  Fleet fleet{8, 0.02};
  for (int i = 0; i < 5; ++i) {
    fleet.fixture.run_for(8s);
    fleet.fixture.restart_server();
  }
  std::vector<double> driven;
  for (const auto& aiv : fleet.fixture.vehicles) driven.push_back(aiv->driven_m);
  fleet.fixture.run_for(60s);
  EXPECT_EQ(fleet.touches, 0);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_GT(fleet.fixture.vehicles[i]->driven_m, driven[i] + 3.0);
    EXPECT_THAT(fleet.fixture.vehicles[i]->refusals, IsEmpty());
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
