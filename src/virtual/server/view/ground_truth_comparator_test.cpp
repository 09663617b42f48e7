// The detections of the camera over the zone (GVS) compared with the twins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/virtual/server/view/ground_truth_comparator.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class GvsFixture : public testing::Test {
 protected:
  GvsFixture() {
    aiv.blocked = true;  // the vehicle is stopped, so that only the test causes differences
    fixture.run_for(1s);
  }
  void connect(wire::ConnectionState state, const std::string& trouble = {}) {
    fixture.feed(wire::InputKind::message, "cosiva/v1/gvs/connection",
                 wire::to_json(wire::GvsConnection{state, fixture.now, "a camera", trouble}), true);
  }
  /// An image exposed a tenth of a second ago, by a camera whose field of view covers the oval.
  void detect(const std::vector<std::pair<std::string, Pose2>>& vehicles) {
    wire::GvsDetections detections{++images, fixture.now - 100ms, 0.25, {}, {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}}};
    for (const auto& [name, pose] : vehicles)
      detections.detections.push_back(
          {name, static_cast<std::uint32_t>(detections.detections.size() + 1), fixture.now - 98ms, pose, 0.001});
    publish(wire::to_json(detections));
  }
  void publish(std::string payload, bool retained = false) {
    fixture.feed(wire::InputKind::message, "cosiva/v1/gvs/detections", std::move(payload), retained);
  }
  /// Four images per second of these vehicles, all stopped.
  void watch(SimDuration duration, const std::vector<std::pair<std::string, Pose2>>& vehicles) {
    for (const SimTime end = fixture.now + duration; fixture.now < end;) {
      fixture.run_for(240ms);
      detect(vehicles);
    }
  }
  [[nodiscard]] JsonValue gvs() const { return *fixture.snapshot().find("gvs"); }
  [[nodiscard]] JsonValue::Array detected() const { return *gvs().find("detections")->array(); }
  [[nodiscard]] JsonValue::Array findings() const { return *fixture.bijection().find("findings")->array(); }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
  std::uint32_t images{0};
};

TEST_F(GvsFixture, without_a_camera_there_is_no_data) {
  EXPECT_TRUE(gvs().is_null());
  EXPECT_THAT(findings(), IsEmpty());
  EXPECT_EQ(*fixture.bijection().find("actual_m")->number("count"), 0.0);
}

TEST_F(GvsFixture, measures_the_distance_of_a_twin_from_the_detected_vehicle) {
  connect(wire::ConnectionState::online);
  fixture.run_for(500ms);
  const Pose2 twin = aiv.pose();
  detect({{"CoSiVA/AIV1", twin * Pose2{0.03, 0.04, 0.2}}});
  ASSERT_THAT(detected(), SizeIs(1));
  EXPECT_NEAR(detected()[0].number("gap_m").value_or(-1.0), 0.05, 1e-4);
  EXPECT_NEAR(detected()[0].number("gap_rad").value_or(-1.0), 0.2, 1e-4);
  EXPECT_EQ(detected()[0].flag("twin"), true);
  EXPECT_EQ(gvs().text("state"), "watching");
  const JsonValue actual = *fixture.bijection().find("actual_m");
  EXPECT_EQ(*actual.number("count"), 1.0);
  EXPECT_NEAR(*actual.number("max"), 0.05, 1e-4);
}

TEST_F(GvsFixture, compares_an_image_with_the_twin_s_pose_at_the_exposure) {
  connect(wire::ConnectionState::online);
  aiv.blocked = false;
  fixture.run_for(2s);
  // Half a second late: at 0.3 m/s or more the twin has moved on by 15 cm.
  const Pose2 then = fixture.vehicles[0]->pose();
  const SimTime at = fixture.now;
  fixture.run_for(500ms);
  ASSERT_GT(distance(then, fixture.vehicles[0]->pose()), 0.1);
  wire::GvsDetections detections{++images, at, 0.25, {{"CoSiVA/AIV1", 1, at, then, 0.001}}, {}};
  publish(wire::to_json(detections));
  ASSERT_THAT(detected(), SizeIs(1));
  EXPECT_LT(detected()[0].number("gap_m").value_or(9.0), 0.02);
}

TEST_F(GvsFixture, compares_nothing_older_than_its_history_or_in_the_future) {
  connect(wire::ConnectionState::online);
  fixture.run_for(3s);
  for (const SimDuration off : {SimDuration{-10s}, SimDuration{10s}}) {
    publish(wire::to_json(wire::GvsDetections{
        ++images, fixture.now + off, 0.25, {{"CoSiVA/AIV1", 1, fixture.now + off, aiv.pose(), 0.001}}, {}}));
    ASSERT_THAT(detected(), SizeIs(1));
    EXPECT_TRUE(detected()[0].find("gap_m")->is_null());
    fixture.run_for(100ms);
  }
}

TEST_F(GvsFixture, reports_an_aiv_without_a_twin_after_a_while_and_until_it_has_one) {
  const zone::TrackPosition position{0, 1.5};
  const Pose2 there = fixture.zone->circuit.pose_at(position);
  watch(720ms, {{"CoSiVA/AIV1", aiv.pose()}, {"CoSiVA/AIV7", there}});
  EXPECT_THAT(findings(), IsEmpty()) << "its first report may be in transit";
  const double matched = *fixture.bijection().number("matched_ratio");
  watch(2s, {{"CoSiVA/AIV1", aiv.pose()}, {"CoSiVA/AIV7", there}});
  ASSERT_THAT(findings(), SizeIs(1));
  EXPECT_EQ(findings()[0].text("kind"), "no twin");
  EXPECT_EQ(findings()[0].text("id"), "CoSiVA/AIV7");
  EXPECT_THAT(findings()[0].text("text").value(), HasSubstr("(tag 2)"));
  EXPECT_LT(*fixture.bijection().number("matched_ratio"), matched);
  fixture.add("AIV7", position).blocked = true;
  watch(1s, {{"CoSiVA/AIV1", aiv.pose()}, {"CoSiVA/AIV7", there}});
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(GvsFixture, reports_a_twin_that_the_camera_does_not_detect) {
  watch(2s, {});
  EXPECT_THAT(findings(), IsEmpty());
  watch(2s, {});
  ASSERT_THAT(findings(), SizeIs(1));
  EXPECT_EQ(findings()[0].text("kind"), "not detected");
  EXPECT_EQ(findings()[0].text("id"), "CoSiVA/AIV1");
  EXPECT_THAT(findings()[0].text("text").value(), HasSubstr("sees no AIV"));
  watch(1s, {{"CoSiVA/AIV1", aiv.pose()}});
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(GvsFixture, reports_no_twin_outside_the_field_of_view_as_missing) {
  for (int i = 0; i < 30; ++i) {
    fixture.run_for(240ms);
    publish(wire::to_json(wire::GvsDetections{++images, fixture.now, 0.25, {}, {{50, 50}, {51, 50}, {51, 51}}}));
  }
  EXPECT_EQ(gvs().text("state"), "watching");
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(GvsFixture, a_virtual_aiv_is_neither_detected_nor_missed_by_a_camera) {
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":")" +
                       fixture.zone->circuit.part(0).name + R"(","s":1.4}})");
  watch(6s, {{"CoSiVA/AIV1", aiv.pose()}});
  ASSERT_EQ(*fixture.bijection().number("augmented"), 1.0);
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(GvsFixture, reports_that_no_image_arrives_and_why) {
  connect(wire::ConnectionState::online);
  watch(1s, {{"CoSiVA/AIV1", aiv.pose()}});
  EXPECT_THAT(findings(), IsEmpty());
  fixture.run_for(2100ms);
  EXPECT_EQ(gvs().text("state"), "unresponsive");
  connect(wire::ConnectionState::online, "/dev/video0: no camera answers there");
  fixture.run_for(100ms);
  ASSERT_THAT(findings(), SizeIs(1)) << "neither vehicles nor twins are known now";
  EXPECT_EQ(findings()[0].text("kind"), "no detection");
  EXPECT_EQ(findings()[0].text("id"), "GVS");
  EXPECT_THAT(findings()[0].text("text").value(), HasSubstr("/dev/video0"));
  const double matched = *fixture.bijection().number("matched_ratio");
  fixture.run_for(5s);
  EXPECT_GE(*fixture.bijection().number("matched_ratio"), matched) << "a camera without images proves nothing";
  connect(wire::ConnectionState::online);
  watch(500ms, {{"CoSiVA/AIV1", aiv.pose()}});
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(GvsFixture, reports_that_the_camera_program_failed_but_not_that_it_ended_normally) {
  connect(wire::ConnectionState::online);
  watch(1s, {{"CoSiVA/AIV1", aiv.pose()}});
  connect(wire::ConnectionState::connection_broken);
  fixture.run_for(100ms);
  EXPECT_EQ(gvs().text("state"), "broken");
  ASSERT_THAT(findings(), SizeIs(1));
  EXPECT_THAT(findings()[0].text("text").value(), HasSubstr("program is gone"));
  connect(wire::ConnectionState::offline);
  fixture.run_for(10s);
  EXPECT_EQ(gvs().text("state"), "ended");
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(GvsFixture, violates_the_contract_of_a_twin_far_from_its_vehicle) {
  watch(5s, {{"CoSiVA/AIV1", aiv.pose()}});
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("contract")->flag("actual"), true);
  watch(5s, {{"CoSiVA/AIV1", aiv.pose() * Pose2{0.0, 0.2, 0.0}}});
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("contract")->flag("actual"), false);
  EXPECT_LT(*fixture.bijection().number("held_ratio"), 1.0);
}

TEST_F(GvsFixture, unreadable_or_old_messages_change_nothing) {
  detect({{"CoSiVA/AIV1", aiv.pose()}});
  const std::string before = fixture.server->snapshot_json();
  publish("{");
  publish(R"({"headerId":1})");
  publish(wire::to_json(wire::GvsDetections{9, fixture.now, 0.25, {{"CoSiVA/AIV9", 9, fixture.now, {}, 0.0}}, {}}),
          true);
  publish(
      wire::to_json(wire::GvsDetections{0, fixture.now - 1s, 0.25, {{"CoSiVA/AIV8", 8, fixture.now, {}, 0.0}}, {}}));
  EXPECT_EQ(fixture.server->snapshot_json(), before);
  EXPECT_TRUE(fixture.logged("cosiva/v1/gvs/detections"));
}

TEST_F(GvsFixture, a_flood_of_names_uses_bounded_memory) {
  for (int i = 0; i < 3; ++i) {
    wire::GvsDetections detections{++images, fixture.now, 0.25, {}, {}};
    for (std::uint32_t n = 0; n < 200; ++n)
      detections.detections.push_back(
          {"made/up" + std::to_string(200U * static_cast<unsigned>(i) + n), n, fixture.now, {}, 0.0});
    publish(wire::to_json(detections));
    fixture.run_for(20ms);
  }
  EXPECT_THAT(detected(), SizeIs(GroundTruthComparator::detected_max));
}

/// The comparator without a server around it, in the oval: the test determines when images arrive.
class GroundTruth : public testing::Test {
 protected:
  using Detection = wire::GvsDetections::Detection;

  [[nodiscard]] Result<std::string> receive(std::string_view topic, std::string payload, bool retained = false) {
    return comparator.on_message(
        orders.now, {orders.now, wire::InputKind::message, std::string(topic), std::move(payload), retained});
  }
  std::string connect(wire::ConnectionState state, const std::string& trouble = {}) {
    return receive(wire::gvs_connection_topic,
                   wire::to_json(wire::GvsConnection{state, orders.now, "a camera", trouble}))
        .value();
  }
  /// An image with a later time stamp than the one before.
  std::string detect(std::vector<Detection> vehicles, double period_s = 0.25) {
    stamp += 1ms;
    return receive(wire::gvs_detections_topic,
                   wire::to_json(wire::GvsDetections{1, stamp, period_s, std::move(vehicles), corners}))
        .value();
  }
  [[nodiscard]] Detection vehicle_at(const std::string& name, const Pose2& X_MB) const {
    return {name, 7, orders.now, X_MB, 0.001};
  }
  void pass(SimDuration duration) {
    orders.pass(duration);
    comparator.tick(orders.now, true);
  }
  /// An image of these vehicles after every second.
  void watch_seconds(int count, const std::vector<Detection>& vehicles) {
    for (int i = 0; i < count; ++i) {
      pass(1s);
      detect(vehicles);
    }
  }
  VehicleIndex add_twin(const std::string& serial, zone::TrackPosition position, double speed_mps = 0.0) {
    const VehicleIndex vehicle = orders.add_at(serial, position);
    AivProxy& proxy = orders.proxy(vehicle);
    proxy.twin_link.on_monitored(orders.server.simulator.monitor().entity(proxy.name()));
    orders.report_at(vehicle, position, speed_mps);
    return vehicle;
  }
  [[nodiscard]] Pose2 twin_pose(VehicleIndex vehicle) {
    return orders.server.simulator.image(*orders.proxy(vehicle).twin(), orders.now).X_MB;
  }
  [[nodiscard]] const std::vector<Finding>& found() const { return orders.server.simulator.monitor().findings(); }
  [[nodiscard]] JsonValue shown() const {
    JsonWriter json;
    comparator.write(json);
    return *JsonValue::parse(json.text());
  }
  [[nodiscard]] JsonValue bijection() const {
    JsonWriter json;
    orders.server.simulator.monitor().write(json);
    return *JsonValue::parse(json.text());
  }
  [[nodiscard]] JsonValue::Array shown_detections() const { return *shown().find("detections")->array(); }
  /// Of the first detection.
  [[nodiscard]] std::optional<double> gap_m() const { return shown_detections().front().number("gap_m"); }
  /// Whether the twin at (0.5, 0) counts as missing where the camera detects whole tags only within this polygon.
  [[nodiscard]] bool expected_within(std::vector<Point2> polygon) {
    corners = std::move(polygon);
    watch_seconds(7, {});
    return !found().empty();
  }

  OrdersFixture orders;
  GroundTruthComparator comparator{orders.server.registry, orders.server.simulator};
  SimTime stamp{virtual_epoch};
  std::vector<Point2> corners{{-9, -9}, {9, -9}, {9, 9}, {-9, 9}};
};

TEST_F(GroundTruth, subscribes_to_detections_and_connection) {
  EXPECT_THAT(
      GroundTruthComparator::subscriptions(),
      testing::ElementsAre("cosiva/v1/gvs/detections", "cosiva/v1/gvs/connection", "cosiva/v1/reference/poses"));
}

TEST_F(GroundTruth, is_measured_by_an_instrument_where_no_camera_watches) {
  (void)add_twin("AIV1", orders.at("south", 0.5));
  const auto send = [&](const Pose2& X_MB) {
    pass(20ms);
    wire::GvsDetections poses{0, orders.now, 1.0, {{"CoSiVA/AIV1", 0, orders.now, X_MB, 0.0}}, {}};
    EXPECT_TRUE(comparator.on_message(
        orders.now,
        {orders.now, wire::InputKind::message, std::string(wire::reference_poses_topic), wire::to_json(poses), false}));
  };
  const Pose2 at = orders.server.simulator.circuit()->pose_at(orders.at("south", 0.5));
  send(at);  // from now on the poses of twins are recorded
  send(at * Pose2{0.0, 0.03, 0.0});
  const auto& monitor = orders.server.simulator.monitor();
  EXPECT_EQ(bijection().find("references")->text("actual"), "instrument");
  EXPECT_EQ(monitor.actual_m().count(), 1U);
  EXPECT_NEAR(monitor.actual_m().max(), 0.03, 1e-6);
  EXPECT_THAT(found(), IsEmpty());
  connect(wire::ConnectionState::online);
  detect({vehicle_at("CoSiVA/AIV1", at)});
  pass(20ms);
  send(at * Pose2{0.0, 0.09, 0.0});
  EXPECT_EQ(bijection().find("references")->text("actual"), "camera");
  EXPECT_LT(monitor.actual_m().max(), 0.01) << "a camera that watches is the reference";
}

TEST_F(GroundTruth, summarises_the_connection_with_its_trouble) {
  EXPECT_EQ(connect(wire::ConnectionState::online), "unresponsive");
  EXPECT_EQ(connect(wire::ConnectionState::online, "no camera"), "unresponsive: no camera");
  EXPECT_EQ(connect(wire::ConnectionState::offline), "ended");
  EXPECT_EQ(connect(wire::ConnectionState::connection_broken, "cable"), "broken: cable");
  EXPECT_EQ(receive(wire::gvs_connection_topic, "{").error().code, "json.syntax");
  EXPECT_EQ(shown().text("state"), "broken");
  EXPECT_EQ(receive(wire::gvs_connection_topic, ""), "");
  EXPECT_TRUE(shown().is_null()) << "the retained message was deleted";
  detect({});
  EXPECT_EQ(connect(wire::ConnectionState::online), "watching");
}

TEST_F(GroundTruth, summarises_an_image_only_where_the_number_of_vehicles_changes) {
  EXPECT_EQ(detect({}), "0 in the image");
  EXPECT_EQ(detect({}), "");
  EXPECT_EQ(detect({vehicle_at("CoSiVA/AIV7", {})}), "1 in the image");
  EXPECT_EQ(detect({vehicle_at("CoSiVA/AIV8", {})}), "");
}

TEST_F(GroundTruth, ignores_retained_images_empty_ones_and_the_preview) {
  const std::string image = wire::to_json(wire::GvsDetections{1, stamp, 0.25, {vehicle_at("CoSiVA/AIV7", {})}, {}});
  EXPECT_EQ(receive(wire::gvs_detections_topic, image, true), "");
  EXPECT_EQ(receive(wire::gvs_detections_topic, ""), "");
  EXPECT_EQ(receive(wire::gvs_preview_topic, image), "");
  EXPECT_TRUE(shown().is_null());
  EXPECT_EQ(receive(wire::gvs_detections_topic, "{").error().code, "json.syntax");
  EXPECT_EQ(receive(wire::gvs_detections_topic, image), "1 in the image");
}

TEST_F(GroundTruth, ignores_an_image_that_was_overtaken_but_not_one_after_a_clock_was_set_back) {
  const SimTime last = virtual_epoch + 60s;
  const auto receive_image = [&](SimTime timestamp, std::size_t vehicles) {
    wire::GvsDetections image{1, timestamp, 0.25, {}, {}};
    for (std::size_t i = 0; i < vehicles; ++i)
      image.detections.push_back(vehicle_at("CoSiVA/AIV" + std::to_string(i), {}));
    return receive(wire::gvs_detections_topic, wire::to_json(image));
  };
  EXPECT_EQ(receive_image(last, 0), "0 in the image");
  EXPECT_EQ(receive_image(last, 1), "");
  EXPECT_EQ(receive_image(last - 4999ms, 1), "");
  EXPECT_THAT(shown_detections(), IsEmpty());
  EXPECT_EQ(receive_image(last - 5s, 1), "1 in the image");
  EXPECT_EQ(receive_image(last - 4999ms, 2), "2 in the image");
}

TEST_F(GroundTruth, is_unresponsive_after_two_seconds_or_three_periods) {
  detect({}, 0.25);
  pass(2s);
  EXPECT_EQ(shown().text("state"), "watching");
  pass(1ms);
  EXPECT_EQ(shown().text("state"), "unresponsive");
  detect({}, 1.0);
  pass(3s);
  EXPECT_EQ(shown().text("state"), "watching");
  pass(1ms);
  EXPECT_EQ(shown().text("state"), "unresponsive");
}

TEST_F(GroundTruth, shows_each_field_of_a_detection) {
  connect(wire::ConnectionState::online, "dark");
  EXPECT_TRUE(shown().find("last_ms")->is_null());
  EXPECT_TRUE(shown().find("period_s")->is_null());
  detect({{"CoSiVA/AIV7", 12, orders.now - 50ms, {1.23456, -0.25, 0.5}, 0.00123}});
  const JsonValue all = shown();
  EXPECT_EQ(all.text("source"), "a camera");
  EXPECT_EQ(all.text("trouble"), "dark");
  EXPECT_NEAR(*all.number("last_ms"), to_milliseconds_scaled(orders.now), 0.01);
  EXPECT_EQ(all.number("period_s"), 0.25);
  const JsonValue detected = shown_detections().at(0);
  EXPECT_EQ(detected.text("id"), "CoSiVA/AIV7");
  EXPECT_EQ(detected.number("tag"), 12.0);
  EXPECT_EQ(detected.flag("twin"), false);
  EXPECT_NEAR(*detected.number("x"), 1.2346, 1e-9);
  EXPECT_NEAR(*detected.number("y"), -0.25, 1e-9);
  EXPECT_NEAR(*detected.number("heading"), 0.5, 1e-9);
  EXPECT_NEAR(*detected.number("uncertainty_m"), 0.0012, 1e-9);
  EXPECT_NEAR(*detected.number("at_ms"), to_milliseconds_scaled(orders.now - 50ms), 0.01);
  EXPECT_TRUE(detected.find("gap_m")->is_null());
  EXPECT_TRUE(detected.find("gap_rad")->is_null());
}

TEST_F(GroundTruth, shows_no_source_without_a_connection) {
  detect({});
  EXPECT_EQ(shown().text("source"), "");
  EXPECT_EQ(shown().text("trouble"), "");
}

TEST_F(GroundTruth, interpolates_the_pose_of_a_twin_between_two_ticks) {
  const VehicleIndex vehicle = add_twin("AIV1", orders.at("east", 0.3), 0.4);
  connect(wire::ConnectionState::online);
  pass(0ms);
  const SimTime first = orders.now;
  const Pose2 a = twin_pose(vehicle);
  pass(100ms);
  const Pose2 b = twin_pose(vehicle);
  ASSERT_NEAR(distance(a, b), 0.04, 1e-3);
  // A quarter of the time from a to b.
  const Pose2 between{a.x_m + 0.25 * (b.x_m - a.x_m), a.y_m + 0.25 * (b.y_m - a.y_m),
                      a.heading_rad + 0.25 * (b.heading_rad - a.heading_rad)};
  detect({{"CoSiVA/AIV1", 7, first + 25ms, between, 0.001}});
  EXPECT_EQ(gap_m(), 0.0);
  EXPECT_EQ(shown_detections().at(0).number("gap_rad"), 0.0);
  detect({{"CoSiVA/AIV1", 7, first + 100ms, b, 0.001}});
  EXPECT_EQ(gap_m(), 0.0);
}

TEST_F(GroundTruth, compares_detections_with_the_last_two_seconds) {
  const Pose2 twin = twin_pose(add_twin("AIV1", orders.at("south", 0.5)));
  connect(wire::ConnectionState::online);
  pass(0ms);
  const SimTime first = orders.now;
  const auto compares = [&](SimTime at) {
    detect({{"CoSiVA/AIV1", 7, at, twin, 0.001}});
    return gap_m().has_value();
  };
  EXPECT_FALSE(compares(first - 1ms));
  EXPECT_TRUE(compares(first));
  EXPECT_FALSE(compares(first + 1ms));
  for (int i = 0; i < 4; ++i) pass(500ms);
  EXPECT_TRUE(compares(first));
  EXPECT_TRUE(compares(first + 2s));
  pass(1ms);
  EXPECT_FALSE(compares(first));
  EXPECT_TRUE(compares(first + 500ms));
}

TEST_F(GroundTruth, measures_the_gap_of_position_and_heading) {
  const Pose2 twin = twin_pose(add_twin("AIV1", orders.at("south", 0.5)));
  connect(wire::ConnectionState::online);
  pass(0ms);
  detect({vehicle_at("CoSiVA/AIV1", twin * Pose2{0.03, -0.04, 0.2})});
  EXPECT_NEAR(gap_m().value_or(-1.0), 0.05, 1e-9);
  EXPECT_NEAR(shown_detections().at(0).number("gap_rad").value_or(-1.0), 0.2, 1e-9);
  EXPECT_EQ(orders.server.simulator.monitor().actual_m().count(), 1U);
  pass(1ms);
  detect({vehicle_at("CoSiVA/AIV1", {})});
  EXPECT_NEAR(gap_m().value_or(-1.0), 0.5, 1e-9);
}

TEST_F(GroundTruth, reports_a_vehicle_without_a_twin_within_a_second_with_its_position) {
  connect(wire::ConnectionState::online);
  const std::vector<Detection> there{vehicle_at("CoSiVA/AIV7", {-1.57, 0.02, 0.0})};
  detect(there);
  pass(900ms);
  EXPECT_THAT(found(), IsEmpty());
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  const Finding first{Finding::Kind::no_twin, "CoSiVA/AIV7",
                      "the camera sees it (tag 7) at (-1.6, 0.0), and it has no twin", orders.now, true};
  EXPECT_EQ(found().front(), first);
  pass(500ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front(), first) << "since then";
  comparator.tick(orders.now, false);
  EXPECT_THAT(found(), IsEmpty()) << "it may belong to another control area";
}

TEST_F(GroundTruth, writes_positions_in_whole_decimetres) {
  connect(wire::ConnectionState::online);
  const std::vector<Detection> there{vehicle_at("CoSiVA/AIV7", {2.04, -0.37, 0.0})};
  watch_seconds(4, there);
  pass(500ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_THAT(found().front().text, HasSubstr("(2.0, -0.4)"));
}

TEST_F(GroundTruth, reports_no_vehicle_that_has_not_been_detected_for_three_seconds) {
  connect(wire::ConnectionState::online);
  const std::vector<Detection> there{vehicle_at("CoSiVA/AIV7", {})};
  detect(there);
  watch_seconds(4, there);
  watch_seconds(2, {});
  pass(1s);
  EXPECT_THAT(found(), SizeIs(1)) << "detected three seconds ago";
  pass(1ms);
  EXPECT_THAT(found(), IsEmpty());
  detect({});
  pass(1s);
  detect({});
  pass(1s);
  detect({});
  pass(999ms);
  EXPECT_THAT(shown_detections(), SizeIs(1)) << "six seconds ago";
  pass(1ms);
  EXPECT_THAT(shown_detections(), IsEmpty());
}

TEST_F(GroundTruth, continues_a_series_of_detections_over_a_gap_of_three_seconds) {
  connect(wire::ConnectionState::online);
  const std::vector<Detection> there{vehicle_at("CoSiVA/AIV7", {})};
  detect(there);
  watch_seconds(3, {});
  watch_seconds(1, there);
  pass(1ms);
  EXPECT_THAT(found(), SizeIs(1));
}

TEST_F(GroundTruth, begins_another_series_after_a_longer_gap) {
  connect(wire::ConnectionState::online);
  const std::vector<Detection> there{vehicle_at("CoSiVA/AIV7", {})};
  detect(there);
  watch_seconds(3, {});
  pass(1ms);
  detect({});
  watch_seconds(1, there);
  pass(900ms);
  EXPECT_THAT(found(), IsEmpty()) << "0.9 s after the second series began";
  pass(1ms);
  EXPECT_THAT(found(), SizeIs(1));
}

TEST_F(GroundTruth, retains_the_time_of_each_finding) {
  connect(wire::ConnectionState::online);
  const SimTime begin = orders.now;
  const Detection seventh = vehicle_at("CoSiVA/AIV7", {});
  const Detection eighth = vehicle_at("CoSiVA/AIV8", {1.0, 0.0, 0.0});
  detect({seventh});
  watch_seconds(6, {seventh, eighth});
  ASSERT_THAT(found(), SizeIs(2));
  EXPECT_EQ(found()[0].id, "CoSiVA/AIV7");
  EXPECT_EQ(found()[0].since, begin + 1s);
  EXPECT_EQ(found()[1].id, "CoSiVA/AIV8");
  EXPECT_EQ(found()[1].since, begin + 2s);
}

TEST_F(GroundTruth, reports_a_twin_that_is_not_detected_for_three_seconds) {
  (void)add_twin("AIV1", orders.at("south", 0.5));
  connect(wire::ConnectionState::online);
  detect({});
  pass(0ms);
  watch_seconds(3, {});
  EXPECT_THAT(found(), IsEmpty());
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front(), (Finding{Finding::Kind::not_detected, "CoSiVA/AIV1",
                                      "its twin is at (0.5, 0.0), where the camera sees no AIV", orders.now}));
  detect({vehicle_at("CoSiVA/AIV1", {0.5, 0.0, 0.0})});
  watch_seconds(3, {});
  EXPECT_THAT(found(), IsEmpty());
  pass(1ms);
  EXPECT_THAT(found(), SizeIs(1));
}

TEST_F(GroundTruth, waits_for_three_seconds_of_images_before_it_misses_a_twin) {
  (void)add_twin("AIV1", orders.at("south", 0.5));
  connect(wire::ConnectionState::online);
  detect({});
  pass(0ms);
  pass(5s);
  detect({});
  watch_seconds(3, {});
  EXPECT_THAT(found(), IsEmpty()) << "no image arrived before";
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front().kind, Finding::Kind::not_detected);
}

TEST_F(GroundTruth, misses_a_twin_only_within_the_field_of_view) {
  (void)add_twin("AIV1", orders.at("south", 0.5));
  connect(wire::ConnectionState::online);
  EXPECT_TRUE(expected_within({{-1, -1}, {2, -1}, {2, 1}, {-1, 1}}));
  EXPECT_FALSE(expected_within({{1, -1}, {2, -1}, {2, 1}, {1, 1}}));
  EXPECT_FALSE(expected_within({{-2, -1}, {-1, -1}, {-1, 1}, {-2, 1}}));
  EXPECT_FALSE(expected_within({{-1, 1}, {2, 1}, {2, 2}, {-1, 2}}));
  EXPECT_FALSE(expected_within({{-1, -2}, {2, -2}, {2, -1}, {-1, -1}}));
  EXPECT_FALSE(expected_within({}));
  // The right edges lead through (0.6, 0) and (0.4, 0).
  EXPECT_TRUE(expected_within({{-3, -1}, {1.6, -1}, {-2.4, 3}, {-3, 3}}));
  EXPECT_FALSE(expected_within({{-3, -1}, {1.4, -1}, {-2.6, 3}, {-3, 3}}));
  EXPECT_TRUE(expected_within({{-3, 3}, {-2.4, 3}, {1.6, -1}, {-3, -1}})) << "in the other direction";
  EXPECT_FALSE(expected_within({{-3, 3}, {-2.6, 3}, {1.4, -1}, {-3, -1}}));
  EXPECT_TRUE(expected_within({{0, 0}, {1, -1}, {2, 0}, {1, 1}})) << "two corners as far up as the twin";
}

TEST_F(GroundTruth, neither_misses_nor_compares_a_vehicle_that_has_left) {
  const VehicleIndex vehicle = add_twin("AIV1", orders.at("south", 0.5));
  connect(wire::ConnectionState::online);
  detect({});
  pass(0ms);
  orders.proxy(vehicle).membership.on_retired();
  pass(1ms);
  detect({vehicle_at("CoSiVA/AIV1", {0.5, 0.0, 0.0})});
  EXPECT_EQ(shown_detections().at(0).flag("twin"), false);
  EXPECT_EQ(gap_m(), std::nullopt);
  watch_seconds(8, {});
  EXPECT_THAT(found(), IsEmpty());
}

TEST_F(GroundTruth, gives_a_camera_three_seconds_to_start) {
  connect(wire::ConnectionState::online);
  pass(3s);
  EXPECT_THAT(found(), IsEmpty());
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front(), (Finding{Finding::Kind::no_detection, "GVS", "no image arrives", orders.now}));
  connect(wire::ConnectionState::online);
  pass(3s);
  EXPECT_THAT(found(), IsEmpty()) << "it has connected again";
}

TEST_F(GroundTruth, gives_a_camera_three_seconds_from_its_last_image_or_connection) {
  connect(wire::ConnectionState::online);
  pass(10s);
  detect({});
  pass(3s);
  EXPECT_EQ(shown().text("state"), "unresponsive");
  EXPECT_THAT(found(), IsEmpty());
  pass(1ms);
  EXPECT_THAT(found(), SizeIs(1));
  connect(wire::ConnectionState::online);
  pass(3s);
  EXPECT_THAT(found(), IsEmpty());
  pass(1ms);
  EXPECT_THAT(found(), SizeIs(1));
}

TEST_F(GroundTruth, reports_missing_images_at_once_where_there_is_trouble_or_no_connection) {
  detect({});
  pass(2001ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front().text, "no image arrives");
  connect(wire::ConnectionState::online, "no camera");
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front().text, "no image arrives: no camera");
}

TEST_F(GroundTruth, reports_the_end_of_the_camera_s_program_only_where_it_failed) {
  connect(wire::ConnectionState::connection_broken);
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front(), (Finding{Finding::Kind::no_detection, "GVS", "the camera's program is gone", orders.now}));
  connect(wire::ConnectionState::connection_broken, "cable");
  pass(1ms);
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found().front().text, "the camera's program is gone: cable");
  connect(wire::ConnectionState::offline);
  pass(10s);
  EXPECT_THAT(found(), IsEmpty());
}

TEST_F(GroundTruth, folds_its_state_and_the_detections_into_the_digest) {
  Digest none;
  comparator.fold(none);
  EXPECT_EQ(none, Digest{});
  const Pose2 twin = twin_pose(add_twin("AIV1", orders.at("south", 0.5)));
  connect(wire::ConnectionState::online);
  pass(0ms);
  detect({vehicle_at("CoSiVA/AIV1", {twin.x_m, twin.y_m + 0.25, 0.0}), vehicle_at("CoSiVA/AIV7", {1.5, 0.75, 0.0})});
  const SimTime received_at = orders.now;
  pass(3s);
  Digest expected;
  expected.add(std::string_view{"unresponsive"});
  expected.add(received_at);
  expected.add(std::string_view{"CoSiVA/AIV1"});
  expected.add(twin.x_m);
  expected.add(twin.y_m + 0.25);
  expected.add(0.25);
  expected.add(std::string_view{"CoSiVA/AIV7"});
  expected.add(1.5);
  expected.add(0.75);
  expected.add(-1.0);
  Digest folded;
  comparator.fold(folded);
  EXPECT_EQ(folded, expected);
}

}  // namespace
}  // namespace cosiva::virtual_side
