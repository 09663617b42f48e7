// The same rules read by fuzzylite 6 and by CoSiVA, with the same inputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/fuzzy/oracle/test_fuzzylite.h"
#include "cosiva/fuzzy/rule_base.h"
#include "cosiva/fuzzy/test_random_rules.h"

namespace cosiva::fuzzy {
namespace {

#if defined(__SANITIZE_ADDRESS__)
#define COSIVA_SLOW_BUILD
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define COSIVA_SLOW_BUILD
#endif
#endif

// Under the sanitizers each decision costs ten times as much, and the bits are the same.
#ifdef COSIVA_SLOW_BUILD
constexpr std::size_t questions = 50'000;
#else
constexpr std::size_t questions = 1'000'000;
#endif
constexpr double deviation_max = 1e-6;  // of an output's range

/// A batch of random inputs: each over its range and a little beyond.
std::vector<std::vector<double>> evaluate_all(const Engine& engine, std::size_t count, Random& random) {
  std::vector<std::vector<double>> columns;
  for (const Variable& input : engine.inputs) {
    const double more = 0.1 * (input.maximum - input.minimum);
    std::vector<double> column(count);
    for (double& x : column) x = random.uniform(input.minimum - more, input.maximum + more);
    columns.push_back(std::move(column));
  }
  return columns;
}

/// The largest difference over this many decisions, as a ratio of each output's range.
double worst_deviation(const RuleBase& own, Fuzzylite& theirs, std::size_t count, Random& random) {
  const Engine& engine = own.engine();
  const auto columns = evaluate_all(engine, count, random);
  std::vector<std::vector<double>> responses(engine.outputs.size(), std::vector<double>(count));
  const std::vector<std::span<const double>> inputs(columns.begin(), columns.end());
  const std::vector<std::span<double>> outputs(responses.begin(), responses.end());
  own.evaluate(inputs, outputs);

  double worst = 0.0;
  std::vector<double> question(inputs.size());
  std::vector<double> response(outputs.size());
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < question.size(); ++i) question[i] = columns[i][k];
    theirs.evaluate(question, response);
    for (std::size_t o = 0; o < response.size(); ++o) {
      const double range = engine.outputs[o].maximum - engine.outputs[o].minimum;
      const double deviation = std::fabs(responses[o][k] - response[o]) / range;
      // NaN on either side counts as an infinite deviation.
      worst = deviation <= worst ? worst : (deviation > worst ? deviation : HUGE_VAL);
    }
  }
  return worst;
}

TEST(Fuzzylite, gives_the_same_outputs_for_a_million_inputs_of_the_agent_s_rules) {
  std::ostringstream text;
  text << std::ifstream(source_dir() + "/rules/agent.fll").rdbuf();
  const auto own = RuleBase::read(text.str(), "rules/agent.fll");
  ASSERT_TRUE(own) << to_string(own.error());
  Fuzzylite theirs{text.str()};
  ASSERT_TRUE(theirs.ready());
  Random random{1, "questions"};
  const double worst = worst_deviation(*own, theirs, questions, random);
  RecordProperty("worst_deviation", std::to_string(worst));
  EXPECT_LE(worst, deviation_max);
}

TEST(Fuzzylite, agrees_on_random_rules_of_every_shape_hedge_and_norm) {
  constexpr std::size_t bases = 200;
  for (std::uint64_t seed = 1; seed <= bases; ++seed) {
    const std::string text = RandomRules{seed}.text();
    const auto own = RuleBase::read(text, "random");
    ASSERT_TRUE(own) << to_string(own.error()) << "\n" << text;
    Fuzzylite theirs{text};
    ASSERT_TRUE(theirs.ready()) << text;
    Random random{seed, "questions"};
    ASSERT_LE(worst_deviation(*own, theirs, questions / bases / 2, random), deviation_max) << "seed " << seed << "\n"
                                                                                           << text;
  }
}

}  // namespace
}  // namespace cosiva::fuzzy

// fuzzylite's library has a main of its own, which the linker would prefer to the test library's.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
