// Several servers on one broker: claims, handover, and which server sends messages to which vehicle.
#include "cosiva/virtual/server/areas/control_areas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/testing/vehicle_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

zone::ZoneConfiguration area_file(const std::string& name) { return zone_file("../e2e/areas/" + name + ".toml"); }

const std::string aiv1 = "CoSiVA/AIV1";

/// The servers of control areas a and b on one broker that stores retained messages, and the fixture's vehicles on
/// their floor. Two straights at y = ±0.29 m, and between them a gate of 0.6 m at y = 0 that begins at x = 1.307 m.
class ControlAreasFixture {
 public:
  explicit ControlAreasFixture(std::vector<std::string> areas = {"a", "b"}) {
    for (const std::string& area : areas) start(area);
  }

  struct Server {
    std::unique_ptr<ServerCore> core;
    std::string state_file;
    std::vector<std::string> logs;
    std::vector<wire::Publish> published;
    bool deaf_to_owners{false};  ///< messages about owners are delayed
    std::vector<wire::Publish> waiting;
  };
  std::map<std::string, Server> servers;
  std::map<std::string, zone::ZoneConfiguration> zone_of{{"a", area_file("area_a")}, {"b", area_file("area_b")}};
  std::vector<std::unique_ptr<FixtureVehicle>> vehicles;
  std::map<std::string, wire::Publish> kept;  ///< retained by the broker
  bool loses_owners{false};                   ///< the broker loses owner messages
  std::vector<wire::Owner> owners;            ///< of AIV1
  SimTime now{virtual_epoch};
  std::function<void()> each_step;

  void start(const std::string& area, bool restore = false) {
    Server& server = servers[area];
    ServerOptions options;
    options.area = area;
    options.zone = zone_of.at(area);
    server.core = std::make_unique<ServerCore>(options);
    if (restore && !server.state_file.empty()) feed(server, wire::InputKind::restore, "", server.state_file);
    link(area);
  }
  void link(const std::string& area) {
    Server& server = servers[area];
    feed(server, wire::InputKind::link, "", "up");
    for (const auto& [topic, message] : std::map{kept}) deliver(server, message, true);
    flush();
  }
  void kill(const std::string& area) {
    const wire::Publish will = servers[area].core->will()->message;
    servers[area].core.reset();
    publish(will);
  }
  FixtureVehicle& add(const std::string& serial, const Pose2& X_MB, const std::string& manufacturer = "CoSiVA") {
    vehicles.push_back(
        std::make_unique<FixtureVehicle>(floor_, wire::VehicleId{manufacturer, serial}, zone::TrackPosition{0, 0.0}));
    FixtureVehicle& vehicle = *vehicles.back();
    vehicle.put(X_MB);
    vehicle.takes_zones = false;
    publish(
        {vehicle.topic("connection"), vda::encode(vehicle.connection(now, wire::ConnectionState::online)), 1, true});
    return vehicle;
  }
  FixtureVehicle& in_a() { return add("AIV1", {0.3, 0.29289322, 0.0}); }

  void publish(wire::Publish message) {
    queue_.push_back(std::move(message));
    flush();
  }
  void publish_owner(const std::string& area) {
    publish({"cosiva/v1/owner/" + aiv1, wire::to_json({area, 50, now, std::nullopt, std::nullopt}), 1, true});
  }
  void send_command(const std::string& area, const std::string& json) {
    feed(servers[area], wire::InputKind::command, "test", json);
    flush();
  }
  void go(const std::string& area, const std::string& to) {
    send_command(area, R"({"command":"go","vehicle":")" + aiv1 + R"(","to":")" + to + "\"}");
  }
  [[nodiscard]] std::string refusal(const std::string& area, const std::string& json) {
    const auto checked = servers[area].core->check_command(DecodedCommand{json});
    return checked ? "" : to_string(checked.error());
  }
  [[nodiscard]] std::string refusal_to_go(const std::string& area, const std::string& to) {
    return refusal(area, R"({"command":"go","vehicle":")" + aiv1 + R"(","to":")" + to + "\"}");
  }
  void receive_again(const std::string& area) {
    Server& server = servers[area];
    server.deaf_to_owners = false;
    for (const wire::Publish& message : std::exchange(server.waiting, {})) deliver(server, message, false);
    flush();
  }

  void run_for(SimDuration duration) {
    for (const SimTime end = now + duration; now < end;) {
      now += 20ms;
      ++steps_;
      for (const auto& vehicle : vehicles) {
        vehicle->step(20ms);
        if (steps_ % 5 == 0)
          publish({vehicle->topic("visualization"), vda::encode(vehicle->visualization(now)), 0, false});
        if (steps_ % 50 != 0 && !std::exchange(vehicle->state_due, false)) continue;
        publish({vehicle->topic("state"), vda::encode(vehicle->state(now)), 0, false});
      }
      for (auto& [area, server] : servers)
        if (server.core) feed(server, wire::InputKind::tick, "", "");
      flush();
      if (each_step) each_step();
    }
  }
  bool run_until(const std::function<bool()>& done, SimDuration timeout) {
    for (const SimTime end = now + timeout; now < end && !done();) run_for(20ms);
    return done();
  }

  [[nodiscard]] std::vector<std::string> table(const std::string& area) const {
    std::vector<std::string> ids;
    if (!servers.at(area).core) return ids;
    const auto snapshot = *JsonValue::parse(servers.at(area).core->snapshot_json());
    for (const JsonValue& aiv : *snapshot.find("aivs")->array()) ids.push_back(*aiv.text("id"));
    return ids;
  }
  [[nodiscard]] JsonValue aiv(const std::string& area) const {
    const auto snapshot = *JsonValue::parse(servers.at(area).core->snapshot_json());
    for (const JsonValue& one : *snapshot.find("aivs")->array())
      if (one.text("id") == aiv1) return one;
    return {};
  }
  [[nodiscard]] std::string mission(const std::string& area) const {
    const JsonValue one = aiv(area);
    if (one.find("mission") == nullptr) return "none";
    return one.find("mission")->text("to").value_or("round") + ", " + *one.find("mission")->text("state");
  }
  /// Number of orders and instant actions for AIV1.
  [[nodiscard]] std::size_t sent(const std::string& area) const {
    return static_cast<std::size_t>(std::ranges::count_if(servers.at(area).published, [](const wire::Publish& p) {
      return p.topic == "uagv/v2/" + aiv1 + "/order" || p.topic == "uagv/v2/" + aiv1 + "/instantActions";
    }));
  }
  [[nodiscard]] std::vector<std::string> published_areas() const {
    std::vector<std::string> areas;
    for (const wire::Owner& owner : owners) areas.push_back(owner.area);
    return areas;
  }

 private:
  void deliver(Server& server, const wire::Publish& message, bool retained) {
    if (!server.core) return;
    if (server.deaf_to_owners && message.topic.starts_with(wire::owner_topic_prefix)) {
      server.waiting.push_back(message);
      return;
    }
    const auto filters = server.core->subscriptions();
    if (std::ranges::any_of(filters, [&](const auto& f) { return wire::topic_matches(f, message.topic); }))
      feed(server, wire::InputKind::message, message.topic, message.payload, retained);
  }
  void feed(Server& server, wire::InputKind kind, std::string source, std::string payload, bool flag = false) {
    wire::Effects effects;
    server.core->handle({now, kind, std::move(source), std::move(payload), flag}, effects);
    for (const wire::Effect& effect : effects) {
      if (const auto* log = std::get_if<wire::Log>(&effect)) server.logs.push_back(log->text);
      if (const auto* state = std::get_if<wire::Persist>(&effect)) server.state_file = state->bytes;
      if (const auto* message = std::get_if<wire::Publish>(&effect)) {
        server.published.push_back(*message);
        queue_.push_back(*message);
      }
    }
  }
  void flush() {
    while (!queue_.empty()) {
      const wire::Publish message = std::move(queue_.front());
      queue_.pop_front();
      if (loses_owners && message.topic.starts_with(wire::owner_topic_prefix)) continue;
      if (message.retained && message.payload.empty()) kept.erase(message.topic);
      if (message.retained && !message.payload.empty()) kept[message.topic] = message;
      for (auto& [area, server] : servers) deliver(server, message, false);
      for (const auto& vehicle : vehicles) {
        vehicle->receive(message);
        if (message.topic != wire::own_topic(wire::owner_topic_prefix, vehicle->id) || message.payload.empty())
          continue;
        const wire::Owner owner = *wire::owner_from_json(message.payload);
        if (wire::to_string(vehicle->id) == aiv1) owners.push_back(owner);
        // Like a CoSiVA vehicle: takes the zone of its owner as soon as the vehicle is stopped; here it is stopped.
        const auto zone = zone::Rtm::initialise(zone_of.at(owner.area))->shared_zone();
        if (vehicle->id.manufacturer == wire::our_manufacturer && vehicle->map_id != zone->name) vehicle->take(zone);
      }
    }
  }

  std::shared_ptr<const zone::TrafficZone> floor_{zone::Rtm::initialise(area_file("floor"))->shared_zone()};
  std::deque<wire::Publish> queue_;
  std::uint64_t steps_{0};
};

TEST(ControlAreas, claim_a_vehicle_without_owner_in_the_area_where_it_is_and_only_there) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(900ms);
  EXPECT_THAT(fixture.owners, IsEmpty()) << "its owner may still be received";
  fixture.run_for(600ms);
  ASSERT_THAT(fixture.published_areas(), ElementsAre("a"));
  EXPECT_EQ(fixture.owners[0].sequence, 1U);
  EXPECT_NEAR(fixture.owners[0].pose->x_m, 0.3, 1e-9);
  EXPECT_TRUE(fixture.kept.contains("cosiva/v1/owner/" + aiv1));
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
  fixture.run_for(5s);
  EXPECT_THAT(fixture.table("b"), IsEmpty());
  EXPECT_GT(fixture.sent("a"), 0U);
  EXPECT_EQ(fixture.sent("b"), 0U) << "not its own vehicle";
  EXPECT_EQ(fixture.owners.size(), 1U) << "published once";
}

TEST(ControlAreas, claim_no_vehicle_that_is_off_all_their_paths) {
  ControlAreasFixture fixture;
  fixture.add("AIV1", {1.6, 5.0, 0.0});
  fixture.run_for(5s);
  EXPECT_THAT(fixture.owners, IsEmpty());
  EXPECT_THAT(fixture.table("a"), IsEmpty());
}

TEST(ControlAreas, do_not_claim_a_vehicle_whose_owner_is_received_late) {
  ControlAreasFixture fixture{{"a"}};
  fixture.in_a();
  fixture.run_for(800ms);
  fixture.publish_owner("b");
  fixture.run_for(5s);
  EXPECT_THAT(fixture.published_areas(), ElementsAre("b")) << "its server is absent, and still owns the vehicle";
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  EXPECT_EQ(fixture.sent("a"), 0U);
}

TEST(ControlAreas, agree_on_the_last_message_where_two_claim_at_once) {
  ControlAreasFixture fixture;
  fixture.add("AIV1", {1.6, 0.0, 0.0});  // in the gate
  fixture.run_for(2s);
  ASSERT_THAT(fixture.published_areas(), ElementsAre("a", "b")) << "neither received the other's claim before its own";
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  EXPECT_THAT(fixture.table("b"), ElementsAre(aiv1));
  const std::size_t by_a = fixture.sent("a");
  fixture.run_for(5s);
  EXPECT_EQ(fixture.sent("a"), by_a);
  EXPECT_THAT(fixture.published_areas(), SizeIs(2)) << "and no further claims";
}

TEST(ControlAreas, hand_a_vehicle_over_where_they_meet_while_it_is_always_in_exactly_one_table) {
  ControlAreasFixture fixture;
  FixtureVehicle& aiv = fixture.in_a();
  fixture.run_for(2s);
  EXPECT_EQ(fixture.refusal_to_go("a", "b/rack_b"), "");
  fixture.go("a", "b/rack_b");
  EXPECT_EQ(fixture.mission("a"), "b/rack_b, driving");
  int neither = 0;
  int both = 0;
  fixture.each_step = [&] {
    const std::size_t tables = fixture.table("a").size() + fixture.table("b").size();
    neither += tables == 0 ? 1 : 0;
    both += tables == 2 ? 1 : 0;
  };
  ASSERT_TRUE(fixture.run_until([&] { return !fixture.table("b").empty(); }, 60s));
  EXPECT_EQ(fixture.published_areas().at(1), "b");
  ASSERT_TRUE(fixture.owners[1].mission);
  EXPECT_EQ(fixture.owners[1].mission->name, "rack_b");
  EXPECT_EQ(fixture.owners[1].sequence, 2U);
  EXPECT_NEAR(fixture.owners[1].pose->y_m, 0.0, 0.02) << "in the gate";
  EXPECT_EQ(aiv.speed_mps, 0.0);
  const std::size_t by_a = fixture.sent("a");
  const auto left = *JsonValue::parse(fixture.servers["a"].core->snapshot_json());
  for (const JsonValue& crossing : *left.find("crossings")->array())
    EXPECT_FALSE(crossing.text("heldBy")) << *crossing.text("name");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.mission("b") == "rack_b, arrived"; }, 40s))
      << fixture.mission("b");
  EXPECT_EQ(fixture.sent("a"), by_a) << "the old server sends nothing";
  EXPECT_EQ(neither, 0);
  EXPECT_EQ(both, 0);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_FALSE(fixture.owners.back().mission) << "published once: a restarted server must not begin it again";

  fixture.go("b", "a/rack_a");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.mission("a") == "rack_a, arrived"; }, 60s))
      << fixture.mission("a");
  EXPECT_EQ(neither, 0);
  EXPECT_EQ(both, 0);
}

TEST(ControlAreas, have_the_twin_as_soon_as_the_owner_is_received_and_send_nothing_after_publishing_it) {
  ControlAreasFixture fixture;
  FixtureVehicle& aiv = fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.servers["a"].deaf_to_owners = true;
  fixture.servers["b"].deaf_to_owners = true;
  ASSERT_TRUE(fixture.run_until([&] { return fixture.owners.size() == 2; }, 60s));
  const std::size_t by_a = fixture.sent("a");
  EXPECT_THAT(fixture.table("a"), IsEmpty()) << "the other may have received it already: never in two tables";
  fixture.send_command("a", R"({"command":"stop","vehicle":"*"})");
  fixture.send_command("a", R"({"command":"circulate","vehicle":"*"})");
  fixture.run_for(1s);
  EXPECT_EQ(fixture.sent("a"), by_a) << "regardless of the commands";
  EXPECT_FALSE(aiv.paused);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1))
      << "the handover has not succeeded within a second: still owned by a";
  EXPECT_EQ(fixture.sent("b"), 0U);

  fixture.receive_again("b");
  const JsonValue twin = fixture.aiv("b");
  ASSERT_TRUE(twin.text("id")) << "before it has reported";
  EXPECT_NEAR(*twin.number("x"), aiv.pose().x_m, 0.01);
  EXPECT_NEAR(*twin.number("y"), aiv.pose().y_m, 0.01);
  EXPECT_EQ(twin.text("section"), "gate");
  EXPECT_EQ(fixture.mission("b"), "rack_b, driving");
  fixture.receive_again("a");
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  ASSERT_TRUE(fixture.run_until([&] { return fixture.mission("b") == "rack_b, arrived"; }, 40s));
  EXPECT_EQ(fixture.sent("a"), by_a);
}

TEST(ControlAreas, publish_a_handover_again_that_was_not_received_back) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.loses_owners = true;
  fixture.run_for(60s);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1)) << "no server has received it";
  EXPECT_THAT(fixture.table("b"), IsEmpty());
  fixture.loses_owners = false;
  fixture.run_for(3s);
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  EXPECT_THAT(fixture.table("b"), ElementsAre(aiv1));
}

TEST(ControlAreas, leave_the_vehicles_of_a_failed_server_to_it_until_it_returns) {
  ControlAreasFixture fixture;
  FixtureVehicle& aiv = fixture.in_a();
  fixture.run_for(3s);
  fixture.kill("a");
  fixture.run_for(5s);
  EXPECT_THAT(fixture.table("b"), IsEmpty());
  EXPECT_THAT(fixture.published_areas(), ElementsAre("a"));
  fixture.start("a");
  fixture.run_for(400ms);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
  EXPECT_NEAR(*fixture.aiv("a").number("x"), aiv.pose().x_m, 0.1) << "the present position, not the claimed one";
  const double driven_m = aiv.driven_m;
  fixture.run_for(5s);
  EXPECT_GT(aiv.driven_m, driven_m + 0.5);
  EXPECT_THAT(fixture.published_areas(), ElementsAre("a")) << "there was nothing to claim";
}

TEST(ControlAreas, restore_the_mission_to_another_area_after_a_crash) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.run_for(500ms);
  fixture.kill("a");
  fixture.start("a", true);
  ASSERT_TRUE(fixture.run_until([&] { return fixture.mission("b") == "rack_b, arrived"; }, 60s))
      << fixture.mission("a");
}

TEST(ControlAreas, give_up_a_vehicle_that_they_await_when_it_belongs_to_another_area) {
  ControlAreasFixture fixture;
  fixture.in_a();
  ASSERT_TRUE(
      fixture.run_until([&] { return fixture.servers["a"].state_file.find(R"("held":)") != std::string::npos; }, 60s));
  fixture.kill("a");
  fixture.vehicles.clear();
  fixture.kept.clear();  // the broker loses all retained messages
  fixture.start("a", true);
  fixture.run_for(1s);
  EXPECT_THAT(fixture.servers["a"].core->stop_targets(), SizeIs(1)) << "it may have a base";
  fixture.publish_owner("b");
  EXPECT_THAT(fixture.servers["a"].core->stop_targets(), IsEmpty());
}

TEST(ControlAreas, wait_where_they_meet_for_a_server_that_has_failed) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.kill("b");
  fixture.run_for(60s);
  EXPECT_EQ(fixture.mission("a"), "b/rack_b, driving");
  EXPECT_THAT(*fixture.aiv("a").find("mission")->text("why"), HasSubstr("waits at gate"));
  fixture.start("b");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.mission("b") == "rack_b, arrived"; }, 40s));
}

TEST(ControlAreas, hand_over_no_vehicle_that_an_operator_has_stopped_until_it_is_restarted) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.kill("b");
  fixture.run_for(20s);
  fixture.send_command("a", R"({"command":"stop","vehicle":"CoSiVA/AIV1"})");
  fixture.run_for(1s);
  fixture.start("b");
  fixture.run_for(10s);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1)) << "area b would not know of the Stop";
  EXPECT_THAT(fixture.table("b"), IsEmpty());
  fixture.send_command("a", R"({"command":"restart","vehicle":"CoSiVA/AIV1"})");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.mission("b") == "rack_b, arrived"; }, 40s));
}

TEST(ControlAreas, publish_the_owner_again_when_the_broker_has_lost_it) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(3s);
  for (const std::string area : {"a", "b"}) {
    wire::Effects effects;
    fixture.servers[area].core->handle({fixture.now, wire::InputKind::link, "", "down", false}, effects);
  }
  fixture.kept.clear();
  fixture.link("a");
  fixture.link("b");
  fixture.run_for(5s);
  EXPECT_THAT(fixture.published_areas(), ElementsAre("a", "a"));
  EXPECT_EQ(fixture.owners.back().sequence, 2U);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
  EXPECT_THAT(fixture.table("b"), IsEmpty());
}

TEST(ControlAreas, release_a_vehicle_whose_owner_is_cleared_and_claim_it_again) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.publish({"cosiva/v1/owner/" + aiv1, "", 1, true});
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  fixture.run_for(3s);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
}

TEST(ControlAreas, change_nothing_where_an_owner_cannot_be_read) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  for (auto& [area, server] : fixture.servers) {
    wire::Effects effects;
    server.core->handle({fixture.now, wire::InputKind::message, "cosiva/v1/owner/" + aiv1, R"({"area":7})", false},
                        effects);
  }
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
  EXPECT_THAT(fixture.table("b"), IsEmpty());
}

TEST(ControlAreas, refuse_to_send_a_vehicle_where_no_route_leads_and_state_the_reason) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  EXPECT_THAT(fixture.refusal_to_go("a", "c/rack"), HasSubstr("no control area 'c' is known; there are b"));
  EXPECT_THAT(fixture.refusal_to_go("a", "b/rack"), HasSubstr("no station or waypoint 'rack'"));
  EXPECT_THAT(fixture.refusal_to_go("a", "b/"), HasSubstr("no station or waypoint ''"));
  EXPECT_THAT(fixture.refusal_to_go("a", "/rack"), HasSubstr("no control area ''"));
  EXPECT_EQ(fixture.refusal_to_go("a", "a/rack_a"), "");
  EXPECT_THAT(fixture.refusal_to_go("a", "a/rack_b"), HasSubstr("in this control area"));
  EXPECT_THAT(fixture.refusal_to_go("b", "b/rack_b"), HasSubstr("no vehicle 'CoSiVA/AIV1'"))
      << "it does not belong to this control area";
  EXPECT_THAT(fixture.refusal("a", R"({"command":"add","virtualObject":{"kind":"aiv","section":"a_far","s":1.0}})"),
              HasSubstr("virtual AIV"));
  EXPECT_EQ(fixture.refusal("a", R"({"command":"add","virtualObject":{"kind":"person","x":1.0,"y":1.0}})"), "");
  fixture.kill("b");
  EXPECT_THAT(fixture.refusal_to_go("a", "b/rack_b"), HasSubstr("does not respond"));
}

TEST(ControlAreas, refuse_to_send_a_vehicle_to_an_area_that_they_do_not_meet) {
  ControlAreasFixture fixture{{}};
  std::string far = fixture.zone_of["b"].text;
  for (std::size_t at = far.find("y = "); at != std::string::npos; at = far.find("y = ", at + 1)) {
    const std::size_t end = far.find(',', at);
    far.replace(at, end - at, "y = " + std::to_string(std::stod(far.substr(at + 4)) - 3.0));
  }
  fixture.zone_of["b"].text = far;
  fixture.start("a");
  fixture.start("b");
  fixture.in_a();
  fixture.run_for(2s);
  EXPECT_THAT(fixture.refusal_to_go("a", "b/rack_b"),
              HasSubstr("no station of this control area is on a section of control area 'b'"));
}

TEST(ControlAreas, hand_over_a_third_party_vehicle_as_well) {
  ControlAreasFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0.3, 0.29289322, 0.0}, "CoSiVA");
  FixtureVehicle& other = fixture.add("R7", {2.0, -1.49289322, pi}, "Robots");
  for (const std::string name : {"area_a", "area_b"})
    other.downloads.push_back(zone::Rtm::initialise(area_file(name))->shared_zone());
  // Published once, while no server owns the vehicle: its later owner must know the factsheet nevertheless.
  wire::Factsheet factsheet;
  factsheet.header = other.header(fixture.now, 0);
  for (const char* action : {"downloadMap", "enableMap", "initPosition", "cancelOrder"})
    factsheet.actions.push_back({action, "", true, false, false, {}});
  fixture.publish({other.topic("factsheet"), vda::encode(factsheet), 0, true});
  fixture.run_for(3s);
  EXPECT_THAT(fixture.table("b"), ElementsAre("Robots/R7"));
  fixture.send_command("b", R"({"command":"go","vehicle":"Robots/R7","to":"a/rack_a"})");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.table("a").size() == 2; }, 90s));
  EXPECT_THAT(fixture.table("a"), UnorderedElementsAre(aiv1, "Robots/R7"));
  ASSERT_TRUE(fixture.run_until([&] { return other.map_id == "area_a" && other.speed_mps > 0.0; }, 20s));
  EXPECT_THAT(other.refusals, IsEmpty());
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST(ControlAreas, do_not_concern_the_only_server_of_its_broker) {
  ServerCore server{ServerOptions{}};
  for (const std::string& filter : server.subscriptions()) {
    EXPECT_THAT(filter, testing::Not(HasSubstr("owner")));
    EXPECT_THAT(filter, testing::Not(HasSubstr("area")));
  }
  EXPECT_EQ(JsonValue::parse(server.snapshot_json())->find("area"), nullptr);
  ServerOptions options;
  options.area = "a";
  EXPECT_EQ(server_options_from_json(to_json(options))->area, "a");
  EXPECT_FALSE(server_options_from_json(R"({"area":"a/b"})"));
}

const std::string owner_topic = "cosiva/v1/owner/" + aiv1;

std::ptrdiff_t owners_published(const ControlAreasFixture& fixture, const std::string& area) {
  return std::ranges::count(fixture.servers.at(area).published, owner_topic, &wire::Publish::topic);
}
void lose_link(ControlAreasFixture& fixture, const std::string& area) {
  wire::Effects effects;
  fixture.servers[area].core->handle({fixture.now, wire::InputKind::link, "", "down", false}, effects);
}
void publish_owner_b(ControlAreasFixture& fixture, std::optional<Pose2> pose,
                     std::optional<wire::Owner::Mission> mission = {}) {
  fixture.publish({owner_topic, wire::to_json(wire::Owner{"b", 7, fixture.now, pose, std::move(mission)}), 1, true});
}
/// From here on the test writes the messages of the only vehicle.
std::unique_ptr<FixtureVehicle> take_out(ControlAreasFixture& fixture) {
  std::unique_ptr<FixtureVehicle> vehicle = std::move(fixture.vehicles.front());
  fixture.vehicles.clear();
  return vehicle;
}

TEST(ControlAreas, claim_a_vehicle_a_second_after_its_first_position_and_again_every_two_seconds) {
  ControlAreasFixture fixture{{"a"}};
  fixture.loses_owners = true;
  fixture.in_a();
  fixture.run_for(1000ms);
  EXPECT_EQ(owners_published(fixture, "a"), 0);
  fixture.run_for(20ms);  // its first position was published at 20 ms
  EXPECT_EQ(owners_published(fixture, "a"), 1);
  fixture.run_for(1980ms);
  EXPECT_EQ(owners_published(fixture, "a"), 1);
  fixture.run_for(20ms);
  EXPECT_EQ(owners_published(fixture, "a"), 2);
}

TEST(ControlAreas, claim_a_vehicle_whose_last_position_is_a_second_old_and_no_older_one) {
  for (const SimDuration late : {SimDuration{0ms}, SimDuration{10ms}}) {
    ControlAreasFixture fixture{{"a"}};
    fixture.in_a();
    const auto vehicle = take_out(fixture);
    fixture.now += late;
    fixture.publish({vehicle->topic("state"), vda::encode(vehicle->state(fixture.now)), 0, false});
    fixture.now -= late;
    fixture.run_for(3s);  // the tick at 1000 ms claims it or none does
    EXPECT_EQ(fixture.kept.contains(owner_topic), late == SimDuration{0ms});
  }
}

TEST(ControlAreas, forget_a_vehicle_without_an_owner_until_it_is_claimed_anew) {
  ControlAreasFixture fixture{{"a"}};
  FixtureVehicle& aiv = fixture.in_a();
  aiv.deaf_to = {"startPause"};
  fixture.run_for(1100ms);
  ASSERT_THAT(fixture.table("a"), ElementsAre(aiv1));
  const auto snapshot = [&] { return *JsonValue::parse(fixture.servers["a"].core->snapshot_json()); };
  EXPECT_EQ(snapshot().find("bijection")->number("matched"), 1.0);
  fixture.send_command("a", R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV1"})");
  fixture.publish({owner_topic, "", 1, true});
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  EXPECT_THAT(fixture.servers["a"].logs.back(), HasSubstr("CoSiVA/AIV1: released"));
  const JsonValue released = snapshot();
  EXPECT_EQ(released.find("bijection")->number("physical"), 0.0);
  EXPECT_EQ(released.find("bijection")->number("virtual"), 0.0);
  EXPECT_EQ(released.find("commands")->array()->back().text("state"), "failed");
  EXPECT_EQ(released.find("commands")->array()->back().text("reason"), "CoSiVA/AIV1 has no owner any more");
  fixture.run_for(900ms);
  EXPECT_THAT(fixture.table("a"), IsEmpty()) << "a second from its next position on";
  fixture.run_for(300ms);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
  fixture.run_for(200ms);
  EXPECT_EQ(snapshot().find("bijection")->number("matched"), 1.0);
}

TEST(ControlAreas, take_over_what_the_owner_message_and_earlier_messages_state) {
  ControlAreasFixture fixture;
  fixture.in_a();
  const auto vehicle = take_out(fixture);
  const wire::Connection broken = vehicle->connection(fixture.now, wire::ConnectionState::connection_broken);
  fixture.publish({vehicle->topic("connection"), vda::encode(broken), 1, true});
  publish_owner_b(fixture, Pose2{1.6, 0.0, 0.0}, wire::Owner::Mission{"go", "rack_b"});
  const JsonValue aiv = fixture.aiv("b");
  EXPECT_EQ(aiv.text("connection"), "CONNECTIONBROKEN");
  EXPECT_EQ(aiv.number("age_ms"), 0.0);
  EXPECT_EQ(aiv.text("section"), "gate");
  EXPECT_EQ(fixture.mission("b"), "rack_b, driving");
  const JsonValue summary = *JsonValue::parse(fixture.servers["b"].core->summary_json());
  EXPECT_EQ(summary.find("aivs")->array()->front().flag("present"), true);
  EXPECT_THAT(fixture.servers["b"].logs, testing::Contains("CoSiVA/AIV1: belongs to this control area"));
  EXPECT_THAT(fixture.servers["b"].state_file, HasSubstr(R"("vehicle":"CoSiVA/AIV1","kind":"go","name":"rack_b")"));
  const wire::Owner published = *wire::owner_from_json(fixture.kept.at(owner_topic).payload);
  EXPECT_EQ(published, (wire::Owner{"b", 8, fixture.now, Pose2{1.6, 0.0, 0.0}, std::nullopt}));
  EXPECT_THAT(fixture.table("a"), IsEmpty());
}

TEST(ControlAreas, show_a_vehicle_only_where_its_pose_is_known_and_of_now) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  ASSERT_THAT(fixture.table("a"), ElementsAre(aiv1));
  fixture.kill("a");
  fixture.start("a");
  EXPECT_THAT(fixture.table("a"), IsEmpty()) << "the retained pose is that of the claim";
  fixture.run_for(200ms);
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
  publish_owner_b(fixture, std::nullopt);
  EXPECT_THAT(fixture.table("a"), IsEmpty());
  EXPECT_THAT(fixture.table("b"), IsEmpty());
  EXPECT_THAT(fixture.servers["a"].logs.back(), HasSubstr("released; it belongs to control area b now"));
  fixture.run_for(200ms);
  EXPECT_THAT(fixture.table("b"), ElementsAre(aiv1));
}

TEST(ControlAreas, give_a_vehicle_no_mission_that_they_do_not_know) {
  ControlAreasFixture fixture;
  fixture.in_a();
  publish_owner_b(fixture, Pose2{1.6, 0.0, 0.0}, wire::Owner::Mission{"go", "nowhere"});
  EXPECT_EQ(fixture.mission("b"), "round, driving");
}

TEST(ControlAreas, publish_a_lost_owner_with_the_pose_of_the_handover) {
  ControlAreasFixture fixture;
  fixture.in_a();
  const auto vehicle = take_out(fixture);
  publish_owner_b(fixture, Pose2{1.6, 0.0, 0.0});
  lose_link(fixture, "b");
  fixture.kept.clear();
  fixture.link("b");
  fixture.run_for(2100ms);  // the startup synchronisation waits two seconds for the vehicle
  ASSERT_TRUE(fixture.kept.contains(owner_topic));
  const wire::Owner published = *wire::owner_from_json(fixture.kept.at(owner_topic).payload);
  EXPECT_EQ(published.area, "b");
  EXPECT_EQ(published.sequence, 8U);
  ASSERT_TRUE(published.pose.has_value());
  EXPECT_EQ(published.pose->x_m, 1.6);
}

/// AIV1 waits in the gate for the server of area b, which has failed; the test writes its messages from then on.
class AtTheGate : public testing::Test {
 protected:
  AtTheGate() {
    fixture.in_a();
    fixture.run_for(2s);
    fixture.go("a", "b/rack_b");
    fixture.kill("b");
    fixture.run_for(20s);
    vehicle = take_out(fixture);
  }
  void expect_not_handed_over() const {
    EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
    EXPECT_THAT(fixture.table("b"), IsEmpty());
  }
  ControlAreasFixture fixture;
  std::unique_ptr<FixtureVehicle> vehicle;
};

TEST_F(AtTheGate, vehicle_is_not_handed_over_while_its_connection_is_broken) {
  const wire::Connection broken = vehicle->connection(fixture.now, wire::ConnectionState::connection_broken);
  fixture.publish({vehicle->topic("connection"), vda::encode(broken), 1, true});
  fixture.start("b");
  fixture.run_for(500ms);
  expect_not_handed_over();
}

TEST_F(AtTheGate, vehicle_is_not_handed_over_while_it_is_lost) {
  fixture.run_for(3s);
  ASSERT_EQ(fixture.aiv("a").flag("lost"), true);
  fixture.start("b");
  fixture.run_for(500ms);
  expect_not_handed_over();
}

TEST(ControlAreas, hand_over_no_vehicle_whose_order_was_cancelled) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.run_for(500ms);
  fixture.send_command("a", R"({"command":"cancel","vehicle":"CoSiVA/AIV1"})");
  fixture.run_for(5s);
  EXPECT_THAT(fixture.published_areas(), ElementsAre("a"));
  EXPECT_THAT(fixture.table("a"), ElementsAre(aiv1));
}

TEST(ControlAreas, publish_a_handover_every_two_seconds_and_at_once_when_the_link_comes_up) {
  ControlAreasFixture fixture;
  fixture.in_a();
  fixture.run_for(2s);
  fixture.go("a", "b/rack_b");
  fixture.loses_owners = true;
  std::vector<SimTime> times;
  std::ptrdiff_t known = owners_published(fixture, "a");
  fixture.each_step = [&] {
    const std::ptrdiff_t count = owners_published(fixture, "a");
    if (count != known) times.push_back(fixture.now);
    known = count;
  };
  ASSERT_TRUE(fixture.run_until([&] { return times.size() >= 3; }, 60s));
  EXPECT_EQ(times[1] - times[0], 2s);
  EXPECT_EQ(times[2] - times[1], 2s);
  lose_link(fixture, "a");
  fixture.link("a");
  fixture.run_for(1500ms);
  EXPECT_EQ(times.size(), 4U) << "the handover from before is void";
}

TEST(ControlAreas, register_no_vehicle_with_a_name_that_the_standard_does_not_permit_and_no_virtual_aiv_of_others) {
  ControlAreasFixture fixture{{"a"}};
  const std::size_t logged = fixture.servers["a"].logs.size();
  fixture.publish({"uagv/v2/Ac me/x/connection", "{}", 1, false});
  fixture.publish({"uagv/v2/Acme/x y/connection", "{}", 1, false});
  EXPECT_EQ(fixture.servers["a"].logs.size(), logged + 2);
  EXPECT_THAT(fixture.servers["a"].logs.back(), HasSubstr("has a name with characters that VDA 5050 does not permit"));
  const wire::Connection online{{1, fixture.now, "2.1.0", "CoSiVA.virtual", "V9"}, wire::ConnectionState::online};
  fixture.publish({"uagv/v2/CoSiVA.virtual/V9/connection", vda::encode(online), 1, false});
  const JsonValue summary = *JsonValue::parse(fixture.servers["a"].core->summary_json());
  EXPECT_THAT(*summary.find("aivs")->array(), IsEmpty());
  EXPECT_EQ(summary.number("messages_refused"), 2.0);
}

}  // namespace
}  // namespace cosiva::virtual_side
