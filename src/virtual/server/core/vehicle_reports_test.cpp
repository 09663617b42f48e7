#include "cosiva/virtual/server/core/vehicle_reports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(VehicleReports, show_a_vehicle_without_a_known_position_as_an_orphan) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.position_known = false;
  fixture.run_for(2s);
  const JsonValue metrics = fixture.bijection();
  EXPECT_EQ(*metrics.number("physical"), 1.0);
  EXPECT_EQ(*metrics.number("virtual"), 0.0);
  ASSERT_THAT(*metrics.find("orphans")->array(), SizeIs(1));
  EXPECT_EQ((*metrics.find("orphans")->array())[0].text("id"), "CoSiVA/AIV1");
  EXPECT_EQ((*metrics.find("orphans")->array())[0].text("side"), "physical");
  EXPECT_EQ(*metrics.number("matched_ratio"), 0.0);
}

TEST(VehicleReports, treat_a_vehicle_that_reports_after_a_stale_last_will_as_online) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  fixture.run_for(3s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("connection"), "ONLINE");
}

TEST(VehicleReports, do_not_move_a_twin_back_for_a_late_report) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  const auto late = vda::encode(aiv.visualization(fixture.now - 200ms));
  const auto late_state = vda::encode(aiv.state(fixture.now - 1500ms));
  fixture.run_for(2s);
  const JsonValue before = fixture.aiv("CoSiVA/AIV1");
  fixture.send(aiv, "visualization", late);
  fixture.send(aiv, "state", late_state);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("x"), *before.number("x"));
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("orderUpdateId"), *before.number("orderUpdateId"));
  EXPECT_THAT(fixture.server->summary_json(), HasSubstr("\"outdated\":2"));
}

TEST(VehicleReports, ignore_a_retained_state) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.send(aiv, "state", vda::encode(aiv.state(fixture.now)), true);
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
  EXPECT_TRUE(fixture.logged("retained state"));
}

TEST(VehicleReports, ignore_a_message_with_another_vehicle_s_name_and_log_that_once) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  wire::State forged = aiv.state(fixture.now);
  forged.header.serial_number = "AIV2";
  for (int i = 0; i < 5; ++i) fixture.send(aiv, "state", vda::encode(forged));
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
  EXPECT_EQ(std::ranges::count_if(fixture.logs, [](const auto& l) { return l.find("AIV2") != std::string::npos; }), 1);
}

TEST(VehicleReports, count_lost_messages_and_let_header_ids_wrap) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  std::uint32_t id = 0xFFFFFFFEU;
  for (const std::uint32_t step : {0U, 1U, 1U, 3U}) {  // …fe, …ff, 0, 3: two lost
    id += step;
    wire::State state = aiv.state(fixture.now);
    state.header.header_id = id;
    fixture.now += 20ms;
    state.header.timestamp = fixture.now;
    fixture.send(aiv, "state", vda::encode(state));
  }
  EXPECT_THAT(fixture.server->summary_json(), HasSubstr("\"missed\":2"));
}

TEST(VehicleReports, extrapolate_from_the_arrival_when_a_vehicle_s_clock_is_wrong) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.clock_ahead = -100s;
  fixture.run_for(10s);
  EXPECT_TRUE(fixture.logged("clock"));
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  EXPECT_LT(*shown.number("age_ms"), 150.0);
  const Pose2 ground_truth = aiv.pose();
  EXPECT_LT(distance({*shown.number("x"), *shown.number("y")}, position(ground_truth)), 0.03);
  EXPECT_THAT(
      (*shown.find("errors")->array()).back().text() != nullptr ? *(*shown.find("errors")->array()).back().text() : "",
      HasSubstr("clock"));
}

TEST(VehicleReports, tolerate_malformed_messages_on_every_topic_and_serve_valid_ones) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  const std::vector<std::string> garbage{"",
                                         "{",
                                         "null",
                                         "[]",
                                         "\xFF\xFE",
                                         R"({"headerId":-1})",
                                         R"({"agvPosition":{"x":1e999,"y":0}})",
                                         std::string(300'000, '['),
                                         R"({"manufacturer":1,"serialNumber":[]})"};
  for (const std::string& payload : garbage)
    for (const char* topic : {"state", "visualization", "connection", "factsheet"}) {
      fixture.send(aiv, topic, payload);
      fixture.feed(wire::InputKind::message, std::string("uagv/v2/Acme/x1/") + topic, payload);
    }
  for (const char* topic : {"", "/", "uagv", "uagv/v2//x/state", "uagv/v3/Acme/new/state", "uagv/v2/Ac me/x/state",
                            "uagv/v2/Acme/x/order", "uagv/v2/Acme/x/y/state", "cosiva/v1/zone/", "other/v2/a/b/state"})
    fixture.feed(wire::InputKind::message, topic, "{}");
  fixture.run_for(2s);
  EXPECT_GT(aiv.speed_mps, 0.0);
  EXPECT_EQ(*fixture.bijection().number("matched"), 1.0);
  EXPECT_TRUE(fixture.logged("v3"));
}

TEST(VehicleReports, refuse_impossible_positions_and_versions) {
  ServerFixture fixture;
  FixtureVehicle& far = fixture.add("AIV1", {0, 0.5});
  wire::State state = far.state(fixture.now);
  state.position->pose.x_m = 1e6;
  fixture.send(far, "state", vda::encode(state));
  EXPECT_TRUE(fixture.logged("100 km"));
  FixtureVehicle& newer = fixture.add("AIV2", {0, 0.5});
  newer.version = "3.0.0";
  fixture.send(newer, "state", vda::encode(newer.state(fixture.now)));
  EXPECT_TRUE(fixture.logged("3.0.0"));
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
}

TEST(VehicleReports, accept_no_more_vehicles_than_the_limit) {
  ServerFixture fixture;
  for (int i = 0; i < 1000; ++i)
    fixture.feed(
        wire::InputKind::message, "uagv/v2/Flood/n" + std::to_string(i) + "/connection",
        R"({"headerId":0,"timestamp":"2023-07-11T00:00:00.000Z","version":"2.1.0","manufacturer":"Flood","serialNumber":"n)" +
            std::to_string(i) + R"(","connectionState":"ONLINE"})");
  EXPECT_TRUE(fixture.logged("256 vehicles"));
  EXPECT_LT(fixture.logs.size(), 300U);
}

TEST(VehicleReports, show_events_of_the_physical_side_with_their_latency) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  aiv.information = {{"lastTag", "", {{"tag", "12"}, {"distance_m", "0.25"}}}};
  aiv.charge = 88.9;
  aiv.blocked = true;
  aiv.state_due = true;
  fixture.run_for(1s);
  const JsonValue metrics = fixture.bijection();
  const JsonValue& kinds = *metrics.find("events")->find("by_kind");
  EXPECT_EQ(*kinds.number("tag"), 1.0);
  EXPECT_EQ(*kinds.number("obstacle"), 1.0);
  EXPECT_EQ(*kinds.number("stop"), 1.0);
  EXPECT_EQ(*kinds.number("battery"), 1.0);
  EXPECT_NEAR(*metrics.find("events")->find("latency_ms")->number("p50"), 4.0, 0.5);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("lastTag"), 12.0);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("sinceTag_m"), 0.25);
}

}  // namespace
}  // namespace cosiva::virtual_side
