#include "cosiva/virtual/server/core/zone_change.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

/// A switch from the oval to "yard", the same 5 cm to the left, and vehicles whose messages the test writes.
class Changing : public testing::Test {
 protected:
  explicit Changing(ServerOptions options = {}) : fixture{oval(), std::move(options)} {}
  FixtureVehicle& add_written(const std::string& serial, const std::string& manufacturer = "CoSiVA") {
    FixtureVehicle& vehicle = fixture.add(serial, {2, 0.5}, manufacturer);
    vehicle.alive = false;
    return vehicle;
  }
  void report(FixtureVehicle& vehicle, bool driving, double speed_mps) {
    wire::State state = vehicle.state(fixture.now);
    state.driving = driving;
    state.velocity = wire::Velocity{speed_mps, 0.0, 0.0};
    fixture.send(vehicle, "state", vda::encode(state));
  }
  void begin() {
    zone::ZoneConfiguration yard = oval();
    yard.origin = "yard";
    yard.text.replace(yard.text.find("\"oval\""), 6, "\"yard\"");
    yard.text.replace(yard.text.find("y = 0.0"), 7, "y = 0.05");
    JsonWriter json;
    json.begin_object().field("command", "switch");
    zone::write_json(json.key("zone"), yard);
    json.end_object();
    fixture.send_command(json.take());
    begun_at = fixture.now;
  }
  [[nodiscard]] JsonValue switched() const { return *fixture.snapshot().find("zone")->find("switched"); }
  [[nodiscard]] double snapped() const { return *switched().number("snapped"); }
  [[nodiscard]] bool has_moved() const { return switched().number("first_moving_ms").has_value(); }
  [[nodiscard]] std::vector<std::string> off_route() const {
    std::vector<std::string> names;
    const JsonValue change = switched();
    for (const JsonValue& name : *change.find("offRoute")->array()) names.push_back(*name.text());
    return names;
  }
  SimTime begun_at{};
  ServerFixture fixture;
};

TEST_F(Changing, waits_ten_seconds_at_most_for_a_vehicle_that_drives_on_the_old_map) {
  FixtureVehicle& first = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& second = add_written("AIV2");
  report(second, true, 0.3);
  fixture.run_for(1s);
  begin();
  fixture.run_for(1s);
  const std::size_t orders = first.orders.size();
  for (int i = 0; i < 8; ++i) {
    report(second, true, 0.3);
    fixture.run_for(1s);
  }
  report(second, true, 0.3);
  fixture.run_for(980ms);
  EXPECT_EQ(first.orders.size(), orders);
  EXPECT_EQ(snapped(), 0.0);
  EXPECT_THAT(off_route(), IsEmpty());
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV2").find("offRoute")->is_null()) << "it may still change";
  fixture.run_for(20ms);
  EXPECT_EQ(snapped(), 1.0);
  EXPECT_THAT(off_route(), ElementsAre("CoSiVA/AIV2"));
  const std::string why = "is on map 'oval', not on 'yard'; it gets no orders until it is";
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").text("offRoute"), why);
  EXPECT_TRUE(fixture.logged("CoSiVA/AIV2: off-route: it " + why));
  fixture.run_for(500ms);
  EXPECT_GT(first.orders.size(), orders);
  EXPECT_EQ(snapped(), 1.0) << "counted once";
}

TEST_F(Changing, sends_orders_while_a_third_party_vehicle_drives_on_the_old_map_and_counts_it_after_ten_seconds) {
  fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& agv = add_written("agv-7", "Acme");
  report(agv, true, 0.3);
  fixture.run_for(1s);
  begin();
  for (int i = 0; i < 9; ++i) {
    fixture.run_for(1s);
    report(agv, true, 0.3);
  }
  EXPECT_TRUE(has_moved());
  EXPECT_LT(*switched().number("first_moving_ms"), 1500.0);
  fixture.run_for(980ms);
  EXPECT_EQ(snapped(), 0.0);
  EXPECT_THAT(off_route(), IsEmpty());
  fixture.run_for(20ms);
  EXPECT_EQ(snapped(), 1.0);
  EXPECT_THAT(off_route(), ElementsAre("Acme/agv-7"));
}

TEST_F(Changing, waits_for_no_vehicle_whose_connection_is_broken) {
  fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& second = add_written("AIV2");
  report(second, true, 0.3);
  fixture.run_for(1s);
  begin();
  fixture.connection(second, wire::ConnectionState::connection_broken);
  fixture.run_for(1500ms);
  EXPECT_TRUE(has_moved());
}

TEST_F(Changing, waits_for_no_vehicle_that_is_lost) {
  fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& second = fixture.add("AIV2", {2, 0.5});
  fixture.run_for(5s);
  second.alive = false;
  fixture.run_for(2s);
  ASSERT_EQ(fixture.aiv("CoSiVA/AIV2").flag("lost"), true);
  ASSERT_EQ(fixture.aiv("CoSiVA/AIV2").flag("driving"), true);
  begin();
  fixture.run_for(1500ms);
  EXPECT_TRUE(has_moved());
}

TEST_F(Changing, waits_for_a_report_after_the_switch) {
  FixtureVehicle& first = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& second = add_written("AIV2");
  report(second, false, 0.0);
  fixture.run_for(1s);
  report(second, false, 0.0);
  begin();
  fixture.run_for(1500ms);
  EXPECT_EQ(first.map_id, "yard");
  EXPECT_FALSE(has_moved()) << "a report of the same moment is not after the switch";
  report(second, false, 0.0);
  fixture.run_for(500ms);
  EXPECT_TRUE(has_moved());
  EXPECT_GT(*switched().number("first_moving_ms"), 1500.0);
}

TEST_F(Changing, counts_a_vehicle_that_names_no_map_when_it_has_reported) {
  fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& agv = add_written("agv-7", "Acme");
  agv.map_id = "";
  report(agv, false, 0.0);
  fixture.run_for(1s);
  report(agv, false, 0.0);
  begin();
  fixture.run_for(1500ms);
  EXPECT_TRUE(has_moved()) << "nothing is waited for";
  EXPECT_EQ(snapped(), 0.0) << "but the vehicles are not counted";
  EXPECT_TRUE(fixture.aiv("Acme/agv-7").find("offRoute")->is_null());
  report(agv, false, 0.0);
  fixture.run_for(100ms);
  EXPECT_EQ(snapped(), 2.0);
  EXPECT_THAT(off_route(), IsEmpty());
}

TEST_F(Changing, takes_a_vehicle_for_stopped_up_to_a_centimetre_per_second) {
  fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& second = add_written("AIV2");
  report(second, false, 0.011);
  fixture.run_for(1s);
  begin();
  for (int i = 0; i < 15; ++i) {
    fixture.run_for(100ms);
    report(second, false, 0.011);
  }
  EXPECT_FALSE(has_moved());
  fixture.run_for(100ms);
  report(second, false, 0.01);
  fixture.run_for(500ms);
  EXPECT_TRUE(has_moved());
}

TEST_F(Changing, names_the_time_after_which_the_first_vehicle_moves_or_turns) {
  for (const auto& [driving, speed_mps] : {std::pair{false, 0.02}, {true, 0.0}}) {
    fixture.logs.clear();
    fixture.published.clear();
    fixture.vehicles.clear();
    fixture.restart_server();
    FixtureVehicle& aiv = add_written("AIV1");
    report(aiv, false, 0.0);
    fixture.now += 20ms;  // before the startup synchronisation: no order was sent on the old map
    begin();
    aiv.map_id = "yard";
    for (int i = 0; i < 5; ++i) {
      fixture.run_for(100ms);
      report(aiv, false, 0.01);
    }
    EXPECT_EQ(snapped(), 1.0);
    EXPECT_FALSE(has_moved());
    fixture.run_for(100ms);
    ASSERT_THAT(fixture.published_on("uagv/v2/CoSiVA/AIV1/order"), Not(IsEmpty()));
    EXPECT_FALSE(has_moved());
    report(aiv, driving, speed_mps);
    fixture.run_for(20ms);
    EXPECT_EQ(switched().number("first_moving_ms"), to_milliseconds_scaled(fixture.now - begun_at)) << driving;
    EXPECT_EQ(fixture.now - begun_at, 620ms);
    EXPECT_TRUE(fixture.logged("zone 'yard': CoSiVA/AIV1 moves on it, 620 ms after the switch"));
  }
}

/// A server that gives no orders.
class WatchedChange : public Changing {
 protected:
  WatchedChange() : Changing{watching()} {}
  static ServerOptions watching() {
    ServerOptions options;
    options.drive = false;
    return options;
  }
};

TEST_F(WatchedChange, counts_a_vehicle_without_an_order_when_it_has_stopped) {
  FixtureVehicle& aiv = add_written("AIV1");
  report(aiv, false, 0.0);
  fixture.run_for(400ms);
  begin();
  aiv.map_id = "yard";
  fixture.run_for(100ms);
  report(aiv, true, 0.3);
  fixture.run_for(100ms);
  EXPECT_EQ(snapped(), 0.0) << "it coasts";
  EXPECT_FALSE(has_moved()) << "it has no order";
  report(aiv, false, 0.01);
  fixture.run_for(20ms);
  EXPECT_EQ(snapped(), 1.0);
  EXPECT_FALSE(has_moved());
}

/// The types of the actions that a stopped vehicle on this map is sent.
std::vector<std::string> map_actions(bool drive, const std::string& manufacturer, const std::string& map_id) {
  ServerOptions options;
  options.drive = drive;
  ServerFixture fixture{oval(), options};
  FixtureVehicle& vehicle = fixture.add("X1", {0, 0.5}, manufacturer);
  vehicle.blocked = true;
  vehicle.map_id = map_id;
  wire::Factsheet factsheet;
  factsheet.header = vehicle.header(fixture.now, 0);
  factsheet.actions.push_back({"initPosition", "", true, false, false, {}});
  fixture.send(vehicle, "factsheet", vda::encode(factsheet));
  fixture.run_for(1s);
  std::vector<std::string> types;
  for (const wire::InstantActions& message : vehicle.actions) types.push_back(message.actions.front().action_type);
  return types;
}

TEST(MapDeploymentOfTheZone, concerns_third_party_vehicles_that_name_another_map_where_the_server_drives) {
  EXPECT_THAT(map_actions(true, "Acme", "elsewhere"), Contains("initPosition"));
  EXPECT_THAT(map_actions(false, "Acme", "elsewhere"), Not(Contains("initPosition")));
  EXPECT_THAT(map_actions(true, "CoSiVA", "elsewhere"), Not(Contains("initPosition")));
  EXPECT_THAT(map_actions(true, "Acme", ""), Not(Contains("initPosition")));
  EXPECT_THAT(map_actions(true, "Acme", "oval"), Not(Contains("initPosition")));
}

TEST(ZoneChange, names_eighty_bytes_of_a_map_that_is_not_in_force) {
  ServerFixture fixture;
  FixtureVehicle& agv = fixture.add("agv-7", {0, 0.5}, "Acme");
  agv.map_id = std::string(100, 'm');
  fixture.run_for(100ms);
  EXPECT_EQ(fixture.aiv("Acme/agv-7").text("offRoute"),
            "is on map '" + std::string(80, 'm') + "', not on 'oval'; it gets no orders until it is");
}

}  // namespace
}  // namespace cosiva::virtual_side
