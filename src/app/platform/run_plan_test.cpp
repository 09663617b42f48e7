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

std::vector<std::string> units_of(const UpArguments& arguments) {
  const auto plan = plan_run(arguments);
  EXPECT_TRUE(plan) << to_string(plan.error());
  std::vector<std::string> units;
  for (const experiments::WorldUnit& unit : plan->units) units.push_back(unit.crossing + (unit.off ? " off" : ""));
  return units;
}

TEST(RunPlan, has_a_unit_at_each_crossing_or_at_the_named_ones) {
  UpArguments arguments;
  arguments.zone = lacet4;
  EXPECT_THAT(units_of(arguments), ::testing::IsEmpty());
  arguments.crossing_units = {"X3", "X1"};
  EXPECT_THAT(units_of(arguments), ::testing::ElementsAre("X3", "X1"));
  arguments.crossing_units = {"all"};
  EXPECT_THAT(units_of(arguments), ::testing::ElementsAre("X1", "X2", "X3", "X4"));
  arguments.v2x = false;
  EXPECT_EQ(plan_run(arguments).error().code, "up.v2x") << "they would receive nothing";
  arguments.v2x = true;
  arguments.crossing_units = {"X9"};
  const auto unknown = plan_run(arguments);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, "up.crossing_units");
  EXPECT_THAT(unknown.error().message, HasSubstr("X1, X2, X3, X4"));
}

TEST(RunPlan, has_the_units_of_the_scenario_and_those_that_it_adds_switched_off) {
  Scratch scratch;
  const std::string file = day(scratch,
                               "crossing_units = [\"X1\"]\n[[at]]\nt_s = 1\n"
                               "unit = { crossing = \"X1\", on = false }\n[[at]]\nt_s = 2\n"
                               "unit = { crossing = \"X2\", on = true }\n");
  UpArguments arguments = with_scenario(file);
  EXPECT_THAT(units_of(arguments), ::testing::ElementsAre("X1", "X2 off"));
  arguments.crossing_units = {"X4"};
  arguments.given.crossing_units = true;
  EXPECT_THAT(units_of(arguments), ::testing::ElementsAre("X4", "X1 off", "X2 off"));
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
