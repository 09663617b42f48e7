// The detections of the camera over the zone (GVS) compared with the twins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  watch(2s, {{"CoSiVA/AIV1", aiv.pose()}, {"CoSiVA/AIV7", there}});
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

}  // namespace
}  // namespace cosiva::virtual_side
