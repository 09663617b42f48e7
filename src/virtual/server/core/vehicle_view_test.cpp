#include "cosiva/virtual/server/core/vehicle_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;

/// One vehicle on the oval, stopped by an obstacle at 0.5 m on the south side, which lies on the x axis.
class Shown : public testing::Test {
 protected:
  Shown() {
    aiv.blocked = true;
    fixture.run_for(2s);
  }
  [[nodiscard]] JsonValue shown() const { return fixture.aiv("CoSiVA/AIV1"); }
  [[nodiscard]] bool is_null(std::string_view name) const {
    const JsonValue json = shown();
    const JsonValue* found = json.find(name);
    return found != nullptr && found->text() == nullptr && found->number() == nullptr && found->array() == nullptr &&
           !json.flag(name);
  }
  [[nodiscard]] std::vector<std::string> errors() const {
    std::vector<std::string> texts;
    const JsonValue json = shown();
    for (const JsonValue& text : *json.find("errors")->array()) texts.push_back(*text.text());
    return texts;
  }
  void report(FixtureVehicle& vehicle) {
    vehicle.state_due = true;
    fixture.run_for(40ms);
  }
  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(Shown, vehicle_has_its_identity_position_and_state) {
  const JsonValue json = shown();
  EXPECT_EQ(json.text("id"), "CoSiVA/AIV1");
  EXPECT_EQ(json.number("handle"), 0.0);
  EXPECT_EQ(json.number("number"), 1.0);
  EXPECT_EQ(json.flag("augmented"), false);
  EXPECT_EQ(json.text("connection"), "ONLINE");
  EXPECT_EQ(json.flag("lost"), false);
  EXPECT_EQ(json.text("status"), "stopped");
  EXPECT_NEAR(*json.number("x"), 0.5, 1e-9);
  EXPECT_NEAR(*json.number("y"), 0.0, 1e-9);
  EXPECT_NEAR(*json.number("heading"), 0.0, 1e-9);
  EXPECT_EQ(json.number("speed"), 0.0);
  EXPECT_EQ(json.text("section"), "south");
  EXPECT_NEAR(*json.number("s"), 0.5, 1e-9);
  EXPECT_EQ(json.number("priority"), 0.0);
  EXPECT_EQ(json.text("map"), "oval");
  EXPECT_NEAR(*json.find("reported")->number("x"), 0.5, 1e-9);
  EXPECT_NEAR(*json.find("reported")->number("y"), 0.0, 1e-9);
  EXPECT_NEAR(*json.find("reported")->number("heading"), 0.0, 1e-9);
  EXPECT_GE(*json.number("age_ms"), 4.0) << "the link takes 4 ms";
  EXPECT_LT(*json.number("age_ms"), 120.0) << "five reports a second, and two steps";
  EXPECT_NEAR(*json.number("divergence_m"), 0.0, 1e-9);
  EXPECT_EQ(json.number("battery"), 90.0);
  EXPECT_EQ(json.number("sinceTag_m"), 0.0);
  EXPECT_EQ(json.text("lastNode"), aiv.book->last_node().node_id);
  EXPECT_EQ(json.text("orderId"), aiv.book->ids().order_id);
  EXPECT_EQ(json.number("orderUpdateId"), aiv.book->ids().order_update_id);
  EXPECT_EQ(json.flag("driving"), false);
  EXPECT_EQ(json.flag("paused"), false);
  EXPECT_EQ(json.flag("fieldViolation"), true);
  for (const auto name : {"speedLimit", "offRoute", "lastTag", "waitsFor", "brakingFor"})
    EXPECT_TRUE(is_null(name)) << name;
  EXPECT_THAT(errors(), IsEmpty());
  for (const auto name : {"matched", "divergence", "age", "actual"})
    EXPECT_EQ(json.find("contract")->flag(name), true) << name;
  for (const auto name : {"boards", "power", "ranges"}) EXPECT_EQ(json.find(name), nullptr) << name;
}

TEST_F(Shown, vehicle_drives_when_nothing_obstructs_it) {
  aiv.blocked = false;
  fixture.run_for(1s);
  const JsonValue json = shown();
  EXPECT_EQ(json.text("status"), "Normal");
  EXPECT_NEAR(*json.number("speed"), aiv.cruise_mps, 1e-6);
  EXPECT_EQ(json.flag("driving"), true);
  EXPECT_EQ(json.flag("fieldViolation"), false);
  EXPECT_NEAR(*json.number("x"), aiv.pose().x_m, 0.3 * 0.12 + 1e-6);
}

TEST_F(Shown, reserved_path_is_drawn_every_ten_centimetres_from_the_vehicle_to_the_end_of_its_base) {
  const JsonValue json = shown();
  const auto& points = *json.find("reserved")->array();
  const double left_m = aiv.book->distance_to_base_end_m();
  ASSERT_GT(left_m, 1.0);
  const auto x = [&](std::size_t i) { return *(*points[i].array())[0].number(); };
  ASSERT_EQ(points.size(), static_cast<std::size_t>(left_m / 0.1) + 2);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    EXPECT_NEAR(x(i), 0.5 + 0.1 * static_cast<double>(i), 5e-5) << i;
    EXPECT_NEAR(*(*points[i].array())[1].number(), 0.0, 5e-5) << i;
  }
  EXPECT_NEAR(x(points.size() - 1), 0.5 + left_m, 5e-5);
}

TEST_F(Shown, vehicle_with_a_broken_connection_is_lost_and_stopped) {
  aiv.blocked = false;
  fixture.run_for(1s);
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  const JsonValue json = shown();
  EXPECT_EQ(json.flag("lost"), true);
  EXPECT_EQ(json.number("speed"), 0.0);
  EXPECT_EQ(json.text("status"), "stopped");
  EXPECT_EQ(json.text("connection"), "CONNECTIONBROKEN");
}

TEST_F(Shown, errors_are_those_that_the_vehicle_reports_with_their_descriptions) {
  aiv.errors = {{"batteryLow", wire::ErrorLevel::warning, "charge at 5 %", {}},
                {"motorError", wire::ErrorLevel::fatal, "", {}}};
  report(aiv);
  EXPECT_THAT(errors(), ElementsAre("batteryLow: charge at 5 %", "motorError"));
  EXPECT_TRUE(is_null("offRoute"));
}

TEST_F(Shown, vehicle_on_another_map_is_off_route) {
  aiv.errors = {{"motorError", wire::ErrorLevel::fatal, "", {}}};
  aiv.map_id = "elsewhere";
  report(aiv);
  EXPECT_EQ(shown().text("map"), "elsewhere");
  const std::string why = "is on map 'elsewhere', not on 'oval'; it gets no orders until it is";
  EXPECT_EQ(shown().text("offRoute"), why);
  EXPECT_THAT(errors(), ElementsAre("motorError", "off-route: it " + why));
}

TEST_F(Shown, vehicle_is_off_route_further_than_thirty_centimetres_from_every_section) {
  aiv.put({1.0, 0.3, 0.0});
  fixture.run_for(500ms);
  EXPECT_TRUE(is_null("offRoute"));
  aiv.put({1.0, 0.35, 0.0});
  fixture.run_for(500ms);
  EXPECT_EQ(shown().text("offRoute"),
            "is 0.350 m from the nearest section of 'oval'; move it to within 0.300 m of one");
  EXPECT_NEAR(*shown().number("y"), 0.35, 0.005);
}

TEST_F(Shown, mission_names_its_goal) {
  const std::string goal = fixture.zone->waypoints[fixture.zone->waypoint_behind({2, 1.0})].id;
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":")" + goal + "\"}");
  const JsonValue json = shown();
  EXPECT_EQ(json.find("mission")->text("kind"), "go");
  EXPECT_EQ(json.find("mission")->text("to"), goal);
  EXPECT_EQ(json.find("mission")->text("state"), "driving");
}

// --- position records -----------------------------------------------------------------------------------------------

std::vector<PositionRecord> records_of(const ServerFixture& fixture, SimDuration later = {}) {
  std::vector<PositionRecord> records(3);
  fixture.server->positions(fixture.now + later, records);
  return records;
}

TEST_F(Shown, position_record_has_the_pose_and_the_state_of_the_twin) {
  const auto stopped = records_of(fixture);
  ASSERT_EQ(stopped.size(), 1U) << "earlier records are discarded";
  EXPECT_EQ(stopped[0].handle, 0);
  EXPECT_EQ(stopped[0].kind, PositionRecord::Kind::aiv);
  EXPECT_EQ(stopped[0].status, 1) << "stopped";
  EXPECT_FALSE(stopped[0].augmented);
  EXPECT_TRUE(stopped[0].blocked);
  EXPECT_FLOAT_EQ(stopped[0].x_m, 0.5F);
  EXPECT_FLOAT_EQ(stopped[0].speed_mps, 0.0F);
  EXPECT_FLOAT_EQ(stopped[0].reported_dx_m, 0.0F);
  aiv.blocked = false;
  fixture.run_for(1s);
  const auto driving = records_of(fixture);
  EXPECT_EQ(driving[0].status, 0) << "normal";
  EXPECT_FALSE(driving[0].blocked);
  EXPECT_NEAR(driving[0].speed_mps, 0.3F, 1e-6F);
  const auto later = records_of(fixture, 100ms);
  EXPECT_NEAR(later[0].x_m - driving[0].x_m, 0.03F, 1e-5F) << "extrapolated";
  EXPECT_NEAR(later[0].x_m + later[0].reported_dx_m, driving[0].x_m + driving[0].reported_dx_m, 1e-5F)
      << "the last report is the same";
  EXPECT_LT(later[0].reported_dx_m, -0.03F + 1e-5F);
  EXPECT_NEAR(records_of(fixture, -1s)[0].x_m, driving[0].x_m, 1e-6F) << "not before the present time";
}

TEST_F(Shown, position_record_of_a_vehicle_with_a_broken_connection_is_lost) {
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  const auto records = records_of(fixture);
  EXPECT_EQ(records[0].status, 5);
  EXPECT_FALSE(records[0].blocked);
  EXPECT_EQ(records[0].speed_mps, 0.0F);
}

TEST_F(Shown, position_records_of_virtual_objects_follow_those_of_vehicles) {
  fixture.send_command(
      R"({"command":"add","virtualObject":{"kind":"person","id":"P1","path":[[0,0.2],[0.6,1]],"speed":0.5}})");
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","id":"box","x":1.5,"y":0.5}})");
  const auto records = records_of(fixture, 1s);
  ASSERT_EQ(records.size(), 3U);
  const PositionRecord& person = records[1];
  EXPECT_EQ(person.kind, PositionRecord::Kind::person);
  EXPECT_TRUE(person.augmented);
  EXPECT_LT(records[0].handle, person.handle);
  EXPECT_LT(person.handle, records[2].handle);
  // Three to the right and four up: half a metre after one second.
  EXPECT_NEAR(person.x_m, 0.3F, 1e-5F);
  EXPECT_NEAR(person.y_m, 0.6F, 1e-5F);
  EXPECT_NEAR(person.heading_rad, 0.9273F, 1e-4F);
  EXPECT_NEAR(person.speed_mps, 0.5F, 1e-5F);
  EXPECT_EQ(person.status, 0);
  EXPECT_EQ(records[2].kind, PositionRecord::Kind::obstacle);
  EXPECT_EQ(records[2].speed_mps, 0.0F);
  EXPECT_EQ(records[2].x_m, 1.5F);
  EXPECT_EQ(records[2].y_m, 0.5F);
}

TEST_F(Shown, limit_of_an_operator_is_in_metres_per_second) {
  fixture.send_command(R"({"command":"limit","speed":0.25,"vehicle":"CoSiVA/AIV1"})");
  fixture.run_for(500ms);
  EXPECT_EQ(shown().number("speedLimit"), 0.25);
}

TEST_F(Shown, vehicle_that_reports_its_position_only_has_an_empty_state) {
  FixtureVehicle& other = fixture.add("AIV2", {2, 0.5});
  other.alive = false;
  fixture.send(other, "visualization", vda::encode(other.visualization(fixture.now)));
  const JsonValue json = fixture.aiv("CoSiVA/AIV2");
  EXPECT_EQ(json.text("section"), "north");
  EXPECT_EQ(json.number("battery"), 0.0);
  EXPECT_EQ(json.number("age_ms"), 0.0);
  EXPECT_EQ(json.text("lastNode"), "");
  EXPECT_EQ(json.text("orderId"), "");
  EXPECT_EQ(json.number("orderUpdateId"), 0.0);
  EXPECT_EQ(json.flag("driving"), false);
  EXPECT_THAT(*json.find("errors")->array(), IsEmpty());
  EXPECT_THAT(*json.find("reserved")->array(), IsEmpty());
}

TEST_F(Shown, reserved_path_is_drawn_as_soon_as_an_order_is_sent) {
  FixtureVehicle& other = fixture.add("AIV2", {2, 0.5});
  other.alive = false;  // it does not receive the order, let alone report it
  fixture.send(other, "state", vda::encode(other.state(fixture.now)));
  EXPECT_THAT(*fixture.aiv("CoSiVA/AIV2").find("reserved")->array(), IsEmpty());
  fixture.run_for(100ms);
  EXPECT_THAT(*fixture.aiv("CoSiVA/AIV2").find("reserved")->array(), testing::Not(IsEmpty()));
}

TEST_F(Shown, vehicle_off_the_circuit_has_no_section_and_no_reserved_path) {
  aiv.put({1.0, 0.5, 0.0});
  fixture.run_for(500ms);
  EXPECT_TRUE(is_null("section"));
  EXPECT_TRUE(is_null("s"));
  EXPECT_THAT(*shown().find("reserved")->array(), IsEmpty());
}

TEST_F(Shown, virtual_aiv_holds_the_contract_and_has_no_physical_vehicle_to_differ_from) {
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"north","s":0.5}})");
  fixture.run_for(500ms);
  const JsonValue json = fixture.aiv("CoSiVA.virtual/V1");
  EXPECT_EQ(json.flag("augmented"), true);
  for (const auto name : {"matched", "divergence", "age", "actual"})
    EXPECT_EQ(json.find("contract")->flag(name), true) << name;
  EXPECT_EQ(fixture.bijection().number("physical"), 1.0);
  EXPECT_EQ(fixture.bijection().number("virtual"), 1.0);
}

TEST_F(Shown, position_record_of_a_vehicle_without_reports_is_lost) {
  EXPECT_EQ(records_of(fixture, 500ms)[0].status, 1) << "stopped";
  const auto records = records_of(fixture, 20s);
  EXPECT_EQ(records[0].status, 5);
  EXPECT_FALSE(records[0].blocked);
}

TEST(PositionRecords, have_the_offset_of_the_last_report_along_both_axes) {
  ServerFixture fixture;
  fixture.add("AIV1", {2, 0.5});
  fixture.run_for(2s);
  const auto now = records_of(fixture);
  const auto later = records_of(fixture, 100ms);
  // On the north side, at y = 1, to the left.
  EXPECT_NEAR(now[0].y_m, 1.0F, 1e-4F);
  EXPECT_NEAR(now[0].reported_dy_m, 0.0F, 1e-4F);
  EXPECT_NEAR(later[0].reported_dx_m - now[0].reported_dx_m, 0.03F, 1e-5F);
}

}  // namespace
}  // namespace cosiva::virtual_side
