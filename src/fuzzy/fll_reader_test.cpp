#include "cosiva/fuzzy/fll_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cosiva/fuzzy/test_rules.h"

namespace cosiva::fuzzy {
namespace {

using testing::HasSubstr;

/// "location: message" of the fault of a text.
std::string fault_of_text(const std::string& text) {
  const auto engine = read_fll(text, "my.fll");
  return engine ? "nothing" : to_string(engine.error());
}
std::string fault(const RuleText& rules) { return fault_of_text(rules.text()); }

TEST(Fll, may_begin_with_a_bom_and_have_windows_line_ends) {
  std::string text = RuleText{}.text();
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, 1, '\r');
  EXPECT_EQ(fault_of_text("\xEF\xBB\xBF" + text), "nothing");
  EXPECT_THAT(fault_of_text("x\xEF\xBB\xBF" + text), testing::StartsWith("my.fll:1"));
}

TEST(Fll, is_read_with_comments_descriptions_and_blocks_in_any_order) {
  const auto engine = read_fll(
      "# a remark\nEngine: speed\ndescription: what it is for\n\n"
      "RuleBlock: rules\n  rule: if gap is far then go is yes # so be it\n"
      "OutputVariable: go\n  defuzzifier: WeightedSum TakagiSugeno\n  term: yes Linear 2.0 0.5\n"
      "InputVariable: gap\n  description: metres\n  enabled: false\n  range: -inf inf\n  term: far Ramp 1 2 0.5\n",
      "my.fll");
  ASSERT_TRUE(engine) << to_string(engine.error());
  EXPECT_EQ(engine->name, "speed");
  EXPECT_EQ(engine->description, "what it is for");
  ASSERT_EQ(engine->inputs.size(), 1U);
  EXPECT_EQ(engine->inputs[0].description, "metres");
  EXPECT_FALSE(engine->inputs[0].enabled);
  EXPECT_EQ(engine->inputs[0].terms[0].height, 0.5);
  EXPECT_FALSE(engine->outputs[0].is_average);
  EXPECT_TRUE(std::isnan(engine->outputs[0].otherwise));
  EXPECT_THAT(engine->outputs[0].terms[0].parameters, testing::ElementsAre(2.0, 0.5));
  EXPECT_EQ(engine->rules[0].line, 6U);
  EXPECT_EQ(engine->rules[0].text, "if gap is far then go is yes");
}

TEST(Fll, and_binds_tighter_than_or_and_brackets_tightest) {
  RuleText rules;
  rules.rules = "  rule: if x is low or x is high and (y is low or y is any) then out is full with 0.25\n";
  const auto engine = read_fll(rules.text(), "my.fll");
  ASSERT_TRUE(engine) << to_string(engine.error());
  const Rule& rule = engine->rules[0];
  ASSERT_EQ(rule.conditions.size(), 7U);
  EXPECT_EQ(rule.conditions[6].kind, Condition::Kind::any_of);
  EXPECT_EQ(rule.conditions[6].left, 0U);
  EXPECT_EQ(rule.conditions[5].kind, Condition::Kind::all_of);
  EXPECT_EQ(rule.conditions[4].kind, Condition::Kind::any_of);
  EXPECT_EQ(rule.weight, 0.25);
}

TEST(Fll, rules_of_a_disabled_block_are_checked_but_ignored) {
  RuleText rules;
  EXPECT_EQ(fault({.rules = rules.rules + "RuleBlock: more\n  enabled: false\n  rule: if x is low then out is full\n"}),
            "nothing");
  EXPECT_THAT(
      fault({.rules = rules.rules + "RuleBlock: more\n  enabled: false\n  rule: if x is lo then out is full\n"}),
      HasSubstr("'x' has no such term"));
}

TEST(FllFault, of_a_condition_names_line_column_and_the_alternatives) {
  EXPECT_EQ(fault({.rules = "  rule: if x is lo then out is full\n"}),
            "my.fll:20:17: 'x' has no such term; expected a hedge or low or high, but found 'lo'");
  EXPECT_EQ(fault({.rules = "  rule: if z is low then out is full\n"}),
            "my.fll:20:12: expected an input (x or y), but found 'z'");
  EXPECT_EQ(fault({.rules = "  rule: if x is low\n"}),
            "my.fll:20:20: expected 'and', 'or' or 'then', but the rule ends here");
  EXPECT_THAT(fault({.rules = "  rule: if (x is low then out is full\n"}), HasSubstr("my.fll:20:22: expected ')'"));
  EXPECT_THAT(fault({.rules = "  rule: if out is full then out is full\n"}),
              HasSubstr("cannot refer to the output 'out'"));
}

TEST(FllFault, of_a_conclusion_states_what_to_write_instead) {
  EXPECT_THAT(
      fault({.rules = "  rule: if x is low then out is very full\n"}),
      HasSubstr("my.fll:20:33: a hedge such as 'very' is not taken in a conclusion; weaken the rule with 'with 0.5'"));
  EXPECT_THAT(fault({.rules = "  rule: if x is low then out is full and out is none\n"}), HasSubstr("already"));
  EXPECT_THAT(fault({.rules = "  rule: if x is low then out is full with 2\n"}),
              HasSubstr("my.fll:20:43: expected the rule's weight, from 0 to 1, but found '2'"));
}

TEST(FllFault, of_a_missing_or_unknown_norm_names_the_known_ones) {
  EXPECT_THAT(fault({.norms = "", .rules = "  rule: if x is low and y is low then out is full\n"}),
              HasSubstr("'and' needs a norm: write 'conjunction: AlgebraicProduct' in the RuleBlock"));
  EXPECT_THAT(fault({.norms = "  conjunction: EinsteinProduct\n"}),
              HasSubstr("my.fll:18:16: the conjunction 'EinsteinProduct' is not taken; there are none, Minimum, "
                        "AlgebraicProduct and BoundedDifference"));
}

TEST(FllFault, of_a_mamdani_file_states_how_to_write_it_for_takagi_sugeno) {
  EXPECT_THAT(fault({.output = "  defuzzifier: Centroid 100\n"}),
              HasSubstr("my.fll:13:16: the defuzzifier 'Centroid 100' is not taken: outputs are Takagi-Sugeno; write "
                        "'WeightedAverage TakagiSugeno'"));
  EXPECT_THAT(fault({.output_terms = "  term: full Triangle 0 1 2\n"}), HasSubstr("write 'Constant number'"));
  EXPECT_THAT(fault({.output = "  defuzzifier: WeightedAverage\n  lock-previous: true\n"}),
              HasSubstr("lock-previous is not supported"));
  EXPECT_THAT(fault({.norms = "  activation: Highest 1\n"}), HasSubstr("write 'General'"));
  EXPECT_THAT(fault({.output = ""}), HasSubstr("needs a line 'defuzzifier: WeightedAverage TakagiSugeno'"));
}

TEST(FllFault, of_a_term_names_its_shape_and_the_fault_of_its_numbers) {
  EXPECT_THAT(fault({.input_terms = "  term: low Wedge 0 1\n"}), HasSubstr("my.fll:5:13: there is no shape 'Wedge'"));
  EXPECT_THAT(fault({.input_terms = "  term: low Triangle 0 1\n"}),
              HasSubstr("Triangle has 3 numbers (left, top and right)"));
  EXPECT_THAT(fault({.input_terms = "  term: low Triangle 2 1 0\n"}), HasSubstr("must not fall from left to right"));
  EXPECT_THAT(fault({.input_terms = "  term: low Gaussian 0 0\n"}), HasSubstr("its width must be above 0"));
  EXPECT_THAT(fault({.input_terms = "  term: low Ramp 1 1\n"}), HasSubstr("must differ"));
  EXPECT_THAT(fault({.input_terms = "  term: low Ramp 0 1e10\n"}), HasSubstr("within ±1e9"));
  EXPECT_THAT(fault({.input_terms = "  term: low Ramp 0 ten\n"}),
              HasSubstr("my.fll:5:20: expected a number, but found 'ten'"));
  EXPECT_THAT(fault({.input_terms = "  term: low Ramp 0 1 1.5\n"}),
              HasSubstr("height of a term is above 0 and at most 1"));
  EXPECT_THAT(fault({.input_terms = "  term: very Ramp 0 1\n"}), HasSubstr("'very' cannot name a term"));
}

TEST(FllFault, of_an_invalid_line_names_what_is_expected) {
  EXPECT_EQ(fault_of_text("hello\n").substr(0, 50), "my.fll:1:1: expected 'key: value', such as 'range:");
  EXPECT_THAT(fault_of_text("  range: 0 1\n"), HasSubstr("my.fll:1:3: 'range' is outside any block"));
  EXPECT_THAT(fault({.input_terms = "  terms: low Ramp 0 1\n"}), HasSubstr("my.fll:5:3: there is no 'terms' here"));
  EXPECT_THAT(fault({.input_terms = "  range: 5 1\n"}), HasSubstr("the lowest number of 'range'"));
  EXPECT_THAT(fault({.input_terms = "  enabled: yes\n"}), HasSubstr("'enabled' is true or false, but found 'yes'"));
  EXPECT_THAT(fault_of_text(""), HasSubstr("a rule file needs an InputVariable"));
}

TEST(FllFault, of_a_text_that_is_too_large_is_reported_at_once) {
  EXPECT_THAT(fault_of_text(std::string((1U << 20U) + 1, '#')), HasSubstr("at most 1 MiB"));
  std::string nested = "  rule: if " + std::string(20, '(') + "x is low";
  EXPECT_THAT(fault({.rules = nested + std::string(20, ')') + " then out is full\n"}),
              HasSubstr("more brackets within brackets"));
}

}  // namespace
}  // namespace cosiva::fuzzy
