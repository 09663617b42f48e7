#include "cosiva/app/platform/run_plan.h"

#include <gmock/gmock.h>

#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string lacet4 = source_dir() + "/zones/lacet4.toml";

UpArguments with_scenario(const std::string& file) {
  UpArguments arguments;
  arguments.scenario = file;
  return arguments;
}

std::string day(const Scratch& scratch, const std::string& more = {}) {
  return scratch.write("day.toml", "name = \"day\"\nzone = \"" + lacet4 + "\"\naivs = 3\nseed = 8\n" + more);
}

TEST(RunPlan, without_a_scenario_follows_the_command_line) {
  UpArguments arguments;
  arguments.zone = lacet4;
  arguments.aivs = 2;
  const auto plan = plan_run(arguments);
  ASSERT_TRUE(plan) << to_string(plan.error());
  EXPECT_FALSE(plan->scenario);
  EXPECT_EQ(plan->arguments.aivs, 2U);
  EXPECT_THAT(plan->name, StartsWith("lacet4, "));
  EXPECT_EQ(plan->zone_file, lacet4) << "a zone given as a file may be saved into it";
}

TEST(RunPlan, takes_missing_options_from_the_scenario) {
  Scratch scratch;
  UpArguments arguments = with_scenario(day(scratch, "duration_s = 30\n"));
  arguments.name = "Thursday";
  const auto plan = plan_run(arguments);
  ASSERT_TRUE(plan) << to_string(plan.error());
  EXPECT_EQ(plan->arguments.aivs, 3U);
  EXPECT_EQ(plan->arguments.seed, 8U);
  EXPECT_EQ(plan->arguments.duration_s, 30.0);
  EXPECT_EQ(plan->name, "Thursday");
  EXPECT_EQ(plan->scenario->name, "day");
}

TEST(RunPlan, prefers_the_command_line_to_the_scenario) {
  Scratch scratch;
  UpArguments arguments = with_scenario(day(scratch, "duration_s = 30\n[[at]]\nt_s = 20\nremove = \"*\"\n"));
  arguments.aivs = 5;
  arguments.seed = 9;
  arguments.duration_s = 10.0;
  arguments.given = {false, true, true, true};
  ::testing::internal::CaptureStderr();
  const auto plan = plan_run(arguments);
  const std::string standard_error = ::testing::internal::GetCapturedStderr();
  ASSERT_TRUE(plan) << to_string(plan.error()) << ": a shortened run is valid";
  EXPECT_EQ(plan->arguments.aivs, 5U);
  EXPECT_EQ(plan->arguments.seed, 9U);
  EXPECT_EQ(plan->arguments.duration_s, 10.0);
  EXPECT_THAT(standard_error, HasSubstr("--aivs 5 overrides the scenario's 3"));
  EXPECT_THAT(standard_error, HasSubstr("--seed 9 overrides the scenario's 8"));
}

TEST(RunPlan, with_fewer_AIVs_than_the_scenario_names_is_refused) {
  Scratch scratch;
  UpArguments arguments = with_scenario(day(scratch, "[[at]]\nt_s = 1\ncommand = \"stop\"\nvehicle = \"AIV3\"\n"));
  EXPECT_TRUE(plan_run(arguments));
  arguments.aivs = 2;
  arguments.given.aivs = true;
  ::testing::internal::CaptureStderr();
  const auto plan = plan_run(arguments);
  ::testing::internal::GetCapturedStderr();
  ASSERT_FALSE(plan);
  EXPECT_THAT(plan.error().message, HasSubstr("this scenario has AIV1 to AIV2"));
}

TEST(RunPlan, with_a_missing_or_invalid_zone_or_scenario_is_refused) {
  Scratch scratch;
  EXPECT_EQ(plan_run(with_scenario("/nonexistent/day.toml")).error().code, "scenario.missing");
  EXPECT_EQ(plan_run(with_scenario(scratch.write("bad.toml", "nam = 1\n"))).error().code, "scenario.unknown_key");
  EXPECT_EQ(plan_run(with_scenario(scratch.write("gone.toml", "name = 'x'\nzone = 'gone/z.toml'\n"))).error().code,
            "zone.missing");
}

}  // namespace
}  // namespace cosiva::app
