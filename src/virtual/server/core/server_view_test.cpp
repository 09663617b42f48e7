#include "cosiva/virtual/server/core/server_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

TEST(ServerView, shows_a_broken_connection_at_once_and_keeps_the_twin) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  fixture.kill(aiv);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("connection"), "CONNECTIONBROKEN");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), true);
  fixture.run_for(10s);
  EXPECT_EQ(*fixture.bijection().number("virtual"), 1.0);
  EXPECT_EQ(*fixture.bijection().number("matched"), 0.0);
  EXPECT_GT(*fixture.aiv("CoSiVA/AIV1").number("age_ms"), 9000.0);
}

TEST(ServerView, shows_an_unresponsive_vehicle_as_lost_after_a_second_and_stops_its_twin) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  const double x0 = *fixture.aiv("CoSiVA/AIV1").number("x");
  aiv.alive = false;
  fixture.run_for(900ms);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), false);
  fixture.run_for(300ms);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), true);
  const JsonValue then = fixture.aiv("CoSiVA/AIV1");
  fixture.run_for(5s);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("x"), *then.number("x"));
  EXPECT_LE(std::fabs(*then.number("x") - x0), 0.3 * 1.0 + 0.05) << "extrapolated for a second at most";
  EXPECT_EQ(then.find("contract")->flag("age"), false);
}

/// A third-party vehicle that publishes only its state, and the ratio of the time for which it is shown as lost.
class SlowReporter {
 public:
  SlowReporter() : vehicle_{fixture_.add("agv-7", {0, 0.5}, "Acme")} {
    vehicle_.alive = false;  // the fixture does not report for it
    fixture_.each_step = [this] {
      if (const auto lost = fixture_.aiv("Acme/agv-7").flag("lost")) ++(*lost ? steps_lost_ : steps_live_);
    };
  }
  void report_for(SimDuration duration, double period_s, double jitter_s = 0.0) {
    for (const SimTime end = fixture_.now + duration; fixture_.now < end;) {
      fixture_.send(vehicle_, "state", vda::encode(vehicle_.state(fixture_.now)));
      be_unresponsive_for(from_seconds(period_s + fixture_.random.uniform(-jitter_s, jitter_s)));
    }
  }
  void be_unresponsive_for(SimDuration duration) { fixture_.run_for(duration); }
  [[nodiscard]] double lost_ratio() const {
    return static_cast<double>(steps_lost_) / static_cast<double>(steps_lost_ + steps_live_);
  }
  [[nodiscard]] bool lost() const { return *fixture_.aiv("Acme/agv-7").flag("lost"); }

 private:
  ServerFixture fixture_;
  FixtureVehicle& vehicle_;
  std::uint64_t steps_lost_{0};
  std::uint64_t steps_live_{0};
};

TEST(ServerView, never_shows_a_vehicle_with_a_constant_slow_rate_as_lost) {
  for (const double period_s : {1.2, 2.0, 3.0}) {
    for (const double jitter_s : {0.0, 0.3 * period_s}) {
      SlowReporter vehicle;
      vehicle.report_for(60s, period_s, jitter_s);
      EXPECT_EQ(vehicle.lost_ratio(), 0.0) << "a state every " << period_s << " s, give or take " << jitter_s;
    }
  }
}

TEST(ServerView, shows_a_slow_vehicle_as_lost_after_three_of_its_usual_gaps) {
  for (const double period_s : {1.2, 2.0, 3.0}) {
    SlowReporter vehicle;
    vehicle.report_for(180s, period_s);  // and one gap without a report already
    vehicle.be_unresponsive_for(from_seconds(1.9 * period_s));
    EXPECT_FALSE(vehicle.lost()) << period_s;
    vehicle.be_unresponsive_for(from_seconds(0.2 * period_s));
    EXPECT_TRUE(vehicle.lost()) << period_s;
  }
}

std::vector<std::string> members(const JsonValue& json) {
  std::vector<std::string> names;
  for (const auto& [name, value] : *json.object()) names.push_back(name);
  return names;
}

TEST(ServerView, has_these_members_in_this_order) {
  ServerFixture fixture;
  EXPECT_THAT(
      members(fixture.snapshot()),
      testing::ElementsAre("time", "time_ms", "zoneRevision", "zoneEdits", "registry", "zone", "aivs", "virtualObjects",
                           "obstacles", "crossings", "deadlocks", "bijection", "commands", "battery", "gvs", "units"));
  EXPECT_EQ(fixture.snapshot().text("time"), "2023-07-11T00:00:00.000Z");
  EXPECT_EQ(fixture.snapshot().number("time_ms"), to_milliseconds_scaled(virtual_epoch));
  EXPECT_EQ(fixture.snapshot().number("zoneRevision"), 1.0);
  EXPECT_TRUE(fixture.snapshot().find("battery")->is_null());
  EXPECT_TRUE(fixture.snapshot().find("gvs")->is_null());
}

TEST(ServerView, summarises_each_vehicle_and_the_orders) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV3", {0, 0.5});
  const JsonValue before = *JsonValue::parse(fixture.server->summary_json());
  EXPECT_THAT(members(before),
              testing::ElementsAre("bijection", "aivs", "orders", "deadlocks", "messages_refused", "traces"));
  const JsonValue& absent = before.find("aivs")->array()->front();
  EXPECT_EQ(absent.text("id"), "CoSiVA/AIV3");
  EXPECT_EQ(absent.number("number"), 3.0);
  EXPECT_EQ(absent.flag("augmented"), false);
  EXPECT_EQ(absent.text("connection"), "ONLINE");
  EXPECT_EQ(absent.flag("present"), false);
  EXPECT_EQ(absent.flag("twin"), false);
  EXPECT_EQ(absent.number("messages"), 1.0);
  EXPECT_EQ(absent.number("missed"), 0.0);
  EXPECT_EQ(absent.number("refused"), 0.0);
  EXPECT_EQ(absent.number("outdated"), 0.0);
  EXPECT_EQ(before.find("orders")->number("sent"), 0.0);
  fixture.run_for(1s);
  const JsonValue after = *JsonValue::parse(fixture.server->summary_json());
  EXPECT_EQ(after.find("aivs")->array()->front().flag("present"), true);
  EXPECT_EQ(after.find("aivs")->array()->front().flag("twin"), true);
  EXPECT_EQ(after.find("orders")->number("sent"), 1.0);
  EXPECT_EQ(after.find("deadlocks")->number("detected"), 0.0);
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
  EXPECT_EQ(after.number("traces"), *traces.find("traces")->array()->back().number("n"));
  EXPECT_FALSE(aiv.orders.empty());
}

TEST(ServerView, lists_the_path_of_a_virtual_object_that_has_more_than_one_point) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","id":"box","x":1.0,"y":0.5}})");
  fixture.send_command(
      R"({"command":"add","virtualObject":{"kind":"person","path":[[0,0.5],[2,0.5]],"speed":0.5,"repeat":"loop"}})");
  fixture.now += 1s;
  fixture.feed(wire::InputKind::tick, "", "");
  const JsonValue snapshot = fixture.snapshot();
  const JsonValue& box = (*snapshot.find("virtualObjects")->array())[0];
  EXPECT_THAT(members(box), testing::ElementsAre("id", "handle", "kind", "x", "y", "heading", "radius", "speed",
                                                 "perceivedBy", "since_ms"));
  EXPECT_EQ(box.text("kind"), "obstacle");
  EXPECT_EQ(box.number("handle"), 32768.0);
  EXPECT_EQ(box.number("since_ms"), to_milliseconds_scaled(virtual_epoch));
  const JsonValue& person = (*snapshot.find("virtualObjects")->array())[1];
  EXPECT_EQ(person.number("x"), 0.5);
  EXPECT_EQ(person.number("speed"), 0.5);
  EXPECT_EQ(person.text("repeat"), "loop");
  const JsonValue::Array& path = *person.find("path")->array();
  ASSERT_EQ(path.size(), 2U);
  EXPECT_EQ(*(*path[1].array())[0].number(), 2.0);
  EXPECT_EQ(*(*path[1].array())[1].number(), 0.5);
}

TEST(ServerView, names_the_holder_of_each_crossing) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  int number = 0;
  for (const zone::TrackPosition position : fixture.zone->start_positions(2))
    fixture.add("AIV" + std::to_string(++number), position);
  std::set<std::string> holders;
  bool was_free = false;
  int steps = 0;
  fixture.each_step = [&] {
    if (++steps % 10 != 0) return;
    const JsonValue snapshot = fixture.snapshot();
    const JsonValue::Array& crossings = *snapshot.find("crossings")->array();
    ASSERT_EQ(crossings.size(), fixture.zone->crossings.size());
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      EXPECT_EQ(crossings[i].text("name"), fixture.zone->crossings[i].name);
      ASSERT_NE(crossings[i].find("waiting")->array(), nullptr);
      if (const auto holder = crossings[i].text("heldBy"))
        holders.insert(*holder);
      else
        was_free = true;
    }
  };
  fixture.run_for(60s);
  EXPECT_THAT(holders, testing::ElementsAre("CoSiVA/AIV1", "CoSiVA/AIV2"));
  EXPECT_TRUE(was_free);
}

TEST(ServerView, shows_a_finding_of_the_camera_and_changes_its_revision) {
  ServerFixture fixture;
  const auto detect = [&] {
    wire::GvsDetections detections;
    detections.timestamp = fixture.now;
    detections.period_s = 0.5;
    detections.detections = {{"CoSiVA/AIV9", 9, fixture.now, {1.0, 0.0, 0.0}, 0.001}};
    fixture.feed(wire::InputKind::message, std::string(wire::gvs_detections_topic), wire::to_json(detections));
  };
  detect();
  fixture.run_for(500ms);
  const ServerCore::PageRevision before = fixture.server->page_revision();
  EXPECT_TRUE(fixture.bijection().find("findings")->array()->empty());
  detect();
  fixture.run_for(500ms);
  ASSERT_EQ(fixture.bijection().find("findings")->array()->size(), 1U);
  EXPECT_EQ(fixture.bijection().find("findings")->array()->front().text("kind"), "no twin");
  EXPECT_NE(fixture.server->page_revision().waited_for, before.waited_for);
  EXPECT_EQ(fixture.snapshot().find("gvs")->text("state"), "watching");
}

TEST(ServerView, counts_the_age_of_present_vehicles_until_they_report_that_they_are_offline) {
  ServerFixture fixture;
  const auto age = [&](const char* field) { return *fixture.bijection().find("age_ms")->number(field); };
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& absent = fixture.add("AIV2", {2, 0.5});
  absent.alive = false;
  fixture.run_for(2s);
  EXPECT_GT(age("count"), 90.0);
  EXPECT_LT(age("max"), 200.0) << "a vehicle that never reported has no age";
  aiv.alive = false;
  fixture.run_for(2s);
  EXPECT_NEAR(age("max"), 2000.0, 120.0);
  fixture.connection(aiv, wire::ConnectionState::offline);
  const double count = age("count");
  fixture.run_for(2s);
  EXPECT_EQ(age("count"), count);
}

}  // namespace
}  // namespace cosiva::virtual_side
