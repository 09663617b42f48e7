// Ten deliberate violations of the bijection: each is found within a second of its evidence, and explained.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

/// Two vehicles of which the first one can be disturbed, and a camera that sees the whole zone.
class Violation : public testing::Test {
 protected:
  Violation() {
    aiv.blocked = true;
    other.blocked = true;
    run(3s);
  }

  /// Four images per second.
  void run(SimDuration duration) {
    for (const SimTime end = fixture.now + duration; fixture.now < end;) {
      fixture.run_for(240ms);
      if (camera) send_image();
    }
  }
  void send_image() {
    wire::GvsDetections image{++images, fixture.now - 100ms, 0.25, {}, {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}}};
    for (const auto& [name, pose] : bodies) image.detections.push_back({name, 1, fixture.now - 98ms, pose, 0.001});
    fixture.feed(wire::InputKind::message, "cosiva/v1/gvs/detections", wire::to_json(image), false);
  }
  void watch() {
    camera = true;
    bodies = {{"CoSiVA/AIV1", aiv.pose()}, {"CoSiVA/AIV2", other.pose()}};
    run(4s);
  }

  /// What the monitor states about an id, as "side or kind: reason"; nothing: the bijection holds for it.
  [[nodiscard]] std::optional<std::string> statement_about(const std::string& id) const {
    const JsonValue bijection = fixture.bijection();
    for (const JsonValue& orphan : *bijection.find("orphans")->array())
      if (orphan.text("id") == id) return *orphan.text("side") + ": " + orphan.text("reason").value_or("");
    for (const JsonValue& finding : *bijection.find("findings")->array())
      if (finding.text("id") == id) return *finding.text("kind") + ": " + finding.text("text").value_or("");
    return std::nullopt;
  }
  /// There is evidence from now on: within a second the monitor states this, and counts the time as not matched.
  void expect_within_a_second(const std::string& id, const std::string& statement) {
    EXPECT_EQ(statement_about(id), std::nullopt) << "before the evidence";
    const double matched_ratio = *fixture.bijection().number("matched_ratio");
    run(960ms);
    EXPECT_EQ(statement_about(id).value_or("nothing"), statement);
    run(1s);
    EXPECT_LT(*fixture.bijection().number("matched_ratio"), matched_ratio);
  }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
  FixtureVehicle& other{fixture.add("AIV2", {0, 2.5})};
  bool camera{false};
  std::vector<std::pair<std::string, Pose2>> bodies;
  std::uint32_t images{0};
};

TEST_F(Violation, by_none_is_not_found) {
  watch();
  EXPECT_EQ(statement_about("CoSiVA/AIV1"), std::nullopt);
  EXPECT_EQ(statement_about("CoSiVA/AIV2"), std::nullopt);
  EXPECT_EQ(*fixture.bijection().number("matched_ratio"), 1.0);
}

TEST_F(Violation, by_a_vehicle_that_signs_off_is_found) {
  aiv.alive = false;
  fixture.connection(aiv, wire::ConnectionState::offline);
  expect_within_a_second("CoSiVA/AIV1", "virtual: it has signed off (OFFLINE)");
}

TEST_F(Violation, by_a_vehicle_whose_connection_ends_is_found) {
  aiv.alive = false;
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  expect_within_a_second("CoSiVA/AIV1", "virtual: its connection has ended (CONNECTIONBROKEN)");
}

TEST_F(Violation, by_a_vehicle_that_no_longer_reports_is_found) {
  aiv.alive = false;
  run(960ms);  // the silence ends after a second
  expect_within_a_second("CoSiVA/AIV1", "virtual: it no longer reports, although it is ONLINE");
}

// The process hangs while its connection library still responds, as one that is stopped by a debugger.
TEST_F(Violation, by_a_frozen_process_that_still_announces_its_connection_is_found) {
  aiv.alive = false;
  run(480ms);
  fixture.connection(aiv, wire::ConnectionState::online);
  run(480ms);
  expect_within_a_second("CoSiVA/AIV1", "virtual: it no longer reports, although it is ONLINE");
}

TEST_F(Violation, by_two_programs_under_one_name_is_found) {
  fixture.add("AIV1", {2, 0.5}).blocked = true;
  expect_within_a_second("CoSiVA/AIV1", "two programs: two programs report under this name");
}

TEST_F(Violation, by_a_body_that_only_the_camera_sees_is_found) {
  watch();
  bodies.emplace_back("ACME/9", Pose2{5.0, 5.0, 0.0});
  run(240ms);  // the first image of it
  expect_within_a_second("ACME/9", "physical: the camera sees it (tag 1) at (5.0, 5.0), and it has no twin");
}

TEST_F(Violation, by_a_vehicle_that_was_carried_away_is_found) {
  watch();
  bodies.front().second = aiv.pose() * Pose2{0.0, 0.5, 0.0};
  expect_within_a_second("CoSiVA/AIV1", "displaced: the camera sees it at (0.5, 0.5), 0.5 m from its twin");
}

TEST_F(Violation, by_a_vehicle_that_was_taken_away_while_its_program_reports_is_found) {
  watch();
  bodies.erase(bodies.begin());
  run(2880ms);  // a marker may be covered for three seconds
  expect_within_a_second("CoSiVA/AIV1", "not detected: its twin is at (0.5, 0.0), where the camera sees no AIV");
}

TEST_F(Violation, by_a_tag_that_was_moved_on_one_side_is_found) {
  aiv.motion.shift(fixture.zone->circuit, 0.4);
  wire::Information tag;
  tag.type = "lastTag";
  tag.references = {{"tag", "7"}};
  aiv.information = {tag};
  aiv.state_due = true;
  expect_within_a_second("tag 7",
                         "displaced tag: CoSiVA/AIV1 was displaced by 0.4 m when it read the tag: the tag is elsewhere "
                         "on one side, or the vehicle was moved");
}

TEST_F(Violation, by_a_vehicle_that_reports_no_position_is_found) {
  FixtureVehicle& lost = fixture.add("AIV3", {2, 0.5});
  lost.position_known = false;
  run(960ms);  // a vehicle that was switched on may need a second
  expect_within_a_second("CoSiVA/AIV3", "physical: it reports no position");
}

}  // namespace
}  // namespace cosiva::virtual_side
