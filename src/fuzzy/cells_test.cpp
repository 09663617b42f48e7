#include "cosiva/fuzzy/cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/fuzzy/compiler.h"
#include "cosiva/fuzzy/fll_reader.h"
#include "cosiva/fuzzy/kernel.h"
#include "cosiva/fuzzy/test_random_rules.h"
#include "cosiva/fuzzy/test_rules.h"

namespace cosiva::fuzzy {
namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

struct Both {
  explicit Both(const std::string& text) : engine{*read_fll(text, "test.fll")}, compiled{*compile(engine)} {}

  Engine engine;
  Compiled compiled;
};

std::string agent_rules() {
  std::ostringstream text;
  text << std::ifstream(source_dir() + "/rules/agent.fll").rdbuf();
  return text.str();
}

std::vector<double> by_the_whole_program(const Both& both, const std::vector<double>& question) {
  std::vector<double> values(both.compiled.program.values);
  std::ranges::copy(question, values.begin());
  run_one(both.compiled.program, values.data());
  std::vector<double> responses;
  for (const std::uint16_t slot : both.compiled.program.outputs) responses.push_back(values[slot]);
  return responses;
}

std::vector<double> by_cells(const Both& both, const std::vector<double>& question) {
  std::vector<double> responses(both.engine.outputs.size());
  run_cells(both.compiled.cells, question.data(), responses.data());
  return responses;
}

void expect_same_bits(const Both& both, const std::vector<double>& question) {
  const std::vector<double> whole = by_the_whole_program(both, question);
  const std::vector<double> cells = by_cells(both, question);
  for (std::size_t o = 0; o < whole.size(); ++o) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(cells[o]), std::bit_cast<std::uint64_t>(whole[o]))
        << testing::PrintToString(question) << ", output " << o << ": " << cells[o] << ", not " << whole[o];
  }
}

/// Critical values of an input: the ends of its flanks and their neighbours, those of its range, and NaN.
std::vector<double> sharp_points(const Variable& input) {
  std::vector<double> points{input.minimum, input.maximum, -0.0, 0.0, infinite, -infinite, no_number, 1e300, -1e300};
  for (const Term& term : input.terms)
    for (const double p : term.parameters)
      points.insert(points.end(), {p, std::nextafter(p, infinite), std::nextafter(p, -infinite), p + 2e-6, p - 2e-6});
  return points;
}

/// Random inputs, half of them critical values.
void expect_same_bits_anywhere(const Both& both, std::size_t count, std::uint64_t seed) {
  Random random{seed, "questions"};
  std::vector<std::vector<double>> sharp;
  for (const Variable& input : both.engine.inputs) sharp.push_back(sharp_points(input));
  std::vector<double> question(sharp.size());
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < question.size(); ++i) {
      const Variable& input = both.engine.inputs[i];
      const std::vector<double>& points = sharp[i];
      question[i] = random.chance(0.5) ? points[random.below(points.size())]
                                       : random.uniform(input.minimum - 1.0, input.maximum + 1.0);
    }
    expect_same_bits(both, question);
  }
}

TEST(Cells, decide_by_the_agent_s_rules_with_the_bits_of_the_whole_program) {
  const Both both{agent_rules()};
  ASSERT_TRUE(both.compiled.cells.pay());
  expect_same_bits_anywhere(both, 20'000, 1);
}

TEST(Cells, leave_few_of_the_agent_s_rules_and_steps_for_its_alternatives_only) {
  const Cells cells = Both{agent_rules()}.compiled.cells;
  // The rules of by_body and by_queue have alternatives ("or"), whose maxima are no degrees of one flank.
  EXPECT_EQ(cells.steps.size(), 256U) << "of all cells";
  std::size_t looked_at = 0;
  for (const Cells::Group& group : cells.groups) looked_at += group.outputs * group.firings_each;
  EXPECT_EQ(looked_at, 25U);
}

TEST(Cells, decide_by_random_rules_with_the_bits_of_the_whole_program) {
  std::size_t paying = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const std::string text = RandomRules{seed}.text();
    const Both both{text};
    if (!both.compiled.cells.pay()) continue;
    ++paying;
    expect_same_bits_anywhere(both, 200, seed);
    if (HasFatalFailure()) FAIL() << "seed " << seed << "\n" << text;
  }
  EXPECT_GT(paying, 100U);
}

TEST(Cells, divide_the_maximum_number_of_inputs) {
  std::string text = "Engine: wide\n";
  std::string rules;
  for (int i = 0; i < 19; ++i) {
    const std::string name = "x" + std::to_string(i);
    text += "InputVariable: " + name +
            "\n  range: 0.0 10.0\n  lock-range: true\n  term: low Ramp 6.0 3.0\n  term: high Ramp 3.0 6.0\n";
    rules += "  rule: if " + name + " is low then out" + std::to_string(i % 5) + " is none\n  rule: if " + name +
             " is high then out" + std::to_string(i % 5) + " is full\n";
  }
  for (int o = 0; o < 5; ++o)
    text += "OutputVariable: out" + std::to_string(o) +
            "\n  range: 0.0 1.0\n  lock-range: true\n  defuzzifier: WeightedAverage TakagiSugeno\n  default: nan\n"
            "  term: none Constant 0.0\n  term: full Linear 0.1 0.2 -0.3\n";
  const Both both{text + "RuleBlock: rules\n  conjunction: AlgebraicProduct\n  disjunction: Maximum\n" + rules};
  ASSERT_TRUE(both.compiled.cells.pay());
  expect_same_bits_anywhere(both, 2'000, 1);
}

TEST(Cells, leave_inputs_undivided_if_dividing_all_would_make_too_many_cells) {
  std::string text = "Engine: deep\n";
  std::string condition;
  for (int i = 0; i < 7; ++i) {
    const std::string name = "x" + std::to_string(i);
    text += "InputVariable: " + name + "\n  range: 0.0 10.0\n  term: low Triangle 0.0 2.0 4.0\n" +
            "  term: middle Triangle 2.0 4.0 6.0\n  term: high Ramp 4.0 9.0\n";
    condition += (i == 0 ? "" : " and ") + name + " is not middle";
  }
  const Both both{text + "OutputVariable: out\n  range: 0.0 1.0\n  lock-range: false\n" +
                  "  defuzzifier: WeightedAverage TakagiSugeno\n  default: 0.5\n  term: none Constant 0.0\n" +
                  "  term: full Constant 1.0\nRuleBlock: rules\n  conjunction: Minimum\n  disjunction: Maximum\n" +
                  "  rule: if " + condition + " then out is full\n  rule: if x0 is low then out is none\n"};
  ASSERT_TRUE(both.compiled.cells.pay());
  EXPECT_LT(both.compiled.cells.firings.size(), 2'000U);
  expect_same_bits_anywhere(both, 2'000, 1);
}

TEST(Cells, do_not_pay_if_a_term_that_does_not_hold_may_be_nan) {
  RuleText rules{.input_terms = "  lock-range: false\n  term: low Ramp 10 0\n  term: high Ramp 0 10\n",
                 .output_terms = "  term: none Constant 0.0\n  term: full Linear 1.0 0.0 0.0\n"};
  EXPECT_TRUE(Both{rules.text()}.compiled.cells.pay());
  rules.output_terms = "  term: none Constant 0.0\n  term: full Linear 2.0 0.0 0.0\n";
  EXPECT_FALSE(Both{rules.text()}.compiled.cells.pay());
}

TEST(Cells, give_plus_zero_if_terms_that_do_not_hold_are_negative) {
  const Both both{
      RuleText{.output_terms = "  term: none Linear -1.0 0.0 0.0\n  term: full Linear 0.0 -1.0 0.0\n"}.text()};
  ASSERT_TRUE(both.compiled.cells.pay());
  for (const double x : {0.0, 10.0}) {
    const std::vector<double> question{x, x == 0.0 ? 5.0 : 0.0};
    expect_same_bits(both, question);
    EXPECT_EQ(by_cells(both, question)[0], 0.0);
    EXPECT_FALSE(std::signbit(by_cells(both, question)[0]));
  }
}

}  // namespace
}  // namespace cosiva::fuzzy
