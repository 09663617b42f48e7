#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Writes the built-in rules, with one text replaced by another, to a file.
std::string edited(const Scratch& scratch, const std::string& from, const std::string& to) {
  std::string text(aiv::built_in_rules_text());
  text.replace(text.find(from), from.size(), to);
  const std::string file = scratch / "my.fll";
  EXPECT_TRUE(adapters::write_file(file, text));
  return file;
}

TEST(AgentExplain, prints_the_decision_the_fired_rules_and_the_reason) {
  const CommandOutput output = cosiva({"agent", "explain", "--gap", "0.75", "--closing", "60"});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, StartsWith("decision: slow (1.25 of"));
  EXPECT_THAT(output.data, HasSubstr("because of by_gap; at the crossing it goes"));
  EXPECT_THAT(output.data, HasSubstr("75 %  line"));
  EXPECT_THAT(output.data, HasSubstr("if gap is near and closing is closing then by_gap is slow"));
  EXPECT_THAT(output.data, HasSubstr("because gap is near: 75 %, closing is closing: 100 %"));
  EXPECT_THAT(output.data, Not(HasSubstr("charge is low then")));
  EXPECT_THAT(cosiva({"agent", "explain", "--all"}).data, HasSubstr("charge is low then"));
}

TEST(AgentExplain, takes_its_own_speed_as_the_closing_speed_towards_a_stopped_body) {
  // On lacet4 medium is 0.4 m/s.
  EXPECT_EQ(cosiva({"agent", "explain", "--gap", "0.9", "--speed", "0.1"}).data,
            cosiva({"agent", "explain", "--gap", "0.9", "--closing", "25"}).data);
  EXPECT_EQ(cosiva({"agent", "explain", "--gap", "0.9", "--speed", "0.1", "--zone", "workshop", "--json"}).data,
            cosiva({"agent", "explain", "--gap", "0.9", "--closing", "33.333333333333336", "--json"}).data);
  EXPECT_EQ(cosiva({"agent", "explain", "--speed", "0.4"}).data, cosiva({"agent", "explain"}).data)
      << "no body is ahead";
  EXPECT_EQ(cosiva({"agent", "surface", "--y", "charge", "--gap", "2", "--speed", "0.4"}).status, 0);
  EXPECT_EQ(cosiva({"agent", "explain", "--speed", "-1"}).status, 2);
  EXPECT_EQ(cosiva({"agent", "explain", "--gap", "1", "--speed", "1", "--zone", "nowhere"}).status, 2);
  const CommandOutput both = cosiva({"agent", "explain", "--gap", "1", "--speed", "1", "--closing", "3"});
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.standard_error, HasSubstr("cosiva agent explain: "));
  EXPECT_THAT(both.standard_error, HasSubstr("`cosiva agent explain --help`"));
}

TEST(AgentExplain, prints_the_same_as_json) {
  const CommandOutput output = cosiva({"agent", "explain", "--instruction", "slow", "--json"});
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json) << output.data;
  EXPECT_EQ(json->text("profile"), "slow");
  EXPECT_EQ(json->text("decided_by"), "by_instruction");
  EXPECT_EQ(json->flag("goes"), true);
  EXPECT_EQ(json->find("explanation")->find("rules")->array()->size(), 31U);
}

TEST(AgentExplain, keeps_the_present_profile_near_a_border) {
  EXPECT_THAT(cosiva({"agent", "explain", "--gap", "0.9"}).data, StartsWith("decision: slow"));
  EXPECT_THAT(cosiva({"agent", "explain", "--gap", "0.9", "--present", "medium"}).data, StartsWith("decision: medium"));
}

TEST(AgentExplain, follows_the_edit_of_an_edited_file) {
  const Scratch scratch;
  const std::string file = edited(scratch, "if instruction is none then by_instruction is medium",
                                  "if instruction is none then by_instruction is fast");
  EXPECT_THAT(cosiva({"agent", "explain", "--rules", file}).data, StartsWith("decision: fast"));
}

TEST(AgentRules, with_errors_end_every_command_with_2_and_their_line) {
  const Scratch scratch;
  const std::string file = edited(scratch, "if charge is low then", "if charge is lw then");
  const std::vector<std::vector<std::string>> commands{{"agent", "explain"},
                                                       {"agent", "surface"},
                                                       {"up", "--headless", "--virtual-time", "--duration", "1"},
                                                       {"up", "--headless", "--duration", "1"},
                                                       {"aiv", "--number", "1", "--sockets", scratch.path()},
                                                       {"server", "--headless"}};
  for (std::vector<std::string> command : commands) {
    command.insert(command.end(), {"--rules", file});
    const CommandOutput output = cosiva(command);
    EXPECT_EQ(output.status, 2) << command[0];
    EXPECT_THAT(output.standard_error,
                HasSubstr("my.fll:287:22: 'charge' has no such term; expected a hedge or low or good"))
        << command[0];
  }
  EXPECT_EQ(cosiva({"agent", "explain", "--rules", scratch / "gone.fll"}).status, 2);
}

TEST(AgentSurface, is_printed_as_a_map_of_letters_in_the_terminal) {
  const CommandOutput output = cosiva({"agent", "surface", "--x", "gap", "--y", "charge"});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, StartsWith("speed over gap [braking distances] and charge [%]"));
  EXPECT_THAT(output.data, HasSubstr("     0.0 |sssss"));
  EXPECT_THAT(output.data, HasSubstr("x stop, s slow, m medium, f fast"));
}

TEST(AgentSurface, is_drawn_into_a_file) {
  const Scratch scratch;
  ASSERT_EQ(cosiva({"agent", "surface", "--out", scratch / "s.svg"}).status, 0);
  const std::string svg = *adapters::read_file(scratch / "s.svg");
  EXPECT_THAT(svg, HasSubstr("Speed over gap and closing"));
  EXPECT_THAT(svg, HasSubstr("closing [% of the medium speed]"));
  EXPECT_THAT(svg, HasSubstr("with instruction none, base 10"));
  ASSERT_EQ(cosiva({"agent", "surface", "--of", "go", "--x", "margin", "--y", "priority", "--crossing", "1", "--out",
                    scratch / "s.png"})
                .status,
            0);
  EXPECT_THAT(*adapters::read_file(scratch / "s.png"), StartsWith("\x89PNG"));
}

TEST(AgentSurface, names_the_available_inputs_and_outputs) {
  EXPECT_THAT(cosiva({"agent", "surface", "--x", "gapp"}).standard_error,
              HasSubstr("--x: the rules have no input 'gapp'; they have instruction, gap,"));
  EXPECT_THAT(cosiva({"agent", "surface", "--of", "joy"}).standard_error, HasSubstr("there are speed, by_instruction"));
  EXPECT_EQ(cosiva({"agent", "surface", "--x", "gap", "--y", "gap"}).status, 2);
  EXPECT_EQ(cosiva({"agent", "surface", "--out", "surface.gif"}).status, 2);
  EXPECT_EQ(cosiva({"agent"}).status, 2);
  EXPECT_EQ(cosiva({"agent", "explain", "--instruction", "hurry"}).status, 2);
}

TEST(Rules, of_virtual_time_are_those_that_were_requested) {
  const auto run = [](const char* rules) {
    const CommandOutput output =
        cosiva({"up", "--virtual-time", "--duration", "20", "--aivs", "4", "--json", "--rules", rules});
    EXPECT_EQ(output.status, 0) << output.standard_error;
    return output.data;
  };
  EXPECT_EQ(run("fuzzy"), run("fuzzy"));
  run("crisp");
}

TEST(Switches, are_on_or_off_and_nothing_else) {
  const auto run = [](const char* name, const char* word) {
    return cosiva({"up", "--virtual-time", "--duration", "5", "--aivs", "2", "--json", name, word});
  };
  for (const char* name : {"--v2x", "--convoys"}) {
    EXPECT_EQ(run(name, "on").status, 0) << name;
    EXPECT_EQ(run(name, "off").status, 0) << name;
    const CommandOutput output = run(name, "perhaps");
    EXPECT_EQ(output.status, 2);
    EXPECT_THAT(output.standard_error, HasSubstr(name));
  }
}

}  // namespace
}  // namespace cosiva::app
