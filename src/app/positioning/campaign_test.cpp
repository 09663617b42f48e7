#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cosiva/adapters/append_file.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string examples = source_dir() + "/examples/";
const std::string small =
    "runs = 3\ndistance_m = 10\n[vary]\nalgorithm = [\"arc_kalman\", \"ekf\"]\npitch_m = [0.5, 1.0, 2.0]\n";

TEST(Campaign, dry_run_prints_the_amount_of_work_and_does_nothing) {
  const Scratch scratch;
  const CommandOutput output = cosiva({"campaign", examples + "campaign.toml", "--out", scratch / "out", "--dry-run"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.data, AllOf(HasSubstr("14 environments, 3 algorithms, 20 runs each: 840 runs of 50.0 m"),
                                 HasSubstr("pitch_m: 7 values"), HasSubstr("0 finished")));
  EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
  EXPECT_EQ(cosiva({"campaign", examples + "campaign_grid.toml", "--dry-run"}).status, 0);
}

TEST(Campaign, writes_report_tables_and_database_and_repeats_the_result_at_once) {
  const Scratch scratch;
  const std::string plan = scratch.write("plan.toml", small);
  const CommandOutput output = cosiva({"campaign", plan, "--out", scratch / "out", "--json"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  for (const char* file : {"report.html", "result.json", "runs.csv", "cells.csv", "campaign.sqlite", "campaign.state"})
    EXPECT_TRUE(std::filesystem::exists(scratch / (std::string("out/") + file))) << file;
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json);
  EXPECT_EQ(json->find("cells")->array()->size(), 6U);
  EXPECT_EQ(json->text("digest")->size(), 16U);
  EXPECT_THAT(output.standard_error, HasSubstr("ms a run"));
  const CommandOutput again = cosiva({"campaign", plan, "--out", scratch / "out", "--json"});
  EXPECT_EQ(again.data, output.data);
  EXPECT_THAT(again.standard_error, AllOf(HasSubstr("3 of 3 units"), Not(HasSubstr("ms a run"))));
  EXPECT_EQ(cosiva({"campaign", plan, "--json", "--threads", "3"}).data, output.data) << "also without a folder";
  EXPECT_THAT(cosiva({"campaign", plan, "--out", scratch / "out", "--dry-run"}).data, HasSubstr("3 finished"));
}

TEST(Campaign, refuses_the_state_of_another_plan_unless_started_anew) {
  const Scratch scratch;
  const std::string plan = scratch.write("plan.toml", small);
  EXPECT_EQ(cosiva({"campaign", plan, "--out", scratch / "out"}).status, 0);
  scratch.write("plan.toml", "seed = 5\n" + small);
  const CommandOutput output = cosiva({"campaign", plan, "--out", scratch / "out"});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error,
              AllOf(HasSubstr("campaign.state:1"), HasSubstr("another plan"), HasSubstr("--anew")));
  EXPECT_EQ(cosiva({"campaign", plan, "--out", scratch / "out", "--anew"}).status, 0);
  // A tolerance changes no run: finished units stay valid.
  scratch.write("plan.toml", "tolerance_m = 0.02\nseed = 5\n" + small);
  EXPECT_THAT(cosiva({"campaign", plan, "--out", scratch / "out"}).standard_error, HasSubstr("units are finished"));
}

TEST(Campaign, names_errors_of_plan_options_and_folder) {
  const Scratch scratch;
  const std::string plan = scratch.write("plan.toml", small);
  const auto refused = [](const std::vector<std::string>& standard_error, const std::string& what) {
    const CommandOutput output = cosiva(standard_error);
    EXPECT_EQ(output.status, 2) << output.standard_error;
    EXPECT_THAT(output.standard_error, HasSubstr(what));
    EXPECT_EQ(output.data, "");
  };
  refused({"campaign"}, "plan is required");
  refused({"campaign", scratch / "none.toml"}, "none.toml: cannot read: No such file");
  refused({"campaign", plan, "--thread", "2"}, "did you mean '--threads'?");
  refused({"campaign", scratch.write("a.toml", "[vary]\npich_m = 1\n")}, "a.toml:2: vary.pich_m: unknown key");
  refused({"campaign", scratch.write("b.toml", "zone = \"lacet5\"\n[vary]\n")}, "lacet5");
  refused({"campaign", scratch.write("c.toml", "distance_m = 0.001\n[vary]\n")},
          "c.toml: the run ends before the first odometry");
  refused({"campaign", plan, "--out", "/proc/nothing"}, "/proc/nothing: the folder cannot be made");
  scratch.write("out/campaign.state", "something else\n");
  refused({"campaign", plan, "--out", scratch / "out"}, "campaign.state:1: this is no campaign's state");
  const auto busy = adapters::AppendFile::open(scratch / "busy/campaign.state");
  refused({"campaign", plan, "--out", scratch / "busy"}, "another process is writing it");
}

TEST(Campaign, finds_a_zone_file_relative_to_its_plan) {
  const Scratch scratch;
  const auto zone = adapters::read_file(fixture::zones + "lacet4.toml");
  ASSERT_TRUE(zone);
  scratch.write("mine.toml", *zone);
  const std::string plan = scratch.write("plan.toml", "zone = \"mine.toml\"\n" + small);
  EXPECT_EQ(cosiva({"campaign", plan}).status, 0);
}

}  // namespace
}  // namespace cosiva::app
