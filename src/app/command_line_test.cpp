#include "app/command_line.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "adapters/files.h"
#include "adapters/test_bench.h"
#include "base/json_value.h"
#include "wire/core.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::HasSubstr;

struct Said {
  int status;
  std::string data;
  std::string words;
};

Said cosiva(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"cosiva"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Said said{run_command_line(static_cast<int>(argv.size()), argv.data()), {}, {}};
  std::fflush(nullptr);
  said.data = ::testing::internal::GetCapturedStdout();
  said.words = ::testing::internal::GetCapturedStderr();
  return said;
}

const std::string zones = std::string(COSIVA_SOURCE_DIR) + "/zones/";

TEST(CommandLine, bare_shows_what_there_is_with_two_examples) {
  const Said said = cosiva({});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.data, HasSubstr("cosiva up "));
  EXPECT_THAT(said.data, HasSubstr("--virtual-time --duration 600"));
  EXPECT_THAT(said.data, HasSubstr("replay"));
}

TEST(CommandLine, help_of_each_verb_goes_to_standard_output) {
  for (const char* verb : {"up", "server", "plant", "aiv", "replay", "zone"}) {
    const Said said = cosiva({verb, "--help"});
    EXPECT_EQ(said.status, 0) << verb;
    EXPECT_THAT(said.data, HasSubstr("--help")) << verb;
    EXPECT_EQ(said.words, "") << verb;
  }
  EXPECT_THAT(cosiva({"--version"}).data, HasSubstr("cosiva 0."));
}

TEST(CommandLine, wrong_words_end_with_2_and_the_nearest_right_one) {
  const Said verb = cosiva({"serve"});
  EXPECT_EQ(verb.status, 2);
  EXPECT_THAT(verb.words, HasSubstr("did you mean 'server'?"));
  EXPECT_EQ(verb.data, "");
  const Said option = cosiva({"up", "--duraton", "3"});
  EXPECT_EQ(option.status, 2);
  EXPECT_THAT(option.words, HasSubstr("did you mean '--duration'?"));
  EXPECT_THAT(cosiva({"zone", "chekc", "x"}).words, HasSubstr("did you mean 'check'?"));
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
                                                  {"zone"},
                                                  {"replay"}};
  for (const auto& arguments : all) {
    const Said said = cosiva(arguments);
    EXPECT_EQ(said.status, 2) << arguments.front() << " " << arguments.back() << "\n" << said.words;
    EXPECT_NE(said.words, "");
    EXPECT_EQ(said.data, "");
  }
}

TEST(ZoneCheck, tells_what_the_ready_zone_holds) {
  const Said said = cosiva({"zone", "check", zones + "lacet4.toml", "--json"});
  ASSERT_EQ(said.status, 0) << said.words;
  const auto facts = JsonValue::parse(said.data);
  ASSERT_TRUE(facts);
  // A11: four straights of 1.5 m, four arcs of 270° with a radius of 0.6 m, 12 tags.
  EXPECT_EQ(facts->number("sections"), 8.0);
  EXPECT_EQ(facts->number("tags"), 12.0);
  EXPECT_NEAR(*facts->number("length_m"), 4 * 1.5 + 4 * 1.5 * 3.14159265358979 * 0.6, 1e-9);
  // 12 tags on a ring: the longest way without one is at least their mean distance.
  EXPECT_GE(*facts->number("longest_tag_free_m"), *facts->number("length_m") / 12.0);
  EXPECT_LT(*facts->number("longest_tag_free_m"), 3.0);
}

TEST(ZoneCheck, of_a_bad_file_names_file_and_line) {
  Scratch scratch;
  const std::string file =
      scratch.write("bad.toml", "name = \"x\"\nformat_version = 1\n[[section]]\nkind = \"spiral\"\n");
  const Said said = cosiva({"zone", "check", file});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.words, HasSubstr(file + ":"));
}

TEST(ZoneShow, draws_into_a_file_or_to_standard_output) {
  Scratch scratch;
  EXPECT_EQ(cosiva({"zone", "show", zones + "lacet4.toml", "--svg", scratch / "z.svg"}).status, 0);
  EXPECT_THAT(adapters::read_file(scratch / "z.svg").value(), HasSubstr("<svg"));
  EXPECT_THAT(cosiva({"zone", "show", zones + "lacet4.toml"}).data, HasSubstr("</svg>"));
  EXPECT_EQ(cosiva({"zone", "show", zones + "lacet4.toml", "--svg", "/nonexistent/z.svg"}).status, 2);
}

TEST(Replay, of_what_is_no_journal_ends_with_2_and_the_file_s_name) {
  Scratch scratch;
  const std::string file = scratch.write("not.journal", "hello");
  const Said said = cosiva({"replay", file});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.words, HasSubstr(file));
  EXPECT_EQ(cosiva({"replay", "/nonexistent"}).status, 2);
}

TEST(VirtualTime, same_seed_same_digest_other_seed_another) {
  const auto run = [](const std::string& seed) {
    const Said said = cosiva({"up", "--virtual-time", "--zone", zones + "lacet4.toml", "--aivs", "2", "--duration",
                              "10", "--seed", seed, "--loss", "0.02", "--json"});
    EXPECT_EQ(said.status, 0) << said.words << said.data;
    return JsonValue::parse(said.data)->text("digest").value_or("none");
  };
  const std::string one = run("1");
  EXPECT_EQ(one.size(), 16U);
  EXPECT_EQ(run("1"), one);
  EXPECT_NE(run("2"), one);
}

TEST(VirtualTime, writes_every_message_where_asked) {
  Scratch scratch;
  cosiva({"up", "--virtual-time", "--zone", zones + "lacet4.toml", "--aivs", "1", "--duration", "2", "--trace-messages",
          scratch / "trace"});
  const std::string trace = adapters::read_file(scratch / "trace").value();
  EXPECT_THAT(trace, HasSubstr("uagv/v2/CoSiVA/AIV1/state"));
  const auto line = JsonValue::parse(trace.substr(0, trace.find('\n')));
  ASSERT_TRUE(line);
  for (const char* member : {"time", "from", "topic", "payload"}) EXPECT_NE(line->find(member), nullptr) << member;
}

}  // namespace
}  // namespace cosiva::app
