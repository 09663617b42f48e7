#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "adapters/files.h"
#include "adapters/test_bench.h"
#include "app/command_line_bench.h"
#include "app/external_algorithm.h"
#include "base/json_value.h"
#include "base/test_places.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using bench::cosiva;
using bench::Said;
using ::testing::HasSubstr;

const std::string source = source_dir();

JsonValue json_of(const Said& said) {
  auto json = JsonValue::parse(said.data);
  EXPECT_TRUE(json) << said.data << said.words;
  return json ? std::move(*json) : JsonValue{};
}

const JsonValue& algorithm(const JsonValue& json, std::size_t index) {
  return (*json.find("algorithms")->array())[index];
}

TEST(Qualify, in_virtual_time_gives_the_figures_and_the_limit) {
  const Said said = cosiva({"qualify", "arc_kalman", "--runs", "8", "--way", "40", "--json"});
  EXPECT_EQ(said.status, 0) << said.words;
  const JsonValue json = json_of(said);
  EXPECT_EQ(algorithm(json, 0).text("name"), "arc_kalman");
  // Beacons every half metre, 1 cm each: 8.7 mm along and 2 mm across the line.
  EXPECT_NEAR(*algorithm(json, 0).number("limit_m"), 0.0089, 3e-4);
  EXPECT_NEAR(*algorithm(json, 0).number("rmse_m"), 0.0089, 1e-3);
  EXPECT_EQ(cosiva({"qualify", "arc_kalman", "--runs", "8", "--way", "40", "--json"}).data, said.data);
}

TEST(Qualify, lists_what_there_is) {
  const Said said = cosiva({"qualify", "--list"});
  EXPECT_EQ(said.status, 0);
  for (const char* name : {"dead_reckoning", "reset_rule", "arc_kalman", "arc_kalman_scale", "ekf", "ukf", "iekf",
                           "particles", "arc_smoother", "ufir"})
    EXPECT_THAT(said.data, HasSubstr(name));
}

TEST(Compare, shows_that_the_filter_is_better_than_the_article_s_rule) {
  const JsonValue json =
      json_of(cosiva({"compare", "reset_rule", "arc_kalman", "--runs", "12", "--way", "40", "--json"}));
  const JsonValue& comparison = json.find("comparisons")->array()->front();
  EXPECT_EQ(comparison.text("verdict"), "different");
  EXPECT_LT(*comparison.number("rmse_difference_m"), 0.0);
}

TEST(Compare, on_a_recording_reads_it_and_writes_its_report) {
  const Scratch scratch;
  const std::string out = scratch / "out";
  const std::string recorded = source + "/src/experiments/recording/plaza1";
  // A name after the folder is an algorithm's, and no second folder.
  const Said said =
      cosiva({"compare", "dead_reckoning", "--recording", recorded, "calibrating", "--out", out, "--json"});
  EXPECT_EQ(said.status, 0) << said.words;
  const JsonValue json = json_of(said);
  EXPECT_LT(*algorithm(json, 1).number("rmse_m"), 0.45);
  EXPECT_FALSE(algorithm(json, 1).find("rmse_interval_m")->is_null());
  for (const char* file : {"report.html", "result.json", "runs.csv", "truth.tum", "calibrating.tum", "calibrating.zip"})
    EXPECT_TRUE(std::filesystem::exists(out + "/" + file)) << file;
  // What was written can be judged again, and comes to the same figure.
  const JsonValue again =
      json_of(cosiva({"compare", "--reference", out + "/truth.tum", "--estimate", out + "/calibrating.tum", "--json"}));
  EXPECT_NEAR(*algorithm(again, 0).number("rmse_m"), *algorithm(json, 1).number("rmse_m"), 1e-12);
}

TEST(Compare, takes_the_python_example_as_one_of_many) {
  const Said said = cosiva({"compare", "arc_kalman", "reset_rule", "--runs", "3", "--way", "10", "--external",
                            "mine=python3 " + source + "/examples/estimator.py", "--json"});
  EXPECT_EQ(said.status, 0) << said.words;
  const JsonValue json = json_of(said);
  EXPECT_EQ(algorithm(json, 2).text("name"), "mine");
  EXPECT_LT(*algorithm(json, 2).number("rmse_m"), 0.03);
  EXPECT_EQ(json.find("comparisons")->array()->size(), 3U);
}

TEST(Compare, keeps_the_others_when_a_program_hangs_ends_or_talks_nonsense) {
  const Said said =
      cosiva({"compare", "arc_kalman", "--runs", "2", "--way", "5", "--patience", "0.3", "--external", "hangs=sleep 60",
              "--external", "ends=exit 4", "--external", "nonsense=while read -r line; do echo hello; done", "--json"});
  EXPECT_EQ(said.status, 1);
  const JsonValue json = json_of(said);
  EXPECT_TRUE(algorithm(json, 0).number("rmse_m"));
  EXPECT_EQ(algorithm(json, 1).find("failed")->text("code"), "process.silent");
  EXPECT_EQ(algorithm(json, 2).find("failed")->text("code"), "process.gone");
  EXPECT_EQ(algorithm(json, 3).find("failed")->text("code"), "algorithm.garbage");
  EXPECT_THAT(said.words, HasSubstr("hangs failed: hangs: it gave no answer for 300 ms (in run 1)"));
  EXPECT_THAT(said.words, HasSubstr("exit status 4"));
  EXPECT_THAT(said.words, HasSubstr("that is no JSON: 'hello'"));
}

TEST(Compare, refuses_bad_input_with_its_place) {
  const Scratch scratch;
  const auto words = [](const std::vector<std::string>& arguments) {
    const Said said = cosiva(arguments);
    EXPECT_EQ(said.status, 2) << said.words;
    return said.words;
  };
  EXPECT_THAT(words({"qualify", "kalmann"}), HasSubstr("there is no such algorithm"));
  EXPECT_THAT(words({"compare", "ekf"}), HasSubstr("at least two"));
  EXPECT_THAT(words({"compare", "ekf", "ekf"}), HasSubstr("named twice"));
  EXPECT_THAT(words({"qualify", "ekf", "--recording", scratch / "nowhere"}), HasSubstr("cannot read the folder"));
  EXPECT_THAT(words({"qualify", "--external", "mine"}), HasSubstr("NAME=COMMAND"));
  EXPECT_THAT(words({"qualify", "--way", "0"}), HasSubstr("longer than nothing"));
  EXPECT_THAT(words({"qualify", "--zone", "nowhere"}), HasSubstr("nowhere"));
  const std::string bad = scratch / "bad.tum";
  EXPECT_TRUE(adapters::write_file(bad, "0 0 0 0 0 0 0 1\nnan 0 0 0 0 0 0 1\n"));
  EXPECT_THAT(words({"compare", "--reference", bad, "--estimate", bad}), HasSubstr("bad.tum:2"));
  EXPECT_THAT(words({"compare", "--estimate", bad}), HasSubstr("--reference"));
  EXPECT_THAT(words({"compare", "--reference", scratch / "mine.tum", "--estimate", scratch / "groundtruth.tum"}),
              HasSubstr("seem to be swapped"));
}

TEST(ExternalEstimate, is_a_pose_and_where_it_states_one_a_covariance) {
  const auto plain = read_estimate(R"({"x_m":1,"y_m":2,"heading_rad":7})");
  ASSERT_TRUE(plain);
  EXPECT_NEAR(plain->pose.heading_rad, 7.0 - 2.0 * pi, 1e-12);
  EXPECT_TRUE(std::isnan(plain->covariance(0, 0)));
  EXPECT_EQ(read_estimate(R"({"x_m":1,"y_m":2,"heading_rad":0,"covariance":[1,2,3,4,5,6,7,8,9]})")->covariance(1, 2),
            6.0);
  for (const char* line :
       {"", "nonsense", "[]", R"({"x_m":1})", R"({"x_m":"1","y_m":2,"heading_rad":0})",
        R"({"x_m":1e300,"y_m":2,"heading_rad":0})", R"({"x_m":1,"y_m":2,"heading_rad":0,"covariance":[1]})"}) {
    const auto refused = read_estimate(line);
    ASSERT_FALSE(refused) << line;
    EXPECT_EQ(refused.error().code, "algorithm.garbage") << line;
  }
}

}  // namespace
}  // namespace cosiva::app
