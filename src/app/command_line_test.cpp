#include <gmock/gmock.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using fixture::zones;
using ::testing::HasSubstr;

const std::string scenarios = source_dir() + "/scenarios/";

TEST(CommandLine, without_arguments_shows_its_subcommands_with_two_examples) {
  const CommandOutput output = cosiva({});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, HasSubstr("cosiva up "));
  EXPECT_THAT(output.data, HasSubstr("--virtual-time --duration 600"));
  EXPECT_THAT(output.data, HasSubstr("replay"));
}

TEST(CommandLine, help_of_each_command_goes_to_standard_output) {
  for (const char* command :
       {"up", "server", "plant", "aiv", "unit", "replay", "zone", "scenario", "agent", "qualify", "compare"}) {
    const CommandOutput output = cosiva({command, "--help"});
    EXPECT_EQ(output.status, 0) << command;
    EXPECT_THAT(output.data, HasSubstr("--help")) << command;
    EXPECT_EQ(output.standard_error, "") << command;
  }
  for (const char* command : {"up", "server", "plant", "aiv", "unit", "scenario", "agent"})
    EXPECT_THAT(cosiva({command, "--help"}).data, HasSubstr(std::string("cosiva ") + command + " ")) << "an example";
  EXPECT_THAT(cosiva({"--version"}).data, HasSubstr("cosiva 0."));
}

TEST(CommandLine, wrong_terms_end_with_2_and_the_nearest_valid_term) {
  const CommandOutput command = cosiva({"serve"});
  EXPECT_EQ(command.status, 2);
  EXPECT_THAT(command.standard_error, HasSubstr("did you mean 'server'?"));
  EXPECT_EQ(command.data, "");
  const CommandOutput option = cosiva({"up", "--duraton", "3"});
  EXPECT_EQ(option.status, 2);
  EXPECT_THAT(option.standard_error, HasSubstr("did you mean '--duration'?"));
  EXPECT_THAT(cosiva({"zone", "chekc", "x"}).standard_error, HasSubstr("did you mean 'check'?"));
}

TEST(CommandLine, values_out_of_range_or_missing_end_with_2) {
  const std::vector<std::vector<std::string>> all{{"up", "--aivs", "-3"},
                                                  {"up", "--aivs", "0"},
                                                  {"up", "--port", "70000"},
                                                  {"up", "--duration", "0"},
                                                  {"up", "--loss", "2", "--virtual-time"},
                                                  {"up", "--loss", "0.1"},
                                                  {"up", "--record", "x", "--virtual-time"},
                                                  {"up", "--broker", "nowhere:"},
                                                  {"up", "--zone", "/nonexistent.toml"},
                                                  {"up", "--aivs", "150"},
                                                  {"plant", "--sockets", "x"},
                                                  {"aiv", "--number", "1"},
                                                  {"aiv", "--number", "1", "--sockets", "x", "--start", "east"},
                                                  {"aiv", "--number", "1", "--sockets", "x", "--serial", "a/b"},
                                                  {"unit", "--zone", "lacet4"},
                                                  {"unit", "--zone", "lacet4", "--crossing", "X9"},
                                                  {"up", "--crossing-units", "X9"},
                                                  {"server", "--area", "no rth"},
                                                  {"server", "--area", "a/b"},
                                                  {"up", "--page"},
                                                  {"up", "--speed", "2"},
                                                  {"up", "--virtual-time", "--page", "--speed", "0"},
                                                  {"up", "--virtual-time", "--speed", "2"},
                                                  {"up", "--scenario", "/nonexistent.toml"},
                                                  {"scenario"},
                                                  {"scenario", "check"},
                                                  {"scenario", "check", "/nonexistent.toml"},
                                                  {"zone"},
                                                  {"replay"}};
  for (const auto& arguments : all) {
    const CommandOutput output = cosiva(arguments);
    EXPECT_EQ(output.status, 2) << arguments.front() << " " << arguments.back() << "\n" << output.standard_error;
    EXPECT_NE(output.standard_error, "");
    EXPECT_EQ(output.data, "");
  }
}

TEST(ZoneCheck, prints_the_contents_of_a_ready_zone) {
  const CommandOutput output = cosiva({"zone", "check", zones + "lacet4.toml", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto metadata = JsonValue::parse(output.data);
  ASSERT_TRUE(metadata);
  // A11: four straights of 1.5 m, four arcs of 270° with a radius of 0.6 m, 12 tags.
  EXPECT_EQ(metadata->number("sections"), 8.0);
  EXPECT_EQ(metadata->number("tags"), 12.0);
  EXPECT_NEAR(*metadata->number("length_m"), 4 * 1.5 + 4 * 1.5 * 3.14159265358979 * 0.6, 1e-9);
  // 12 tags on a loop: the longest distance without a tag is at least their mean distance.
  EXPECT_GE(*metadata->number("longest_tag_free_m"), *metadata->number("length_m") / 12.0);
  EXPECT_LT(*metadata->number("longest_tag_free_m"), 3.0);
}

TEST(ZoneCheck, names_file_and_line_of_a_bad_file) {
  Scratch scratch;
  const std::string file =
      scratch.write("bad.toml", "name = \"x\"\nformat_version = 1\n[[section]]\nkind = \"spiral\"\n");
  const CommandOutput output = cosiva({"zone", "check", file});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr(file + ":"));
}

TEST(ZoneShow, draws_into_a_file_or_to_standard_output) {
  Scratch scratch;
  EXPECT_EQ(cosiva({"zone", "show", zones + "lacet4.toml", "--svg", scratch / "z.svg"}).status, 0);
  EXPECT_THAT(adapters::read_file(scratch / "z.svg").value(), HasSubstr("<svg"));
  EXPECT_THAT(cosiva({"zone", "show", zones + "lacet4.toml"}).data, HasSubstr("</svg>"));
  EXPECT_EQ(cosiva({"zone", "show", zones + "lacet4.toml", "--svg", "/nonexistent/z.svg"}).status, 2);
}

TEST(ScenarioCheck, prints_the_timeline_as_text_and_as_json) {
  const CommandOutput people = cosiva({"scenario", "check", scenarios + "laboratory.toml"});
  ASSERT_EQ(people.status, 0) << people.standard_error;
  EXPECT_THAT(people.data, HasSubstr("laboratory: good\n"));
  EXPECT_THAT(people.data, HasSubstr("4 AIVs on lacet4, seed 3, 120 s"));
  EXPECT_THAT(people.data, HasSubstr("\n    50.0 s  AIV2 loses 30 % of its messages for 20 s\n"));
  const CommandOutput program = cosiva({"scenario", "check", scenarios + "laboratory.toml", "--json"});
  const auto json = JsonValue::parse(program.data);
  ASSERT_TRUE(json) << program.data;
  EXPECT_EQ(json->text("scenario"), "laboratory");
  EXPECT_EQ(json->number("duration_s"), 120.0);
  const auto& steps = *json->find("steps")->array();
  EXPECT_EQ(steps.size(), 10U) << "nine, and the end of the message loss";
  EXPECT_EQ(steps[0].number("t_s"), 10.0);
  EXPECT_EQ(steps[0].find("command")->text("command"), "add");
}

TEST(ScenarioCheck, names_file_line_and_field_of_a_bad_file) {
  Scratch scratch;
  const std::string file =
      scratch.write("bad.toml", "name = \"x\"\n[[at]]\nt_s = 1\ncommand = \"stpo\"\nvehicle = \"*\"\n");
  const CommandOutput output = cosiva({"scenario", "check", file});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr(file + ":4: at[1].command: "));
  EXPECT_THAT(output.standard_error, HasSubstr("did you mean \"stop\"?"));
  EXPECT_EQ(output.data, "");
}

TEST(ScenarioCheck, reports_a_scenario_that_does_not_fit_its_zone) {
  Scratch scratch;
  const std::string file =
      scratch.write("off.toml", "name = \"x\"\nzone = \"" + zones +
                                    "lacet4.toml\"\n[[at]]\nt_s = 1\ncommand = \"stop\"\nvehicle = \"AIV9\"\n");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"scenario", "check", file}, {"up", "--virtual-time", "--scenario", file}}) {
    const CommandOutput output = cosiva(arguments);
    EXPECT_EQ(output.status, 2) << arguments[0];
    EXPECT_THAT(output.standard_error, HasSubstr("off.toml:3: vehicle: there is no vehicle \"AIV9\"")) << arguments[0];
  }
}

TEST(ScenarioList, names_the_ready_scenarios) {
  const CommandOutput output = cosiva({"scenario", "list", "--json"});
  EXPECT_EQ(output.status, 0);
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json) << output.data;
  EXPECT_NE(json->find("scenarios")->array(), nullptr);
}

TEST(Replay, of_a_file_that_is_no_journal_ends_with_2_and_its_name) {
  Scratch scratch;
  const std::string file = scratch.write("not.journal", "hello");
  const CommandOutput output = cosiva({"replay", file});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr(file));
  EXPECT_EQ(cosiva({"replay", "/nonexistent"}).status, 2);
}

TEST(VirtualTime, gives_equal_digests_for_equal_seeds_only) {
  const auto run = [](const std::string& seed) {
    const CommandOutput output = cosiva({"up", "--virtual-time", "--zone", zones + "lacet4.toml", "--aivs", "2",
                                         "--duration", "10", "--seed", seed, "--loss", "0.02", "--json"});
    EXPECT_EQ(output.status, 0) << output.standard_error << output.data;
    return JsonValue::parse(output.data)->text("digest").value_or("none");
  };
  const std::string one = run("1");
  EXPECT_EQ(one.size(), 16U);
  EXPECT_EQ(run("1"), one);
  EXPECT_NE(run("2"), one);
}

TEST(VirtualTime, writes_every_message_where_requested) {
  Scratch scratch;
  cosiva({"up", "--virtual-time", "--zone", zones + "lacet4.toml", "--aivs", "1", "--duration", "2", "--trace-messages",
          scratch / "trace"});
  const std::string trace = adapters::read_file(scratch / "trace").value();
  EXPECT_THAT(trace, HasSubstr("uagv/v2/CoSiVA/AIV1/state"));
  const auto line = JsonValue::parse(trace.substr(0, trace.find('\n')));
  ASSERT_TRUE(line);
  for (const char* member : {"time", "from", "topic", "payload"}) EXPECT_NE(line->find(member), nullptr) << member;
}

/// Two AIVs for six seconds, in which one is stopped.
std::string short_scenario(const Scratch& scratch) {
  return scratch.write("short.toml",
                       "name = \"short\"\nzone = \"" + zones +
                           "lacet4.toml\"\naivs = 2\nseed = 5\nduration_s = 6\n[[at]]\nt_s = 2\ncommand = "
                           "\"stop\"\nvehicle = \"AIV1\"\n");
}

TEST(VirtualTime, plays_a_scenario_and_prints_each_step) {
  Scratch scratch;
  const CommandOutput output = cosiva({"up", "--virtual-time", "--scenario", short_scenario(scratch), "--json"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.standard_error, HasSubstr("     2.0 s  AIV1: stop\n"));
  const auto run = JsonValue::parse(output.data);
  ASSERT_TRUE(run) << output.data;
  EXPECT_EQ(run->text("scenario"), "short");
  EXPECT_EQ(run->number("aivs"), 2.0);
  EXPECT_EQ(run->number("seed"), 5.0);
  EXPECT_GE(run->number("duration_s").value_or(0.0), 6.0) << "from the moment the fleet was complete";
  EXPECT_EQ(run->find("bijection")->find("commands")->number("issued"), 1.0);
}

TEST(VirtualTime, prefers_the_command_line_to_the_scenario_and_reports_it) {
  Scratch scratch;
  const CommandOutput output = cosiva({"up", "--virtual-time", "--scenario", short_scenario(scratch), "--aivs", "1",
                                       "--seed", "5", "--duration", "1.5", "--json"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.standard_error, HasSubstr("--aivs 1 overrides the scenario's 2"));
  EXPECT_THAT(output.standard_error, HasSubstr("--duration 1.5 s overrides the scenario's 6.0 s"));
  EXPECT_THAT(output.standard_error, ::testing::Not(HasSubstr("--seed"))) << "both agree";
  EXPECT_THAT(output.standard_error, ::testing::Not(HasSubstr("AIV1: stop"))) << "the run ends before this step";
  EXPECT_EQ(JsonValue::parse(output.data)->number("aivs"), 1.0);
}

}  // namespace
}  // namespace cosiva::app
