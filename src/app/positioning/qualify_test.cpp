#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/app/positioning/external_algorithm.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_places.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::cosiva;
using fixture::Said;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string source = source_dir();

JsonValue json_of(const Said& said) {
  auto json = JsonValue::parse(said.data);
  EXPECT_TRUE(json) << said.data << said.standard_error;
  return json ? std::move(*json) : JsonValue{};
}

const JsonValue& algorithm(const JsonValue& json, std::size_t index) {
  return (*json.find("algorithms")->array())[index];
}

TEST(Qualify, in_virtual_time_gives_the_figures_and_the_limit) {
  const Said said = cosiva({"qualify", "arc_kalman", "--runs", "8", "--way", "40", "--json"});
  EXPECT_EQ(said.status, 0) << said.standard_error;
  const JsonValue json = json_of(said);
  EXPECT_EQ(algorithm(json, 0).text("name"), "arc_kalman");
  // Beacons every half metre, 1 cm each: 8.7 mm along and 2 mm across the line.
  EXPECT_NEAR(*algorithm(json, 0).number("limit_m"), 0.0089, 3e-4);
  EXPECT_NEAR(*algorithm(json, 0).number("rmse_m"), 0.0089, 1e-3);
  EXPECT_EQ(cosiva({"qualify", "arc_kalman", "--runs", "8", "--way", "40", "--json"}).data, said.data);
}

TEST(QualifyStatistics, says_the_same_to_the_byte_on_any_number_of_threads) {
  const std::string recorded = source + "/src/experiments/positioning/recording/labyrinth";
  for (const std::vector<std::string>& requested :
       {std::vector<std::string>{"compare", "reset_rule", "arc_kalman", "particles", "arc_smoother", "--runs", "20"},
        std::vector<std::string>{"compare", "--recording", recorded}}) {
    std::vector<std::string> said;
    for (const char* threads : {"1", "2", "4"}) {
      std::vector<std::string> arguments = requested;
      if (arguments.size() > 3) arguments.insert(arguments.end(), {"--way", "10"});
      arguments.insert(arguments.end(), {"--json", "--threads", threads});
      const Said one = cosiva(arguments);
      EXPECT_EQ(one.status, 0) << one.standard_error;
      said.push_back(one.data);
    }
    EXPECT_EQ(said[0], said[1]);
    EXPECT_EQ(said[0], said[2]);
    EXPECT_THAT(said[0], Not(HasSubstr("--threads")));
    EXPECT_THAT(said[0], HasSubstr("\"digest\""));
  }
  EXPECT_EQ(cosiva({"qualify", "--threads", "0"}).status, 2);
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
  const std::string recorded = source + "/src/experiments/positioning/recording/plaza1";
  // A name after the folder is an algorithm's, and no second folder.
  const Said said =
      cosiva({"compare", "dead_reckoning", "--recording", recorded, "calibrating", "--out", out, "--json"});
  EXPECT_EQ(said.status, 0) << said.standard_error;
  const JsonValue json = json_of(said);
  EXPECT_LT(*algorithm(json, 1).number("rmse_m"), 0.45);
  EXPECT_FALSE(algorithm(json, 1).find("rmse_interval_m")->is_null());
  EXPECT_THAT(json.find("conditions")->text("seems late against the truth, first run (not corrected)").value_or(""),
              HasSubstr("calibrating "));
  for (const char* file :
       {"report.html", "result.json", "runs.csv", "ground_truth.tum", "calibrating.tum", "calibrating.zip"})
    EXPECT_TRUE(std::filesystem::exists(out + "/" + file)) << file;
  // What was written can be judged again, and comes to the same figure.
  const JsonValue again = json_of(
      cosiva({"compare", "--reference", out + "/ground_truth.tum", "--estimate", out + "/calibrating.tum", "--json"}));
  EXPECT_NEAR(*algorithm(again, 0).number("rmse_m"), *algorithm(json, 1).number("rmse_m"), 1e-12);
}

TEST(Qualify, says_on_the_terminal_and_in_the_report_what_it_made_of_a_recording_that_cannot_be_quite_so) {
  const Scratch scratch;
  // Straight on along x, and the truth's heading looks back.
  std::string odometry = "time_s,delta_distance_m,delta_heading_rad\n";
  std::string ground_truth = "time_s,x_m,y_m,heading_rad\n0,0,0,3.1416\n";
  for (int i = 1; i <= 200; ++i) {
    odometry += std::to_string(0.1 * i) + ",0.1,0\n";
    ground_truth += std::to_string(0.1 * i) + "," + std::to_string(0.1 * i) + ",0,3.1416\n";
  }
  std::filesystem::create_directories(scratch / "drive");
  ASSERT_TRUE(adapters::write_file(scratch / "drive/odometry.csv", odometry));
  ASSERT_TRUE(adapters::write_file(scratch / "drive/groundtruth.csv", ground_truth));
  const Said said = cosiva({"qualify", "--recording", scratch / "drive", "--out", scratch / "out", "--json"});
  EXPECT_EQ(said.status, 0) << said.standard_error;
  EXPECT_THAT(said.standard_error, HasSubstr("drive: the truth's heading is 180 degrees off the way it goes"));
  EXPECT_THAT(adapters::read_file(scratch / "out/report.html").value_or(""), HasSubstr("180 degrees off the way"));
  EXPECT_LT(*algorithm(json_of(said), 0).number("rmse_m"), 0.01);
}

TEST(Qualify, draws_ways_on_the_zone_s_lines) {
  const Scratch scratch;
  EXPECT_EQ(cosiva({"qualify", "--runs", "2", "--way", "5", "--zone", "lacet4", "--out", scratch / "out"}).status, 0);
  EXPECT_THAT(adapters::read_file(scratch / "out/report.html").value_or(""), HasSubstr("class=\"line ground\""));
}

TEST(Compare, of_trajectories_writes_a_report_and_what_evo_opens_and_keeps_one_that_is_bad_out_of_it) {
  const Scratch scratch;
  const auto tum = [](double off_m) {
    std::string text;
    for (int i = 0; i < 60; ++i) {
      const double y = 1.0 + (i % 2 == 0 ? off_m : -off_m);
      text += std::to_string(0.1 * i) + " " + std::to_string(0.05 * i) + " " + std::to_string(y) + " 0 0 0 0 1\n";
    }
    return text;
  };
  std::filesystem::create_directories(scratch / "a");
  std::filesystem::create_directories(scratch / "b");
  for (const auto& [file, text] : std::vector<std::pair<std::string, std::string>>{{"ground_truth.tum", tum(0.0)},
                                                                                   {"a/mine.tum", tum(0.02)},
                                                                                   {"b/mine.tum", tum(0.03)},
                                                                                   {"bad.tum", "1 2 3\n"}})
    ASSERT_TRUE(adapters::write_file(scratch / file, text));
  const std::string out = scratch / "out";
  const Said said = cosiva({"compare", "--reference", scratch / "ground_truth.tum", "--estimate",
                            scratch / "a/mine.tum", "--estimate", scratch / "b/mine.tum", "--estimate",
                            scratch / "bad.tum", "--out", out, "--reference-error", "0.05", "--json"});
  EXPECT_EQ(said.status, 1) << said.standard_error;  // one is bad, the others have their figures
  EXPECT_THAT(said.standard_error, HasSubstr("bad.tum:1"));
  const auto read = [&](const std::string& file) { return adapters::read_file(out + "/" + file).value_or(""); };
  // Two files of one name are told apart.
  EXPECT_EQ(algorithm(json_of(said), 1).text("name"), "mine_2");
  EXPECT_EQ(read("result.json"), said.data);
  const std::string page = read("report.html");
  for (const char* phrase : {"least rmse: mine", "mine_2 − mine", "unresolved", "bad.tum:1: here are 3 numbers",
                             "Reference and estimates from above", "Distribution of all errors", "<svg"})
    EXPECT_THAT(page, HasSubstr(phrase)) << phrase;
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  const std::string errors = read("errors.csv");
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1 + 2 * 60);
  EXPECT_THAT(errors, HasSubstr("\nmine_2,0,0.03"));
  for (const char* zip : {"mine.zip", "mine_2.zip"}) EXPECT_THAT(read(zip), HasSubstr("error_array.npy")) << zip;
  EXPECT_FALSE(std::filesystem::exists(out + "/bad.zip"));
  // What was written is judged the same.
  const JsonValue again =
      json_of(cosiva({"compare", "--reference", out + "/reference.tum", "--estimate", out + "/mine_2.tum", "--json"}));
  EXPECT_NEAR(*algorithm(again, 0).number("rmse_m"), 0.03, 1e-9);
}

TEST(Compare, of_a_reference_and_an_estimate_whose_names_say_that_they_are_swapped_is_refused) {
  const Scratch scratch;
  const std::string line = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n";
  for (const char* file : {"est.tum", "gt.tum", "latest_test.tum", "my_estimate.tum", "a.tum"})
    ASSERT_TRUE(adapters::write_file(scratch / file, line));
  const auto evaluated = [&](const char* reference, const char* estimate) {
    return cosiva({"compare", "--reference", scratch / reference, "--estimate", scratch / estimate}).status;
  };
  EXPECT_EQ(evaluated("a.tum", "gt.tum"), 2);
  EXPECT_EQ(evaluated("est.tum", "a.tum"), 2);
  EXPECT_EQ(evaluated("my_estimate.tum", "a.tum"), 2);
  EXPECT_EQ(evaluated("gt.tum", "est.tum"), 0);
  EXPECT_EQ(evaluated("a.tum", "est.tum"), 0);
  EXPECT_EQ(evaluated("latest_test.tum", "a.tum"), 0);    // "est" is no word in it
  EXPECT_EQ(evaluated("est.tum", "my_estimate.tum"), 0);  // one estimate against another
}

TEST(Compare, names_the_folder_of_a_recording_that_is_bad) {
  const Scratch scratch;
  std::filesystem::create_directories(scratch / "lap2");
  ASSERT_TRUE(
      adapters::write_file(scratch / "lap2/odometry.csv", "time_s,delta_distance_m,delta_heading_rad\nnan,1,0\n"));
  ASSERT_TRUE(adapters::write_file(scratch / "lap2/groundtruth.csv", "time_s,x_m,y_m\n0,0,0\n"));
  const Said said = cosiva({"compare", "--recording", source + "/src/experiments/positioning/recording/labyrinth",
                            "--recording", scratch / "lap2"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.standard_error, HasSubstr("lap2/odometry.csv:2: 'nan' under time_s is no finite number"));
}

TEST(Compare, aligns_when_it_is_asked_to_and_says_so) {
  const Scratch scratch;
  std::string ground_truth;
  std::string off;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.1 * i;
    const double y = 0.002 * i * i;
    ground_truth += std::to_string(i) + " " + std::to_string(x) + " " + std::to_string(y) + " 0 0 0 0 1\n";
    // A quarter turn to the left, then (5, -3).
    off += std::to_string(i) + " " + std::to_string(5.0 - y) + " " + std::to_string(x - 3.0) + " 0 0 0 0 1\n";
  }
  const std::string reference = scratch / "ground_truth.tum";
  const std::string estimate = scratch / "off.tum";
  EXPECT_TRUE(adapters::write_file(reference, ground_truth) && adapters::write_file(estimate, off));
  const auto evaluated = [&](const std::string& how) {
    return json_of(cosiva({"compare", "--reference", reference, "--estimate", estimate, "--align", how, "--json"}));
  };
  const JsonValue plain = evaluated("none");
  EXPECT_EQ(plain.text("align"), "none");
  EXPECT_GT(*algorithm(plain, 0).number("rmse_m"), 1.0);
  EXPECT_TRUE(algorithm(plain, 0).find("alignment")->is_null());
  const JsonValue se2 = evaluated("se2");
  EXPECT_EQ(se2.text("align"), "se2");
  EXPECT_LT(*algorithm(se2, 0).number("rmse_m"), 1e-6);
  EXPECT_NEAR(*algorithm(se2, 0).find("alignment")->number("turn_rad"), -0.5 * pi, 1e-6);
  EXPECT_LT(*algorithm(evaluated("se3"), 0).number("rmse_m"), 1e-6);
  EXPECT_THAT(cosiva({"compare", "--reference", reference, "--estimate", estimate, "--align", "se2"}).data,
              HasSubstr("Aligned (se2): estimates were turned about the vertical"));
  // Of a recording, whose truth here has no heading.
  const std::string recorded = source + "/src/experiments/positioning/recording/labyrinth";
  const JsonValue drive =
      json_of(cosiva({"qualify", "calibrating", "--recording", recorded, "--align", "se2", "--json"}));
  EXPECT_EQ(drive.text("align"), "se2");
  EXPECT_EQ(algorithm(drive, 0).find("alignment_by_run")->array()->size(), 1U);
  EXPECT_THAT(cosiva({"qualify", "calibrating", "--recording", recorded, "--align", "origin"}).standard_error,
              HasSubstr("the truth has no heading"));
}

TEST(Compare, refuses_an_alignment_that_means_nothing) {
  const Scratch scratch;
  const std::string line = scratch / "line.tum";
  EXPECT_TRUE(adapters::write_file(line, "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"));
  const auto refusal = [](const std::vector<std::string>& arguments) {
    const Said said = cosiva(arguments);
    EXPECT_EQ(said.status, 2) << said.standard_error;
    return said.standard_error;
  };
  EXPECT_THAT(refusal({"compare", "--align", "se2"}),
              HasSubstr("--align se2: in virtual time all are told the truth's own frame"));
  EXPECT_THAT(
      refusal({"qualify", "--recording", source + "/src/experiments/positioning/recording/plaza1", "--align", "se3"}),
      HasSubstr("a recording lies on the floor"));
  EXPECT_THAT(refusal({"compare", "--align", "sim3"}), HasSubstr("sim3"));
  EXPECT_THAT(refusal({"compare", "--reference", line, "--estimate", line, "--align", "se3"}),
              HasSubstr("too near one line"));
}

TEST(Compare, tells_the_reference_s_budget_and_calls_what_is_below_it_unresolved) {
  const Scratch scratch;
  const std::string budget = scratch / "reference_budget.json";
  const auto write_budget = [&](const std::string& metres) {
    EXPECT_TRUE(adapters::write_file(budget, R"({"format": "cosiva.reference_budget.v1", "parts": [
      {"name": "floor fit", "uncertainty_m": )" + metres +
                                                 R"(, "source": "left-out blocks"},
      {"name": "time stamp", "time_s": 0.001, "speed_mps": 0.5, "source": "gvs track --against"}]})"));
  };
  const auto compared = [&] {
    return json_of(cosiva({"compare", "reset_rule", "arc_kalman", "--runs", "12", "--way", "40", "--reference-budget",
                           budget, "--json"}));
  };
  write_budget("0.05");
  const JsonValue coarse = compared();
  EXPECT_EQ(coarse.find("comparisons")->array()->front().text("verdict"), "unresolved");
  EXPECT_NEAR(*coarse.find("reference")->number("uncertainty_m"), std::sqrt(0.05 * 0.05 + 0.0005 * 0.0005), 1e-12);
  EXPECT_EQ(coarse.find("reference")->find("parts")->array()->back().text("source"), "gvs track --against");
  write_budget("0.0001");
  EXPECT_EQ(compared().find("comparisons")->array()->front().text("verdict"), "different");
  // Of trajectories, too: two estimates a millimetre apart, judged by a truth that is good to five.
  const auto line = [&](const std::string& name, const std::string& y) {
    std::string text;
    for (int i = 0; i < 20; ++i) text += std::to_string(i) + " " + std::to_string(i) + " " + y + " 0 0 0 0 1\n";
    EXPECT_TRUE(adapters::write_file(scratch / name, text));
    return scratch / name;
  };
  const std::string ground_truth = line("ground_truth.tum", "0");
  const std::string a = line("a.tum", "0.013");
  const std::string b = line("b.tum", "0.014");
  write_budget("0.005");
  const std::vector<std::string> arguments{
      "compare", "--reference", ground_truth, "--estimate", a, "--estimate", b, "--json", "--reference-budget", budget};
  const JsonValue evaluated = json_of(cosiva(arguments));
  EXPECT_EQ(evaluated.find("comparisons")->array()->front().text("verdict"), "unresolved");
  EXPECT_EQ(evaluated.find("reference_error")->find("parts")->array()->size(), 2U);
  EXPECT_NEAR(*algorithm(evaluated, 0).number("rmse_without_reference_m"), std::sqrt(0.013 * 0.013 - 25.25e-6), 1e-9);
}

TEST(Compare, on_the_plane_draws_the_limit_beside_each_bar) {
  const Scratch scratch;
  const std::string recorded = source + "/src/experiments/positioning/recording/labyrinth";
  const Said said = cosiva({"compare", "dead_reckoning", "calibrating", "smoother", "--recording", recorded, "--out",
                            scratch / "out", "--json"});
  EXPECT_EQ(said.status, 0) << said.standard_error;
  const JsonValue json = json_of(said);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(*algorithm(json, i).number("limit_m"), 0.005);
    EXPECT_TRUE(algorithm(json, i).number("gap_percent"));
    EXPECT_EQ(algorithm(json, i).flag("limit_assumed"), true);
  }
  // Who looks back has the lower one.
  EXPECT_EQ(*algorithm(json, 0).number("limit_m"), *algorithm(json, 1).number("limit_m"));
  EXPECT_LT(*algorithm(json, 2).number("limit_m"), *algorithm(json, 1).number("limit_m"));
}

TEST(Compare, takes_the_python_example_as_one_of_many) {
  const Said said = cosiva({"compare", "arc_kalman", "reset_rule", "--runs", "3", "--way", "10", "--external",
                            "mine=python3 " + source + "/examples/estimator.py", "--json"});
  EXPECT_EQ(said.status, 0) << said.standard_error;
  const JsonValue json = json_of(said);
  EXPECT_EQ(algorithm(json, 2).text("name"), "mine");
  EXPECT_LT(*algorithm(json, 2).number("rmse_m"), 0.03);
  EXPECT_EQ(json.find("comparisons")->array()->size(), 3U);
}

TEST(Compare, keeps_the_others_when_a_program_hangs_ends_or_talks_nonsense) {
  const Said said =
      cosiva({"compare", "arc_kalman", "--runs", "2", "--way", "5", "--timeout", "0.3", "--external", "hangs=sleep 60",
              "--external", "ends=exit 4", "--external", "nonsense=while read -r line; do echo hello; done", "--json"});
  EXPECT_EQ(said.status, 1);
  const JsonValue json = json_of(said);
  EXPECT_TRUE(algorithm(json, 0).number("rmse_m"));
  EXPECT_EQ(algorithm(json, 1).find("failed")->text("code"), "process.unresponsive");
  EXPECT_EQ(algorithm(json, 2).find("failed")->text("code"), "process.gone");
  EXPECT_EQ(algorithm(json, 3).find("failed")->text("code"), "algorithm.garbage");
  EXPECT_THAT(said.standard_error, HasSubstr("hangs failed: hangs: it gave no answer for 300 ms (in run 1)"));
  EXPECT_THAT(said.standard_error, HasSubstr("exit status 4"));
  EXPECT_THAT(said.standard_error, HasSubstr("that is no JSON: 'hello'"));
}

TEST(Compare, refuses_bad_input_with_its_place) {
  const Scratch scratch;
  const auto refusal = [](const std::vector<std::string>& arguments) {
    const Said said = cosiva(arguments);
    EXPECT_EQ(said.status, 2) << said.standard_error;
    return said.standard_error;
  };
  EXPECT_THAT(refusal({"qualify", "kalmann"}), HasSubstr("there is no such algorithm"));
  EXPECT_THAT(refusal({"compare", "ekf"}), HasSubstr("at least two"));
  EXPECT_THAT(refusal({"compare", "ekf", "ekf"}), HasSubstr("named twice"));
  EXPECT_THAT(refusal({"qualify", "ekf", "--recording", scratch / "nowhere"}), HasSubstr("cannot read the folder"));
  EXPECT_THAT(refusal({"qualify", "--external", "mine"}), HasSubstr("NAME=COMMAND"));
  EXPECT_THAT(refusal({"qualify", "--way", "0"}), HasSubstr("longer than nothing"));
  EXPECT_THAT(refusal({"qualify", "--zone", "nowhere"}), HasSubstr("nowhere"));
  const std::string bad = scratch / "bad.tum";
  EXPECT_TRUE(adapters::write_file(bad, "0 0 0 0 0 0 0 1\nnan 0 0 0 0 0 0 1\n"));
  EXPECT_THAT(refusal({"compare", "--reference", bad, "--estimate", bad}), HasSubstr("bad.tum:2"));
  EXPECT_THAT(refusal({"compare", "--estimate", bad}), HasSubstr("--reference"));
  EXPECT_THAT(refusal({"compare", "--reference-budget", scratch / "no.json"}), HasSubstr("no.json"));
  EXPECT_THAT(refusal({"compare", "--reference-budget", bad}), HasSubstr("bad.tum"));
  EXPECT_THAT(refusal({"compare", "--reference-budget", bad, "--reference-error", "0.01"}),
              HasSubstr("give one of them"));
  EXPECT_THAT(
      refusal({"compare", "--reference", scratch / "mine.tum", "--estimate", scratch / "groundground_truth.tum"}),
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
