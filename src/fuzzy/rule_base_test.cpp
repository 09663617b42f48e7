#include "cosiva/fuzzy/rule_base.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "cosiva/base/digest.h"
#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/fuzzy/kernel.h"
#include "cosiva/fuzzy/shapes.h"
#include "cosiva/fuzzy/test_rules.h"

namespace cosiva::fuzzy {
namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

RuleBase base_of(const std::string& text) {
  auto base = RuleBase::read(text, "test.fll");
  EXPECT_TRUE(base) << to_string(base.error());
  return std::move(*base);
}

double response(const RuleBase& base, double x, double y = 0.0) {
  double out = 0.0;
  base.evaluate(std::array{x, y}, std::span(&out, 1));
  return out;
}

/// The degree of one condition: it alone determines the output, between 0 and 1, without a division by itself.
double degree(const std::string& condition, double x, double y = 0.0, RuleText rules = {}) {
  rules.output = "  defuzzifier: WeightedSum TakagiSugeno\n  default: 0.0\n";
  rules.rules = "  rule: if " + condition + " then out is full\n";
  return response(base_of(rules.text()), x, y);
}
double membership(const std::string& term, double x) {
  return degree("x is it", x, 0.0, {.input_terms = "  lock-range: false\n  term: it " + term + "\n"});
}

TEST(Membership, of_each_shape_has_its_published_form) {
  EXPECT_DOUBLE_EQ(membership("Triangle 0 4 8", 1.0), 0.25);
  EXPECT_DOUBLE_EQ(membership("Triangle -inf 4 8", -1e6), 1.0);
  EXPECT_DOUBLE_EQ(membership("Trapezoid 0 2 4 8", 3.0), 1.0);
  EXPECT_DOUBLE_EQ(membership("Trapezoid 0 2 4 8", 7.0), 0.25);
  EXPECT_DOUBLE_EQ(membership("Trapezoid 0 2 4 inf", 1e9), 1.0);
  EXPECT_DOUBLE_EQ(membership("Ramp 0 10", 3.0), 0.3);
  EXPECT_DOUBLE_EQ(membership("Ramp 10 0", 3.0), 0.7);
  EXPECT_DOUBLE_EQ(membership("Rectangle 2 4", 3.0), 1.0);
  EXPECT_DOUBLE_EQ(membership("SShape 0 10", 2.5), 0.125);
  EXPECT_DOUBLE_EQ(membership("ZShape 0 10", 2.5), 0.875);
  EXPECT_DOUBLE_EQ(membership("PiShape 0 10 20 30", 27.5), 0.125);
  EXPECT_NEAR(membership("Gaussian 5 2", 7.0), std::exp(-0.5), 1e-15);
  EXPECT_NEAR(membership("Sigmoid 5 2", 6.0), 1.0 / (1.0 + std::exp(-2.0)), 1e-15);
  EXPECT_NEAR(membership("Bell 5 2 3", 8.0), 1.0 / (1.0 + std::pow(1.5, 6.0)), 1e-15);
  EXPECT_NEAR(membership("Bell 5 2 0.7", 8.0), 1.0 / (1.0 + std::pow(1.5, 1.4)), 1e-15);
  EXPECT_NEAR(membership("Spike 5 20", 6.0), std::exp(-0.5), 1e-15);
  EXPECT_DOUBLE_EQ(membership("Concave 0 10", 5.0), 10.0 / 15.0);
  EXPECT_NEAR(membership("Cosine 5 8", 6.0), 0.5 * (1.0 + std::cos(pi / 4.0)), 1e-15);
  EXPECT_DOUBLE_EQ(membership("Triangle 0 4 8 0.5", 4.0), 0.5);
}

TEST(Membership, at_upright_flanks_is_all_or_nothing) {
  EXPECT_EQ(membership("Rectangle 2 4", 1.9), 0.0);
  EXPECT_EQ(membership("Rectangle 2 4", 2.0), 1.0);
  EXPECT_EQ(membership("Rectangle 2 4", 4.0), 1.0);
  EXPECT_EQ(membership("Rectangle 2 4", 4.1), 0.0);
  EXPECT_EQ(membership("Triangle 2 2 4", 1.9), 0.0);
  EXPECT_EQ(membership("Triangle 2 2 4", 2.0), 1.0);
}

TEST(Hedge, changes_a_degree_by_its_formula) {
  EXPECT_DOUBLE_EQ(degree("x is not high", 3.0), 0.7);
  EXPECT_DOUBLE_EQ(degree("x is very high", 3.0), 0.09);
  EXPECT_DOUBLE_EQ(degree("x is somewhat high", 4.0), std::sqrt(0.4));
  EXPECT_DOUBLE_EQ(degree("x is extremely high", 4.0), 0.32);
  EXPECT_DOUBLE_EQ(degree("x is extremely high", 6.0), 0.68);
  EXPECT_DOUBLE_EQ(degree("x is seldom high", 2.0), std::sqrt(0.1));
  EXPECT_DOUBLE_EQ(degree("x is seldom high", 8.0), 1.0 - std::sqrt(0.1));
  EXPECT_EQ(degree("x is any", 3.0), 1.0);
  EXPECT_EQ(degree("x is not any", 3.0), 0.0);
  EXPECT_DOUBLE_EQ(degree("x is not very high", 3.0), 0.91);
}

TEST(Norm, joins_two_degrees_by_its_formula) {
  const auto joined = [](const char* norms, const char* word) {
    return degree(std::string("x is high ") + word + " y is high", 6.0, 7.0, {.norms = norms});
  };
  EXPECT_DOUBLE_EQ(joined("  conjunction: Minimum\n", "and"), 0.6);
  EXPECT_DOUBLE_EQ(joined("  conjunction: AlgebraicProduct\n", "and"), 0.42);
  EXPECT_NEAR(joined("  conjunction: BoundedDifference\n", "and"), 0.3, 1e-15);
  EXPECT_DOUBLE_EQ(joined("  disjunction: Maximum\n", "or"), 0.7);
  EXPECT_DOUBLE_EQ(joined("  disjunction: AlgebraicSum\n", "or"), 0.88);
  EXPECT_DOUBLE_EQ(joined("  disjunction: BoundedSum\n", "or"), 1.0);
}

TEST(RuleBase, averages_its_conclusions_by_how_far_their_rules_hold) {
  const RuleBase base = base_of(RuleText{}.text());
  EXPECT_DOUBLE_EQ(response(base, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(response(base, 3.0), 0.3);
  EXPECT_DOUBLE_EQ(response(base, 10.0), 1.0);
}

TEST(RuleBase, weighs_a_rule_with_its_weight) {
  const RuleBase base = base_of(RuleText{.rules = "  rule: if x is low then out is none with 0.5\n"
                                                  "  rule: if x is high then out is full\n"}
                                    .text());
  EXPECT_DOUBLE_EQ(response(base, 5.0), 0.5 / 0.75);
}

TEST(RuleBase, accepts_an_output_that_is_linear_in_its_inputs) {
  const RuleBase base =
      base_of(RuleText{.output_terms = "  term: none Constant 0.0\n  term: full Linear 0.5 0.25 1.0\n",
                       .rules = "  rule: if x is any then out is full\n"}
                  .text());
  EXPECT_DOUBLE_EQ(response(base, 4.0, 2.0), 3.5);
}

TEST(RuleBase, gives_its_default_if_no_rule_fires) {
  EXPECT_EQ(response(base_of(RuleText{.rules = "  rule: if x is high then out is full\n"}.text()), 0.0), -1.0);
  EXPECT_EQ(response(base_of(RuleText{.rules = "  rule: if x is high then out is full\n"}.text()), 1e-6), -1.0);
}

TEST(RuleBase, limits_an_output_to_its_locked_range) {
  const RuleBase base = base_of(RuleText{.output = "  lock-range: true\n  defuzzifier: WeightedSum\n  default: 0.0\n",
                                         .output_terms = "  term: none Constant -7.0\n  term: full Constant 9.0\n"}
                                    .text());
  EXPECT_EQ(response(base, 0.0), 0.0);
  EXPECT_EQ(response(base, 10.0), 1.0);
}

TEST(RuleBase, limits_an_input_to_its_locked_range_and_treats_nan_as_the_minimum) {
  const RuleBase base = base_of(RuleText{}.text());
  EXPECT_EQ(response(base, 11.0), 1.0);
  EXPECT_EQ(response(base, infinite), 1.0);
  EXPECT_EQ(response(base, -infinite), 0.0);
  EXPECT_EQ(response(base, no_number), 0.0);
}

TEST(RuleBase, never_gives_nan_for_any_input_while_its_default_is_a_number) {
  RuleText rules{.input_terms =
                     "  lock-range: false\n  term: a Gaussian 5 2\n  term: b Sigmoid 5 -2\n  term: c Bell 5 2 3.3\n"
                     "  term: d Spike 5 1\n  term: e Concave 0 5\n  term: f Cosine 5 3\n  term: g PiShape 1 2 3 4\n"
                     "  term: h Rectangle 1 1\n"};
  rules.rules.clear();
  for (const char name : std::string("abcdefgh"))
    rules.rules += std::string("  rule: if x is ") + name + " and y is not seldom low then out is full\n";
  const RuleBase base = base_of(rules.text());
  constexpr double huge = std::numeric_limits<double>::max();
  for (const double x :
       {-infinite, -huge, -1e300, -1.0, -0.0, 0.0, 1e-310, 5.0, 1e9, 1e300, huge, infinite, no_number}) {
    for (const double y : {-infinite, 0.0, 7.0, infinite, no_number})
      EXPECT_TRUE(std::isfinite(response(base, x, y))) << x;
  }
}

TEST(RuleBase, treats_conditions_on_a_disabled_input_as_not_holding) {
  EXPECT_EQ(degree("x is high", 10.0, 0.0, {.input_terms = "  enabled: false\n  term: high Ramp 0 10\n"}), 0.0);
}

TEST(RuleBase, rejects_too_many_rules) {
  RuleText rules;
  rules.input_terms.clear();
  rules.rules.clear();
  for (int t = 0; t < 62; ++t)
    rules.input_terms += "  term: t" + std::to_string(t) + " Gaussian " + std::to_string(t) + " 1\n";
  for (const char* hedges : {"", "not ", "very ", "somewhat ", "extremely ", "seldom ", "not very "}) {
    for (int t = 0; t < 62; ++t)
      rules.rules += "  rule: if x is t" + std::to_string(t) + " and y is " + hedges + "low then out is full\n";
  }
  EXPECT_TRUE(RuleBase::read(rules.text(), "my.fll"));
  for (int t = 0; t < 62; ++t)
    rules.rules += "  rule: if x is t" + std::to_string(t) + " and y is not seldom low then out is full\n";
  EXPECT_THAT(to_string(RuleBase::read(rules.text(), "my.fll").error()),
              testing::MatchesRegex("my.fll: the rules make 1[0-9]+ values, and at most 1024 can be worked with.*"));
}

std::string agent_rules() {
  std::ostringstream text;
  text << std::ifstream(source_dir() + "/rules/agent.fll").rdbuf();
  return text.str();
}

std::vector<std::vector<double>> questions(const RuleBase& base, std::size_t count) {
  Random random{3, "questions"};
  std::vector<std::vector<double>> columns;
  for (const Variable& input : base.engine().inputs) {
    columns.emplace_back(count);
    for (double& x : columns.back()) x = random.uniform(input.minimum, input.maximum);
  }
  return columns;
}

std::vector<std::vector<double>> responses(const RuleBase& base, const std::vector<std::vector<double>>& columns) {
  std::vector<std::vector<double>> all(base.engine().outputs.size(), std::vector<double>(columns.front().size()));
  const std::vector<std::span<const double>> inputs(columns.begin(), columns.end());
  base.evaluate(inputs, std::vector<std::span<double>>(all.begin(), all.end()));
  return all;
}

std::string curved_rules() {
  return RuleText{.input_terms =
                      "  term: a Gaussian 5 2\n  term: b Sigmoid 5 -2\n  term: c Bell 5 2 3.3\n  term: d Spike 5 9\n"
                      "  term: e Concave 0 5\n  term: f Cosine 5 7\n  term: g PiShape 1 2 3 4\n",
                  .rules =
                      "  rule: if x is a or x is very b then out is full\n"
                      "  rule: if x is c and y is seldom low then out is none\n"
                      "  rule: if x is d or x is somewhat e then out is none\n"
                      "  rule: if x is not f and x is extremely g then out is full\n"}
      .text();
}

TEST(Decisions, taken_together_have_the_bits_of_single_ones) {
  for (const std::string& rules : {agent_rules(), curved_rules()}) {
    const RuleBase base = base_of(rules);
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, lanes - 1, lanes, lanes + 1, std::size_t{1000}}) {
      const auto columns = questions(base, count);
      const auto together = responses(base, columns);
      std::vector<double> question(columns.size());
      std::vector<double> alone(together.size());
      for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t i = 0; i < columns.size(); ++i) question[i] = columns[i][k];
        base.evaluate(question, alone);
        for (std::size_t o = 0; o < alone.size(); ++o)
          ASSERT_EQ(std::bit_cast<std::uint64_t>(alone[o]), std::bit_cast<std::uint64_t>(together[o][k]));
      }
    }
  }
}

/// The correct outputs are the subject of the tests above and of fuzzylite; this one tests that they are the same
/// everywhere.
TEST(Decisions, have_the_same_bits_with_every_compiler_processor_and_optimisation) {
  Digest digest;
  for (const std::string& rules : {agent_rules(), curved_rules()}) {
    const RuleBase base = base_of(rules);
    for (const auto& column : responses(base, questions(base, 10'000)))
      for (const double value : column) digest.add(value);
  }
  EXPECT_EQ(digest.hex(), "2549d96bc14749b2");
}

TEST(Exponential, is_within_an_ulp_or_two_of_the_exact_value) {
  for (double x = -690.0; x <= 690.0; x += 0.37) EXPECT_NEAR(exponential(x) / std::exp(x), 1.0, 5e-16) << x;
}

}  // namespace
}  // namespace cosiva::fuzzy
