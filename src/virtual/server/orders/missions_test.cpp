#include "cosiva/virtual/server/orders/missions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
std::string on_section(const std::string& verb, const std::string& section) {
  return R"({"command":")" + verb + R"(","section":")" + section + "\"}";
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

TEST(Missions, are_refused_with_a_message_that_lists_similar_names) {
  ServerFixture fixture{fork()};
  fixture.add("AIV1", {0, 0.1});
  fixture.run_for(300ms);
  EXPECT_THAT(fixture.refusal(go("duck")), HasSubstr("dock"));
  EXPECT_THAT(fixture.refusal(go("")), HasSubstr("state the destination"));
  EXPECT_THAT(fixture.refusal(go("dock", "CoSiVA/AIV9")), HasSubstr("no vehicle 'CoSiVA/AIV9'"));
  EXPECT_THAT(fixture.refusal(R"({"command":"go","to":"dock"})"), HasSubstr("state which vehicle"));
  EXPECT_THAT(fixture.refusal(R"({"command":"circulate","vehicle":"*","loop":"outer"})"), HasSubstr("no loops"));
  EXPECT_THAT(fixture.refusal(on_section("close", "soth")), HasSubstr("south"));
  EXPECT_THAT(fixture.refusal(on_section("open", "south")), HasSubstr("open already"));
  EXPECT_THAT(fixture.refusal(R"({"command":"close"})"), HasSubstr("which section"));
  EXPECT_EQ(fixture.refusal(go("gate")), "");
  ServerCore nowhere{ServerOptions{}};
  EXPECT_THAT(nowhere.check_command(DecodedCommand{go("dock")}).error().message, HasSubstr("no zone yet"));
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

}  // namespace
}  // namespace cosiva::virtual_side
