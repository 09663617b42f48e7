#include "cosiva/virtual/server/areas/control_areas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/exchange/traces.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

using std::chrono::seconds;
using testing::SizeIs;

const std::string online_payload = R"({"connectionState":"ONLINE"})";

wire::Input received(std::string payload, SimTime at = virtual_epoch, bool retained = false) {
  return {at, wire::InputKind::message, "topic", std::move(payload), retained};
}

/// A lane of 4 m that begins at (0, y), with a dead end.
std::string lane_text(std::string_view name, std::string_view y_and_heading, std::string_view stations) {
  return "name = \"" + std::string(name) +
         "\"\nformat_version = 1\n[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n[circuit]\nstart = { x = 0.0, " +
         std::string(y_and_heading) +
         " }\n[[section]]\nname = \"lane\"\nkind = \"straight\"\nlength_m = 4.0\nnext = []\n" + std::string(stations);
}
std::string station_text(std::string_view name, std::string_view s_m) {
  return "[[station]]\nname = \"" + std::string(name) + "\"\nsection = \"lane\"\ns_m = " + std::string(s_m) + "\n";
}

/// Control area a, a lane along y = 0, and what it receives of others.
class Areas : public testing::Test {
 protected:
  void has_stations(const std::string& stations) { home = built(lane_text("home", level, stations)); }
  static std::shared_ptr<const zone::TrafficZone> built(const std::string& text) {
    return zone::Rtm::initialise({"toml", "test", text})->shared_zone();
  }
  void publishes_zone(std::string_view area, const std::string& text) {
    EXPECT_TRUE(areas.on_area({area, "zone/toml"}, received(text)));
  }
  void connects(std::string_view area, const std::string& payload = online_payload) {
    EXPECT_TRUE(areas.on_area({area, "server/connection"}, received(payload)));
  }
  [[nodiscard]] Result<Mission> routed(std::string_view to) {
    WaypointGraph map{home};
    Missions missions{registry, publisher};
    missions.set_map(&map);
    return areas.route_to(to, *home, missions);
  }
  [[nodiscard]] Error refusal(std::string_view to) {
    const auto route = routed(to);
    EXPECT_FALSE(route) << to;
    return route ? Error{} : route.error();
  }
  [[nodiscard]] std::string station_towards(std::string_view to) {
    const auto route = routed(to);
    return route ? route->name : route.error().message;
  }
  [[nodiscard]] std::string written() const {
    JsonWriter json;
    areas.write(json);
    return json.take();
  }

  static constexpr std::string_view level = "y = 0.0, heading_deg = 0";
  static constexpr std::string_view next_to_it = "y = -0.1, heading_deg = 0";
  const wire::VehicleId aiv1{"CoSiVA", "AIV1"};
  ControlAreas areas{"a"};
  std::shared_ptr<const zone::TrafficZone> home{built(lane_text("home", level, ""))};
  Traces traces{10};
  MessagePublisher publisher{traces};
  Registry registry{"uagv"};
};

TEST_F(Areas, own_exactly_the_vehicles_whose_last_owner_they_are) {
  EXPECT_FALSE(areas.owns(aiv1)) << "never received";
  ControlAreas::Vehicle& vehicle = *areas.vehicle(aiv1);
  EXPECT_FALSE(areas.owns(aiv1)) << "without an owner";
  vehicle.owner = wire::Owner{"b", 1, virtual_epoch, std::nullopt, std::nullopt};
  EXPECT_FALSE(areas.owns(aiv1));
  vehicle.owner->area = "a";
  EXPECT_TRUE(areas.owns(aiv1));
  EXPECT_FALSE(areas.owns({"CoSiVA", "AIV2"}));
}

TEST(OnlyArea, owns_every_vehicle) {
  const ControlAreas only{""};
  EXPECT_FALSE(only.several());
  EXPECT_TRUE(only.owns({"CoSiVA", "AIV1"}));
}

TEST_F(Areas, store_one_entry_for_each_vehicle) {
  EXPECT_TRUE(areas.several());
  EXPECT_EQ(areas.own(), "a");
  ControlAreas::Vehicle* vehicle = areas.vehicle(aiv1);
  ASSERT_NE(vehicle, nullptr);
  EXPECT_EQ(vehicle->id, aiv1);
  EXPECT_EQ(areas.vehicle(aiv1), vehicle);
  EXPECT_NE(areas.vehicle({"CoSiVA", "AIV2"}), vehicle);
  EXPECT_THAT(areas.vehicles(), SizeIs(2));
}

TEST_F(Areas, store_at_most_4096_vehicles) {
  for (int i = 0; i < 4096; ++i) ASSERT_NE(areas.vehicle({"Acme", std::to_string(i)}), nullptr) << i;
  EXPECT_EQ(areas.vehicle(aiv1), nullptr);
  EXPECT_NE(areas.vehicle({"Acme", "4095"}), nullptr) << "known already";
  EXPECT_THAT(areas.vehicles(), SizeIs(4096));
}

/// Messages of AIV1.
class Overheard : public Areas {
 protected:
  static std::string visualization(double x_m, bool initialised = true) {
    wire::Visualization message;
    message.header = {1, virtual_epoch, "2.1.0", "CoSiVA", "AIV1"};
    message.position = wire::AgvPosition{{x_m, 2.0, 0.5}, "home", initialised, std::nullopt, std::nullopt};
    return wire::vda5050::encode(message);
  }
  static std::string state(double x_m) {
    wire::State message;
    message.header = {1, virtual_epoch, "2.1.0", "CoSiVA", "AIV1"};
    message.position = wire::AgvPosition{{x_m, 2.0, 0.5}, "home", true, std::nullopt, std::nullopt};
    return wire::vda5050::encode(message);
  }
  ControlAreas::Vehicle& vehicle{*areas.vehicle(aiv1)};
};

TEST_F(Overheard, connection_and_factsheet_are_stored_for_the_next_owner) {
  areas.overhear(vehicle, "connection", received("1"));
  EXPECT_FALSE(vehicle.factsheet);
  areas.overhear(vehicle, "factsheet", received("2"));
  areas.overhear(vehicle, "state", received("3"));
  ASSERT_TRUE(vehicle.connection && vehicle.factsheet);
  EXPECT_EQ(vehicle.connection->payload, "1");
  EXPECT_EQ(vehicle.factsheet->payload, "2");
  vehicle.owner = wire::Owner{"b", 1, virtual_epoch, std::nullopt, std::nullopt};
  areas.overhear(vehicle, "connection", received("4"));
  EXPECT_EQ(vehicle.connection->payload, "4") << "of any owner";
}

TEST_F(Overheard, position_is_stored_with_the_times_of_the_first_and_of_the_last_report) {
  areas.overhear(vehicle, "visualization", received(visualization(1.0), virtual_epoch + seconds{1}));
  areas.overhear(vehicle, "state", received(state(1.5), virtual_epoch + seconds{3}));
  ASSERT_TRUE(vehicle.pose);
  EXPECT_EQ(*vehicle.pose, (Pose2{1.5, 2.0, 0.5}));
  EXPECT_EQ(vehicle.pose_since, virtual_epoch + seconds{1});
  EXPECT_EQ(vehicle.pose_at, virtual_epoch + seconds{3});
}

TEST_F(Overheard, position_of_a_vehicle_with_an_owner_is_not_stored) {
  vehicle.owner = wire::Owner{"b", 1, virtual_epoch, std::nullopt, std::nullopt};
  areas.overhear(vehicle, "visualization", received(visualization(1.0)));
  EXPECT_FALSE(vehicle.pose);
}

TEST_F(Overheard, position_in_a_retained_message_is_outdated) {
  areas.overhear(vehicle, "state", received(state(1.0), virtual_epoch, true));
  EXPECT_FALSE(vehicle.pose);
}

TEST_F(Overheard, position_is_taken_from_states_and_visualizations_only) {
  areas.overhear(vehicle, "connection", received(state(1.0)));
  areas.overhear(vehicle, "order", received(state(1.0)));
  areas.overhear(vehicle, "order", received(visualization(1.0)));
  EXPECT_FALSE(vehicle.pose);
}

TEST_F(Overheard, position_that_is_unknown_or_unreadable_is_not_stored) {
  areas.overhear(vehicle, "visualization", received(visualization(1.0, false)));
  areas.overhear(vehicle, "visualization", received("no json"));
  areas.overhear(vehicle, "state", received("no json"));
  EXPECT_FALSE(vehicle.pose);
  EXPECT_EQ(vehicle.pose_since, SimTime{});
}

TEST_F(Overheard, is_received_anew_when_the_link_comes_up_but_the_owner_stays) {
  vehicle.owner = wire::Owner{"a", 1, virtual_epoch, std::nullopt, std::nullopt};
  vehicle.owner_received = true;
  vehicle.pose = Pose2{};
  vehicle.claimed_at = virtual_epoch;
  areas.link_up();
  EXPECT_FALSE(vehicle.owner_received);
  EXPECT_FALSE(vehicle.pose);
  EXPECT_FALSE(vehicle.claimed_at);
  EXPECT_TRUE(areas.owns(aiv1));
}

TEST_F(Areas, are_there_when_they_are_online_and_have_published_their_zone) {
  EXPECT_FALSE(areas.is_there("b"));
  connects("b");
  EXPECT_FALSE(areas.is_there("b")) << "no zone yet";
  publishes_zone("c", lane_text("there", level, ""));
  EXPECT_FALSE(areas.is_there("c")) << "not online";
  publishes_zone("b", lane_text("there", level, ""));
  EXPECT_TRUE(areas.is_there("b"));
  connects("b", R"({"connectionState":"CONNECTIONBROKEN"})");
  EXPECT_FALSE(areas.is_there("b"));
}

TEST_F(Areas, are_online_only_where_their_server_writes_so) {
  publishes_zone("b", lane_text("there", level, ""));
  for (const char* payload : {"", "no json", "{}", R"({"connectionState":"OFFLINE"})", R"({"connectionState":7})"}) {
    connects("b");
    connects("b", payload);
    EXPECT_FALSE(areas.is_there("b")) << payload;
  }
}

TEST_F(Areas, read_connections_of_at_most_4096_bytes) {
  publishes_zone("b", lane_text("there", level, ""));
  const std::string begin = R"({"connectionState":"ONLINE","x":")";
  const std::string end = "\"}";
  const std::size_t rest = 4096 - begin.size() - end.size();
  connects("b", begin + std::string(rest + 1, 'x') + end);
  EXPECT_FALSE(areas.is_there("b"));
  connects("b", begin + std::string(rest, 'x') + end);
  EXPECT_TRUE(areas.is_there("b"));
}

TEST_F(Areas, do_not_count_themselves_among_the_others) {
  connects("a");
  publishes_zone("a", lane_text("own", level, ""));
  EXPECT_FALSE(areas.is_there("a"));
  EXPECT_FALSE(areas.has_map("own"));
  EXPECT_EQ(written(), R"({"name":"a","others":[]})");
}

TEST_F(Areas, are_written_by_name_with_their_connection) {
  connects("c");
  publishes_zone("b", lane_text("there", level, ""));
  EXPECT_EQ(written(), R"({"name":"a","others":[{"name":"b","online":false},{"name":"c","online":true}]})");
}

TEST_F(Areas, store_at_most_256_others) {
  for (int i = 0; i < 256; ++i) connects("area" + std::to_string(i));
  connects("b");
  publishes_zone("b", lane_text("there", level, ""));
  EXPECT_FALSE(areas.is_there("b"));
  EXPECT_FALSE(areas.has_map("there"));
  publishes_zone("area255", lane_text("last", level, ""));
  EXPECT_TRUE(areas.is_there("area255"));
}

TEST_F(Areas, have_the_maps_that_others_have_published_last) {
  EXPECT_FALSE(areas.has_map("there"));
  connects("c");
  publishes_zone("b", lane_text("there", level, ""));
  EXPECT_TRUE(areas.has_map("there"));
  EXPECT_FALSE(areas.has_map("home"));
  publishes_zone("b", lane_text("elsewhere", level, ""));
  EXPECT_FALSE(areas.has_map("there"));
  EXPECT_TRUE(areas.has_map("elsewhere"));
}

TEST_F(Areas, preserve_a_zone_whose_topic_is_cleared) {
  publishes_zone("b", lane_text("there", level, ""));
  publishes_zone("b", "");
  EXPECT_TRUE(areas.has_map("there"));
}

TEST_F(Areas, refuse_a_zone_that_cannot_be_built_and_preserve_the_one_before) {
  publishes_zone("b", lane_text("there", level, ""));
  EXPECT_FALSE(areas.on_area({"b", "zone/toml"}, received("name = 7")));
  EXPECT_FALSE(areas.on_area({"b", "zone/nonsense"}, received("x")));
  EXPECT_TRUE(areas.has_map("there"));
}

TEST_F(Areas, take_no_zone_from_another_topic) {
  EXPECT_TRUE(areas.on_area({"b", "server/heartbeat"}, received("name = 7")));
  EXPECT_TRUE(areas.on_area({"b", "zones/toml"}, received(lane_text("there", level, ""))));
  EXPECT_FALSE(areas.has_map("there"));
}

TEST_F(Areas, build_a_zone_that_is_received_again_only_once) {
  const std::string text = lane_text("there", level, "");
  publishes_zone("b", text);
  const std::uint64_t before = zone::Rtm::initialised_count();
  publishes_zone("b", text);
  EXPECT_EQ(zone::Rtm::initialised_count(), before);
  publishes_zone("b", lane_text("elsewhere", level, ""));
  EXPECT_EQ(zone::Rtm::initialised_count(), before + 1);
}

TEST_F(Areas, route_to_stations_of_their_own_like_any_mission) {
  has_stations(station_text("dock", "1.0"));
  const auto mission = routed("a/dock");
  ASSERT_TRUE(mission) << to_string(mission.error());
  EXPECT_EQ(*mission, (Mission{Mission::Kind::go, "dock", {}}));
  EXPECT_EQ(refusal("a/rack"),
            (Error{"mission.to", "there is no station or waypoint 'rack' in this control area", "to"}));
  EXPECT_EQ(refusal("a").message, "there is no station or waypoint '' in this control area");
}

TEST_F(Areas, name_the_others_where_one_is_unknown) {
  EXPECT_EQ(refusal("x/dock"), (Error{"mission.area", "no control area 'x' is known", "to"}));
  connects("b");
  EXPECT_EQ(refusal("x/dock").message, "no control area 'x' is known; there are b");
  connects("c");
  EXPECT_EQ(refusal("x/dock").message, "no control area 'x' is known; there are b, c");
  EXPECT_EQ(refusal(std::string(81, 'x') + "/dock").message,
            "no control area '" + std::string(80, 'x') + "' is known; there are b, c");
}

TEST_F(Areas, state_why_another_one_cannot_be_a_goal) {
  publishes_zone("b", lane_text("there", next_to_it, station_text("rack", "3.5")));
  EXPECT_EQ(refusal("b/rack"),
            (Error{"mission.area", "the server of control area 'b' does not respond; start it, then try again", "to"}));
  connects("c");
  EXPECT_EQ(refusal("c/rack"), (Error{"mission.area", "control area 'c' has not published its zone; try again", "to"}));
  connects("b");
  EXPECT_EQ(refusal("b/dock"), (Error{"mission.to", "control area 'b' has no station or waypoint 'dock'", "to"}));
  EXPECT_EQ(refusal("b/rack"),
            (Error{"mission.to",
                   "no station of this control area is on a section of control area 'b' with a route to 'rack'; define "
                   "one where the two control areas meet",
                   "to"}));
}

/// Control area b, whose lane passes the stations of control area a.
class Routes : public Areas {
 protected:
  void there(std::string_view y_and_heading, std::string_view rack_s_m) {
    connects("b");
    publishes_zone("b", lane_text("there", y_and_heading, station_text("rack", rack_s_m)));
  }
};

TEST_F(Routes, lead_to_a_station_where_the_areas_meet_with_the_goal_beyond) {
  has_stations(station_text("gate", "1.0"));
  there(next_to_it, "3.5");
  const auto mission = routed("b/rack");
  ASSERT_TRUE(mission) << to_string(mission.error());
  EXPECT_EQ(*mission, (Mission{Mission::Kind::go, "gate", "b/rack"}));
}

TEST_F(Routes, lead_to_the_station_nearest_to_the_other_path_in_whatever_order_they_are_listed) {
  // The other lane sinks by 2°: it passes 0.07 m from (0.5, 0) and 0.10 m from (1.5, 0).
  there("y = -0.05, heading_deg = -2", "3.5");
  has_stations(station_text("near", "0.5") + station_text("far", "1.5"));
  EXPECT_EQ(station_towards("b/rack"), "near");
  has_stations(station_text("far", "1.5") + station_text("near", "0.5"));
  EXPECT_EQ(station_towards("b/rack"), "near");
}

TEST_F(Routes, lead_to_the_first_of_two_stations_that_are_equally_near) {
  there(next_to_it, "3.5");
  has_stations(station_text("one", "1.5") + station_text("two", "0.5"));
  EXPECT_EQ(station_towards("b/rack"), "one");
}

TEST_F(Routes, lead_past_a_station_from_which_the_goal_cannot_be_reached) {
  // The other lane ends at 4 m: from 3.0 m on, the goal at 2.0 m is behind the vehicle.
  there(next_to_it, "2.0");
  has_stations(station_text("late", "3.0") + station_text("early", "0.5"));
  EXPECT_EQ(station_towards("b/rack"), "early");
}

TEST_F(Routes, lead_to_waypoints_as_well) {
  has_stations(station_text("gate", "1.0"));
  there(next_to_it, "3.5");
  const auto other = built(lane_text("there", next_to_it, station_text("rack", "3.5")));
  ASSERT_FALSE(other->waypoints.empty());
  const zone::Waypoint& last = other->waypoints.back();
  ASSERT_GT(last.position.s_m, 1.0);
  EXPECT_EQ(station_towards("b/" + last.id), "gate");
}

TEST_F(Routes, lead_only_to_stations_that_vehicles_can_be_sent_to) {
  there(next_to_it, "3.5");
  const auto with_gate = built(lane_text("home", level, station_text("gate", "1.0")));
  WaypointGraph map{home};
  Missions missions{registry, publisher};
  missions.set_map(&map);
  EXPECT_FALSE(areas.route_to("b/rack", *with_gate, missions)) << "the map in force has no such station";
}

TEST_F(Routes, do_not_begin_where_the_other_path_is_more_than_30_centimetres_from_the_station) {
  has_stations(station_text("gate", "1.0"));
  there("y = -0.31, heading_deg = 0", "3.5");
  EXPECT_EQ(refusal("b/rack").code, "mission.to");
  there("y = -0.29, heading_deg = 0", "3.5");
  EXPECT_EQ(station_towards("b/rack"), "gate");
}

TEST_F(Areas, fold_the_owner_of_each_vehicle) {
  const auto digest_of = [this] {
    Digest digest;
    areas.fold(digest);
    return digest.hex();
  };
  EXPECT_EQ(digest_of(), Digest{}.hex());
  areas.vehicle(aiv1)->owner = wire::Owner{"b", 1, virtual_epoch, std::nullopt, std::nullopt};
  ASSERT_NE(areas.vehicle({"CoSiVA", "AIV2"}), nullptr);
  Digest expected;
  expected.add(std::string_view{"CoSiVA/AIV1"});
  expected.add(std::string_view{"b"});
  expected.add(std::string_view{"CoSiVA/AIV2"});
  EXPECT_EQ(digest_of(), expected.hex());
}

}  // namespace
}  // namespace cosiva::virtual_side
