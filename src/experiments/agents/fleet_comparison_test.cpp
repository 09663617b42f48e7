#include "cosiva/experiments/agents/fleet_comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/experiments/agents/fleet_report.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

FleetCase case_of(std::vector<double> crisp_laps, std::vector<double> rules_laps, std::uint64_t crisp_stops,
                  std::uint64_t rules_stops) {
  FleetCase fleet_case{24, 0, {}, {}};
  for (std::size_t i = 0; i < crisp_laps.size(); ++i) {
    fleet_case.crisp.push_back({.laps = crisp_laps[i], .stops = crisp_stops + i % 2, .energy_kj = 40.0});
    fleet_case.rules.push_back({.laps = rules_laps[i], .stops = rules_stops, .energy_kj = 44.0});
  }
  return fleet_case;
}

TEST(PairedMean, has_student_s_interval_of_the_differences) {
  // Differences 1, 2 and 3: mean 2, deviation 1, t(2) = 4.303 at 95 %: 2 ± 4.303/√3.
  const PairedMean laps = case_of({10.0, 20.0, 30.0}, {11.0, 22.0, 33.0}, 5, 5).laps();
  EXPECT_NEAR(laps.crisp, 20.0, 1e-12);
  EXPECT_NEAR(laps.rules, 22.0, 1e-12);
  EXPECT_NEAR(laps.difference, 2.0, 1e-12);
  EXPECT_NEAR(laps.interval.low, 2.0 - 4.3027 / std::sqrt(3.0), 1e-3);
  EXPECT_NEAR(laps.interval.high, 2.0 + 4.3027 / std::sqrt(3.0), 1e-3);
  EXPECT_FALSE(laps.less());
  EXPECT_FALSE(laps.more());
  EXPECT_NEAR(laps.percent(), 10.0, 1e-12);
}

TEST(Violations, are_fewer_laps_more_stops_too_many_stops_and_collisions) {
  FleetComparison comparison;
  comparison.cases = {case_of({10.0, 11.0, 12.0}, {10.1, 11.1, 12.2}, 100, 79)};
  EXPECT_THAT(violations_of(comparison, 20.0), ::testing::IsEmpty());
  EXPECT_THAT(violations_of(comparison, 25.0), ::testing::ElementsAre(::testing::HasSubstr("% fewer stops, not 25.0")));
  comparison.cases = {case_of({10.0, 11.0, 12.0}, {9.8, 10.8, 11.79}, 100, 79)};
  EXPECT_THAT(violations_of(comparison, 0.0), ::testing::ElementsAre(::testing::HasSubstr("fewer laps")));
  comparison.cases = {case_of({10.0, 11.0, 12.0}, {10.0, 11.0, 12.0}, 100, 103)};
  EXPECT_THAT(violations_of(comparison, 0.0),
              ::testing::ElementsAre(::testing::HasSubstr("more stops"), ::testing::HasSubstr("fewer stops, not")));
  comparison.cases = {case_of({10.0, 11.0, 12.0}, {10.1, 11.1, 12.2}, 100, 79)};
  comparison.cases.front().rules.front().collisions = 1;
  EXPECT_THAT(violations_of(comparison, 0.0), ::testing::ElementsAre(::testing::HasSubstr("1 collisions")));
}

/// Parts in reverse order.
class Backwards final : public Workers {
 protected:
  void run(std::size_t count, Call call, void* context) override {
    for (std::size_t i = count; i-- > 0;) call(context, i);
  }
};

FleetPlan plan() {
  using std::chrono::seconds;
  FleetPlan plan;
  plan.rtm =
      std::make_shared<const zone::Rtm>(*zone::Rtm::initialise(zone::testing::configuration_file("lacet4.toml")));
  plan.rules = {aiv::SpeedRules::Kind::fuzzy, {}, {}};
  plan.vehicles = {4, 12};
  plan.persons = {0, 1};
  plan.first_seed = 7;
  plan.last_seed = 8;
  plan.duration = seconds{90};
  return plan;
}

TEST(FleetComparison, gives_the_same_digest_in_any_order_of_the_runs) {
  AloneWorker alone;
  Backwards backwards;
  const auto one = compare_fleets(plan(), alone);
  const auto other = compare_fleets(plan(), backwards);
  ASSERT_TRUE(one) << to_string(one.error());
  ASSERT_TRUE(other);
  EXPECT_EQ(one->digest, other->digest);
  ASSERT_EQ(one->cases.size(), 4U);
  EXPECT_EQ(one->cases[1].vehicles, 12U);
  EXPECT_EQ(one->cases[2].persons, 1U);
  for (const FleetCase& fleet_case : one->cases) {
    EXPECT_GT(fleet_case.laps().crisp, fleet_case.vehicles) << "in 90 s";
    // 3 W of each vehicle's electronics, and the drives.
    EXPECT_GT(fleet_case.energy_kj().crisp, 0.003 * 20.0 * fleet_case.vehicles);
    EXPECT_EQ(fleet_case.collisions(), 0U);
  }
  EXPECT_LT(one->cases[2].laps().crisp, one->cases[0].laps().crisp) << "a person in the path delays vehicles";
  JsonWriter json;
  write_json(json, plan(), *one);
  EXPECT_THAT(json.text(), ::testing::HasSubstr("\"first_seed\":7"));
  EXPECT_THAT(to_text(plan(), *one), ::testing::HasSubstr("12 AIVs, 1 persons, 0 collisions"));
  const std::string page = to_html(plan(), *one, 20.0, "cosiva agent measure --seeds 7..8");
  for (const char* text : {"12 AIVs, 1 persons, 0 collisions", "creeping_s", "cosiva agent measure --seeds 7..8"})
    EXPECT_THAT(page, ::testing::HasSubstr(text));
}

/// The built-in rules with one rule changed.
aiv::SpeedRules changed(std::string_view rule, std::string_view by) {
  std::string text(aiv::built_in_rules_text());
  const std::size_t at = text.find(rule);
  EXPECT_NE(at, std::string::npos) << rule;
  return {aiv::SpeedRules::Kind::custom, "changed.fll", text.replace(at, rule.size(), by)};
}

TEST(FleetComparison, shows_that_a_crowded_fleet_drives_as_many_laps_with_fewer_stops) {
  FleetPlan crowded = plan();
  crowded.vehicles = {24};
  crowded.persons = {0};
  crowded.last_seed = crowded.first_seed + 2;
  crowded.duration = std::chrono::seconds{120};
  AloneWorker alone;
  const auto comparison = compare_fleets(crowded, alone);
  ASSERT_TRUE(comparison);
  EXPECT_THAT(violations_of(*comparison, 10.0), ::testing::IsEmpty());
  EXPECT_TRUE(comparison->cases.front().stops().percent() < -10.0);
  EXPECT_GT(comparison->cases.front().laps().difference, 0.0);
}

TEST(FleetComparison, finds_a_rule_that_makes_every_vehicle_slow) {
  FleetPlan slow = plan();
  slow.vehicles = {4};
  slow.persons = {0};
  slow.duration = std::chrono::seconds{60};
  slow.rules = changed("if instruction is none then by_instruction is medium",
                       "if instruction is none then by_instruction is slow");
  AloneWorker alone;
  const auto comparison = compare_fleets(slow, alone);
  ASSERT_TRUE(comparison);
  EXPECT_THAT(violations_of(*comparison, 0.0), ::testing::Contains(::testing::HasSubstr("fewer laps")));
}

TEST(FleetComparison, finds_a_rule_that_makes_a_crowded_fleet_stop_for_each_release) {
  FleetPlan halting = plan();
  halting.vehicles = {24};
  halting.persons = {0};
  halting.rules = changed("crossing is inner and passed is before then by_queue is creep",
                          "crossing is inner and passed is before then by_queue is fast");
  AloneWorker alone;
  const auto comparison = compare_fleets(halting, alone);
  ASSERT_TRUE(comparison);
  EXPECT_THAT(violations_of(*comparison, 10.0), ::testing::Contains(::testing::HasSubstr("fewer stops, not 10.0")));
}

TEST(FleetRun, on_a_zone_without_room_for_its_vehicles_or_persons_is_refused) {
  FleetRunOptions options;
  options.rtm = plan().rtm;
  options.vehicles = 190;
  EXPECT_FALSE(run_fleet(options));
  options.vehicles = 2;
  options.persons = 5;
  const auto run = run_fleet(options);
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, "agents.persons");
  EXPECT_THAT(run.error().message, ::testing::HasSubstr("has 4 sections without a crossing for 5 persons"));
}

}  // namespace
}  // namespace cosiva::experiments
