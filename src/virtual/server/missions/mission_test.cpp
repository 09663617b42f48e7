#include "cosiva/virtual/server/missions/mission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;

/// The fork zone with its station "gate" at another position of the north side, which has waypoints at least 0.1 m
/// apart.
class Goals : public testing::Test {
 protected:
  [[nodiscard]] WaypointIndex on_north(std::size_t number) const {
    const auto first = std::ranges::find(zone.waypoints, *zone.circuit.find("north"),
                                         [](const zone::Waypoint& waypoint) { return waypoint.position.section; });
    return static_cast<WaypointIndex>(first - zone.waypoints.begin()) + static_cast<WaypointIndex>(number);
  }
  [[nodiscard]] double s_m(WaypointIndex index) const { return zone.waypoints[index].position.s_m; }
  [[nodiscard]] std::vector<WaypointIndex> with_gate_at(double gate_m) {
    std::ranges::find(zone.stations, "gate", &zone::Station::name)->position.s_m = gate_m;
    return goals_of(WaypointGraph{std::make_shared<const zone::TrafficZone>(zone)}, "gate");
  }
  zone::TrafficZone zone{*zone::Rtm::initialise(fork())->shared_zone()};
};

TEST_F(Goals, of_a_station_are_the_waypoint_that_its_position_was_rounded_to) {
  const WaypointIndex waypoint = on_north(2);
  EXPECT_THAT(with_gate_at(s_m(waypoint)), ElementsAre(waypoint));
  EXPECT_THAT(with_gate_at(s_m(waypoint) + 0.0199), ElementsAre(waypoint));
  EXPECT_THAT(with_gate_at(s_m(waypoint) - 0.0199), ElementsAre(waypoint));
  EXPECT_THAT(with_gate_at(s_m(waypoint) + 0.0201), IsEmpty());
  EXPECT_THAT(with_gate_at(s_m(waypoint) - 0.0201), IsEmpty());
}

TEST_F(Goals, of_a_station_between_two_waypoints_are_the_nearer_one) {
  const WaypointIndex first = on_north(2);
  zone::Waypoint close = zone.waypoints[first + 1];
  close.position.s_m = s_m(first) + 0.03;
  zone.waypoints.replace(first + 1, close);
  EXPECT_THAT(with_gate_at(s_m(first) + 0.014), ElementsAre(first));
  EXPECT_THAT(with_gate_at(s_m(first) + 0.016), ElementsAre(first + 1));
}

TEST_F(Goals, of_a_node_are_its_waypoints_on_all_sections) {
  const WaypointIndex second = on_north(1);
  zone::Waypoint same_node = zone.waypoints[second];
  same_node.id = zone.waypoints[0].id;
  zone.waypoints.replace(second, same_node);
  const WaypointGraph map{std::make_shared<const zone::TrafficZone>(zone)};
  EXPECT_THAT(goals_of(map, zone.waypoints[0].id), ElementsAre(0U, second));
  EXPECT_THAT(goals_of(map, "nowhere"), IsEmpty());
}

TEST(LoopOf, a_mission_without_a_name_is_the_first_loop_of_the_zone) {
  const std::string loops =
      "[[loop]]\nname = \"wide\"\nsections = [\"entry\", \"south\", \"east\", \"north\", \"west\"]\n"
      "[[loop]]\nname = \"narrow\"\nsections = [\"entry\", \"bypass1\", \"bypass2\", \"bypass3\", \"bypass4\", "
      "\"bypass5\", \"east\", \"north\", \"west\"]\n";
  const WaypointGraph map{zone::Rtm::initialise(fork(loops))->shared_zone()};
  EXPECT_EQ(loop_of(map, {}), &map.zone().loops[0]);
  EXPECT_EQ(loop_of(map, {Mission::Kind::circulate, "narrow"}), &map.zone().loops[1]);
  EXPECT_EQ(loop_of(map, {Mission::Kind::circulate, "other"}), nullptr);
  const WaypointGraph without{zone::Rtm::initialise(fork())->shared_zone()};
  EXPECT_EQ(loop_of(without, {}), nullptr);
}

}  // namespace
}  // namespace cosiva::virtual_side
