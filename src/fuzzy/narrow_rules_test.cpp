#include "cosiva/fuzzy/narrow_rules.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::fuzzy {
namespace {

RuleBase agent_rules() {
  std::ostringstream text;
  text << std::ifstream(source_dir() + "/rules/agent.fll").rdbuf();
  auto rules = RuleBase::read(text.str(), "rules/agent.fll");
  EXPECT_TRUE(rules) << to_string(rules.error());
  return std::move(*rules);
}

/// Random inputs, some of which never change: compares the outputs of the narrow rules with those of the whole rule
/// base.
void expect_same(const RuleBase& rules, const std::vector<std::size_t>& fixed,
                 const std::vector<std::size_t>& requested, std::uint64_t seed) {
  Random random{seed, "narrow"};
  const std::size_t inputs = rules.engine().inputs.size();
  const auto draw = [&](std::size_t i) {
    const Variable& input = rules.engine().inputs[i];
    // Often at an end or beyond it, where the memberships are 0 and 1.
    if (random.chance(0.4)) return random.chance(0.5) ? input.minimum : input.maximum + 1.0;
    return random.uniform(input.minimum, input.maximum);
  };
  std::vector<std::optional<double>> known(inputs);
  for (const std::size_t i : fixed) known[i] = draw(i);
  auto narrow = NarrowRules::make(rules, known, requested);
  ASSERT_TRUE(narrow);
  const auto rows = std::make_unique<double[][lanes]>(narrow->rows());
  std::vector<std::vector<double>> questions(lanes, std::vector<double>(inputs));
  for (std::size_t k = 0; k < lanes; ++k) {
    for (std::size_t i = 0; i < inputs; ++i) {
      questions[k][i] = known[i] ? *known[i] : draw(i);
      if (!known[i]) rows[i][k] = questions[k][i];
    }
  }
  narrow->run(rows.get());
  for (std::size_t k = 0; k < lanes; ++k) {
    std::vector<double> responses(rules.engine().outputs.size());
    rules.evaluate(questions[k], responses);
    for (std::size_t o = 0; o < requested.size(); ++o)
      EXPECT_EQ(narrow->known(o) ? *narrow->known(o) : rows[narrow->row(o)][k], responses[requested[o]])
          << k << " " << o;
  }
}

TEST(NarrowRules, give_the_outputs_of_the_whole_rule_base) {
  const RuleBase rules = agent_rules();
  const std::size_t inputs = rules.engine().inputs.size();
  const std::size_t outputs = rules.engine().outputs.size();
  Random random{1, "which"};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::vector<std::size_t> fixed;
    std::vector<std::size_t> requested;
    for (std::size_t i = 0; i < inputs; ++i)
      if (random.chance(0.6)) fixed.push_back(i);
    for (std::size_t o = 0; o < outputs; ++o)
      if (random.chance(0.7)) requested.push_back(o);
    expect_same(rules, fixed, requested, seed);
  }
}

TEST(NarrowRules, need_no_work_if_everything_is_known) {
  const RuleBase rules = agent_rules();
  std::vector<std::optional<double>> known(rules.engine().inputs.size(), 0.5);
  const auto narrow = NarrowRules::make(rules, known, {0, 1});
  ASSERT_TRUE(narrow);
  EXPECT_TRUE(narrow->known(0));
  EXPECT_TRUE(narrow->known(1));
  EXPECT_LE(narrow->rows(), rules.engine().inputs.size());
}

}  // namespace
}  // namespace cosiva::fuzzy
