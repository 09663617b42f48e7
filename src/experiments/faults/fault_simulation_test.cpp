#include "cosiva/experiments/faults/fault_simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "cosiva/experiments/faults/fault_schedule.h"
#include "cosiva/experiments/faults/shrink.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

FaultSimulationOptions options_of(SimDuration duration, Planted planted = Planted::none) {
  FaultSimulationOptions options;
  if (concerns_handovers(planted)) options.areas = two_areas();
  const auto rtm =
      zone::Rtm::initialise(options.areas ? options.areas->floor : zone::testing::configuration_file("lacet4.toml"));
  EXPECT_TRUE(rtm);
  options.rtm = std::make_shared<const zone::Rtm>(*rtm);
  options.duration = duration;
  options.planted = planted;
  return options;
}

std::string verdict(const FaultSimulationResult& result) {
  if (!result.violation) return "holds";
  return result.violation->invariant + ": " + result.violation->text;
}

/// The first seed of 1 to 200 that violates an invariant; 0: none does.
std::uint64_t first_failed_seed(const FaultSimulationOptions& options) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const auto result = simulate_faults(seed, options);
    EXPECT_TRUE(result);
    if (result && result->violation) return seed;
  }
  return 0;
}

TEST(FaultSimulation, gives_the_same_result_for_the_same_seed) {
  const auto options = options_of(seconds{12});
  const auto once = simulate_faults(3, options);
  const auto again = simulate_faults(3, options);
  const auto other = simulate_faults(4, options);
  ASSERT_TRUE(once && again && other);
  EXPECT_EQ(once->digest, again->digest);
  EXPECT_EQ(once->simulated, again->simulated);
  EXPECT_NE(once->digest, other->digest);
  EXPECT_EQ(verdict(*once), "holds");
}

TEST(FaultSimulation, injects_only_the_chosen_faults) {
  auto options = options_of(seconds{12});
  options.only = {2};
  const auto result = simulate_faults(3, options);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->faults.size(), 1U);
  EXPECT_EQ(result->faults.front().number, 2U);
}

TEST(FaultSimulation, shrinks_a_failed_seed_to_the_faults_that_it_needs) {
  const auto options = options_of(seconds{12}, Planted::hidden_age);
  const auto failed = simulate_faults(3, options);
  ASSERT_TRUE(failed && failed->violation);
  const auto shrunk = shrink(*failed, options);
  ASSERT_TRUE(shrunk);
  EXPECT_TRUE(shrunk->numbers.empty()) << "an age that is always hidden needs no fault";
  EXPECT_EQ(shrunk->result.violation->invariant, failed->violation->invariant);
}

/// scripts/test runs 200 seeds more, others for each commit.
TEST(FaultSimulationStatistics, every_invariant_holds_over_40_seeds_of_a_minute) {
  const auto options = options_of(minutes{1});
  FaultCounts injected{};
  std::uint64_t accepted = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto result = simulate_faults(seed, options);
    ASSERT_TRUE(result);
    EXPECT_EQ(verdict(*result), "holds") << "cosiva simulate --minutes 1 --seeds " << seed;
    const FaultCounts counts = count_kinds(result->faults);
    for (std::size_t i = 0; i < fault_kinds; ++i) injected.at(i) += counts.at(i);
    accepted += result->accepted;
  }
  for (std::size_t i = 0; i < fault_kinds; ++i) EXPECT_GE(injected.at(i), 5U) << to_string(static_cast<FaultKind>(i));
  EXPECT_GT(accepted, 200U);
}

class PlantedDefects : public ::testing::TestWithParam<Planted> {};

TEST_P(PlantedDefects, is_found_within_200_seeds) {
  const std::uint64_t seed = first_failed_seed(options_of(seconds{30}, GetParam()));
  EXPECT_GT(seed, 0U) << to_string(GetParam());
  std::printf("%s is found with seed %llu\n", std::string(to_string(GetParam())).c_str(),
              static_cast<unsigned long long>(seed));
}

INSTANTIATE_TEST_SUITE_P(Statistics, PlantedDefects, ::testing::ValuesIn(all_planted), [](const auto& tested) {
  std::string name{to_string(tested.param)};
  std::ranges::replace(name, '-', '_');
  return name;
});

}  // namespace
}  // namespace cosiva::experiments
