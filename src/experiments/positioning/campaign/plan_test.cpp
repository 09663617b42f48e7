#include "cosiva/experiments/positioning/campaign/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "cosiva/experiments/positioning/campaign/test_campaign.h"

namespace cosiva::experiments {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::plan_of;

TEST(CampaignPlan, takes_numbers_lists_and_ranges) {
  const CampaignPlan plan = plan_of(
      "name = \"Density\"\nzone = \"indus8\"\nruns = 7\nseed = 40\ndistance_m = 50.0\nrate_hz = 10\nfiducials = "
      "\"grid\"\n"
      "reach_m = 0.03\ntolerance_m = 0.02\ntolerance_of = \"p95\"\nthreshold_m = 0.015\n[vary]\n"
      "algorithm = [\"arc_smoother\", \"arc_kalman\"]\npitch_m = { from = 0.1, to = 1.6, steps = 5, log = true }\n"
      "origin_x_m = { from = 0, to = 0.2, steps = 3 }\nrotation_deg = [45, -10.5]\nspeed_mps = 0.25\n");
  EXPECT_EQ(plan.name, "Density");
  EXPECT_EQ(plan.runs, 7U);
  EXPECT_EQ(plan.fiducials, Fiducials::grid);
  EXPECT_EQ(plan.evaluated, EvaluatedQuantity::p95);
  EXPECT_THAT(plan.algorithms, ElementsAre("arc_smoother", "arc_kalman"));
  EXPECT_THAT(plan.of(Swept::pitch), ElementsAre(DoubleNear(0.1, 1e-15), DoubleNear(0.2, 1e-15), DoubleNear(0.4, 1e-15),
                                                 DoubleNear(0.8, 1e-14), 1.6));
  EXPECT_THAT(plan.of(Swept::origin_x), ElementsAre(0.0, 0.1, 0.2));
  EXPECT_THAT(plan.of(Swept::rotation), ElementsAre(-10.5, 45.0)) << "in rising order";
  EXPECT_THAT(plan.of(Swept::speed), ElementsAre(0.25));
  EXPECT_THAT(plan.of(Swept::missed), ElementsAre(0.0)) << "a missing factor has its default value";
  EXPECT_EQ(plan.environments(), 5U * 3U * 2U);
  EXPECT_EQ(plan.cells(), 60U);
}

TEST(CampaignPlan, enumerates_its_grid_with_the_pitch_fastest) {
  const CampaignPlan plan = plan_of("[vary]\npitch_m = [0.5, 1.0]\nspeed_mps = [0.2, 0.4, 0.6]\n");
  ASSERT_EQ(plan.environments(), 6U);
  std::vector<std::pair<double, double>> detected;
  for (std::size_t i = 0; i < 6; ++i) {
    const SweptValues values = plan.environment(i);
    detected.emplace_back(value_of(values, Swept::speed), value_of(values, Swept::pitch));
  }
  EXPECT_THAT(detected, ElementsAre(std::pair{0.2, 0.5}, std::pair{0.2, 1.0}, std::pair{0.4, 0.5}, std::pair{0.4, 1.0},
                                    std::pair{0.6, 0.5}, std::pair{0.6, 1.0}));
}

struct Bad {
  const char* text;
  const char* location;
  const char* message;
};

TEST(CampaignPlan, reports_line_key_and_the_value_of_errors) {
  const std::vector<Bad> all{
      {"[vary]\npich_m = 0.5\n", "plan.toml:2: vary.pich_m", "did you mean \"pitch_m\"?"},
      {"run = 3\n[vary]\n", "plan.toml:1: run", "did you mean \"runs\"?"},
      {"runs = 3\n", "plan.toml:1: vary", "found nothing"},
      {"[vary]\npitch_m = []\n", "plan.toml:2: vary.pitch_m", "found an empty list"},
      {"[vary]\npitch_m = nan\n", "plan.toml:2: vary.pitch_m", "found nan"},
      {"[vary]\npitch_m = [0.5, inf]\n", "plan.toml:2: vary.pitch_m", "found inf"},
      {"[vary]\npitch_m = [0.5, -1]\n", "plan.toml:2: vary.pitch_m", "over 0, at most 100000, found -1"},
      {"[vary]\npitch_m = 0\n", "plan.toml:2: vary.pitch_m", "found 0"},
      {"[vary]\npitch_m = \"wide\"\n", "plan.toml:2: vary.pitch_m", "found \"wide\""},
      {"[vary]\npitch_m = [0.5, 1.0, 0.5]\n", "plan.toml:2: vary.pitch_m", "0.5 is in it twice"},
      {"[vary]\npitch_m = { from = 1, to = 0.5, steps = 3 }\n", "vary.pitch_m.to", "expected more than from = 1"},
      {"[vary]\npitch_m = { from = 0.1, to = 0.5, steps = 1 }\n", "vary.pitch_m.steps", "from 2 to 10000"},
      {"[vary]\npitch_m = { from = 0.1, to = 0.5, stops = 1 }\n", "vary.pitch_m.stops", "did you mean \"steps\"?"},
      {"[vary]\npitch_m = { from = 0.1, to = 0.5, steps = 3, log = 1 }\n", "vary.pitch_m.log", "true or false"},
      {"[vary]\nmissed_ratio = { from = 0, to = 0.5, steps = 3, log = true }\n", "vary.missed_ratio.from", "over 0"},
      {"[vary]\npitch_m = { from = 1e-320, to = 1, steps = 3, log = true }\n", "vary.pitch_m.to", "1e15 times"},
      {"[vary]\nmissed_ratio = 1.0\n", "vary.missed_ratio", "from 0 to 0.99, a list"},
      {"[vary]\nalgorithm = \"arc_kalmann\"\n", "plan.toml:2: vary.algorithm", "did you mean \"arc_kalman\"?"},
      {"[vary]\nalgorithm = []\n", "plan.toml:2: vary.algorithm", "an empty list"},
      {"[vary]\nalgorithm = [\"ekf\", 3]\n", "plan.toml:2: vary.algorithm", "found 3"},
      {"[vary]\nalgorithm = [\"ekf\", \"ekf\"]\n", "plan.toml:2: vary.algorithm", "given twice"},
      {"[vary]\nrotation_deg = 45\n", "plan.toml:2: vary.rotation_deg", "set fiducials = \"grid\""},
      {"fiducials = \"grid\"\nreach_m = 0.3\n[vary]\npitch_m = 0.5\n", "vary.pitch_m", "two beacons"},
      {"fiducials = \"gird\"\n[vary]\n", "plan.toml:1: fiducials", "did you mean \"grid\"?"},
      {"runs = 0\n[vary]\n", "plan.toml:1: runs", "found 0"},
      {"distance_m = -3\n[vary]\n", "plan.toml:1: distance_m", "found -3"},
      {"runs = 1000000\n[vary]\npitch_m = { from = 0.1, to = 9, steps = 10000 }\nspeed_mps = [1, 2]\n",
       "plan.toml:2: vary", "a grid of 2e+10 runs"},
      {"runs = \n[vary]\n", "plan.toml:1", ""},
  };
  for (const Bad& bad : all) {
    const auto plan = read_campaign_plan(bad.text, "plan.toml");
    ASSERT_FALSE(plan) << bad.text;
    EXPECT_THAT(plan.error().location, HasSubstr(bad.location)) << bad.text;
    EXPECT_THAT(plan.error().message, HasSubstr(bad.message)) << bad.text;
  }
  EXPECT_FALSE(read_campaign_plan(std::string(2U << 20U, '#'), "plan.toml"));
}

}  // namespace
}  // namespace cosiva::experiments
