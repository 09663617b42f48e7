#include "cosiva/experiments/positioning/campaign/summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/experiments/positioning/campaign/result.h"
#include "cosiva/experiments/positioning/campaign/result_json.h"
#include "cosiva/experiments/positioning/campaign/result_page.h"
#include "cosiva/experiments/positioning/campaign/result_text.h"
#include "cosiva/experiments/positioning/campaign/test_campaign.h"
#include "cosiva/experiments/positioning/metrology/limit.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::work_of;

struct Done {
  CampaignWork work;
  std::vector<UnitRecord> records;
  CampaignSummary summary;
};

Done done_of(const std::string& text) {
  CampaignWork work = work_of(text);
  std::vector<UnitRecord> records;
  for (std::size_t i = 0; i < work.units(); ++i) {
    auto record = work.done(i);
    EXPECT_TRUE(record);
    records.push_back(std::move(*record));
  }
  AloneWorker alone;
  CampaignSummary summary = sum_up(work, records, alone);
  return {std::move(work), std::move(records), std::move(summary)};
}

TEST(Crossing, is_where_the_tolerance_is_passed_and_exact_for_a_power_law) {
  const std::vector<double> pitch{0.1, 1.0, 10.0};
  const Crossing at = crossing_of(pitch, {0.01, 0.1, 1.0}, 0.5);
  EXPECT_EQ(at.where, Crossing::Where::at);
  EXPECT_NEAR(at.x, 5.0, 1e-12);
  EXPECT_EQ(crossing_of(pitch, {0.01, 0.1, 1.0}, 0.001).where, Crossing::Where::under);
  EXPECT_EQ(crossing_of(pitch, {0.01, 0.1, 1.0}, 2.0).where, Crossing::Where::over);
  EXPECT_EQ(crossing_of({0.5}, {0.1}, 2.0).where, Crossing::Where::over);
}

TEST(Crossing, is_at_the_first_pitch_above_the_tolerance_even_if_a_wider_one_meets_it) {
  EXPECT_LT(crossing_of({0.1, 0.2, 0.4}, {0.01, 0.03, 0.01}, 0.02).x, 0.2);
}

TEST(Crossing, next_to_a_pitch_without_beacons_is_the_last_pitch_with_beacons) {
  const Crossing at = crossing_of({0.1, 0.2}, {0.01, std::nan("")}, 0.02);
  EXPECT_EQ(at.where, Crossing::Where::at);
  EXPECT_EQ(at.x, 0.1);
}

TEST(CampaignSummary, finds_the_pitch_of_the_limit_s_closed_form_with_certainty) {
  // Nine runs of 60 m at nine pitches. The path is followed to 2 mm, which adds to the error along it.
  const Done done = done_of(
      "runs = 9\ndistance_m = 60\ntolerance_m = 0.01\n[vary]\nalgorithm = [\"reset_rule\", \"arc_kalman\"]\n"
      "pitch_m = { from = 0.1, to = 3.2, steps = 9, log = true }\n");
  ASSERT_EQ(done.summary.pitches_met.size(), 2U);
  const double along_m = std::sqrt(1e-4 - 4e-6);
  const double expected_m = *pitch_for(along_m, 1e-4, 1e-4);
  const PitchMet& kalman = done.summary.pitches_met[1];
  EXPECT_NEAR(kalman.pitch.x, expected_m, 0.15 * expected_m);
  ASSERT_TRUE(kalman.limit);
  EXPECT_NEAR(kalman.limit->x, expected_m, 0.05 * expected_m);
  ASSERT_TRUE(kalman.low && kalman.high);
  EXPECT_LT(kalman.low->x, kalman.pitch.x);
  EXPECT_GT(kalman.high->x, kalman.pitch.x);
  // The article's rule is never better than a reading: 10 mm along and 2 mm across.
  EXPECT_EQ(done.summary.pitches_met[0].pitch.where, Crossing::Where::under);
  EXPECT_EQ(done.summary.leaks, 0U);
}

TEST(CampaignSummary, contains_the_metrics_and_the_limit_of_each_cell) {
  const Done done = done_of(testing::small_plan);
  ASSERT_EQ(done.summary.cells.size(), 12U);
  for (const CellMetrics& cell : done.summary.cells) {
    ASSERT_TRUE(cell.rmse_m.interval);
    EXPECT_LT(cell.rmse_m.interval->low, cell.rmse_m.value);
    EXPECT_GT(cell.rmse_m.interval->high, cell.rmse_m.value);
    EXPECT_GT(cell.limit_m, 0.004);
    EXPECT_LE(cell.p95_m.value, cell.max_m);
    EXPECT_FALSE(cell.leak);
  }
  // Missed reads increase the error: the limit at 30 % is above that at 0 % for each pitch.
  for (std::size_t pitch = 0; pitch < 3; ++pitch)
    EXPECT_GT(done.summary.cells[2 * (3 + pitch)].limit_m, done.summary.cells[2 * pitch].limit_m);
}

TEST(CampaignSummary, calls_a_cell_below_the_limit_a_leak) {
  Done done = done_of(testing::small_plan);
  for (UnitRecord& record : done.records)
    if (record.unit == 2)
      for (std::size_t i = 0; i < record.votes.size(); i += 2)
        record.votes[i].mse_m2 = 1e-9 * (1.0 + 0.1 * static_cast<double>(i));
  AloneWorker alone;
  const CampaignSummary summary = sum_up(done.work, done.records, alone);
  EXPECT_EQ(summary.leaks, 1U);
  EXPECT_TRUE(summary.cells[4].leak);
  EXPECT_NE(summary.digest, done.summary.digest);
}

TEST(CampaignSummary, of_one_run_has_no_interval) {
  const Done done = done_of("runs = 1\ndistance_m = 12\n[vary]\npitch_m = [0.5, 1.0]\n");
  EXPECT_FALSE(done.summary.cells[0].rmse_m.interval);
  EXPECT_FALSE(done.summary.pitches_met[0].low);
}

TEST(CampaignResult, has_equal_content_as_text_json_and_page) {
  const Done done = done_of(testing::small_plan);
  const CampaignResult result{done.work, done.records, done.summary};
  const std::string json = to_json(result);
  EXPECT_THAT(json, HasSubstr("\"digest\":\"" + done.summary.digest + "\""));
  EXPECT_THAT(to_text(result), HasSubstr(done.summary.digest));
  const std::string page = to_html(result, testing::small_plan);
  EXPECT_THAT(page, HasSubstr("The pitch that meets 9 mm"));
  EXPECT_THAT(page, HasSubstr("stroke-dasharray")) << "the limit's curve";
  EXPECT_THAT(page, HasSubstr("opacity=\"0.18\"")) << "the interval's band";
  EXPECT_THAT(page, HasSubstr("Against the pitch, missed_ratio = 0.3"));
  EXPECT_THAT(page, HasSubstr(done.summary.digest));
  for (const char* word : {"nan", "inf<"}) EXPECT_THAT(page, Not(HasSubstr(word)));
}

TEST(CampaignResult, of_a_grid_draws_the_pitch_over_all_its_placements) {
  const Done done = done_of(
      "runs = 3\ndistance_m = 10\nfiducials = \"grid\"\n[vary]\nalgorithm = \"arc_kalman\"\npitch_m = [0.1, 0.2]\n"
      "origin_x_m = [0.0, 0.05]\nrotation_deg = [20, 40]\n");
  ASSERT_EQ(done.summary.pitches_met.size(), 1U);
  const Curve curve = curve_of(done.work, done.records, Swept::pitch, 0, {});
  ASSERT_EQ(curve.x.size(), 2U);
  double mean = 0.0;
  for (std::size_t i = 0; i < 8; i += 2) mean += std::pow(done.summary.cells[i].rmse_m.value, 2.0) / 4.0;
  EXPECT_NEAR(curve.y[0].value, std::sqrt(mean), 1e-12);
  EXPECT_GE(curve.worst[0], curve.y[0].value);
  const CampaignResult result{done.work, done.records, done.summary};
  EXPECT_THAT(to_html(result, ""), HasSubstr("grid's rotation [°]"));
}

}  // namespace
}  // namespace cosiva::experiments
