#include "cosiva/virtual/simulator/bijection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using testing::SizeIs;

class Bijection : public testing::Test {
 protected:
  void wait(SimDuration duration) {
    now += duration;
    monitor.elapse(now);
  }
  [[nodiscard]] JsonValue written() const {
    JsonWriter json;
    monitor.write(json);
    return *JsonValue::parse(json.text());
  }
  SimTime now{virtual_epoch};
  BijectionMonitor monitor{BijectionContract{}};
};

TEST(BijectionMonitor, gives_a_spare_entity_to_the_next_name) {
  BijectionMonitor monitor{BijectionContract{}};
  const auto a = monitor.entity("make/a");
  const auto b = monitor.entity("make/b");
  EXPECT_EQ(monitor.entity("make/c", a), a);
  EXPECT_EQ(monitor.entity("make/b"), b);
  EXPECT_NE(monitor.entity("make/a"), a) << "the name is new again";
  monitor.set_physical(b, true);
  EXPECT_DEATH(monitor.entity("make/d", b), "physical");
}

TEST_F(Bijection, without_entities_holds) {
  wait(10s);
  EXPECT_EQ(monitor.matched_ratio(), 1.0);
  EXPECT_EQ(monitor.held_ratio(), 1.0);
}

TEST_F(Bijection, is_counted_from_the_first_arrival_on) {
  wait(100s);
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  wait(0s);
  wait(1s);  // without a twin
  monitor.set_virtual(a, true);
  wait(3s);  // with one
  EXPECT_DOUBLE_EQ(monitor.matched_ratio(), 0.75);
}

TEST_F(Bijection, reports_entities_that_are_missing_on_either_side) {
  monitor.set_physical(monitor.entity("make/real"), true);
  monitor.set_virtual(monitor.entity("make/ghost"), true);
  const auto both = monitor.entity("make/both");
  monitor.set_physical(both, true);
  monitor.set_virtual(both, true);
  const JsonValue json = written();
  EXPECT_EQ(*json.number("physical"), 2.0);
  EXPECT_EQ(*json.number("virtual"), 2.0);
  EXPECT_EQ(*json.number("matched"), 1.0);
  const auto& orphans = *json.find("orphans")->array();
  ASSERT_THAT(orphans, SizeIs(2));
  EXPECT_EQ(orphans[0].text("side"), "physical");
  EXPECT_EQ(orphans[0].text("id"), "make/real");
  EXPECT_EQ(orphans[0].text("reason"), "its twin has disappeared");
  EXPECT_EQ(orphans[1].text("side"), "virtual");
  EXPECT_FALSE(monitor.held(monitor.entity("make/real")).matched);
  EXPECT_TRUE(monitor.held(both).matched);
}

TEST_F(Bijection, measures_divergence_age_commands_and_events) {
  const auto a = monitor.entity("make/a");
  for (int i = 1; i <= 4; ++i) {
    monitor.divergence(a, 0.001 * i, 0.01 * i);
    monitor.age(a, 10.0 * i);
  }
  monitor.command_issued();
  monitor.command_issued();
  monitor.command_accepted();
  monitor.command_materialised(250.0);
  monitor.command_failed();
  monitor.event(PhysicalEvent::tag, 4.0);
  monitor.event(PhysicalEvent::tag, 8.0);
  monitor.event(PhysicalEvent::battery, 6.0);
  const JsonValue json = written();
  EXPECT_DOUBLE_EQ(*json.find("divergence_m")->number("mean"), 0.0025);
  EXPECT_DOUBLE_EQ(*json.find("divergence_m")->number("max"), 0.004);
  EXPECT_DOUBLE_EQ(*json.find("divergence_rad")->number("p50"), 0.02);
  EXPECT_DOUBLE_EQ(*json.find("age_ms")->number("p99"), 40.0);
  EXPECT_EQ(*json.find("commands")->number("issued"), 2.0);
  EXPECT_EQ(*json.find("commands")->number("failed"), 1.0);
  EXPECT_EQ(*json.find("commands")->find("latency_ms")->number("max"), 250.0);
  EXPECT_EQ(*json.find("events")->number("count"), 3.0);
  EXPECT_EQ(*json.find("events")->find("latency_ms")->number("mean"), 6.0);
  EXPECT_EQ(*json.find("events")->find("by_kind")->number("tag"), 2.0);
  EXPECT_EQ(*json.find("events")->find("by_kind")->number("stop"), 0.0);
}

TEST_F(Bijection, counts_the_time_of_a_violated_contract_as_not_held) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  wait(0s);
  for (int i = 0; i < 100; ++i) monitor.age(a, 50.0);  // end of the initial period
  wait(6s);
  monitor.age(a, 151.0);  // the only evaluated sample is above 150 ms, so its p99 is
  EXPECT_FALSE(monitor.held(a).age);
  wait(2s);
  EXPECT_DOUBLE_EQ(monitor.held_ratio(), 0.75);
  EXPECT_DOUBLE_EQ(monitor.matched_ratio(), 1.0);
}

TEST_F(Bijection, shows_a_short_overload_as_over_four_seconds_after_its_end_though_the_metrics_of_the_run_include_it) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  // The age is measured at 50 Hz, a report is received at 10 Hz, and the camera delivers four images per second.
  const auto pass = [&](SimDuration duration, double age_ms, double divergence_m) {
    for (int i = 0; i < duration / 20ms; ++i) {
      monitor.age(a, age_ms);
      if (i % 5 == 0) monitor.divergence(a, divergence_m, 0.0);
      if (i % 12 == 0) monitor.actual(a, 2.0 * divergence_m, 0.0, "camera");
      wait(20ms);
    }
  };
  const auto fleet = [this](const char* figure) { return written().find("held")->flag(figure); };
  pass(20s, 50.0, 0.001);
  EXPECT_TRUE(monitor.held(a).age && monitor.held(a).divergence && monitor.held(a).actual);
  EXPECT_EQ(fleet("age"), true);
  pass(3s, 400.0, 0.05);
  monitor.command_materialised(2500.0);
  monitor.event(PhysicalEvent::tag, 600.0);
  monitor.effect(WorldEffect::brakes, 300.0);
  EXPECT_FALSE(monitor.held(a).age || monitor.held(a).divergence || monitor.held(a).actual);
  for (const char* figure : {"divergence", "age", "actual", "commands", "events", "effects"})
    EXPECT_EQ(fleet(figure), false) << figure;
  pass(3s, 50.0, 0.001);
  EXPECT_FALSE(monitor.held(a).age) << "a display that turns green at once is overlooked";
  pass(1s, 50.0, 0.001);
  EXPECT_TRUE(monitor.held(a).age && monitor.held(a).divergence && monitor.held(a).actual);
  for (const char* figure : {"divergence", "age", "actual", "commands", "events", "effects"})
    EXPECT_EQ(fleet(figure), true) << figure;
  EXPECT_EQ(*written().find("age_ms")->number("p99"), 400.0);
}

TEST_F(Bijection, shows_a_failed_command_as_a_violation) {
  monitor.set_physical(monitor.entity("make/a"), true);
  wait(0s);
  monitor.command_failed();
  EXPECT_EQ(written().find("held")->flag("commands"), false);
  wait(4s);
  EXPECT_EQ(written().find("held")->flag("commands"), true);
}

TEST_F(Bijection, includes_a_slow_start_in_its_metrics_but_evaluates_contracts_from_two_seconds_after_the_arrival) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  for (int i = 0; i < 100; ++i) monitor.age(a, 400.0);           // 2 s of ticks
  for (int i = 0; i < 20; ++i) monitor.divergence(a, 1.0, 0.0);  // 2 s of reports
  EXPECT_TRUE(monitor.held(a).age);
  EXPECT_TRUE(monitor.held(a).divergence);
  EXPECT_EQ(monitor.age_ms().max(), 400.0);
  EXPECT_EQ(monitor.divergence_m().max(), 1.0);
  monitor.age(a, 400.0);
  monitor.divergence(a, 1.0, 0.0);
  EXPECT_FALSE(monitor.held(a).age);
  EXPECT_FALSE(monitor.held(a).divergence);
}

TEST_F(Bijection, is_not_held_when_commands_or_events_take_too_long) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  wait(0s);
  monitor.command_materialised(2001.0);
  wait(1s);
  EXPECT_EQ(monitor.held_ratio(), 0.0);
  EXPECT_TRUE(monitor.held(a).divergence);
}

TEST_F(Bijection, measures_effects_between_both_sides_and_limits_them_to_200_ms) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  wait(0s);
  monitor.effect(WorldEffect::perceived, 12.0);
  monitor.effect(WorldEffect::brakes, 30.0);
  monitor.effect(WorldEffect::shown, 60.0);
  wait(1s);
  EXPECT_EQ(monitor.held_ratio(), 1.0);
  monitor.effect(WorldEffect::perceived, 201.0);
  wait(1s);
  EXPECT_EQ(monitor.held_ratio(), 0.5);
  const JsonValue json = written();
  EXPECT_EQ(*json.find("effects")->find("perceived_ms")->number("max"), 201.0);
  EXPECT_EQ(*json.find("effects")->find("brakes_ms")->number("count"), 1.0);
  EXPECT_EQ(*json.find("effects")->find("shown_ms")->number("p50"), 60.0);
  EXPECT_EQ(*json.find("contract")->number("effect_p99_ms"), 200.0);
}

TEST_F(Bijection, counts_virtual_aivs_separately) {
  monitor.set_augmented(3);
  EXPECT_EQ(*written().number("augmented"), 3.0);
  EXPECT_EQ(*written().number("physical"), 0.0);
}

TEST_F(Bijection, gives_one_entity_per_name) {
  EXPECT_EQ(monitor.entity("make/a"), monitor.entity("make/a"));
  EXPECT_NE(monitor.entity("make/a"), monitor.entity("make/A"));
}

TEST_F(Bijection, is_not_matched_while_an_observer_of_both_sides_reports_a_difference) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  wait(0s);
  wait(2s);
  EXPECT_DOUBLE_EQ(monitor.matched_ratio(), 1.0);
  monitor.set_findings(Observer::camera,
                       {{Finding::Kind::no_twin, "make/b", "the camera sees it, and it has no twin", now}});
  wait(2s);
  EXPECT_DOUBLE_EQ(monitor.matched_ratio(), 0.5);
  const JsonValue json = written();
  const auto& findings = *json.find("findings")->array();
  ASSERT_THAT(findings, SizeIs(1));
  EXPECT_EQ(findings[0].text("kind"), "no twin");
  EXPECT_EQ(findings[0].text("id"), "make/b");
}

TEST_F(Bijection, is_not_affected_by_a_camera_without_detections) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  monitor.set_findings(Observer::camera, {{Finding::Kind::no_detection, "GVS", "no image arrives", now}});
  wait(0s);
  wait(2s);
  EXPECT_DOUBLE_EQ(monitor.matched_ratio(), 1.0);
  EXPECT_DOUBLE_EQ(monitor.held_ratio(), 1.0);
}

TEST_F(Bijection, does_not_hold_with_a_twin_that_the_camera_detects_elsewhere_after_its_first_images) {
  const auto a = monitor.entity("make/a");
  monitor.set_physical(a, true);
  monitor.set_virtual(a, true);
  for (int i = 0; i < 8; ++i) monitor.actual(a, 0.2, 0.1, "camera");  // while its program starts
  EXPECT_TRUE(monitor.held(a).actual);
  monitor.actual(a, 0.051, 0.1, "camera");
  EXPECT_FALSE(monitor.held(a).actual);
  for (int i = 0; i < 200; ++i) monitor.actual(a, 0.049, 0.1, "camera");
  EXPECT_TRUE(monitor.held(a).actual);
  EXPECT_EQ(monitor.actual_m().count(), 209U);
}

}  // namespace
}  // namespace cosiva::virtual_side
