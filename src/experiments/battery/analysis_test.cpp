#include "cosiva/experiments/battery/analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/battery/autonomy_output.h"
#include "cosiva/experiments/battery/autonomy_report.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Cell {
  int number;
  int channel;
  std::string series;
  int run;
  double seconds;
};

std::vector<Cell> hg2() {
  std::ifstream file{source_dir() + "/src/battery/testdata/lghg2_fleet_figures.csv"};
  std::string line;
  std::getline(file, line);
  std::vector<Cell> cells;
  while (std::getline(file, line)) {
    std::istringstream in{line};
    std::vector<std::string> fields;
    for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
    cells.push_back(
        {std::stoi(fields[0]), std::stoi(fields[1]), fields[2], std::stoi(fields[3]), std::stod(fields[5])});
  }
  EXPECT_EQ(cells.size(), 29U);
  return cells;
}

BatteryRun record_of(std::size_t battery, std::size_t run, double seconds, StopCause stop = StopCause::floor) {
  BatteryRun record;
  record.run = run;
  record.vehicle = battery;
  record.battery = battery;
  record.tag.id = "HG2-" + std::to_string(battery + 1);
  record.started = virtual_epoch;
  record.stop = stop;
  record.autonomy_s = seconds;
  return record;
}

std::vector<BatteryRun> fleet() {
  std::vector<BatteryRun> records;
  for (const Cell& cell : hg2())
    if (cell.series == "fleet_first_run") records.push_back(record_of(records.size(), 0, cell.seconds));
  return records;
}

// Nine LG HG2 cells from full to 2.5 V at 3 A (Battery Testing Consortium, 2021).
TEST(Autonomy, of_the_nine_cells_equals_the_published_metrics) {
  const AutonomyMetrics metrics = analyse(fleet(), 9);
  EXPECT_NEAR(metrics.at_s, 3605.46, 0.01);
  EXPECT_EQ(metrics.mean_s, metrics.at_s);
  EXPECT_NEAR(metrics.sd_s, 49.69, 0.01);
  EXPECT_NEAR(metrics.mean_t->low, 3567.3, 0.05);
  EXPECT_NEAR(metrics.mean_t->high, 3643.7, 0.05);
  EXPECT_NEAR(metrics.sd_interval->high, 1.92 * 49.69, 0.3);
  EXPECT_NEAR(*metrics.tolerance_low_s, 3454.8, 0.1);
  ASSERT_TRUE(metrics.grubbs->is_outlier);
  EXPECT_NEAR(metrics.grubbs->statistic, 2.309, 0.001);
  EXPECT_TRUE(metrics.each[0].is_outlier);
  EXPECT_FALSE(metrics.each[1].is_outlier);
  EXPECT_NEAR(metrics.smallest_covers, 0.72, 0.005);
  EXPECT_EQ(metrics.survival.when_ended(0.5), 3602.42);
  EXPECT_FALSE(metrics.mean_bca);  // nine are too few
}

TEST(Autonomy, depends_on_the_tester_s_channel_more_than_on_the_cell) {
  std::map<int, std::vector<double>> by_channel;
  for (const Cell& cell : hg2())
    if (cell.series == "fleet_first_run" && (cell.channel == 7 || cell.channel == 8))
      by_channel[cell.channel].push_back(cell.seconds);
  const auto channels = statistics::one_factor({by_channel[7], by_channel[8]});
  EXPECT_NEAR(channels->f, 404.0, 2.0);
  EXPECT_LT(channels->p, 5e-5);
  const auto difference = statistics::compare(by_channel[7], by_channel[8]);
  EXPECT_NEAR(difference->difference, 55.0, 0.1);

  // The analysis finds it without a hint, among all nine: channels with a single cell carry no information.
  std::vector<BatteryRun> records = fleet();
  std::size_t i = 0;
  for (const Cell& cell : hg2()) {
    if (cell.series != "fleet_first_run") continue;
    records[i].vehicle = static_cast<std::size_t>(cell.channel);
    records[i++].carrier = "channel " + std::to_string(cell.channel);
  }
  const AutonomyMetrics metrics = analyse(records, 9);
  ASSERT_TRUE(metrics.vehicles);
  ASSERT_EQ(metrics.vehicles->groups.size(), 2U);
  EXPECT_EQ(metrics.vehicles->groups[0].vehicle, "channel 7");
  EXPECT_NEAR(metrics.vehicles->groups[0].sd_s, 3.5, 0.05);
  EXPECT_NEAR(metrics.vehicles->groups[1].sd_s, 3.2, 0.1);
  EXPECT_NEAR(metrics.vehicles->variance.f, channels->f, 1e-9);
  EXPECT_THAT(to_text(metrics, records), HasSubstr("channel 8: 3650.2 s, SD 3.2 s of 3; F 40"));
  EXPECT_FALSE(analyse(fleet(), 9).vehicles);  // nine vehicles, one battery each
}

TEST(Autonomy, does_not_count_a_vehicle_s_failure_as_a_battery_s_end) {
  std::vector<BatteryRun> records = fleet();
  records[5].stop = StopCause::fault;
  records[5].autonomy_s = 2000.0;
  records[7].stop = StopCause::lost;  // cell 9: there is no cell 8
  records[7].autonomy_s = 3000.0;
  const AutonomyMetrics metrics = analyse(records, 9);
  EXPECT_EQ(metrics.failed, 2U);
  EXPECT_THAT(metrics.method, HasSubstr("censored"));
  double counted = 0.0;
  for (const BatteryRun& record : records) counted += record.autonomy_s / 9.0;
  EXPECT_NEAR(counted, 3357.0, 0.5);
  EXPECT_NEAR(metrics.mean_if_counted_s, counted, 1e-9);
  EXPECT_THAT(to_text(metrics, records), HasSubstr("failures would make the mean 3356.8 s (-6.8 %)"));
  EXPECT_NEAR(metrics.mean_s, 3602.0, 1.0);
  EXPECT_TRUE(std::isnan(metrics.each[5].autonomy_s));
  EXPECT_EQ(metrics.each[5].lasted_at_least_s, 2000.0);
}

TEST(Autonomy, of_repeated_runs_reports_the_loss_per_run) {
  std::vector<BatteryRun> records;
  for (const Cell& cell : hg2()) {
    if (cell.series != "same_cell_repeat") continue;
    records.push_back(
        record_of(static_cast<std::size_t>(cell.number) - 1, static_cast<std::size_t>(cell.run) - 1, cell.seconds));
  }
  const AutonomyMetrics metrics = analyse(records, 5);
  ASSERT_TRUE(metrics.trend);
  EXPECT_NEAR(metrics.trend->slope, -10.2, 0.4);
  EXPECT_LT(metrics.trend->p, 1e-6);
  ASSERT_TRUE(metrics.crossed);
  EXPECT_TRUE(metrics.crossed->confounded);  // each stayed on its tester channel
  const AutonomyMetrics one = analyse(std::span{records}.first(4), 1);
  EXPECT_NEAR(one.trend->slope, -9.84, 0.02);
  EXPECT_NEAR(one.trend->at_first, 3602.5, 0.5);
  EXPECT_FALSE(one.mean_t);  // one battery allows no statement about others
  EXPECT_FALSE(one.tolerance_low_s || one.next);
  // About itself it does: 3602.1, 3593.27, 3582.87, 3572.76 s have an SD of 12.7 s, and 3.182 · 12.7/√4 = 20.2 s.
  EXPECT_NEAR(one.runs_sd_s, 12.7136, 0.0001);
  EXPECT_NEAR(one.runs_t->high - one.runs_t->low, 2.0 * 3.1824 * one.runs_sd_s / 2.0, 0.01);
  const auto alone = JsonValue::parse(to_json(one, std::span{records}.first(4), {}));
  EXPECT_EQ(alone->find("autonomy_s")->text("of"), "runs of one battery");
  EXPECT_EQ(alone->find("autonomy_s")->number("sd"), one.runs_sd_s);
  for (const BatteryMetrics& own : metrics.each) {
    EXPECT_NEAR(own.trend->slope, -10.3, 0.75);
    EXPECT_GT(own.trend->r_squared, 0.996);
  }
  // One record for each battery, whatever the number of its runs.
  const auto json = JsonValue::parse(to_json(metrics, records, {}));
  ASSERT_TRUE(json);
  ASSERT_EQ(json->find("batteries")->array()->size(), 5U);
  EXPECT_EQ(json->find("records")->array()->size(), 20U);
  const JsonValue& first = json->find("batteries")->array()->front();
  EXPECT_EQ(json->find("autonomy_s")->text("of"), "batteries");
  EXPECT_EQ(first.number("runs"), 4.0);
  EXPECT_NEAR(*first.number("autonomy_s"), 3587.75, 0.01);
  EXPECT_NEAR(*first.find("slope_per_run")->number("slope_s"), -9.84, 0.02);
}

TEST(Autonomy, of_no_runs_or_of_failures_alone_makes_no_claim) {
  const AutonomyMetrics none = analyse({}, 3);
  EXPECT_TRUE(std::isnan(none.mean_s));
  EXPECT_FALSE(none.mean_t || none.tolerance_low_s || none.next || none.censored || none.crossed);
  const std::vector<BatteryRun> failed{record_of(0, 0, 100.0, StopCause::fault),
                                       record_of(1, 0, 50.0, StopCause::lost)};
  const AutonomyMetrics lost = analyse(failed, 2);
  EXPECT_EQ(lost.failed, 2U);
  EXPECT_FALSE(lost.mean_t || lost.censored);
  EXPECT_TRUE(lost.survival.steps.empty());
  EXPECT_THAT(to_json(lost, failed, {}), HasSubstr("\"mean\":null"));
}

TEST(Autonomy, is_written_with_the_documented_keys) {
  const std::vector<BatteryRun> records = fleet();
  const AutonomyMetrics metrics = analyse(records, 9);
  const auto json = JsonValue::parse(to_json(metrics, records, {}));
  ASSERT_TRUE(json);
  const JsonValue* autonomy = json->find("autonomy_s");
  ASSERT_NE(autonomy, nullptr);
  EXPECT_NEAR(*autonomy->number("mean"), 3605.46, 0.01);
  EXPECT_NEAR(*autonomy->number("sd"), 49.69, 0.01);
  EXPECT_EQ(autonomy->find("ci95")->array()->size(), 2U);
  ASSERT_EQ(json->find("batteries")->array()->size(), 9U);
  EXPECT_EQ(json->find("batteries")->array()->front().text("id"), "HG2-1");
  EXPECT_EQ(json->find("batteries")->array()->front().text("stop"), "floor");
  EXPECT_THAT(to_text(metrics, records), HasSubstr("HG2-1 is an outlier (Grubbs), kept"));
}

TEST(Autonomy, s_report_is_one_self_contained_page_that_escapes_its_input) {
  std::vector<BatteryRun> records = fleet();
  records[0].tag.id = "<script>";
  for (int i = 0; i < 10; ++i)
    records[0].curve.push_back(
        {virtual_epoch + from_seconds(300.0 * i), 1.0 - 0.1 * i, 0.01, 4.0, 3.0, 25.0, 10.0 * i});
  const std::string html =
      report_html(analyse(records, 9), records, {}, {"HG2", "metadata", "cite", "cosiva battery", "3 A", 0.2});
  EXPECT_THAT(html, HasSubstr("1 h 00 min 05 s"));
  EXPECT_THAT(html, HasSubstr("Kaplan and Meier"));
  for (const char* phrase :
       {"Voltage, as measured on board, over time.", "Voltage, as measured on board, over the distance driven.",
        "Charge, as estimated by the gauges, over the charge taken out.", "Temperature, over time."})
    EXPECT_THAT(html, HasSubstr(phrase));
  EXPECT_THAT(html, Not(HasSubstr("<script>")));
  EXPECT_THAT(html, Not(HasSubstr("src=\"http")));
  const std::string csv = to_csv(records);
  EXPECT_THAT(csv, StartsWith("battery_id,run,vehicle,test_time_second,voltage_volt,current_ampere"));
  EXPECT_THAT(csv, HasSubstr("<script>,1,AIV1,300.0,4.0000,-3.0000,25.00,90.000,10.00"));
}

TEST(Duration, is_printed_in_hours_minutes_and_seconds) {
  EXPECT_EQ(duration_text(42.4), "42 s");
  EXPECT_EQ(duration_text(3599.6), "1 h 00 min 00 s");
  EXPECT_EQ(duration_text(125.0), "2 min 05 s");
  EXPECT_EQ(duration_text(std::nan("")), "unknown");
}

}  // namespace
}  // namespace cosiva::experiments
