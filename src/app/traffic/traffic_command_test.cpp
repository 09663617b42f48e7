#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::app {
namespace {

using fixture::cosiva;
using ::testing::HasSubstr;

TEST(TrafficCommand, carries_jobs_on_a_ready_zone_and_prints_the_metrics) {
  const auto output =
      cosiva({"traffic", "--zone", "indus8", "--aivs", "4", "--duration", "600", "--jobs-per-hour", "60"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.data, HasSubstr("indus8: 4 AIVs, 10 min"));
  EXPECT_THAT(output.data, HasSubstr("0 collisions"));
}

TEST(TrafficCommand, gives_equal_metrics_for_equal_seeds) {
  const auto once = [](const std::string& seed) {
    return cosiva({"traffic", "--zone", "indus8", "--duration", "300", "--aivs", "4", "--jobs-per-hour", "200",
                   "--json", "--seed", seed})
        .data;
  };
  const std::string one = once("1");
  EXPECT_TRUE(JsonValue::parse(one, 1U << 20U));
  EXPECT_EQ(one, once("1"));
  EXPECT_NE(one, once("2"));
}

TEST(TrafficCommand, carries_jobs_in_a_layout_with_stations_in_dead_ends) {
  const auto output = cosiva({"traffic", "--zone", "workshop", "--aivs", "6", "--jobs-per-hour", "60", "--json"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data, 1U << 20U);
  ASSERT_TRUE(json);
  EXPECT_GT(json->find("jobs")->number("done").value_or(0.0), 40.0);
  EXPECT_EQ(json->number("collisions"), 0.0);
  EXPECT_EQ(json->number("near_misses"), 0.0);
  EXPECT_EQ(json->number("stuck"), 0.0);
}

TEST(TrafficCommand, counts_near_misses_where_a_zone_leaves_no_clearance) {
  const adapters::testing::Scratch directory;
  const std::string file = directory / "tight.toml";
  ASSERT_EQ(cosiva({"zone", "convert", "workshop", file}).status, 0);
  std::string text = *adapters::read_file(file);
  const std::string clearance = "clearance_m = 0.04";
  ASSERT_NE(text.find(clearance), std::string::npos);
  text.replace(text.find(clearance), clearance.size(), "clearance_m = 0.0");
  ASSERT_TRUE(adapters::write_file(file, text));
  const auto output = cosiva({"traffic", "--zone", file, "--aivs", "12", "--jobs-per-hour", "120", "--json"});
  const auto json = JsonValue::parse(output.data, 1U << 20U);
  ASSERT_TRUE(json) << output.standard_error;
  EXPECT_GT(json->number("near_misses").value_or(0.0), 10.0);
  EXPECT_LT(json->number("smallest_gap_m").value_or(1.0), 0.06);
}

TEST(TrafficCommand, names_the_section_where_a_fleet_has_no_position_to_stop) {
  const std::string lane = source_dir() + "/src/virtual/fleet/testdata/two_way_lane.toml";
  const auto output = cosiva({"traffic", "--zone", lane, "--aivs", "1"});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr("zone 'lane', section 'there': too many crossings close together"));
}

TEST(TrafficCommand, writes_a_report) {
  const adapters::testing::Scratch directory;
  const std::string out = directory / "out/deeper";
  const auto output = cosiva({"traffic", "--duration", "120", "--aivs", "8", "--out", out});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  for (const char* file : {"/report.html", "/result.json", "/jobs.csv"})
    EXPECT_GT(std::filesystem::file_size(out + file), 50U) << file;
}

TEST(TrafficCommand, reports_what_is_wrong_and_where) {
  const adapters::testing::Scratch directory;
  const std::string jobs = directory.write("jobs.csv", "time_s,from,to\n5,shelf_a,moon\n");
  const auto bad_file = cosiva({"traffic", "--zone", "indus8", "--jobs", jobs});
  EXPECT_EQ(bad_file.status, 2);
  EXPECT_THAT(bad_file.standard_error, HasSubstr(jobs + ":2: zone 'indus8' has no station 'moon'"));
  const auto no_rate = cosiva({"traffic", "--jobs-per-hour", "-1"});
  EXPECT_EQ(no_rate.status, 2);
  EXPECT_THAT(no_rate.standard_error, HasSubstr("jobs per hour must be more than 0"));
  EXPECT_EQ(cosiva({"traffic", "--aivs", "0"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--aivs", "100000"}).status, 2) << "no room";
  EXPECT_EQ(cosiva({"traffic", "--rules", "/nowhere.fll"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--jobs", "/nowhere.csv"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--jobs", jobs, "--jobs-per-hour", "3"}).status, 2);
}

}  // namespace
}  // namespace cosiva::app
