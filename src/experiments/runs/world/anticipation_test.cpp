// The twins anticipate what the agents of their vehicles decide (A10, A27).

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

struct AtCrossings {
  double p50_m;
  double p99_m;
};

/// The divergence of the twins near the crossings of lacet4, in a run of two minutes.
AtCrossings divergence(bool anticipation, std::uint32_t aivs, std::uint64_t seed, aiv::SpeedRules::Kind rules) {
  WorldOptions options;
  options.zone = testing::zone_named("lacet4");
  options.aivs = aivs;
  options.seed = seed;
  options.as_values = true;
  options.rules.kind = options.server.virtual_rules.kind = rules;
  options.server.anticipation = anticipation;
  const auto world = World::make(std::move(options));
  (*world)->run_for(120s);
  const JsonValue measured = *testing::bijection(**world).find("crossing_divergence_m");
  EXPECT_GE(measured.number("count").value(), 1500.0);
  return {measured.number("p50").value(), measured.number("p99").value()};
}

TEST(AnticipationStatistics, has_a_lower_divergence_at_crossings_than_motion_at_the_reported_speed) {
  for (const auto rules : {aiv::SpeedRules::Kind::crisp, aiv::SpeedRules::Kind::fuzzy}) {
    for (const std::uint32_t aivs : {4U, 12U, 24U}) {
      AtCrossings with{};
      AtCrossings without{};
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const AtCrossings one = divergence(true, aivs, seed, rules);
        const AtCrossings other = divergence(false, aivs, seed, rules);
        with.p50_m += one.p50_m / 3.0;
        with.p99_m += one.p99_m / 3.0;
        without.p50_m += other.p50_m / 3.0;
        without.p99_m += other.p99_m / 3.0;
      }
      SCOPED_TRACE(std::to_string(aivs) + (rules == aiv::SpeedRules::Kind::crisp ? " crisp" : " fuzzy"));
      EXPECT_LT(with.p50_m, without.p50_m);
      // Four AIVs seldom stop: their p99 is that of the corrections at tags, which no motion predicts.
      EXPECT_LT(with.p99_m, aivs == 4 ? 1.01 * without.p99_m : 0.98 * without.p99_m);
    }
  }
}

}  // namespace
}  // namespace cosiva::experiments
