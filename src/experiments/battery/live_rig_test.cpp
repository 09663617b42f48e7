#include "cosiva/experiments/battery/live_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const SimTime start_of_test = virtual_epoch;

wire::VehicleId aiv(int number) { return {"CoSiVA", "AIV" + std::to_string(number)}; }

LiveRigOptions two_by_hand() {
  LiveRigOptions options;
  options.procedure.vehicles = 2;
  options.procedure.floor = 0.5;
  options.vehicles = {aiv(1), aiv(2)};
  options.batteries = {"red", "blue"};
  return options;
}

/// A vehicle's own report, twice per second, with this charge.
std::string report(SimTime date, double charge) {
  wire::BoardsReport boards;
  boards.timestamp = date;
  wire::Power power;
  power.voltage_mv = 7400;
  power.current_ma = 1000;
  power.temperature_01C = 220;
  power.charge_permille = static_cast<std::uint16_t>(1000.0 * charge);
  power.gauge = wire::Power::Gauge{static_cast<std::uint32_t>(1e6 * charge), 50};
  boards.power = power;
  return to_json(boards);
}

/// @param date  the vehicle's own; nothing: as the test's clock
LiveRig::Responses print_report(LiveRig& rig, SimTime now, int number, double charge,
                                std::optional<SimTime> date = {}) {
  return rig.on_message(now, wire::own_topic(wire::boards_topic_prefix, aiv(number)),
                        report(date.value_or(now), charge));
}
LiveRig::Responses publish_ready(LiveRig& rig, SimTime now, int number, const std::string& battery,
                                 double percent = 100.0) {
  return rig.on_message(now, wire::own_topic(wire::battery_ready_topic_prefix, aiv(number)),
                        to_json(wire::BatteryReady{battery, "leaf33", 3.0, 3600.0, 22.0, percent}));
}
LiveRig::Responses print_position(LiveRig& rig, SimTime now, int number, double x_m) {
  return rig.on_message(now, wire::vda_topic(aiv(number), "visualization"),
                        R"({"agvPosition":{"x":)" + std::to_string(x_m) + R"(,"y":0,"theta":0}})");
}

/// Makes both vehicles ready and running.
LiveRig running(LiveRigOptions options) {
  LiveRig rig{std::move(options)};
  for (const int number : {1, 2}) std::ignore = print_report(rig, start_of_test, number, 1.0);
  std::ignore = rig.start(start_of_test);
  std::ignore = publish_ready(rig, start_of_test, 1, "red");
  std::ignore = publish_ready(rig, start_of_test, 2, "blue");
  return rig;
}

TEST(LiveRig, lists_the_vehicles_without_a_message) {
  LiveRig rig{two_by_hand()};
  EXPECT_EQ(rig.missing(), "CoSiVA/AIV1, CoSiVA/AIV2");
  std::ignore = print_report(rig, start_of_test, 2, 1.0);
  EXPECT_EQ(rig.missing(), "CoSiVA/AIV1");
  std::ignore = print_report(rig, start_of_test, 7, 1.0);  // not of this test
  EXPECT_FALSE(rig.complete());
}

TEST(LiveRig, requests_batteries_with_vehicles_stopped_and_runs_all_when_the_last_is_ready) {
  LiveRig rig{two_by_hand()};
  const auto requested = rig.start(start_of_test);
  ASSERT_THAT(requested.messages, SizeIs(2));
  EXPECT_EQ(requested.messages[0].topic, "cosiva/v1/battery/change/CoSiVA/AIV1");
  EXPECT_TRUE(requested.messages[0].retained);
  EXPECT_EQ(wire::battery_change_from_json(requested.messages[1].payload)->battery, "blue");
  EXPECT_THAT(requested.commands, ElementsAre(HasSubstr(R"("stop","vehicle":"CoSiVA/AIV1")"),
                                              HasSubstr(R"("stop","vehicle":"CoSiVA/AIV2")")));
  EXPECT_THAT(requested.operator_messages, Contains(HasSubstr("put battery 1, full, into AIV1")));

  const auto first = publish_ready(rig, start_of_test, 1, "red");
  EXPECT_THAT(first.commands, IsEmpty());
  ASSERT_THAT(first.messages, SizeIs(1));
  EXPECT_TRUE(first.messages[0].payload.empty()) << "the retained message is removed";
  const auto last = publish_ready(rig, start_of_test + seconds{60}, 2, "blue");
  EXPECT_THAT(last.commands, ElementsAre(HasSubstr("restart"), HasSubstr("restart")));
  EXPECT_TRUE(rig.procedure().running(0) && rig.procedure().running(1));
}

TEST(LiveRig, refuses_a_battery_that_is_not_full_and_requests_it_again) {
  LiveRig rig{two_by_hand()};
  std::ignore = rig.start(start_of_test);
  const auto refused = publish_ready(rig, start_of_test, 1, "red", 80.0);
  EXPECT_THAT(refused.operator_messages, Contains(HasSubstr("AIV1 may not run: it is not full")));
  EXPECT_EQ(wire::battery_change_from_json(refused.messages.back().payload)->battery, "red");
  EXPECT_FALSE(rig.procedure().running(0));
}

TEST(LiveRig, ends_each_at_its_floor_and_records_distance_and_autonomy) {
  LiveRig rig = running(two_by_hand());
  // From 1 to 0.4 in 120 s: the floor of 0.5 is crossed after 100 s, and held three seconds later.
  std::vector<std::string> stopped;
  for (int half = 1; half <= 240; ++half) {
    const SimTime now = start_of_test + half * milliseconds{500};
    std::ignore = print_position(rig, now, 1, 0.25 * half);
    const auto responses = print_report(rig, now, 1, 1.0 - 0.6 * half / 240.0);
    for (const std::string& command : responses.commands) stopped.push_back(command);
    std::ignore = print_report(rig, now, 2, 1.0);
  }
  EXPECT_THAT(stopped, ElementsAre(HasSubstr(R"("stop","vehicle":"CoSiVA/AIV1")")));
  ASSERT_THAT(rig.procedure().records(), SizeIs(1));
  const BatteryRun& record = rig.procedure().records().front();
  EXPECT_EQ(record.stop, StopCause::floor);
  EXPECT_NEAR(record.autonomy_s, 100.0, 1e-3);
  EXPECT_NEAR(record.distance_m, 0.25 * 199, 1e-6);
  EXPECT_EQ(record.tag.id, "red");
  EXPECT_DOUBLE_EQ(record.tag.cycles, 3.0);
}

// The network delays each report by up to two seconds, and holds some back: the autonomy is that of the vehicle's
// dates.
TEST(LiveRig, takes_the_dates_of_samples_from_the_vehicle_and_not_from_their_reception) {
  for (const auto clock_offset : {seconds{0}, seconds{7200}, seconds{-7200}}) {
    LiveRig rig = running(two_by_hand());
    std::ignore =
        print_report(rig, start_of_test + milliseconds{1}, 1, 1.0, start_of_test + milliseconds{1} + clock_offset);
    for (int half = 1; half <= 240; ++half) {
      const SimTime taken = start_of_test + half * milliseconds{500};
      std::ignore = print_report(rig, taken + milliseconds{(half * 617) % 2000}, 1, 1.0 - 0.6 * half / 240.0,
                                 taken + clock_offset);
    }
    ASSERT_THAT(rig.procedure().records(), SizeIs(1)) << clock_offset.count();
    EXPECT_NEAR(rig.procedure().records().front().autonomy_s, 100.0, 2e-3) << clock_offset.count();
  }
}

TEST(LiveRig, requests_from_the_vehicle_itself_whether_a_person_fits_the_battery) {
  LiveRigOptions options = two_by_hand();
  EXPECT_TRUE(wire::battery_request_from_json(LiveRig{options}.start(start_of_test).messages[0].payload)->by_hand);
  options.emulated =
      BatteryUnderTest{*battery::shipped_type("lipo850"), {2, 1, 0.1}, battery::GaugeMethod::rest, true, 22.0};
  EXPECT_FALSE(wire::battery_request_from_json(LiveRig{options}.start(start_of_test).messages[0].payload)->by_hand);
}

TEST(LiveRig, sends_ended_vehicles_to_the_named_station) {
  LiveRigOptions options = two_by_hand();
  options.park = "dock";
  options.procedure.hold = {};
  LiveRig rig = running(options);
  std::ignore = print_report(rig, start_of_test + seconds{1}, 1, 0.51);
  const auto responses = print_report(rig, start_of_test + seconds{2}, 1, 0.49);
  EXPECT_THAT(responses.commands, ElementsAre(AllOf(HasSubstr("\"go\""), HasSubstr("dock"), HasSubstr("AIV1"))));
}

TEST(LiveRig, gives_emulated_vehicles_their_batteries_and_finally_a_service_battery) {
  LiveRigOptions options = two_by_hand();
  options.procedure.hold = {};
  options.emulated =
      BatteryUnderTest{*battery::shipped_type("lipo850"), {2, 1, 0.1}, battery::GaugeMethod::rest, true, 22.0};
  LiveRig rig{options};
  const auto requested = rig.start(start_of_test);
  EXPECT_THAT(requested.messages, Contains(::testing::Field(&wire::Publish::topic, "cosiva/v1/plant/command")));
  for (const auto& [number, name] : {std::pair{1, "red"}, {2, "blue"}})
    std::ignore = publish_ready(rig, start_of_test, number, name);
  std::ignore = print_report(rig, start_of_test + seconds{1}, 1, 0.51);
  const auto ended = print_report(rig, start_of_test + seconds{2}, 1, 0.49);
  EXPECT_THAT(ended.messages, Contains(::testing::Field(&wire::Publish::payload, HasSubstr("service"))));
  EXPECT_THAT(ended.commands, ElementsAre(HasSubstr("restart")));
  // The service battery's own batteryReady is no response to a request.
  EXPECT_THAT(publish_ready(rig, start_of_test + seconds{3}, 1, "service").commands, IsEmpty());
}

TEST(LiveRig, continues_from_its_saved_state_and_counts_no_vehicle_as_lost_meanwhile) {
  LiveRig rig = running(two_by_hand());
  for (const int number : {1, 2}) std::ignore = print_report(rig, start_of_test + seconds{10}, number, 0.9);
  LiveRig again{two_by_hand()};
  const SimTime later = start_of_test + seconds{300};
  const auto restored = again.restore(later, rig.state_json());
  ASSERT_TRUE(restored) << to_string(restored.error());
  EXPECT_THAT(again.tick(later + seconds{5}).commands, IsEmpty());
  EXPECT_TRUE(again.procedure().running(0) && again.procedure().running(1));
  // A vehicle without reports from now on is lost, and its battery lasted at least until the last report.
  std::ignore = print_report(again, later + seconds{20}, 1, 0.8);
  std::ignore = again.tick(later + seconds{40});
  ASSERT_THAT(again.procedure().records(), SizeIs(1));
  EXPECT_EQ(again.procedure().records().front().stop, StopCause::lost);
  EXPECT_EQ(again.procedure().records().front().vehicle, 1U);
}

TEST(LiveRig, repeats_a_battery_request_made_before_a_restart) {
  LiveRig rig{two_by_hand()};
  std::ignore = rig.start(start_of_test);
  std::ignore = publish_ready(rig, start_of_test, 1, "red");
  LiveRig again{two_by_hand()};
  const auto restored = again.restore(start_of_test + seconds{60}, rig.state_json());
  ASSERT_TRUE(restored);
  EXPECT_THAT(restored->commands, ElementsAre(HasSubstr("AIV2")));
  EXPECT_THAT(publish_ready(again, start_of_test + seconds{70}, 2, "blue").commands, SizeIs(2));
}

TEST(LiveRig, records_running_batteries_as_lasting_longer_when_the_operator_ends_the_test) {
  LiveRig rig = running(two_by_hand());
  for (const int number : {1, 2}) std::ignore = print_report(rig, start_of_test + seconds{10}, number, 0.9);
  std::ignore = rig.give_up(start_of_test + seconds{12});
  EXPECT_TRUE(rig.done());
  for (const BatteryRun& record : rig.procedure().records()) EXPECT_EQ(record.stop, StopCause::operator_stop);
}

TEST(LiveRig, requests_nothing_after_the_operator_ended_the_test) {
  LiveRigOptions options = two_by_hand();
  options.procedure.runs = 2;
  LiveRig waiting{options};
  std::ignore = waiting.start(start_of_test);
  EXPECT_FALSE(waiting.done());
  const auto taken_back = waiting.give_up(start_of_test + seconds{1});
  EXPECT_TRUE(waiting.done()) << "no vehicle waits for batteries that are no longer requested";
  ASSERT_THAT(taken_back.messages, SizeIs(2));
  for (const wire::Publish& message : taken_back.messages) EXPECT_TRUE(message.payload.empty());

  LiveRig rig = running(options);
  EXPECT_THAT(rig.give_up(start_of_test + seconds{1}).messages, IsEmpty()) << "the second run does not begin";
  EXPECT_TRUE(rig.done());
}

TEST(LiveRig, reports_its_status) {
  LiveRigOptions options = two_by_hand();
  options.procedure.hold = {};
  LiveRig rig{options};
  for (const int number : {1, 2}) std::ignore = print_report(rig, start_of_test, number, 1.0);
  std::ignore = rig.start(start_of_test);
  std::ignore = publish_ready(rig, start_of_test + seconds{5}, 1, "red");
  wire::BatteryTest test = rig.test(start_of_test + seconds{6});
  EXPECT_EQ(test.began, start_of_test);
  EXPECT_EQ(test.timestamp, start_of_test + seconds{6});
  EXPECT_DOUBLE_EQ(test.floor_percent, 50.0);
  EXPECT_FALSE(test.expected_end || test.done);
  EXPECT_EQ(test.vehicles[0], (wire::BatteryTest::Slot{"CoSiVA/AIV1", "red", wire::BatteryPhase::ready, "", 0, 100.0}));
  EXPECT_EQ(test.vehicles[1], (wire::BatteryTest::Slot{"CoSiVA/AIV2", "blue", {}, "", 0, {}})) << "still requested";

  std::ignore = publish_ready(rig, start_of_test + seconds{10}, 2, "blue");
  for (const int number : {1, 2}) std::ignore = print_report(rig, start_of_test + seconds{60}, number, 0.75);
  test = rig.test(start_of_test + seconds{60});
  EXPECT_NEAR(test.ratio, 0.5, 1e-9);
  EXPECT_EQ(test.expected_end, start_of_test + seconds{110}) << "at the present rate";
  EXPECT_EQ(test.vehicles[0].phase, wire::BatteryPhase::running);
  EXPECT_DOUBLE_EQ(test.vehicles[0].autonomy_s, 50.0);
  EXPECT_NEAR(*test.vehicles[0].charge_percent, 75.0, 1e-9);

  for (const int number : {1, 2}) std::ignore = print_report(rig, start_of_test + seconds{110}, number, 0.45);
  test = rig.test(start_of_test + seconds{200});
  EXPECT_TRUE(test.done);
  EXPECT_EQ(test.run, 1U);
  EXPECT_EQ(test.vehicles[1].phase, wire::BatteryPhase::ended);
  EXPECT_EQ(test.vehicles[1].stop, "floor");
  EXPECT_LT(test.vehicles[1].autonomy_s, 100.0) << "it stays at its end";
}

TEST(LiveRig, reports_why_it_requests_again) {
  LiveRig rig{two_by_hand()};
  std::ignore = rig.start(start_of_test);
  const auto refused = publish_ready(rig, start_of_test, 1, "red", 80.0);
  EXPECT_THAT(wire::battery_change_from_json(refused.messages.back().payload)->reason, HasSubstr("not full"));
}

TEST(LiveRig, ignores_nonsense_and_reports_what_a_bad_response_lacks) {
  LiveRig rig{two_by_hand()};
  std::ignore = rig.start(start_of_test);
  std::ignore = rig.on_message(start_of_test, wire::own_topic(wire::boards_topic_prefix, aiv(1)), "{");
  std::ignore = rig.on_message(start_of_test, wire::vda_topic(aiv(1), "visualization"), "[]");
  std::ignore = rig.on_message(start_of_test, "cosiva/v1/battery/ready/", "{}");
  EXPECT_FALSE(rig.complete());
  const auto bad = rig.on_message(start_of_test, wire::own_topic(wire::battery_ready_topic_prefix, aiv(1)), "{}");
  EXPECT_THAT(bad.operator_messages, ElementsAre(AllOf(HasSubstr("AIV1"), HasSubstr("battery"))));
}

TEST(LiveRig, refuses_the_state_of_another_test) {
  LiveRig rig{two_by_hand()};
  for (const char* text : {"", "{}", R"({"procedure":"{}","slots":[{},{}]})", R"({"procedure":"x","slots":[{}]})"}) {
    const auto restored = rig.restore(start_of_test, text);
    ASSERT_FALSE(restored) << text;
    EXPECT_EQ(restored.error().code, "battery.state");
  }
}

}  // namespace
}  // namespace cosiva::experiments
