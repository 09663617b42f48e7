#include "cosiva/virtual/server/view/physical_presence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Two vehicles that report ten times a second.
class PresenceOfTwo : public testing::Test {
 protected:
  PresenceOfTwo() { fixture.run_for(3s); }
  [[nodiscard]] JsonValue::Array orphans() const { return *fixture.bijection().find("orphans")->array(); }
  [[nodiscard]] double count(const char* side) const { return *fixture.bijection().number(side); }
  void expect_orphan(const std::string& reason) const {
    ASSERT_THAT(orphans(), SizeIs(1));
    EXPECT_EQ(orphans()[0].text("id"), "CoSiVA/AIV1");
    EXPECT_EQ(orphans()[0].text("side"), "virtual");
    EXPECT_EQ(orphans()[0].text("reason"), reason);
    EXPECT_EQ(count("physical"), 1.0);
    EXPECT_EQ(count("virtual"), 2.0) << "the twin stays";
    EXPECT_EQ(count("matched"), 1.0);
  }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
  FixtureVehicle& other{fixture.add("AIV2", {0, 2.5})};
};

TEST_F(PresenceOfTwo, holds_while_both_report) {
  EXPECT_THAT(orphans(), IsEmpty());
  EXPECT_EQ(count("matched"), 2.0);
}

TEST_F(PresenceOfTwo, ends_for_a_vehicle_that_signs_off) {
  aiv.alive = false;
  fixture.connection(aiv, wire::ConnectionState::offline);
  fixture.run_for(100ms);
  expect_orphan("it has signed off (OFFLINE)");
}

TEST_F(PresenceOfTwo, ends_for_a_vehicle_whose_connection_has_ended) {
  aiv.alive = false;
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  fixture.run_for(100ms);
  expect_orphan("its connection has ended (CONNECTIONBROKEN)");
}

TEST_F(PresenceOfTwo, ends_for_a_vehicle_that_is_online_and_sends_nothing_for_a_second_and_not_before) {
  aiv.alive = false;
  fixture.run_for(900ms);
  EXPECT_THAT(orphans(), IsEmpty());
  fixture.run_for(300ms);
  expect_orphan("it no longer reports, although it is ONLINE");
  fixture.run_for(600s);
  expect_orphan("it no longer reports, although it is ONLINE");
}

TEST_F(PresenceOfTwo, returns_with_the_next_report) {
  aiv.alive = false;
  fixture.run_for(5s);
  expect_orphan("it no longer reports, although it is ONLINE");
  aiv.alive = true;
  fixture.run_for(200ms);
  EXPECT_THAT(orphans(), IsEmpty());
  EXPECT_EQ(count("matched"), 2.0);
  EXPECT_LT(*fixture.bijection().number("matched_ratio"), 0.7) << "for five of eight seconds the sides differed";
}

/// The same two, one of them absent.
class DepartureOfOne : public PresenceOfTwo {
 protected:
  void sign_off() {
    aiv.alive = false;
    fixture.connection(aiv, wire::ConnectionState::offline);
    fixture.run_for(100ms);
  }
  [[nodiscard]] std::string error_of(const std::string& json) const {
    const auto checked = fixture.server->check_command(DecodedCommand{json});
    return checked ? "" : to_string(checked.error());
  }
  void retire() { fixture.send_command(R"({"command":"retire","vehicle":"CoSiVA/AIV1"})"); }
  void expect_departed() {
    EXPECT_THAT(orphans(), IsEmpty());
    EXPECT_EQ(count("virtual"), 1.0);
    EXPECT_EQ(count("matched"), 1.0);
    EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").is_null());
  }
  /// "from → to: kind content", of the steps of an arrival or a departure.
  [[nodiscard]] std::vector<std::string> steps() const {
    std::vector<std::string> found;
    const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
    for (const JsonValue& trace : *traces.find("traces")->array()) {
      const std::string kind = *trace.text("kind");
      if (kind == "appear" || kind == "disappear" || kind == "retire")
        found.push_back(*trace.text("from") + " > " + *trace.text("to") + ": " + kind + " " + *trace.text("content"));
    }
    return found;
  }
  /// Four images per second of a camera that sees the whole oval, with these vehicles.
  void watch(SimDuration duration, const std::vector<std::pair<std::string, Pose2>>& detected) {
    for (const SimTime end = fixture.now + duration; fixture.now < end;) {
      fixture.run_for(240ms);
      wire::GvsDetections image{++images, fixture.now - 100ms, 0.25, {}, {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}}};
      for (const auto& [name, pose] : detected) image.detections.push_back({name, 1, fixture.now - 98ms, pose, 0.001});
      fixture.feed(wire::InputKind::message, "cosiva/v1/gvs/detections", wire::to_json(image), false);
    }
  }
  std::uint32_t images{0};
};

TEST_F(DepartureOfOne, is_stated_by_an_operator_and_traced_as_the_inverse_of_its_arrival) {
  sign_off();
  retire();
  expect_departed();
  EXPECT_THAT(steps(),
              ElementsAre("AIV_Server > Simulator: appear CoSiVA/AIV1 gets display number 1",
                          "AIV_Server > Simulator: appear CoSiVA/AIV2 gets display number 2",
                          "operator > AIV_Server: retire CoSiVA/AIV1: an operator has retired it",
                          "AIV_Server > Simulator: disappear CoSiVA/AIV1 has left; display number 1 stays its own"));
  EXPECT_TRUE(fixture.logged("CoSiVA/AIV1: has left the zone; an operator has retired it"));
}

TEST_F(DepartureOfOne, is_refused_while_the_vehicle_reports) {
  EXPECT_THAT(error_of(R"({"command":"retire","vehicle":"CoSiVA/AIV1"})"),
              HasSubstr("CoSiVA/AIV1 reports; switch it off"));
  EXPECT_THAT(error_of(R"({"command":"retire","vehicle":"CoSiVA/AIV9"})"), HasSubstr("no vehicle 'CoSiVA/AIV9'"));
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"north","s":0.5}})");
  fixture.run_for(1s);
  EXPECT_THAT(error_of(R"({"command":"retire","vehicle":"CoSiVA.virtual/V1"})"), HasSubstr("remove it instead"));
  retire();
  EXPECT_EQ(count("matched"), 2.0);
  sign_off();
  EXPECT_EQ(error_of(R"({"command":"retire","vehicle":"CoSiVA/AIV1"})"), "");
}

TEST_F(DepartureOfOne, frees_the_path_for_the_vehicles_behind_it) {
  aiv.alive = false;
  fixture.run_for(60s);
  EXPECT_EQ(other.speed_mps, 0.0) << "the twin of an absent vehicle stays an obstacle";
  retire();
  const double driven_m = other.driven_m;
  fixture.run_for(10s);
  EXPECT_GT(other.driven_m, driven_m + 1.0);
}

TEST_F(DepartureOfOne, ends_with_the_next_report_of_the_vehicle) {
  sign_off();
  retire();
  fixture.run_for(60s);
  expect_departed();
  aiv.alive = true;
  fixture.connection(aiv, wire::ConnectionState::online);
  fixture.run_for(1s);
  EXPECT_EQ(count("matched"), 2.0);
  EXPECT_EQ(steps().back(), "AIV_Server > Simulator: appear CoSiVA/AIV1 is back under display number 1");
  fixture.run_for(5s);
  EXPECT_GT(aiv.speed_mps, 0.0);
}

TEST_F(DepartureOfOne, is_shown_by_a_camera_that_detects_no_vehicle_at_its_position_for_5_seconds) {
  other.blocked = true;
  const auto others = [&] { return std::vector{std::pair{std::string("CoSiVA/AIV2"), other.pose()}}; };
  watch(1s, {{"CoSiVA/AIV1", aiv.pose()}, {"CoSiVA/AIV2", other.pose()}});
  sign_off();
  watch(4s, others());
  EXPECT_THAT(orphans(), SizeIs(1)) << "not yet";
  watch(2s, others());
  expect_departed();
  EXPECT_THAT(
      steps(),
      Contains("GVS > AIV_Server: retire CoSiVA/AIV1: the camera has detected no vehicle at its position for 5 s"));
}

TEST_F(DepartureOfOne, is_not_shown_while_the_camera_detects_the_vehicle_or_another_one_at_its_position) {
  aiv.blocked = true;
  fixture.run_for(1s);
  sign_off();
  watch(10s, {{"CoSiVA/AIV1", aiv.pose()}});
  EXPECT_THAT(orphans(), SizeIs(1)) << "switched off, and still there";
  watch(10s, {{"ACME/9", aiv.pose()}});
  EXPECT_EQ(count("virtual"), 2.0) << "a body is at its position";
  watch(10s, {{"CoSiVA/AIV1", Pose2{5.0, 5.0, 0.0}}});
  EXPECT_EQ(count("virtual"), 2.0) << "carried away, and still in the zone";
}

TEST_F(DepartureOfOne, is_not_shown_for_a_vehicle_that_reports_or_by_a_camera_that_sends_no_images) {
  other.blocked = true;
  aiv.blocked = true;
  watch(10s, {{"CoSiVA/AIV2", other.pose()}});
  EXPECT_EQ(count("virtual"), 2.0) << "it reports: its marker may be covered";
  sign_off();
  fixture.run_for(60s);
  EXPECT_EQ(count("virtual"), 2.0);
}

TEST_F(DepartureOfOne, of_none_explains_a_body_that_the_camera_sees_and_no_vehicle_reports) {
  watch(1s, {{"ACME/9", Pose2{5.0, 5.0, 0.0}}});
  watch(1s, {{"ACME/9", Pose2{5.0, 5.0, 0.0}}});
  ASSERT_THAT(orphans(), SizeIs(1));
  EXPECT_EQ(orphans()[0].text("side"), "physical");
  EXPECT_EQ(orphans()[0].text("id"), "ACME/9");
  EXPECT_THAT(orphans()[0].text("reason").value_or(""), HasSubstr("it has no twin"));
  EXPECT_EQ(count("physical"), 3.0);
  EXPECT_EQ(count("matched"), 2.0);
}

}  // namespace
}  // namespace cosiva::virtual_side
