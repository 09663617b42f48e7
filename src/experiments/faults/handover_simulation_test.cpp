#include "cosiva/experiments/faults/handover_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "cosiva/experiments/faults/shrink.h"
#include "cosiva/experiments/faults/two_areas.h"

namespace cosiva::experiments {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

FaultSimulationOptions options_of(SimDuration duration, Planted planted = Planted::none) {
  FaultSimulationOptions options;
  options.areas = two_areas();
  const auto floor = zone::Rtm::initialise(options.areas->floor);
  EXPECT_TRUE(floor);
  options.rtm = std::make_shared<const zone::Rtm>(*floor);
  options.duration = duration;
  options.planted = planted;
  return options;
}

std::string verdict(const FaultSimulationResult& result) {
  if (!result.violation) return "holds";
  return result.violation->invariant + ": " + result.violation->text;
}

TEST(HandoverSimulation, gives_the_same_result_for_the_same_seed) {
  const auto options = options_of(seconds{12});
  const auto once = simulate_faults(3, options);
  const auto again = simulate_handovers(3, options);
  const auto other = simulate_handovers(4, options);
  ASSERT_TRUE(once && again && other);
  EXPECT_EQ(once->digest, again->digest);
  EXPECT_EQ(once->simulated, again->simulated);
  EXPECT_NE(once->digest, other->digest);
  EXPECT_EQ(verdict(*once), "holds");
}

TEST(HandoverSimulation, hands_each_vehicle_over_without_any_fault) {
  auto options = options_of(seconds{12});
  options.only.emplace();
  const auto result = simulate_handovers(1, options);
  ASSERT_TRUE(result);
  EXPECT_EQ(verdict(*result), "holds");
  EXPECT_EQ(result->handovers, 4U);
  EXPECT_EQ(result->server_starts, 2U);
}

TEST(HandoverSimulation, gives_both_servers_faults_and_never_the_plant) {
  bool first = false;
  bool second = false;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const Fault& fault : handover_schedule_of(seed, options_of(minutes{1}))) {
      EXPECT_NE(fault.process, plant_process);
      if (fault.kind != FaultKind::crash && fault.kind != FaultKind::power_cut) continue;
      first = first || fault.process == server_process;
      second = second || fault.process == first_other_server;
    }
  }
  EXPECT_TRUE(first && second);
}

TEST(HandoverSimulation, shrinks_a_failed_seed_to_the_faults_that_it_needs) {
  const auto options = options_of(seconds{12}, Planted::lost_owner);
  const auto failed = simulate_handovers(1, options);
  ASSERT_TRUE(failed && failed->violation);
  const auto shrunk = shrink(*failed, options);
  ASSERT_TRUE(shrunk);
  EXPECT_TRUE(shrunk->numbers.empty()) << "an owner that is never published needs no fault";
}

/// scripts/test runs seeds 1 to 40.
TEST(HandoverSimulationStatistics, every_invariant_holds_over_20_seeds_of_a_minute) {
  std::uint64_t handovers = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto result = simulate_handovers(seed, options_of(minutes{1}));
    ASSERT_TRUE(result);
    EXPECT_EQ(verdict(*result), "holds") << "cosiva simulate --handovers --minutes 1 --seeds " << seed;
    handovers += result->handovers;
  }
  EXPECT_GT(handovers, 100U) << "at least the one at the end of each vehicle";
}

}  // namespace
}  // namespace cosiva::experiments
