#include "cosiva/virtual/server/missions/missions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/missions/mission.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string go(const std::string& to, const std::string& vehicle = "CoSiVA/AIV1") {
  return R"({"command":"go","vehicle":")" + vehicle + R"(","to":")" + to + "\"}";
}
std::string on_section(const std::string& command, const std::string& section) {
  return R"({"command":")" + command + R"(","section":")" + section + "\"}";
}
std::string state_of(const ServerFixture& fixture, const std::string& name = "CoSiVA/AIV1") {
  const JsonValue aiv = fixture.aiv(name);
  return aiv.find("mission")->text("state").value_or("?");
}
std::string section_of(const ServerFixture& fixture, const FixtureVehicle& aiv) {
  return fixture.zone->circuit.part(aiv.track_position().section).name;
}

TEST(Missions, bring_a_vehicle_to_a_station_where_it_stays_until_the_next_command) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  fixture.run_for(300ms);
  fixture.send_command(go("dock"));
  fixture.run_for(20s);
  EXPECT_EQ(section_of(fixture, aiv), "bypass3");
  EXPECT_NEAR(aiv.track_position().s_m, 0.5, 0.02);
  EXPECT_EQ(state_of(fixture), "arrived");
  ASSERT_FALSE(aiv.orders.empty());
  EXPECT_TRUE(aiv.orders.back().nodes.back().released) << "no horizon beyond the goal";
  const double driven_m = aiv.driven_m;
  fixture.run_for(10s);
  EXPECT_EQ(aiv.driven_m, driven_m);
  fixture.send_command(R"({"command":"circulate","vehicle":"*"})");
  fixture.run_for(10s);
  EXPECT_GT(aiv.driven_m, driven_m + 2.0);
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

/// A vehicle with a mission to the dock, which is 0.5 m along bypass3.
struct RollsPast : ::testing::Test {
  void go_and_roll_on(double past_m) {
    fixture.run_for(300ms);
    fixture.send_command(go("dock"));
    fixture.run_for(300ms);
    aiv.rolls_on_m = past_m;
    for (int i = 0; i < 1000 && aiv.rolls_on_m > 0.0; ++i) fixture.run_for(20ms);
    EXPECT_EQ(section_of(fixture, aiv), "bypass3");
    EXPECT_NEAR(aiv.track_position().s_m, 0.5 + past_m, 0.02);
  }
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.1})};
};

TEST_F(RollsPast, and_drives_to_its_goal_again) {
  go_and_roll_on(0.15);
  EXPECT_EQ(state_of(fixture), "driving");
  fixture.run_for(60s);
  EXPECT_GT(aiv.driven_m, 10.0) << "one lap, as the vehicle cannot return directly";
  EXPECT_EQ(state_of(fixture), "arrived");
  EXPECT_NEAR(aiv.track_position().s_m, 0.5, 0.02);
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST_F(RollsPast, and_has_arrived_within_the_deviation_that_its_order_allows) {
  go_and_roll_on(0.09);
  EXPECT_EQ(state_of(fixture), "driving") << "it has not stopped yet";
  fixture.run_for(1s);
  EXPECT_EQ(state_of(fixture), "arrived");
  EXPECT_EQ(aiv.orders.back().nodes.back().position->allowed_deviation_xy_m, 0.1);
}

TEST(Missions, accept_a_waypoint_as_goal) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  fixture.run_for(300ms);
  const zone::Waypoint& goal = fixture.zone->waypoints[fixture.zone->waypoint_behind({3, 2.0})];
  fixture.send_command(go(goal.id));
  fixture.run_for(40s);
  EXPECT_EQ(aiv.track_position().section, goal.position.section);
  EXPECT_NEAR(aiv.track_position().s_m, goal.position.s_m, 0.02);
  EXPECT_EQ(state_of(fixture), "arrived");
}

TEST(Missions, circulate_on_the_zone_s_first_loop_by_default_and_on_a_named_one_on_command) {
  const std::string loops =
      "[[loop]]\nname = \"long\"\nsections = [\"entry\", \"bypass1\", \"bypass2\", \"bypass3\", \"bypass4\", "
      "\"bypass5\","
      " \"east\", \"north\", \"west\"]\n"
      "[[loop]]\nname = \"short\"\nsections = [\"entry\", \"south\", \"east\", \"north\", \"west\"]\n";
  ServerFixture fixture{fork(loops)};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  std::set<std::string> detected;
  fixture.each_step = [&] { detected.insert(section_of(fixture, aiv)); };
  fixture.run_for(70s);
  EXPECT_TRUE(detected.contains("bypass3"));
  EXPECT_FALSE(detected.contains("south"));
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("mission")->text("loop"), "long");
  fixture.send_command(R"({"command":"circulate","vehicle":"CoSiVA/AIV1","loop":"short"})");
  fixture.run_for(45s);
  detected.clear();
  fixture.run_for(70s);
  EXPECT_TRUE(detected.contains("south"));
  EXPECT_FALSE(detected.contains("bypass3"));
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST(ClosedSections, are_avoided_by_all_vehicles_at_once_and_used_again_when_open) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {3, 0.1});
  fixture.run_for(1s);
  fixture.send_command(on_section("close", "south"));
  fixture.send_command(on_section("close", "bypass1"));
  EXPECT_THAT(*fixture.snapshot().find("zone")->find("closed")->array(), SizeIs(2));
  fixture.run_for(60s);
  EXPECT_EQ(section_of(fixture, aiv), "entry") << "it is stopped at the end of the open sections";
  EXPECT_EQ(state_of(fixture), "no route");
  EXPECT_THAT(fixture.aiv("CoSiVA/AIV1").find("mission")->text("why").value_or(""), HasSubstr("closed"));
  fixture.send_command(on_section("open", "bypass1"));
  fixture.run_for(5s);
  EXPECT_THAT(section_of(fixture, aiv), HasSubstr("bypass"));
  std::set<std::string> detected;
  fixture.each_step = [&] { detected.insert(section_of(fixture, aiv)); };
  fixture.run_for(70s);
  EXPECT_FALSE(detected.contains("south"));
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST(ClosedSections, are_left_by_a_vehicle_on_one_and_not_entered_by_a_base_already_released) {
  ServerFixture fixture{fork()};
  FixtureVehicle& inside = fixture.add("AIV1", {1, 1.2});
  FixtureVehicle& before = fixture.add("AIV2", {0, 0.3});
  // Both vehicles drive until the fork is within the base of the second one.
  fixture.run_for(300ms);
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV2","to":"gate"})");
  for (int i = 0; i < 100 && before.book->targets().empty(); ++i) fixture.run_for(20ms);
  fixture.run_for(1s);
  fixture.send_command(on_section("close", "south"));
  std::set<std::string> detected;
  const bool was_before = section_of(fixture, before) == "entry";
  fixture.each_step = [&] { detected.insert(section_of(fixture, before)); };
  fixture.run_for(60s);
  EXPECT_NE(section_of(fixture, inside), "south");
  EXPECT_TRUE(was_before);
  EXPECT_FALSE(detected.contains("south"));
  EXPECT_TRUE(detected.contains("bypass3"));
  EXPECT_EQ(state_of(fixture, "CoSiVA/AIV2"), "arrived");
}

TEST(ClosedSections, are_taken_from_the_configuration) {
  ServerFixture fixture{fork("[closed]\nsections = [\"bypass3\"]\n")};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  fixture.run_for(300ms);
  fixture.send_command(go("dock"));
  fixture.run_for(20s);
  EXPECT_EQ(state_of(fixture), "no route");
  EXPECT_THAT(fixture.aiv("CoSiVA/AIV1").find("mission")->text("why").value_or(""), HasSubstr("bypass3"));
  EXPECT_NE(section_of(fixture, aiv), "bypass3");
}

TEST(Missions, wait_before_an_occupied_goal_and_report_the_other_vehicle) {
  ServerFixture fixture{fork()};
  fixture.add("AIV1", {0, 0.8});
  FixtureVehicle& second = fixture.add("AIV2", {0, 0.1});
  fixture.run_for(300ms);
  fixture.send_command(go("gate"));
  fixture.run_for(25s);
  ASSERT_EQ(state_of(fixture), "arrived");
  fixture.send_command(go("gate", "CoSiVA/AIV2"));
  fixture.run_for(40s);
  EXPECT_EQ(state_of(fixture, "CoSiVA/AIV2"), "driving");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").find("mission")->text("why"), "CoSiVA/AIV1 is stopped at gate");
  EXPECT_EQ(fixture.touches(), 0);
  fixture.send_command(R"({"command":"circulate","vehicle":"CoSiVA/AIV1"})");
  fixture.run_for(15s);
  EXPECT_EQ(state_of(fixture, "CoSiVA/AIV2"), "arrived");
  EXPECT_THAT(second.refusals, IsEmpty());
}

TEST(Missions, and_closed_sections_persist_over_a_restart_of_the_server) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {3, 0.1});
  fixture.run_for(500ms);
  fixture.send_command(go("dock"));
  fixture.send_command(on_section("close", "south"));
  fixture.run_for(3s);
  fixture.restart_server(true);
  EXPECT_THAT(*fixture.snapshot().find("zone")->find("closed")->array(), SizeIs(1));
  fixture.run_for(45s);
  EXPECT_EQ(section_of(fixture, aiv), "bypass3");
  EXPECT_EQ(state_of(fixture), "arrived");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("mission")->text("to"), "dock");
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

const std::string round_loop =
    "[[loop]]\nname = \"round\"\nsections = [\"entry\", \"south\", \"east\", \"north\", \"west\"]\n";

/// One straight section that leads nowhere.
zone::ZoneConfiguration dead_end() {
  return {"toml", "track", R"(
name = "track"
format_version = 1
[vehicle]
length_m = 0.20
width_m = 0.12
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
closed = false
[[section]]
name = "track"
kind = "straight"
length_m = 4.0
)"};
}

/// One vehicle, CoSiVA/AIV1, whose routes are planned without a server.
class Planned : public testing::Test {
 protected:
  using Route = std::optional<std::vector<zone::SectionId>>;
  explicit Planned(const zone::ZoneConfiguration& configuration = fork()) : orders{configuration} {
    orders.add("AIV1");
  }
  Route plan(const std::vector<zone::TrackPosition>& starts) { return orders.missions.plan(0, starts); }
  [[nodiscard]] std::vector<zone::SectionId> ids(const std::vector<std::string>& names) const {
    std::vector<zone::SectionId> found;
    for (const std::string& name : names) found.push_back(orders.section(name));
    return found;
  }
  [[nodiscard]] std::string json(std::string_view waits_for = "") const {
    JsonWriter text;
    orders.missions.write(text, 0, waits_for);
    return text.text();
  }
  [[nodiscard]] std::string digest() const {
    Digest digest;
    orders.missions.fold(digest);
    return digest.hex();
  }
  [[nodiscard]] Point2 goal_point() const { return orders.map->point(orders.missions.goal(0)); }
  void go(const std::string& to, const std::string& beyond = "") {
    orders.missions.give(0, {Mission::Kind::go, to, beyond});
  }
  OrdersFixture orders;
};

TEST_F(Planned, route_to_a_goal_is_the_fastest_one_and_complete) {
  go("gate");
  EXPECT_EQ(plan({orders.at("entry", 0.3)}), ids({"entry", "south", "east", "north"}));
  EXPECT_TRUE(orders.missions.complete(0));
  EXPECT_EQ(orders.map->waypoint(orders.missions.goal(0)).position.section, orders.section("north"));
  EXPECT_THAT(orders.missions.more(0, orders.section("north")), IsEmpty()) << "it ends at its goal";
  orders.missions.set_closed(ids({"south"}));
  EXPECT_EQ(plan({orders.at("entry", 0.3)}),
            ids({"entry", "bypass1", "bypass2", "bypass3", "bypass4", "bypass5", "east", "north"}));
}

TEST_F(Planned, route_begins_at_the_start_from_which_it_is_the_fastest) {
  go("dock");
  const std::vector<zone::TrackPosition> starts{orders.at("south", 0.0), orders.at("bypass1", 0.0)};
  EXPECT_EQ(plan(starts), ids({"bypass1", "bypass2", "bypass3"}));
  EXPECT_EQ(plan({starts[1], starts[0]}), ids({"bypass1", "bypass2", "bypass3"}));
  EXPECT_NEAR(orders.map->waypoint(orders.missions.goal(0)).position.s_m, 0.5, 0.02);
}

TEST_F(Planned, route_that_does_not_exist_is_reported_with_its_reason) {
  orders.missions.set_closed(ids({"south", "bypass1"}));
  go("gate");
  EXPECT_EQ(plan({orders.at("entry", 0.3)}), std::nullopt);
  EXPECT_EQ(orders.missions.state(0), Missions::State::no_route);
  EXPECT_TRUE(orders.missions.complete(0));
  const std::string why = *JsonValue::parse(json())->text("why");
  EXPECT_THAT(why, HasSubstr("closed"));
  EXPECT_EQ(orders.logs().back(), "w CoSiVA/AIV1: no route: " + why);
  orders.missions.set_closed({});
  EXPECT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  EXPECT_EQ(json(), R"({"kind":"go","to":"gate","state":"driving","why":null})");
}

TEST_F(Planned, roaming_vehicle_takes_the_branches_in_turn_and_plans_one_section_at_a_time) {
  EXPECT_EQ(plan({orders.at("west", 0.3)}), ids({"west"}));
  EXPECT_FALSE(orders.missions.complete(0));
  EXPECT_EQ(orders.missions.goal(0), no_waypoint);
  const zone::SectionId entry = orders.section("entry");
  EXPECT_EQ(orders.missions.more(0, entry), ids({"south"}));
  EXPECT_EQ(orders.missions.more(0, orders.section("south")), ids({"east"}));
  EXPECT_EQ(orders.missions.more(0, entry), ids({"bypass1"}));
  EXPECT_EQ(orders.missions.more(0, entry), ids({"south"}));
  const std::vector<zone::TrackPosition> starts{orders.at("south", 0.0), orders.at("bypass1", 0.0)};
  EXPECT_EQ(plan(starts), ids({"bypass1"})) << "taken less recently";
  EXPECT_EQ(json(), R"({"kind":"circulate","loop":null,"state":"driving","why":null})");
}

TEST_F(Planned, roaming_vehicle_stops_before_closed_sections) {
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  orders.missions.set_closed(ids({"south", "bypass1"}));
  EXPECT_THAT(orders.missions.more(0, orders.section("entry")), IsEmpty());
  EXPECT_TRUE(orders.missions.complete(0));
  EXPECT_EQ(json(),
            R"({"kind":"circulate","loop":null,"state":"no route","why":"every section after 'entry' is closed"})");
  EXPECT_EQ(plan({orders.at("south", 0.0), orders.at("bypass1", 0.0)}), ids({"south"})) << "it is there already";
}

TEST_F(Planned, roaming_vehicle_avoids_sections_until_it_need_not) {
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  const std::uint64_t before = orders.missions.revision(0);
  orders.missions.avoid(0, ids({"south"}));
  EXPECT_EQ(orders.missions.revision(0), before + 1);
  orders.missions.avoid(0, ids({"south"}));
  EXPECT_EQ(orders.missions.revision(0), before + 1) << "nothing has changed";
  const zone::SectionId entry = orders.section("entry");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(orders.missions.more(0, entry), ids({"bypass1"}));
  EXPECT_EQ(plan({orders.at("south", 0.0), orders.at("bypass1", 0.0)}), ids({"bypass1"}));
  orders.missions.need_not_avoid(0);
  EXPECT_EQ(orders.missions.more(0, entry), ids({"south"}));
}

TEST_F(Planned, mission_ends_what_the_previous_one_avoided) {
  orders.missions.avoid(0, ids({"south"}));
  orders.proxy(0).settings.on_cancel();
  const std::uint64_t before = orders.missions.revision(0);
  go("gate");
  EXPECT_EQ(orders.missions.revision(0), before + 1);
  EXPECT_EQ(plan({orders.at("entry", 0.3)}), ids({"entry", "south", "east", "north"}));
  EXPECT_FALSE(orders.proxy(0).settings.no_orders()) << "a new mission ends a cancellation";
}

TEST_F(Planned, detour_exists_where_another_route_leads_to_the_goal) {
  const auto has_detour = [&](const std::string& from, const std::vector<std::string>& around) {
    return orders.missions.has_detour(0, orders.at(from, 0.2), ids(around));
  };
  EXPECT_TRUE(has_detour("entry", {"south"})) << "it can go on for ever on the bypass";
  EXPECT_FALSE(has_detour("entry", {"east"}));
  EXPECT_FALSE(has_detour("entry", {"south", "bypass1"}));
  go("gate");
  EXPECT_TRUE(has_detour("entry", {"south"}));
  EXPECT_FALSE(has_detour("entry", {"east"}));
  EXPECT_TRUE(has_detour("east", {"south", "bypass1"})) << "the gate comes first";
  orders.missions.set_closed(ids({"bypass3"}));
  EXPECT_FALSE(has_detour("entry", {"south"}));
}

TEST_F(Planned, vehicle_is_at_its_goal_within_the_given_distance) {
  go("gate");
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  const Point2 goal = goal_point();
  EXPECT_TRUE(orders.missions.is_at(0, goal, 0.0));
  EXPECT_TRUE(orders.missions.is_at(0, {goal.x_m + 0.05, goal.y_m}, 0.0501));
  EXPECT_FALSE(orders.missions.is_at(0, {goal.x_m + 0.05, goal.y_m}, 0.0499));
  EXPECT_FALSE(orders.missions.is_stopped_at(0, {goal.x_m + 0.05, goal.y_m}, 0.04));
  EXPECT_EQ(orders.missions.state(0), Missions::State::driving);
  EXPECT_TRUE(orders.missions.is_stopped_at(0, {goal.x_m + 0.03, goal.y_m}, 0.04));
  EXPECT_EQ(orders.missions.state(0), Missions::State::arrived);
  EXPECT_TRUE(orders.missions.is_at(0, {0.0, 0.0}, 0.0)) << "a vehicle that has arrived stays";
  EXPECT_TRUE(orders.missions.is_stopped_at(0, goal, 0.0));
  EXPECT_THAT(orders.logs(), testing::ElementsAre("i CoSiVA/AIV1: arrived at gate")) << "logged once";
  EXPECT_TRUE(orders.missions.complete(0));
  orders.missions.give(0, {});
  EXPECT_FALSE(orders.missions.is_at(0, goal, 1.0)) << "a vehicle that circulates has no goal";
}

TEST_F(Planned, vehicle_that_arrives_clears_the_reason_for_which_it_had_no_route) {
  go("gate");
  orders.missions.set_closed(ids({"south", "bypass1"}));
  ASSERT_FALSE(plan({orders.at("entry", 0.3)}).has_value());
  const WaypointIndex gate = goals_of(*orders.map, "gate").front();
  EXPECT_TRUE(orders.missions.is_stopped_at(0, orders.map->point(gate), 0.01));
  EXPECT_EQ(json(), R"({"kind":"go","to":"gate","state":"arrived","why":null})");
}

TEST_F(Planned, mission_states_which_vehicle_occupies_its_goal) {
  go("gate");
  EXPECT_EQ(json("CoSiVA/AIV2"),
            R"({"kind":"go","to":"gate","state":"driving","why":"CoSiVA/AIV2 is stopped at gate"})");
  orders.missions.give(0, {});
  EXPECT_EQ(json("CoSiVA/AIV2"), R"({"kind":"circulate","loop":null,"state":"driving","why":null})");
}

TEST_F(Planned, mission_beyond_the_control_area_ends_in_the_other_area) {
  go("gate", "area_b/rack");
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  EXPECT_EQ(json(), R"({"kind":"go","to":"area_b/rack","state":"driving","why":null})");
  EXPECT_TRUE(orders.missions.is_stopped_at(0, goal_point(), 0.01));
  EXPECT_THAT(orders.logs(), testing::ElementsAre("i CoSiVA/AIV1: arrived at gate, continuing to area_b/rack"));
  EXPECT_EQ(json(), R"({"kind":"go","to":"area_b/rack","state":"driving",)"
                    R"("why":"waits at gate for the server of the other control area"})");
}

TEST_F(Planned, zone_without_the_goal_gives_the_vehicle_its_default_mission) {
  orders.add("AIV2");
  go("gate");
  orders.missions.give(1, {Mission::Kind::circulate, "round"});
  const std::uint64_t before = orders.missions.revision(0);
  const WaypointGraph other{zone::Rtm::initialise(oval())->shared_zone()};
  orders.missions.set_map(&other);
  EXPECT_EQ(orders.missions.mission(0), Mission{});
  EXPECT_EQ(orders.missions.mission(1), Mission{});
  EXPECT_GT(orders.missions.revision(0), before);
  EXPECT_THAT(orders.logs(),
              testing::ElementsAre("w CoSiVA/AIV1: this zone has no 'gate'; it follows its default mission",
                                   "w CoSiVA/AIV2: this zone has no 'round'; it follows its default mission"));
}

TEST_F(Planned, zone_with_the_goal_keeps_the_mission_but_not_the_arrival) {
  go("gate");
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  ASSERT_TRUE(orders.missions.is_stopped_at(0, goal_point(), 0.01));
  orders.missions.avoid(0, ids({"south"}));
  orders.missions.set_map(&*orders.map, ids({"bypass1"}));
  EXPECT_EQ(orders.missions.mission(0).name, "gate");
  EXPECT_EQ(orders.missions.state(0), Missions::State::driving);
  EXPECT_FALSE(orders.missions.complete(0));
  EXPECT_EQ(orders.missions.goal(0), no_waypoint);
  EXPECT_EQ(orders.missions.closed().all(), ids({"bypass1"}));
  EXPECT_EQ(plan({orders.at("entry", 0.3)}), ids({"entry", "south", "east", "north"})) << "nothing is avoided any more";
}

TEST_F(Planned, zone_that_closes_other_sections_replaces_what_operators_have_closed) {
  const std::uint64_t before = orders.missions.revision(0);
  orders.missions.set_closed(ids({"south"}));
  orders.missions.renew();
  EXPECT_EQ(orders.missions.closed().all(), ids({"south"})) << "the configuration closes the same sections as before";
  EXPECT_EQ(orders.missions.revision(0), before + 1);
  zone::TrafficZone zone = orders.map->zone();
  zone.closed = ids({"bypass3"});
  ASSERT_TRUE(orders.map->take(std::make_shared<const zone::TrafficZone>(zone)));
  orders.missions.renew();
  EXPECT_EQ(orders.missions.closed().all(), ids({"bypass3"}));
  EXPECT_EQ(orders.missions.revision(0), before + 2);
}

TEST_F(Planned, digest_depends_on_missions_states_and_closed_sections) {
  const std::string initial = digest();
  orders.add("AIV2");
  EXPECT_EQ(digest(), initial) << "a vehicle without a mission adds nothing";
  go("gate");
  const std::string with_mission = digest();
  EXPECT_NE(with_mission, initial);
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  EXPECT_EQ(digest(), with_mission);
  orders.missions.is_stopped_at(0, goal_point(), 0.01);
  const std::string arrived = digest();
  EXPECT_NE(arrived, with_mission);
  orders.missions.set_closed(ids({"south"}));
  EXPECT_NE(digest(), arrived);
  orders.missions.give(0, {});
  orders.missions.set_closed({});
  EXPECT_EQ(digest(), initial);
  orders.missions.set_closed(ids({"south", "bypass1"}));
  const std::string closed = digest();
  ASSERT_TRUE(plan({orders.at("entry", 0.3)}).has_value());
  EXPECT_EQ(digest(), closed);
  (void)orders.missions.more(0, orders.section("entry"));
  EXPECT_NE(digest(), closed) << "it has no route";
}

TEST_F(Planned, mission_of_a_vehicle_that_was_removed_is_forgotten) {
  go("gate");
  orders.missions.forget(0);
  EXPECT_EQ(orders.missions.mission(0), Mission{});
}

class PlannedOnLoop : public Planned {
 protected:
  PlannedOnLoop() : Planned{fork(round_loop)} {}
};

TEST_F(PlannedOnLoop, route_leads_onto_the_loop_and_lap_after_lap) {
  const Route route = plan({orders.at("bypass3", 0.3)});
  ASSERT_TRUE(route.has_value());
  EXPECT_EQ(route->front(), orders.section("bypass3"));
  EXPECT_FALSE(orders.missions.complete(0));
  EXPECT_THAT(*route, testing::Not(testing::Contains(orders.section("bypass1"))));
  EXPECT_EQ(json(), R"({"kind":"circulate","loop":"round","state":"driving","why":null})");
  std::vector<zone::SectionId> driven{orders.section("west")};
  for (int i = 0; i < 12; ++i) {
    const auto more = orders.missions.more(0, driven.back());
    ASSERT_THAT(more, testing::Not(IsEmpty()));
    driven.insert(driven.end(), more.begin(), more.end());
  }
  for (std::size_t i = 0; i + 1 < driven.size(); ++i) EXPECT_EQ(driven[i + 1], (driven[i] + 1) % 5) << i;
}

TEST_F(PlannedOnLoop, detour_leads_back_onto_the_loop) {
  EXPECT_FALSE(orders.missions.has_detour(0, orders.at("entry", 0.2), ids({"east"})));
  EXPECT_TRUE(orders.missions.has_detour(0, orders.at("entry", 0.2), ids({"south"})));
}

TEST_F(PlannedOnLoop, vehicle_stops_where_the_loop_is_closed) {
  ASSERT_TRUE(plan({orders.at("west", 0.3)}).has_value());
  orders.missions.set_closed(ids({"entry"}));
  EXPECT_THAT(orders.missions.more(0, orders.section("west")), IsEmpty());
  EXPECT_EQ(orders.missions.state(0), Missions::State::no_route);
  EXPECT_TRUE(orders.missions.complete(0));
}

TEST(Missions, end_where_the_path_ends) {
  OrdersFixture orders{dead_end()};
  orders.add("AIV1");
  EXPECT_THAT(orders.missions.plan(0, std::vector{orders.at("track", 1.0)}), testing::Optional(SizeIs(1)));
  EXPECT_THAT(orders.missions.more(0, 0), IsEmpty());
  JsonWriter json;
  orders.missions.write(json, 0, "");
  EXPECT_EQ(json.text(), R"({"kind":"circulate","loop":null,"state":"no route","why":"the path ends with 'track'"})");
  EXPECT_FALSE(orders.missions.has_detour(0, orders.at("track", 1.0), {}));
}

TEST_F(Planned, mission_given_after_one_without_a_route_has_no_reason_any_more) {
  orders.missions.set_closed(ids({"south", "bypass1"}));
  go("gate");
  ASSERT_FALSE(plan({orders.at("entry", 0.3)}).has_value());
  go("dock");
  EXPECT_EQ(json(), R"({"kind":"go","to":"dock","state":"driving","why":null})");
}

TEST_F(Planned, route_to_a_goal_leads_around_what_the_vehicle_avoids) {
  go("gate");
  orders.missions.avoid(0, ids({"south"}));
  EXPECT_EQ(plan({orders.at("entry", 0.3)}),
            ids({"entry", "bypass1", "bypass2", "bypass3", "bypass4", "bypass5", "east", "north"}));
  orders.missions.set_closed(ids({"bypass3"}));
  EXPECT_EQ(plan({orders.at("entry", 0.3)}), std::nullopt) << "it is closed for this vehicle";
}

TEST_F(PlannedOnLoop, route_leads_around_what_the_vehicle_avoids) {
  orders.missions.avoid(0, ids({"south"}));
  EXPECT_EQ(plan({orders.at("entry", 0.3)}),
            ids({"entry", "bypass1", "bypass2", "bypass3", "bypass4", "bypass5", "east", "north", "west"}));
  EXPECT_EQ(orders.missions.more(0, orders.section("west")),
            ids({"entry", "bypass1", "bypass2", "bypass3", "bypass4", "bypass5", "east", "north"}));
  orders.missions.need_not_avoid(0);
  EXPECT_EQ(orders.missions.more(0, orders.section("west")), ids({"entry", "south", "east", "north"}));
}

TEST_F(PlannedOnLoop, mission_names_no_loop_while_there_is_no_zone) {
  EXPECT_EQ(json(), R"({"kind":"circulate","loop":"round","state":"driving","why":null})");
  orders.missions.set_map(nullptr);
  EXPECT_EQ(json(), R"({"kind":"circulate","loop":null,"state":"driving","why":null})");
}

TEST_F(Planned, loop_that_does_not_lead_back_to_itself_ends) {
  zone::TrafficZone zone = orders.map->zone();
  zone.loops = {zone::Loop{"stub", ids({"south"})}};
  const WaypointGraph with_stub{std::make_shared<const zone::TrafficZone>(std::move(zone))};
  orders.missions.set_map(&with_stub);
  orders.missions.give(0, {Mission::Kind::circulate, "stub"});
  EXPECT_EQ(plan({orders.at("south", 0.3)}), ids({"south"}));
  EXPECT_FALSE(orders.missions.complete(0));
  EXPECT_THAT(orders.missions.more(0, orders.section("south")), IsEmpty());
  EXPECT_TRUE(orders.missions.complete(0));
  EXPECT_EQ(json(), R"({"kind":"circulate","loop":"stub","state":"no route","why":"the loop ends here"})");
}

TEST(MissionOnOneSection, leads_along_it_again_and_again_until_it_is_closed) {
  OrdersFixture orders{{"toml", "circle",
                        "name = \"circle\"\nformat_version = 1\n[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n"
                        "[circuit]\nname = \"turn\"\nstart = { x = 0.0, y = 0.0, heading_deg = 0 }\nclosed = true\n"
                        "[[section]]\nname = \"whole\"\nkind = \"arc\"\nradius_m = 1.0\nangle_deg = 360\n"}};
  orders.add("AIV1");
  const std::vector<zone::SectionId> whole{orders.section("whole")};
  ASSERT_NE(loop_of(*orders.map, orders.missions.mission(0)), nullptr);
  EXPECT_EQ(orders.missions.plan(0, std::vector{orders.at("whole", 1.0)}), whole);
  for (int lap = 0; lap < 3; ++lap) EXPECT_EQ(orders.missions.more(0, whole.front()), whole);
  orders.missions.set_closed(whole);
  EXPECT_THAT(orders.missions.more(0, whole.front()), IsEmpty());
  EXPECT_EQ(orders.missions.state(0), Missions::State::no_route);
}

TEST_F(Planned, mission_restored_after_a_restart_is_planned_anew) {
  const std::uint64_t before = orders.missions.revision(0);
  orders.proxy(0).settings.on_cancel();
  orders.missions.restore(0, {Mission::Kind::go, "dock"});
  EXPECT_EQ(orders.missions.revision(0), before + 1);
  EXPECT_EQ(orders.missions.mission(0), (Mission{Mission::Kind::go, "dock"}));
  EXPECT_TRUE(orders.proxy(0).settings.no_orders()) << "an operator's cancellation is still valid";
}

}  // namespace
}  // namespace cosiva::virtual_side
