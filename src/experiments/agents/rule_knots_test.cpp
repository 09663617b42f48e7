#include "cosiva/experiments/agents/rule_knots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cosiva/aiv/decision/agent_rules.h"

namespace cosiva::experiments {
namespace {

constexpr std::string_view small_rules =
    "InputVariable: gap\n  range: 0 10\n  term: near Ramp 2 1  # 5 metres\n  term: far Ramp 1 2\n"
    "InputVariable: charge\n  range: 0 100\n  term: low Ramp 15 5\n  term: good Ramp 5 15\n"
    "OutputVariable: pace\n  range: 0 3\n  default: 1\n  defuzzifier: WeightedAverage\n  term: slow Constant 1\n"
    "  term: fast Constant 3\nRuleBlock:\n  conjunction: AlgebraicProduct\n  rule: if gap is near then pace is slow\n"
    "  rule: if gap is far and charge is good then pace is fast\n  rule: if charge is low then pace is slow\n";

RuleKnots knots_of(std::string_view fll, const std::vector<std::string>& variables = {}) {
  auto knots = RuleKnots::read(fll, "my.fll", variables);
  EXPECT_TRUE(knots) << (knots ? "" : to_string(knots.error()));
  return std::move(*knots);
}

TEST(RuleKnots, are_the_corners_of_terms_each_once_and_the_constants) {
  const RuleKnots knots = knots_of(small_rules);
  EXPECT_THAT(knots.values(), ::testing::ElementsAre(1.0, 2.0, 1.0, 3.0));
  EXPECT_EQ(knots.knots()[1].variable, "gap");
  EXPECT_EQ(knots.knots()[1].high, 10.0);
  EXPECT_EQ(knots.knots()[3].variable, "pace");
}

TEST(RuleKnots, leave_the_text_unchanged_when_their_values_are) {
  const RuleKnots knots = knots_of(aiv::built_in_rules_text());
  EXPECT_EQ(knots.text_with(knots.values()), aiv::built_in_rules_text());
}

TEST(RuleKnots, change_terms_that_meet_at_a_corner_together) {
  const RuleKnots knots = knots_of(small_rules);
  const std::string text = knots.text_with(std::vector<double>{0.5, 2.25, 1.0, 3.0});
  EXPECT_THAT(text, ::testing::HasSubstr("term: near Ramp 2.25 0.5  # 5 metres\n  term: far Ramp 0.5 2.25\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("term: low Ramp 15 5\n")) << "the battery's numbers stay";
  EXPECT_TRUE(aiv::AgentRules::read(text, "my.fll"));
}

TEST(RuleKnots, stay_in_order_apart_and_in_their_range_when_repaired) {
  const RuleKnots knots = knots_of(small_rules);
  EXPECT_THAT(knots.repaired({7.0, 2.0, 2.0, 2.0}),
              ::testing::Pointwise(::testing::DoubleNear(1e-9), {2.0, 7.0, 2.0, 2.03}));
  EXPECT_THAT(knots.repaired({-4.0, 30.0, 5.0, 6.0}),
              ::testing::Pointwise(::testing::DoubleNear(1e-9), {0.0, 10.0, 2.97, 3.0}));
}

TEST(RuleKnots, of_some_variables_are_theirs_alone) {
  EXPECT_EQ(knots_of(small_rules, {"pace"}).knots().size(), 2U);
  for (const char* name : {"pice", "charge"}) {
    const auto unknown = RuleKnots::read(small_rules, "my.fll", {name});
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, "agents.variable");
    EXPECT_THAT(unknown.error().message, ::testing::HasSubstr(name));
  }
}

TEST(RuleKnots, of_rules_that_cannot_be_used_are_refused_with_the_line) {
  const auto knots = RuleKnots::read("InputVariable: voltage\n  range: 0 1\n", "my.fll");
  ASSERT_FALSE(knots);
  EXPECT_THAT(to_string(knots.error()), ::testing::HasSubstr("my.fll"));
}

}  // namespace
}  // namespace cosiva::experiments
