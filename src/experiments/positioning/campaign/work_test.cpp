#include "cosiva/experiments/positioning/campaign/work.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/experiments/positioning/campaign/test_campaign.h"

namespace cosiva::experiments {
namespace {

using testing::lacet4;
using testing::plan_of;
using testing::small_plan;
using testing::work_of;

TEST(CampaignWork, cuts_every_run_of_every_environment_into_exactly_one_unit) {
  const CampaignWork work = work_of("runs = 43\ndistance_m = 500\n[vary]\npitch_m = [0.5, 1.0, 2.0]\n");
  EXPECT_GT(work.units(), 3U) << "blocks, so that little is lost and no rank waits long";
  std::vector<std::vector<int>> detected(3, std::vector<int>(43, 0));
  for (std::size_t i = 0; i < work.units(); ++i) {
    const auto unit = work.unit(i);
    for (std::uint32_t run = unit.first_run; run < unit.first_run + unit.runs; ++run) {
      ++detected[unit.environment][run];
      EXPECT_EQ(work.unit_of(unit.environment, run), i);
    }
  }
  for (const auto& environment : detected)
    for (const int times : environment) EXPECT_EQ(times, 1);
}

TEST(CampaignWork, gives_the_same_votes_each_time) {
  const CampaignWork work = work_of(small_plan);
  const auto first = work.done(3);
  const auto other = work.done(2);
  const auto again = work.done(3);
  ASSERT_TRUE(first && other && again);
  ASSERT_EQ(first->votes.size(), 10U) << "five runs of two algorithms";
  for (std::size_t i = 0; i < first->votes.size(); ++i)
    for (const auto field : vote_fields) EXPECT_EQ(first->votes[i].*field, again->votes[i].*field);
  EXPECT_NE(first->votes[0].mse_m2, other->votes[0].mse_m2);
}

TEST(CampaignWork, gives_all_algorithms_the_same_runs_and_therefore_the_same_limit) {
  const auto record = work_of(small_plan).done(0);
  ASSERT_TRUE(record);
  for (std::size_t run = 0; run < 5; ++run)
    EXPECT_EQ(record->votes[2 * run].limit_m2, record->votes[2 * run + 1].limit_m2);
  EXPECT_GT(record->votes[0].mse_m2, 0.0);
  EXPECT_GE(record->votes[0].max_m, record->votes[0].p95_m);
}

TEST(CampaignWork, of_another_plan_has_another_identity_whatever_the_tolerance) {
  const auto identity = [](const std::string& text) { return work_of(text).identity(); };
  const std::string plain = identity(small_plan);
  EXPECT_EQ(identity("# a remark\nname = \"other\"\n" + small_plan), plain);
  EXPECT_EQ(identity("tolerance_of = \"p95\"\n" + small_plan), plain);
  EXPECT_NE(identity("seed = 2\n" + small_plan), plain);
  EXPECT_NE(identity(small_plan + "reading_noise_m = 0.02\n"), plain);
  CampaignGround other = lacet4();
  auto track = estimation::Track::make(other.track->shared_circuit(), {0}, false);
  ASSERT_TRUE(track);
  other.track = std::make_shared<const estimation::Track>(std::move(*track));
  const auto work = CampaignWork::make(plan_of("distance_m = 0.5\n[vary]\n"), other);
  ASSERT_TRUE(work) << to_string(work.error());
  EXPECT_NE(work->identity(), identity("distance_m = 0.5\n[vary]\n"));
}

TEST(CampaignWork, reads_the_beacons_of_a_grid_as_often_as_their_density_predicts) {
  // A free path passes 2·reach/pitch² beacons a metre; origins and rotations average out the effect of the circuit's
  // own directions.
  const CampaignWork work = work_of(
      "runs = 1\ndistance_m = 1\nfiducials = \"grid\"\nreach_m = 0.02\n[vary]\nalgorithm = \"dead_reckoning\"\n"
      "pitch_m = 0.2\norigin_x_m = [0.0, 0.05, 0.1, 0.15]\norigin_y_m = [0.02, 0.12]\nrotation_deg = [17, 31, 45]\n");
  double per_metre = 0.0;
  for (std::size_t i = 0; i < work.units(); ++i) {
    const auto record = work.done(i);
    ASSERT_TRUE(record);
    EXPECT_GE(record->fiducials.longest_unread_m, record->fiducials.spacing_m);
    per_metre += 1.0 / record->fiducials.spacing_m / static_cast<double>(work.units());
  }
  EXPECT_NEAR(per_metre, 2.0 * 0.02 / (0.2 * 0.2), 0.15);
}

TEST(CampaignWork, reports_a_path_without_beacons_and_continues) {
  // One beacon in a hundred metres, and none under the path.
  const auto record =
      work_of("runs = 2\ndistance_m = 5\nfiducials = \"grid\"\n[vary]\npitch_m = 100\norigin_x_m = 50\n").done(0);
  ASSERT_TRUE(record) << to_string(record.error());
  EXPECT_TRUE(std::isnan(record->fiducials.spacing_m));
  // Odometry alone, and the limit includes this: both drift.
  EXPECT_GT(record->votes[0].limit_m2, 1e-4);
}

TEST(CampaignWork, refuses_an_impossible_environment_and_names_it) {
  auto steps =
      CampaignWork::make(plan_of("distance_m = 1000000\nrate_hz = 10000\n[vary]\nspeed_mps = [0.001, 50]\n"), lacet4());
  ASSERT_FALSE(steps);
  EXPECT_EQ(steps.error().code, "simulation.length");
  EXPECT_EQ(steps.error().location, "speed_mps = 0.001");
  auto grid =
      CampaignWork::make(plan_of("fiducials = \"grid\"\nreach_m = 1e-6\n[vary]\npitch_m = [1e-5, 0.5]\n"), lacet4());
  ASSERT_FALSE(grid);
  EXPECT_EQ(grid.error().code, "campaign.grid");
}

}  // namespace
}  // namespace cosiva::experiments
