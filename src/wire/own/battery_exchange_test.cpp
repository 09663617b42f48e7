#include "cosiva/wire/own/battery_exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>

#include "cosiva/base/random.h"
#include "cosiva/wire/own/limits_fixture.h"

namespace cosiva::wire {
namespace {

using ::testing::HasSubstr;

TEST(BatteryExchange, reads_back_what_it_writes) {
  EXPECT_TRUE(rc::check("any battery", [](std::uint64_t seed) {
    Random random{seed, "battery"};
    const BatteryReady ready{"B" + std::to_string(random.below(1000)),
                             "leaf\"33\n",
                             random.uniform(0, 1e4),
                             random.uniform(0, 1e6),
                             random.uniform(-20, 60),
                             random.uniform(0, 100)};
    RC_ASSERT(battery_ready_from_json(to_json(ready)) == ready);
    const BatteryChange change{"B7", static_cast<std::uint32_t>(random.next()), random.chance(0.5) ? "too cold" : ""};
    RC_ASSERT(battery_change_from_json(to_json(change)) == change);
    const BatteryRequest request{change, random.chance(0.5)};
    RC_ASSERT(battery_request_from_json(to_json(request)) == request);
    RC_ASSERT(battery_change_from_json(to_json(request)) == change);
    const auto time = [&] {
      return SimTime{std::chrono::milliseconds{1'700'000'000'000 + random.below(1'000'000'000)}};
    };
    BatteryTest test{time(), time(), 2, 4, random.uniform(0, 100), random.uniform(0, 1), {}, random.chance(0.5), {}};
    if (random.chance(0.5)) test.expected_end = time();
    const std::size_t count = random.below(BatteryTest::vehicles_max + 1);
    for (std::size_t v = 0; v < count; ++v) {
      test.vehicles.push_back({std::string(60, 'm') + "/AIV" + std::to_string(v),
                               std::string(60, '"'),
                               static_cast<BatteryPhase>(random.below(5)),
                               random.chance(0.5) ? "cut-off" : "",
                               random.uniform(0, 1e6),
                               {}});
      if (random.chance(0.5)) test.vehicles.back().charge_percent = random.uniform(0, 100);
    }
    RC_ASSERT(battery_test_from_json(to_json(test)) == test);
  }));
}

TEST(BatteryExchange, refuses_a_bad_test_naming_the_field) {
  const auto refusal = [](const std::string& from, const std::string& to) {
    const BatteryTest good{{}, {}, 1, 1, 20.0, 0.5, {}, false, {{"CoSiVA/AIV1", "red", {}, "", 0.0, 87.0}}};
    std::string json = to_json(good);
    EXPECT_TRUE(battery_test_from_json(json)) << json;
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << json;
    const auto read = battery_test_from_json(json.replace(at, from.size(), to));
    EXPECT_FALSE(read) << json;
    return read ? std::string{} : to_string(read.error());
  };
  EXPECT_THAT(refusal(R"("progress":0.5)", R"("progress":1.5)"), HasSubstr("progress"));
  EXPECT_THAT(refusal(R"("done":false)", R"("done":0)"), HasSubstr("done"));
  EXPECT_THAT(refusal(R"("expectedEnd":null)", R"("expectedEnd":"soon")"), HasSubstr("expectedEnd"));
  EXPECT_THAT(refusal("changing", "flying"), HasSubstr("vehicles.0.phase"));
  EXPECT_THAT(refusal(R"("charge":87)", R"("charge":-1)"), HasSubstr("vehicles.0.charge"));
  EXPECT_THAT(refusal(R"("vehicles":[)", R"("vehicles":[7,)"), HasSubstr("vehicles.0"));
  EXPECT_FALSE(battery_test_from_json(""));
}

TEST(BatteryExchange, refuses_a_bad_battery_ready_naming_the_field) {
  const auto refusal = [](const std::string& json) {
    const auto ready = battery_ready_from_json(json);
    EXPECT_FALSE(ready) << json;
    return ready ? std::string{} : to_string(ready.error());
  };
  const std::string rest = R"("type":"x","cycles":1,"rest_s":0,"temperature":20,)";
  EXPECT_THAT(refusal("{}"), HasSubstr("battery"));
  EXPECT_THAT(refusal(R"({"battery":"",)" + rest + R"("charge":100})"), HasSubstr("battery"));
  EXPECT_THAT(refusal(R"({"battery":"B",)" + rest + R"("charge":101})"), HasSubstr("charge"));
  EXPECT_THAT(refusal(R"({"battery":"B",)" + rest + R"("charge":"full"})"), HasSubstr("charge"));
  EXPECT_THAT(refusal(R"({"battery":"B","type":"x","cycles":-1,"rest_s":0,"temperature":20,"charge":1})"),
              HasSubstr("cycles"));
  EXPECT_FALSE(refusal("charge").empty());
}

const BatteryTest shown{virtual_epoch,
                        virtual_epoch - std::chrono::minutes{5},
                        2,
                        4,
                        20.0,
                        0.5,
                        virtual_epoch + std::chrono::minutes{5},
                        false,
                        {{"CoSiVA/AIV1", "red", BatteryPhase::running, "", 300.0, 60.0}}};

TEST(BatteryExchange, is_written_as_its_document_shows) {
  EXPECT_EQ(to_json(shown),
            R"({"timestamp":"2023-07-11T00:00:00.000Z","began":"2023-07-10T23:55:00.000Z","run":2,"runs":4,)"
            R"("floor":20,"progress":0.5,"expectedEnd":"2023-07-11T00:05:00.000Z","done":false,)"
            R"("vehicles":[{"vehicle":"CoSiVA/AIV1","battery":"red","phase":"running","stop":"","autonomy_s":300,)"
            R"("charge":60}]})");
  EXPECT_EQ(to_json(BatteryChange{"red", 3, "its run is over"}),
            R"({"battery":"red","run":3,"reason":"its run is over"})");
  EXPECT_EQ(to_json(BatteryReady{"B7", "leaf33", 12.5, 3600.0, 21.5, 100.0}),
            R"({"battery":"B7","type":"leaf33","cycles":12.5,"rest_s":3600,"temperature":21.5,"charge":100})");
}

TEST(BatteryExchange, reads_each_phase_by_its_name) {
  for (const auto& [phase, name] :
       {std::pair{BatteryPhase::changing, "changing"}, std::pair{BatteryPhase::ready, "ready"},
        std::pair{BatteryPhase::running, "running"}, std::pair{BatteryPhase::paused, "paused"},
        std::pair{BatteryPhase::ended, "ended"}}) {
    EXPECT_EQ(to_string(phase), name);
    const auto read =
        battery_test_from_json(test::with_value(to_json(shown), "vehicles.0.phase", "\"" + std::string(name) + "\""));
    ASSERT_TRUE(read) << name;
    EXPECT_EQ(read->vehicles[0].phase, phase);
  }
}

TEST(BatteryExchange, accepts_each_number_within_its_range_only) {
  test::expect_ranges(to_json(shown), battery_test_from_json,
                      {{"run", 0, 4294967295, 1},
                       {"runs", 0, 4294967295, 1},
                       {"floor", 0, 100},
                       {"progress", 0, 1},
                       {"vehicles.0.autonomy_s", 0, 1e9},
                       {"vehicles.0.charge", 0, 100}});
  test::expect_ranges(to_json(BatteryChange{"red", 3, ""}), battery_change_from_json, {{"run", 0, 4294967295, 1}});
  test::expect_ranges(to_json(BatteryReady{"B7", "leaf33", 12.5, 3600.0, 21.5, 90.0}), battery_ready_from_json,
                      {{"cycles", 0, 1e6}, {"rest_s", 0, 1e9}, {"temperature", -100, 200}, {"charge", 0, 100}});
}

TEST(BatteryExchange, requires_every_field_except_the_expected_end_and_the_charge) {
  test::expect_required(
      to_json(shown), battery_test_from_json,
      {"timestamp", "began", "run", "runs", "floor", "progress", "done", "vehicles", "vehicles.0.vehicle",
       "vehicles.0.battery", "vehicles.0.phase", "vehicles.0.stop", "vehicles.0.autonomy_s"});
  test::expect_required(to_json(BatteryChange{}), battery_change_from_json, {"battery", "run", "reason"});
  test::expect_required(to_json(BatteryReady{"B7", "leaf33", 0, 0, 0, 0}), battery_ready_from_json,
                        {"battery", "type", "cycles", "rest_s", "temperature", "charge"});
}

TEST(BatteryExchange, accepts_a_test_of_at_most_256_vehicles) {
  BatteryTest fleet = shown;
  fleet.vehicles.resize(256, shown.vehicles[0]);
  EXPECT_TRUE(battery_test_from_json(to_json(fleet)));
  fleet.vehicles.resize(257, shown.vehicles[0]);
  EXPECT_FALSE(battery_test_from_json(to_json(fleet)));
}

}  // namespace
}  // namespace cosiva::wire
