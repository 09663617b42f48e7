// Forks: their stretches, the leader of each vehicle, and the branch that a vehicle is sent along.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ranges>
#include <set>

#include "cosiva/base/test_paths.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::IsEmpty;
using testing::SizeIs;

class Fork : public testing::Test {
 protected:
  Fork() {
    traffic.set_map(&map);
    traffic.resize(3);
  }
  [[nodiscard]] zone::SectionId id(const std::string& name) const { return *map.circuit().find(name); }
  [[nodiscard]] std::vector<zone::SectionId> bypass() const {
    return {id("entry"), id("bypass1"), id("bypass2"), id("bypass3"), id("bypass4"), id("bypass5"), id("east")};
  }
  /// The last waypoint before the fork.
  [[nodiscard]] WaypointIndex before_fork() const { return map.behind({id("entry"), 1.0})->waypoint; }

  WaypointGraph map{zone::Rtm::initialise(fork())->shared_zone()};
  Traffic traffic;
};

TEST_F(Fork, has_a_stretch_for_each_branch_the_default_one_first) {
  const auto stretches = map.stretches(before_fork());
  ASSERT_THAT(stretches, SizeIs(2));
  EXPECT_EQ(stretches[0].sections.front(), id("south"));
  EXPECT_EQ(stretches[1].sections.front(), id("bypass1"));
  EXPECT_TRUE(stretches[0].crosses && stretches[1].crosses) << "bodies touch at a fork";
  EXPECT_NE(stretches[0].edge_id, stretches[1].edge_id);
  const auto route = bypass();
  EXPECT_EQ(map.along(before_fork(), std::span{route}.subspan(1)), &stretches[1]);
  EXPECT_EQ(map.along(before_fork(), {}), &stretches[0]);
}

TEST_F(Fork, finds_the_route_over_nodes_that_a_vehicle_reports) {
  const auto& stretch = map.stretches(before_fork())[1];
  const std::vector<std::string_view> ids{map.waypoint(before_fork()).id, map.waypoint(stretch.to).id};
  const auto route = map.through({id("entry"), map.waypoint(before_fork()).position.s_m - 0.3}, ids, 2);
  ASSERT_TRUE(route.has_value());
  EXPECT_EQ(route->end, stretch.to);
  EXPECT_THAT(route->sections, Contains(id("bypass1")));
  EXPECT_FALSE(map.through({id("north"), 0.1}, std::vector<std::string_view>{"nowhere"}, 1).has_value());
}

TEST_F(Fork, no_vehicle_is_ahead_on_the_other_branch_once_the_bodies_are_clear) {
  traffic.set_position(0, zone::TrackPosition{id("entry"), 0.5});
  traffic.set_course(0, zone::Course(bypass()));
  traffic.set_position(1, zone::TrackPosition{id("south"), 1.2});
  traffic.update();
  EXPECT_EQ(traffic.ahead(0).vehicle, no_vehicle);
  traffic.set_position(1, zone::TrackPosition{id("south"), 0.1});
  traffic.update();
  EXPECT_EQ(traffic.ahead(0).vehicle, 1U);
  EXPECT_NEAR(traffic.ahead(0).distance_m, 0.6, 1e-9);
  traffic.set_position(1, zone::TrackPosition{id("bypass3"), 0.5});
  traffic.update();
  EXPECT_EQ(traffic.ahead(0).vehicle, 1U) << "on its own branch";
}

TEST_F(Fork, crossings_are_found_along_the_course) {
  std::vector<CrossingIndex> straight;
  std::vector<CrossingIndex> round;
  map.crossings_on({id("entry"), 0.5}, 0.9, straight);
  const auto remaining = bypass();
  map.crossings_on({id("entry"), 0.5}, 0.9, round, Sections{remaining}.subspan(1));
  EXPECT_EQ(straight, round) << "the fork itself is one crossing";
  EXPECT_THAT(straight, Not(IsEmpty()));
}

TEST_F(Fork, leader_is_searched_as_far_as_a_base_is_to_reach) {
  traffic.set_position(0, zone::TrackPosition{id("entry"), 0.0});
  traffic.set_position(1, zone::TrackPosition{id("west"), 1.0});
  traffic.update();
  EXPECT_EQ(traffic.ahead(0).vehicle, no_vehicle) << "further than 6 m";
  EXPECT_EQ(traffic.ahead_within(0, 12.0).vehicle, 1U);
}

TEST(Missions, sent_back_from_the_goal_are_on_route_before_the_vehicle_has_turned) {
  // Two-way edges in a row, N0 to N4, 5 or 10 m each.
  std::ifstream file{source_dir() + "/src/zone/lif/testdata/10.11-multiple-edges-with-load-restrictions.lif.json"};
  std::stringstream text;
  text << file.rdbuf();
  ServerFixture fixture{{"lif", "lanes", text.str()}};
  FixtureVehicle& aiv = fixture.add("AIV1", {*fixture.zone->circuit.find("N2-N1"), 8.0});
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"N1"})");
  fixture.run_for(1s);
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"N1"})");
  fixture.run_for(10s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("mission")->text("state"), "arrived");
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"N2"})");
  aiv.blocked = true;
  fixture.run_for(3s);
  aiv.blocked = false;
  fixture.run_for(45s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("mission")->text("state"), "arrived");
  EXPECT_EQ(aiv.zone().circuit.part(aiv.track_position().section).name, "N1-N2");
  EXPECT_THAT(aiv.refusals, IsEmpty());
  for (const wire::InstantActions& message : aiv.actions)
    for (const wire::Action& action : message.actions) EXPECT_NE(action.action_type, "cancelOrder");
}

TEST(Twins, follow_the_branch_that_their_vehicle_takes) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"dock"})");
  fixture.run_for(300ms);
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"dock"})");
  double worst_m = 0.0;
  fixture.each_step = [&] {
    const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
    if (shown.find("x") == nullptr) return;
    worst_m = std::max(worst_m, distance(Point2{*shown.number("x"), *shown.number("y")}, position(aiv.pose())));
  };
  fixture.run_for(12s);
  EXPECT_EQ(fixture.zone->circuit.part(aiv.track_position().section).name, "bypass3");
  EXPECT_LT(worst_m, 0.05);
}

}  // namespace
}  // namespace cosiva::virtual_side
