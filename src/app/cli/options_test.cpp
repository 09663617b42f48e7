#include "cosiva/app/cli/options.h"

#include <gmock/gmock.h>

#include <cstdio>

#include "cosiva/app/cli/console.h"

namespace cosiva::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Optional;

/// A command line with every type of value, and what it prints.
class Options : public ::testing::Test {
 protected:
  Options() {
    line.version("tool 1.2");
    root.at_most_one_subcommand();
    root.footer("Exit status: 0");
  }

  std::optional<int> parse(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv{"tool"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const std::optional<int> status = line.parse(static_cast<int>(argv.size()), argv.data());
    std::fflush(nullptr);
    data = ::testing::internal::GetCapturedStdout();
    errors = ::testing::internal::GetCapturedStderr();
    return status;
  }

  CommandLine line{"Measures something", "tool"};
  Command root{line.root()};
  std::string data;    ///< what parsing printed on standard output
  std::string errors;  ///< … and on standard error
};

TEST_F(Options, set_variables_of_every_type) {
  std::string text;
  double length{};
  int offset{};
  std::int64_t time{};
  std::uint16_t port{};
  std::uint32_t count{};
  std::uint64_t seed{};
  bool on{};
  std::optional<double> speed;
  std::optional<std::uint32_t> camera;
  std::optional<std::uint64_t> sections;
  root.add_option("--text", text);
  root.add_option("--length", length);
  root.add_option("--offset", offset);
  root.add_option("--time", time);
  root.add_option("--port", port);
  root.add_option("--count", count);
  root.add_option("--seed", seed);
  root.add_flag("--on", on);
  root.add_option("--speed", speed);
  root.add_option("--camera", camera);
  root.add_option("--sections", sections);
  EXPECT_EQ(parse({"--text",      "a b",     "--length", "1e-3",     "--offset",   "-7",         "--time",
                   "-5000000000", "--port",  "65535",    "--count",  "4294967295", "--seed",     "18446744073709551615",
                   "--on",        "--speed", "0.5",      "--camera", "0",          "--sections", "1000"}),
            std::nullopt)
      << errors;
  EXPECT_EQ(text, "a b");
  EXPECT_EQ(length, 0.001);
  EXPECT_EQ(offset, -7);
  EXPECT_EQ(time, -5'000'000'000);
  EXPECT_EQ(port, 65'535);
  EXPECT_EQ(count, 4'294'967'295U);
  EXPECT_EQ(seed, 18'446'744'073'709'551'615U);
  EXPECT_TRUE(on);
  EXPECT_THAT(speed, Optional(0.5));
  EXPECT_THAT(camera, Optional(0U));
  EXPECT_THAT(sections, Optional(1000U));
}

TEST_F(Options, not_given_leave_their_variables_as_they_were) {
  std::string text{"default"};
  std::optional<double> speed;
  bool on{true};
  root.add_option("--text", text);
  root.add_option("--speed", speed);
  root.add_switch("--v2x", on, "sends messages");
  EXPECT_EQ(parse({}), std::nullopt);
  EXPECT_EQ(text, "default");
  EXPECT_EQ(speed, std::nullopt);
  EXPECT_TRUE(on);
  EXPECT_FALSE(root.given("--text"));
}

TEST_F(Options, with_lists_take_values_as_declared) {
  std::vector<std::string> files;
  std::vector<double> foot;
  std::vector<int> numbers;
  std::vector<std::uint32_t> counts;
  std::vector<std::uint64_t> sizes;
  std::vector<std::string> estimates;
  root.add_option("files", files);
  root.add_option("--foot", foot).separator(',').value_count(2);
  root.add_option("--numbers", numbers).separator(',');
  root.add_option("--counts", counts);
  root.add_option("--sizes", sizes);
  root.add_option("--estimate", estimates).one_value_each();
  EXPECT_EQ(parse({"--estimate", "a", "one", "--estimate", "b", "two", "--foot", "0.5,1", "--numbers", "3,-4",
                   "--counts", "1", "2", "--sizes", "5"}),
            std::nullopt)
      << errors;
  EXPECT_THAT(files, ElementsAre("one", "two"));
  EXPECT_THAT(foot, ElementsAre(0.5, 1.0));
  EXPECT_THAT(numbers, ElementsAre(3, -4));
  EXPECT_THAT(counts, ElementsAre(1U, 2U));
  EXPECT_THAT(sizes, ElementsAre(5U));
  EXPECT_THAT(estimates, ElementsAre("a", "b"));
  EXPECT_EQ(parse({"--foot", "0.5,1,2"}), exit_bad_input);
}

TEST_F(Options, refuse_values_outside_their_range_and_name_it) {
  double ratio{};
  std::uint32_t count{};
  std::string word;
  root.add_option("--ratio", ratio).in_range(0.0, 1.0);
  root.add_option("--count", count).in_range(1, 200);
  root.add_option("--word", word).one_of({"svg", "png"});
  EXPECT_EQ(parse({"--ratio", "1", "--count", "200", "--word", "png"}), std::nullopt);
  EXPECT_EQ(parse({"--ratio", "1.1"}), exit_bad_input);
  EXPECT_THAT(errors, HasSubstr("--ratio"));
  EXPECT_THAT(errors, HasSubstr("1.1 not in range"));
  EXPECT_EQ(parse({"--count", "201"}), exit_bad_input);
  EXPECT_THAT(errors, HasSubstr("201 not in range 1 to 200"));
  EXPECT_EQ(parse({"--count", "many"}), exit_bad_input);
  EXPECT_EQ(parse({"--word", "pdf"}), exit_bad_input);
  EXPECT_THAT(errors, HasSubstr("pdf not in {svg,png}"));
  EXPECT_THAT(data, IsEmpty());
}

TEST_F(Options, refuse_values_without_the_declared_sign) {
  double length{};
  double pause{};
  root.add_option("--length", length).positive();
  root.add_option("--pause", pause).not_negative();
  EXPECT_EQ(parse({"--length", "0.1", "--pause", "0"}), std::nullopt);
  EXPECT_EQ(parse({"--length", "0"}), exit_bad_input);
  EXPECT_EQ(parse({"--pause", "-1"}), exit_bad_input);
}

TEST_F(Options, can_be_required_and_can_exclude_or_need_each_other) {
  std::string out;
  double rate{};
  std::string file;
  bool camera{};
  root.add_option("--out", out).required();
  const Option by_rate = root.add_option("--rate", rate);
  root.add_option("--file", file).excludes(by_rate);
  root.option("--file").needs(root.add_flag("--camera", camera));
  EXPECT_EQ(parse({}), exit_bad_input);
  EXPECT_THAT(errors, HasSubstr("--out is required"));
  EXPECT_EQ(parse({"--out", "x", "--rate", "1", "--file", "y", "--camera"}), exit_bad_input);
  EXPECT_THAT(errors, HasSubstr("--rate excludes --file"));
  EXPECT_EQ(parse({"--out", "x", "--file", "y"}), exit_bad_input);
  EXPECT_THAT(errors, HasSubstr("--file requires --camera"));
  EXPECT_EQ(parse({"--out", "x", "--file", "y", "--camera"}), std::nullopt) << errors;
  EXPECT_TRUE(root.given("--file"));
  EXPECT_FALSE(root.given("--rate"));
}

TEST_F(Options, of_switches_are_on_or_off) {
  bool v2x{true};
  root.add_switch("--v2x", v2x, "sends messages");
  EXPECT_EQ(parse({"--v2x", "off"}), std::nullopt);
  EXPECT_FALSE(v2x);
  EXPECT_EQ(parse({"--v2x", "on"}), std::nullopt);
  EXPECT_TRUE(v2x);
  EXPECT_EQ(parse({"--v2x", "yes"}), exit_bad_input);
}

TEST_F(Options, are_described_by_the_help) {
  std::uint32_t aivs{4};
  bool announce{};
  bool v2x{true};
  root.add_option("--aivs", aivs, "how many vehicles").value_name("N").in_range(1, 200).show_default();
  root.add_flag("--announce", announce, "for internal use").hidden();
  root.add_switch("--v2x", v2x, "sends messages");
  EXPECT_EQ(parse({"--help"}), exit_done);
  EXPECT_THAT(data, HasSubstr("Measures something"));
  EXPECT_THAT(data, HasSubstr("--aivs N:INT in [1 - 200]=4"));
  EXPECT_THAT(data, HasSubstr("how many vehicles"));
  EXPECT_THAT(data, HasSubstr("sends messages; without: on"));
  EXPECT_THAT(data, HasSubstr("Exit status: 0"));
  EXPECT_THAT(data, Not(HasSubstr("--announce")));
  EXPECT_EQ(data, root.help());
  EXPECT_THAT(errors, IsEmpty());
}

TEST_F(Options, mistyped_are_refused_with_the_nearest_word) {
  double duration{};
  root.add_option("--duration", duration);
  const Command zone = root.add_subcommand("zone", "Zones");
  const Command check = zone.add_subcommand("check", "Checks a zone");
  EXPECT_EQ(parse({"--duraton", "3"}), exit_bad_input);
  EXPECT_EQ(errors, "tool: '--duraton' is unknown; did you mean '--duration'?\n`tool --help` lists the options\n");
  EXPECT_EQ(parse({"zone", "chekc"}), exit_bad_input);
  EXPECT_EQ(errors, "tool zone: 'chekc' is unknown; did you mean 'check'?\n`tool zone --help` lists the options\n");
  EXPECT_FALSE(check.chosen());
}

TEST_F(Options, choose_commands) {
  const Command zone = root.add_subcommand("zone", "Zones");
  zone.at_most_one_subcommand();
  const Command check = zone.add_subcommand("check", "Checks a zone");
  const Command show = zone.add_subcommand("show", "Draws a zone");
  EXPECT_EQ(parse({"zone", "show"}), std::nullopt);
  EXPECT_TRUE(zone.chosen());
  EXPECT_TRUE(show.chosen());
  EXPECT_FALSE(check.chosen());
  EXPECT_EQ(parse({"zone"}), std::nullopt);
  EXPECT_FALSE(show.chosen());
  EXPECT_EQ(parse({"zone", "show", "check"}), exit_bad_input);
}

TEST_F(Options, print_the_version) {
  EXPECT_EQ(parse({"--version"}), exit_done);
  EXPECT_EQ(data, "tool 1.2\n");
}

}  // namespace
}  // namespace cosiva::app
