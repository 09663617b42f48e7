#include "cosiva/virtual/server/missions/mission_requests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;

std::string go(const std::string& to, const std::string& vehicle = "CoSiVA/AIV1") {
  return R"({"command":"go","vehicle":")" + vehicle + R"(","to":")" + to + "\"}";
}
std::string on_section(const std::string& command, const std::string& section) {
  return R"({"command":")" + command + R"(","section":")" + section + "\"}";
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

/// The fork zone with stations "dock" and "gate", and one vehicle, CoSiVA/AIV1.
class Requests : public testing::Test {
 protected:
  Requests() { orders.add("AIV1"); }
  [[nodiscard]] Error refusal_of_goal(const std::string& name, const std::string& vehicle = "CoSiVA/AIV1") const {
    const auto checked = requests.check(MissionCommand{true, {vehicle}, name});
    return checked ? Error{} : checked.error();
  }
  [[nodiscard]] Error refusal_of_loop(const std::string& name) const {
    const auto checked = requests.check(MissionCommand{false, {"*"}, name});
    return checked ? Error{} : checked.error();
  }
  [[nodiscard]] Error refusal_of_section(bool closes, const std::string& name) const {
    const auto checked = requests.check(SectionCommand{closes, name});
    return checked ? Error{} : checked.error();
  }
  /// Replaces the zone by one with these stations, all on the same waypoint.
  void set_stations(const std::vector<std::string>& names) {
    zone::TrafficZone zone = orders.map->zone();
    const zone::Station station = zone.stations.front();
    zone.stations.clear();
    for (const std::string& name : names) {
      zone.stations.push_back(station);
      zone.stations.back().name = name;
    }
    other_map.emplace(std::make_shared<const zone::TrafficZone>(std::move(zone)));
    orders.missions.set_map(&*other_map);
  }
  std::optional<WaypointGraph> other_map;
  OrdersFixture orders{fork()};
  MissionRequests requests{orders.server.registry, orders.server.publisher, orders.missions};
};

TEST_F(Requests, are_refused_with_code_field_and_the_most_similar_names) {
  EXPECT_EQ(refusal_of_goal("duck"),
            (Error{"mission.to", "there is no station or waypoint 'duck'; there are dock and gate", "to"}));
  set_stations({"dock"});
  EXPECT_EQ(refusal_of_goal("duck").message, "there is no station or waypoint 'duck'; there is dock");
  set_stations({"dock", "gate", "rack"});
  EXPECT_EQ(refusal_of_goal("rock").message, "there is no station or waypoint 'rock'; there are dock, rack and gate");
  set_stations({"gate", "rack", "pier", "deck"});
  EXPECT_EQ(refusal_of_goal("duck").message,
            "there is no station or waypoint 'duck'; the nearest are deck, rack and gate");
  EXPECT_EQ(refusal_of_loop("outer"),
            (Error{"mission.loop", "there is no loop 'outer'; this zone has no loops", "loop"}));
  EXPECT_EQ(refusal_of_loop(""), Error{});
}

TEST_F(Requests, list_waypoints_where_the_zone_has_no_stations) {
  set_stations({});
  const std::string known = orders.map->zone().waypoints.front().id;
  const std::string message = refusal_of_goal(known + "x").message;
  EXPECT_THAT(message, HasSubstr("; the nearest are " + known + ", "));
  EXPECT_EQ(message.find(known + ", " + known), std::string::npos) << "each name once";
  EXPECT_EQ(refusal_of_goal(known), Error{});
}

TEST_F(Requests, list_no_similar_names_where_there_are_more_than_five_thousand) {
  std::vector<std::string> names;
  for (int i = 0; i < 5000; ++i) names.push_back("s" + std::to_string(i));
  set_stations(names);
  EXPECT_THAT(refusal_of_goal("t7").message, HasSubstr("'t7'; the nearest are s7, "));
  names.emplace_back("s5000");
  set_stations(names);
  EXPECT_EQ(refusal_of_goal("t7").message, "there is no station or waypoint 't7'");
}

TEST_F(Requests, name_a_destination_of_one_to_two_hundred_bytes) {
  const Error none{"mission.to", "state the destination, as the name of a station or waypoint", "to"};
  EXPECT_EQ(refusal_of_goal(""), none);
  EXPECT_EQ(refusal_of_goal(std::string(201, 'x')), none);
  EXPECT_THAT(refusal_of_goal(std::string(200, 'x')).message,
              HasSubstr("no station or waypoint '" + std::string(80, 'x') + "'"));
}

TEST_F(Requests, are_refused_where_no_waypoint_is_at_the_station) {
  zone::TrafficZone zone = orders.map->zone();
  zone.stations.front().position.s_m += 0.05;
  other_map.emplace(std::make_shared<const zone::TrafficZone>(zone));
  orders.missions.set_map(&*other_map);
  const std::string name = zone.stations.front().name;
  EXPECT_EQ(refusal_of_goal(name),
            (Error{"mission.to",
                   "no section of this zone has a stopping point at '" + name + "'; move it onto a section", "to"}));
}

TEST_F(Requests, address_known_vehicles_that_are_not_retired) {
  EXPECT_EQ(refusal_of_goal("dock", "CoSiVA/AIV9"),
            (Error{"mission.vehicle", "no vehicle 'CoSiVA/AIV9' is known; name it as manufacturer/serial number",
                   "vehicle"}));
  EXPECT_EQ(refusal_of_goal("dock", ""),
            (Error{"mission.vehicle", "state which vehicle, as manufacturer/serial number, or * for all", "vehicle"}));
  EXPECT_EQ(refusal_of_goal("dock", "*"), Error{});
  const VehicleIndex second = orders.add("AIV2");
  orders.proxy(0).membership.on_retired();
  EXPECT_EQ(refusal_of_goal("dock").code, "mission.vehicle");
  requests.follow(MissionCommand{true, {"*"}, "dock"});
  EXPECT_EQ(orders.missions.mission(0), Mission{}) << "it is retired";
  EXPECT_EQ(orders.missions.mission(second), (Mission{Mission::Kind::go, "dock"}));
  orders.proxy(second).membership.on_retired();
  EXPECT_EQ(refusal_of_goal("dock", "*"), (Error{"mission.vehicle", "no vehicle is known yet", "vehicle"}));
}

TEST_F(Requests, to_circulate_replace_the_mission) {
  requests.follow(MissionCommand{true, {"CoSiVA/AIV1"}, "dock"});
  requests.follow(MissionCommand{false, {"CoSiVA/AIV1"}, ""});
  EXPECT_EQ(orders.missions.mission(0), Mission{});
}

TEST_F(Requests, for_another_control_area_are_passed_on_only_where_the_name_has_an_area) {
  std::vector<std::string> requested;
  requests.set_abroad([&](std::string_view to) -> Result<Mission> {
    requested.emplace_back(to);
    if (to == "b/rack") return Mission{Mission::Kind::go, "gate", "b/rack"};
    return fail("areas.goal", "no such goal");
  });
  EXPECT_EQ(refusal_of_goal("dock"), Error{});
  EXPECT_EQ(refusal_of_goal("rack").code, "mission.to");
  EXPECT_THAT(requested, testing::IsEmpty());
  EXPECT_EQ(refusal_of_goal("b/rack"), Error{});
  EXPECT_EQ(refusal_of_goal("b/nothing").message, "no such goal");
  requests.follow(MissionCommand{true, {"CoSiVA/AIV1"}, "b/rack"});
  EXPECT_EQ(orders.missions.mission(0), (Mission{Mission::Kind::go, "gate", "b/rack"}));
  requests.follow(MissionCommand{true, {"CoSiVA/AIV1"}, "b/nothing"});
  EXPECT_EQ(orders.missions.mission(0).beyond, "b/rack");
  EXPECT_THAT(orders.logs(), testing::Contains("w command refused: no such goal"));
  requests.follow(MissionCommand{true, {"CoSiVA/AIV1"}, "dock"});
  EXPECT_EQ(orders.missions.mission(0), (Mission{Mission::Kind::go, "dock"}));
}

TEST_F(Requests, close_and_open_sections_that_are_not_closed_or_open_already) {
  EXPECT_EQ(refusal_of_section(true, ""), (Error{"mission.section", "state which section to close", "section"}));
  EXPECT_EQ(refusal_of_section(false, ""), (Error{"mission.section", "state which section to open", "section"}));
  EXPECT_EQ(refusal_of_section(true, "bypas3"),
            (Error{"mission.section", "there is no section 'bypas3'; the nearest are bypass3, bypass1 and bypass2",
                   "section"}));
  EXPECT_EQ(refusal_of_section(false, "south"), (Error{"mission.section", "'south' is open already", "section"}));
  EXPECT_EQ(refusal_of_section(true, "south"), Error{});
  requests.follow(SectionCommand{true, "south"});
  requests.follow(SectionCommand{true, "bypass3"});
  EXPECT_EQ(refusal_of_section(true, "south"), (Error{"mission.section", "'south' is closed already", "section"}));
  EXPECT_EQ(refusal_of_section(false, "south"), Error{});
  requests.follow(SectionCommand{false, "south"});
  EXPECT_THAT(orders.missions.closed().all(), testing::ElementsAre(orders.section("bypass3")));
}

TEST_F(Requests, are_refused_while_there_is_no_zone) {
  orders.missions.set_map(nullptr);
  const Error none{"mission.zone", "there is no zone yet; wait until the physical side has sent it, then try again",
                   ""};
  EXPECT_EQ(refusal_of_goal("dock"), none);
  EXPECT_EQ(refusal_of_section(true, "south"), none);
}

TEST_F(Requests, to_circulate_are_never_passed_on_to_another_control_area) {
  std::size_t passed_on = 0;
  requests.set_abroad([&](std::string_view) -> Result<Mission> {
    ++passed_on;
    return fail("areas.goal", "no such goal");
  });
  orders.missions.give(0, {Mission::Kind::go, "dock"});
  EXPECT_EQ(refusal_of_loop(""), Error{});
  requests.follow(MissionCommand{false, {"CoSiVA/AIV1"}, ""});
  EXPECT_EQ(orders.missions.mission(0), Mission{});
  EXPECT_EQ(passed_on, 0U);
}

TEST_F(Requests, with_the_name_of_an_area_are_refused_where_there_are_no_other_areas) {
  const Error error = refusal_of_goal("b/rack");
  EXPECT_EQ(error.code, "mission.to");
  EXPECT_THAT(error.message, HasSubstr("there is no station or waypoint 'b/rack'; there are "));
}

TEST_F(Requests, for_several_vehicles_need_all_of_them) {
  const VehicleIndex second = orders.add("AIV2");
  const MissionCommand command{true, {"CoSiVA/AIV2", "CoSiVA/AIV9"}, "dock"};
  EXPECT_THAT(requests.check(command).error().message, HasSubstr("no vehicle 'CoSiVA/AIV9'"));
  requests.follow(MissionCommand{true, {"CoSiVA/AIV2", "CoSiVA/AIV1"}, "gate"});
  EXPECT_EQ(orders.missions.mission(0).name, "gate");
  EXPECT_EQ(orders.missions.mission(second).name, "gate");
}

TEST_F(Requests, quote_at_most_eighty_bytes_of_a_name) {
  const std::string name = std::string(80, 'x') + "y";
  const std::string quoted = "'" + std::string(80, 'x') + "'";
  EXPECT_THAT(refusal_of_loop(name).message, HasSubstr(quoted));
  EXPECT_THAT(refusal_of_section(true, name).message, HasSubstr(quoted));
  EXPECT_THAT(refusal_of_goal("dock", name).message, HasSubstr(quoted));
  EXPECT_THAT(refusal_of_goal(name).message, HasSubstr(quoted));
}

}  // namespace
}  // namespace cosiva::virtual_side
