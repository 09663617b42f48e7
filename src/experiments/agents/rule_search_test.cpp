#include "cosiva/experiments/agents/rule_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/experiments/agents/rule_search_report.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(RuleProperties, hold_for_the_built_in_rules_and_not_for_rules_that_hurry_into_a_body) {
  const std::string text(aiv::built_in_rules_text());
  EXPECT_TRUE(has_properties(*aiv::AgentRules::built_in()));
  const auto hurries = aiv::AgentRules::read(replaced(text, "if gap is near and closing is steady then by_gap is slow",
                                                      "if gap is near and closing is steady then by_gap is fast"),
                                             "my.fll");
  ASSERT_TRUE(hurries);
  EXPECT_FALSE(has_properties(**hurries));
  const auto both_go = aiv::AgentRules::read(
      replaced(text, "priority is equal then go is yield", "priority is equal then go is go"), "my.fll");
  ASSERT_TRUE(both_go);
  EXPECT_FALSE(has_properties(**both_go));
}

TEST(SearchCost, counts_stops_energy_and_twentyfold_the_missing_laps) {
  EXPECT_NEAR(cost_of({{24, 0, 1.10, 0.8, 1.0}}), 0.8 + 0.5, 1e-12);
  EXPECT_NEAR(cost_of({{24, 0, 0.995, 0.8, 1.0}}), 0.8 + 0.5 + 20.0 * 0.01, 1e-12);
  EXPECT_NEAR(cost_of({{12, 0, 1.1, 0.6, 1.0}, {24, 0, 1.1, 0.8, 1.0}}), 0.7 + 0.5, 1e-12);
}

SearchPlan plan() {
  SearchPlan plan;
  plan.rtm =
      std::make_shared<const zone::Rtm>(*zone::Rtm::initialise(zone::testing::configuration_file("lacet4.toml")));
  plan.fll = aiv::built_in_rules_text();
  plan.origin = "rules/agent.fll";
  plan.vehicles = {12};
  plan.first_seed = plan.last_seed = 3;
  plan.duration = std::chrono::seconds{20};
  plan.budget = 3;
  plan.offspring = 2;
  return plan;
}

TEST(RuleSearch, runs_its_budget_returns_the_lowest_cost_and_repeats_itself) {
  AloneWorker alone;
  const auto result = search_rules(plan(), alone);
  ASSERT_TRUE(result) << to_string(result.error());
  ASSERT_EQ(result->candidates.size(), 4U);
  for (const RuleCandidate& candidate : result->candidates) {
    EXPECT_GE(candidate.cost, result->candidates[result->best].cost);
    EXPECT_NEAR(candidate.cost, cost_of(candidate.cases), 1e-12);
  }
  const auto rules = aiv::AgentRules::read(result->fll, "best.fll");
  ASSERT_TRUE(rules);
  EXPECT_TRUE(has_properties(**rules));
  const auto again = search_rules(plan(), alone);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->fll, result->fll);
  EXPECT_EQ(again->candidates.back().values, result->candidates.back().values);
  JsonWriter json;
  write_json(json, plan(), *result);
  EXPECT_THAT(json.text(), ::testing::HasSubstr("\"budget\":3"));
  EXPECT_THAT(to_html(plan(), *result, "cosiva agent search"), ::testing::HasSubstr("cosiva agent search"));
}

TEST(RuleSearch, of_rules_without_numbers_or_with_an_unknown_variable_is_refused) {
  AloneWorker alone;
  SearchPlan unknown = plan();
  unknown.variables = {"weather"};
  const auto result = search_rules(unknown, alone);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, "agents.variable");
}

}  // namespace
}  // namespace cosiva::experiments
