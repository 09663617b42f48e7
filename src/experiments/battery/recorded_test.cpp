#include "cosiva/experiments/battery/recorded.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/battery/analysis.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;

std::string hg2() {
  std::ifstream file{source_dir() + "/src/battery/testdata/lghg2_fleet_figures.csv"};
  return {std::istreambuf_iterator<char>{file}, {}};
}

std::string refusal(const std::string& csv, const RecordedColumns& columns = {}) {
  const auto all = read_recorded(csv, "my.csv", columns);
  return all ? "read" : to_string(all.error());
}

// Nine LG HG2 cells (Battery Testing Consortium, 2021), as their authors' table has them.
TEST(Recorded, durations_of_others_reproduce_the_published_metrics) {
  auto all = read_recorded(hg2(), "hg2.csv");
  ASSERT_TRUE(all) << to_string(all.error());
  ASSERT_EQ(all->size(), 2U);
  RecordedSeries& fleet = (*all)[0];
  EXPECT_EQ(fleet.name, "fleet_first_run");
  EXPECT_EQ(fleet.batteries, 9U);
  const AutonomyMetrics metrics = analyse(fleet.records, fleet.batteries);
  EXPECT_NEAR(metrics.mean_s, 3605.46, 0.01);
  EXPECT_NEAR(*metrics.tolerance_low_s, 3454.8, 0.1);
  EXPECT_NEAR(metrics.vehicles->variance.f, 404.0, 2.0);
  EXPECT_EQ(metrics.vehicles->groups.front().vehicle, "tester_channel 8");
  EXPECT_EQ((*all)[1].batteries, 5U);
  EXPECT_EQ((*all)[1].records.size(), 20U);

  // And as if vehicles 6 and 9 had failed.
  ASSERT_TRUE(end_early(fleet, "6", 2000.0));
  ASSERT_TRUE(end_early(fleet, "9", 3000.0));
  EXPECT_NEAR(analyse(fleet.records, fleet.batteries).mean_s, 3602.0, 1.0);
  EXPECT_EQ(end_early(fleet, "8", 100.0).error().code, "recorded.failed");
  EXPECT_EQ(end_early(fleet, "1", 4000.0).error().code, "recorded.failed");
}

TEST(Recorded, columns_may_have_any_order_name_and_unit) {
  const auto all =
      read_recorded("\xEF\xBB\xBFnote,\"lasted_hour\",pack,stop\r\nx,1.5,P1,floor\r\n\r\ny,0.5,P2,lost\r\n", "my.csv",
                    {.time = "lasted_hour", .battery = "pack", .vehicle = {}, .run = {}});
  ASSERT_TRUE(all) << to_string(all.error());
  const auto& records = all->front().records;
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[0].autonomy_s, 5400.0);
  EXPECT_EQ(records[1].tag.id, "P2");
  EXPECT_FALSE(records[1].ended());
}

TEST(Recorded, rows_of_one_battery_without_a_run_are_its_runs_in_order) {
  const auto all = read_recorded("cell,time_s\nA,10\nB,20\nA,9\n", "my.csv");
  ASSERT_TRUE(all);
  EXPECT_EQ(all->front().records[2].run, 1U);
  EXPECT_EQ(all->front().batteries, 2U);
}

TEST(Recorded, misleading_tables_are_refused) {
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("cell,autonomy_s\n"), HasSubstr("has no runs"));
  EXPECT_THAT(refusal("test_time_second,voltage_volt,current_ampere\n1,4,-1\n"), HasSubstr("my.csv:1: is a log"));
  EXPECT_THAT(refusal("cell,lasted\nA,10\n"), HasSubstr("my.csv:1: no column holds how long"));
  EXPECT_THAT(refusal("cell,lasted\nA,10\n", {.time = "lasted", .battery = {}, .vehicle = {}, .run = {}}),
              HasSubstr("lacks its unit"));
  EXPECT_THAT(refusal("cell,a_second,b_second\nA,1,2\n"), HasSubstr("select the column of durations with --time"));
  EXPECT_THAT(refusal("cell,autonomy_s\nA,10\nB,ten\n"), HasSubstr("my.csv:3: autonomy_s is 'ten'"));
  EXPECT_THAT(refusal("cell,autonomy_s\nA,-10\n"), HasSubstr("more than 0"));
  EXPECT_THAT(refusal("cell,autonomy_s\nA\n"), HasSubstr("my.csv:2: has 1 fields, the header 2"));
  EXPECT_THAT(refusal("cell,run,autonomy_s\nA,1,10\nA,1,11\n"), HasSubstr("my.csv:3: battery A has run 1 twice"));
  EXPECT_THAT(refusal("cell,run,autonomy_s\nA,0,10\n"), HasSubstr("runs count from 1"));
  EXPECT_THAT(refusal("cell,stop,autonomy_s\nA,broken,10\n"), HasSubstr("stop is 'broken'"));
  EXPECT_THAT(refusal("cell,autonomy_s\nA,10\n", {.time = {}, .battery = "pack", .vehicle = {}, .run = {}}),
              HasSubstr("has no column 'pack'"));
}

TEST(Recorded, a_table_with_too_many_runs_is_refused) {
  std::string text = "cell,autonomy_s\n";
  for (int i = 0; i <= 10'000; ++i) text += std::to_string(i) + ",1\n";
  EXPECT_THAT(refusal(text), HasSubstr("my.csv:10002: has more than 10000 runs"));
}

TEST(Recorded, results_of_two_tests_are_combined) {
  const auto result = [](const std::string& records) { return "{\"records\":[" + records + "]}"; };
  const std::string first = R"({"id":"A","run":1,"stop":"floor","autonomy_s":100,"vehicle":"AIV1"},)"
                            R"({"id":"B","run":1,"stop":"lost","autonomy_s":90,"vehicle":"AIV2"})";
  const std::string second = R"({"id":"A","run":1,"stop":"floor","autonomy_s":99,"vehicle":"AIV2"})";
  const auto all = read_results({{result(first), "a.json"}, {result(second), "b.json"}});
  ASSERT_TRUE(all) << to_string(all.error());
  EXPECT_EQ(all->batteries, 2U);
  ASSERT_EQ(all->records.size(), 3U);
  EXPECT_EQ(all->records[2].run, 1U);  // A's second
  EXPECT_EQ(all->records[2].carrier, "AIV2");
  EXPECT_THAT(to_string(read_results({{"{}", "c.json"}}).error()), HasSubstr("c.json: is no result"));
  EXPECT_THAT(to_string(read_results({{result("{}"), "c.json"}}).error()), HasSubstr("a run lacks"));
  EXPECT_FALSE(read_results({{"{", "c.json"}}));
}

}  // namespace
}  // namespace cosiva::experiments
