#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "adapters/test_bench.h"
#include "app/command_line_bench.h"
#include "base/json_value.h"

namespace cosiva::app {
namespace {

using bench::cosiva;
using ::testing::HasSubstr;

TEST(TrafficVerb, carries_jobs_on_a_ready_zone_and_says_what_came_of_it) {
  const auto said =
      cosiva({"traffic", "--zone", "indus8", "--aivs", "4", "--duration", "600", "--jobs-per-hour", "60"});
  EXPECT_EQ(said.status, 0) << said.words;
  EXPECT_THAT(said.data, HasSubstr("indus8: 4 AIVs, 10 min"));
  EXPECT_THAT(said.data, HasSubstr("0 collisions"));
}

TEST(TrafficVerb, gives_the_same_figures_for_the_same_seed) {
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

TEST(TrafficVerb, writes_a_report_that_can_be_looked_at) {
  const adapters::testing::Scratch directory;
  const std::string out = directory / "out/deeper";
  const auto said = cosiva({"traffic", "--duration", "120", "--aivs", "8", "--out", out});
  EXPECT_EQ(said.status, 0) << said.words;
  for (const char* file : {"/report.html", "/result.json", "/jobs.csv"})
    EXPECT_GT(std::filesystem::file_size(out + file), 50U) << file;
}

TEST(TrafficVerb, says_what_is_wrong_and_where) {
  const adapters::testing::Scratch directory;
  const std::string jobs = directory.write("jobs.csv", "time_s,from,to\n5,shelf_a,moon\n");
  const auto bad_file = cosiva({"traffic", "--zone", "indus8", "--jobs", jobs});
  EXPECT_EQ(bad_file.status, 2);
  EXPECT_THAT(bad_file.words, HasSubstr(jobs + ":2: zone 'indus8' has no station 'moon'"));
  EXPECT_EQ(cosiva({"traffic", "--jobs-per-hour", "-1"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--aivs", "0"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--aivs", "100000"}).status, 2) << "no room";
  EXPECT_EQ(cosiva({"traffic", "--rules", "/nowhere.fll"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--jobs", "/nowhere.csv"}).status, 2);
  EXPECT_EQ(cosiva({"traffic", "--jobs", jobs, "--jobs-per-hour", "3"}).status, 2);
}

}  // namespace
}  // namespace cosiva::app
