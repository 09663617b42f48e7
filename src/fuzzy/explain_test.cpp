#include "cosiva/fuzzy/explain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "cosiva/base/json_value.h"
#include "cosiva/fuzzy/test_rules.h"

namespace cosiva::fuzzy {
namespace {

using testing::HasSubstr;

Explanation explained(double x, double y) {
  const RuleText rules{.rules =
                           "  rule: if x is low then out is none\n"
                           "  rule: if x is very high and y is low then out is full with 0.5\n"};
  return RuleBase::read(rules.text(), "test.fll")->explain(std::array{x, y});
}

TEST(Explanation, states_for_each_rule_how_far_its_conditions_hold_and_what_it_contributes) {
  const Explanation explanation = explained(5.0, 0.0);
  ASSERT_EQ(explanation.rules.size(), 2U);
  const Explanation::Rule& rule = explanation.rules[1];
  EXPECT_EQ(rule.line, 21U);
  ASSERT_EQ(rule.conditions.size(), 2U);
  EXPECT_EQ(rule.conditions[0].text, "x is very high");
  EXPECT_DOUBLE_EQ(rule.conditions[0].degree, 0.25);
  EXPECT_DOUBLE_EQ(rule.degree, 0.125);
  EXPECT_TRUE(rule.fired);
  EXPECT_DOUBLE_EQ(rule.ratios[0].ratio, 0.125 / 0.625);
  EXPECT_DOUBLE_EQ(explanation.outputs[0].value, 0.125 / 0.625);
}

TEST(Explanation, adds_up_to_the_output) {
  for (const double x : {0.0, 1.0, 4.0, 9.5}) {
    const Explanation explanation = explained(x, 2.0);
    double sum = 0.0;
    double ratios = 0.0;
    for (const auto& rule : explanation.rules) {
      sum += rule.ratios[0].ratio * rule.ratios[0].consequent;
      ratios += rule.ratios[0].ratio;
    }
    EXPECT_NEAR(sum, explanation.outputs[0].value, 1e-15);
    EXPECT_NEAR(ratios, 1.0, 1e-15);
  }
}

TEST(Explanation, states_that_no_rule_fired_and_that_an_input_was_beyond_its_range) {
  const Explanation explanation = explained(12.0, 10.0);
  EXPECT_TRUE(explanation.outputs[0].by_default);
  EXPECT_EQ(explanation.outputs[0].value, -1.0);
  const std::string text = to_text(explanation);
  EXPECT_THAT(text, HasSubstr("(given: 12.00)"));
  EXPECT_THAT(text, HasSubstr("no rule fired: its default"));
}

TEST(Explanation, is_written_as_text_with_the_strongest_rule_first) {
  const std::string text = to_text(explained(5.0, 0.0));
  EXPECT_THAT(text, HasSubstr("low 50 %, high 50 %"));
  EXPECT_LT(text.find("line 20"), text.find("line 21"));
  EXPECT_THAT(text, HasSubstr("because x is very high: 25 %, y is low: 100 %"));
  EXPECT_THAT(text, HasSubstr("so out is full (1.00) for 20 % of its result"));
}

TEST(Explanation, is_written_as_json_with_every_rule) {
  JsonWriter json;
  write_json(json, explained(0.0, 0.0));
  const auto value = JsonValue::parse(json.text());
  ASSERT_TRUE(value);
  EXPECT_THAT(json.text(), HasSubstr(R"("fired":false)"));
  EXPECT_THAT(json.text(), HasSubstr(R"("x is very high":0)"));
}

}  // namespace
}  // namespace cosiva::fuzzy
