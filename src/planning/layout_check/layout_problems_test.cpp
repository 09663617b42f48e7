#include "cosiva/planning/layout_check/layout_problems.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::planning {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using zone::Problem;

std::vector<Problem> problems_of(const zone::TrafficZone& zone, const WellFormedLimits& limits = {}) {
  return layout_problems(zone, WellFormed::examine(zone, limits));
}

std::vector<Problem> problems_of_map(const std::vector<std::string>& rows, const WellFormedLimits& limits = {}) {
  std::string text =
      "height " + std::to_string(rows.size()) + "\nwidth " + std::to_string(rows.front().size()) + "\nmap\n";
  for (const std::string& row : rows) text += row + "\n";
  const auto rtm = zone::Rtm::initialise({"movingai", "squares.map", text, ""});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return problems_of(rtm->zone(), limits);
}

std::vector<Problem> problems_of_text(const std::string& text) {
  const auto zone = zone::testing::read_zone(text);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return problems_of(*zone);
}

std::string station(const std::string& name, const std::string& section, const std::string& s_m) {
  return "[[station]]\nname = \"" + name + "\"\nsection = \"" + section + "\"\ns_m = " + s_m + "\n";
}

TEST(LayoutProblems, are_none_where_stations_obstruct_nothing) {
  EXPECT_THAT(problems_of_map({"...", "E@E"}), IsEmpty());
  EXPECT_THAT(problems_of_map({"..."}), IsEmpty()) << "no stations at all";
}

TEST(LayoutProblems, name_a_station_that_cuts_others_off_and_a_remedy) {
  const auto problems = problems_of_map({"E.E.E.E"});
  ASSERT_THAT(problems, SizeIs(3));
  EXPECT_EQ(problems[0].code, "layout.cut");
  EXPECT_EQ(problems[0].severity, Problem::Severity::notice);
  EXPECT_EQ(
      problems[0].text,
      "a vehicle at station 'S2' cuts off station 'S1' from the others; give the station a bay of its own, or add "
      "sections that lead round it");
  EXPECT_EQ(problems[0].at, (Point2{2.0, 0.0}));
  EXPECT_THAT(problems[1].text, HasSubstr("'S3' cuts off station 'S4'"));
  EXPECT_EQ(problems[2].code, "layout.obstructed");
}

TEST(LayoutProblems, name_five_of_many_stations) {
  // In the hub's centre: four arms with two stations each, of which three are off.
  const auto problems = problems_of_map({"@@@E@@@", "@@@E@@@", "@@@.@@@", "EE.E.EE", "@@@.@@@", "@@@E@@@", "@@@E@@@"});
  const auto hub = std::find_if(problems.begin(), problems.end(),
                                [](const Problem& p) { return p.text.starts_with("a vehicle at station 'S5'"); });
  ASSERT_NE(hub, problems.end());
  EXPECT_THAT(hub->text, HasSubstr("cuts off stations 'S3', 'S4', 'S6', 'S7', 'S8' and 1 more from the others"));
}

TEST(LayoutProblems, name_a_station_that_can_be_entered_but_not_left) {
  const auto problems = problems_of_text(
      "name = \"z\"\nformat_version = 1\n"
      "[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = 2.0\n" +
      station("S6", "a", "1") + station("S7", "a", "2"));
  std::vector<std::string> codes;
  codes.reserve(problems.size());
  for (const Problem& problem : problems) codes.push_back(problem.code);
  EXPECT_THAT(codes, ElementsAre("layout.no_exit", "layout.obstructed"));
  EXPECT_EQ(problems[0].severity, Problem::Severity::warning);
  EXPECT_EQ(
      problems[0].text,
      "station 'S7' can be entered but not left; let vehicles turn on the spot there (pivots), or add a section that "
      "leads back");
}

TEST(LayoutProblems, state_that_no_station_can_be_reached_from_another_one) {
  const auto problems = problems_of_text(
      "name = \"z\"\nformat_version = 1\n"
      "[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = 2.0\nnext = []\n"
      "[[section]]\nname = \"b\"\nkind = \"straight\"\nlength_m = 2.0\nnext = []\n"
      "start = { x = 0.0, y = 3.0, heading_deg = 0.0 }\n" +
      station("one", "a", "2") + station("two", "b", "2"));
  ASSERT_FALSE(problems.empty());
  EXPECT_EQ(problems[0].code, "layout.no_transport");
  EXPECT_THAT(problems[0].text, HasSubstr("so that no transport is possible; add sections"));
  for (const Problem& problem : problems) EXPECT_NE(problem.code, "layout.obstructed");
}

TEST(LayoutProblems, name_a_station_at_which_no_vehicle_can_arrive) {
  const auto problems = problems_of_text(
      "name = \"z\"\nformat_version = 1\n[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m "
      "= 2.0\n" +
      station("begin", "a", "0"));
  ASSERT_THAT(problems, SizeIs(1));
  EXPECT_EQ(problems[0].code, "layout.no_entry");
  EXPECT_EQ(problems[0].text, "no vehicle can arrive at station 'begin'; let a section lead to it");
}

TEST(LayoutProblems, list_twenty_of_one_code_and_count_the_others) {
  std::string row;
  for (int i = 0; i < 25; ++i) row += "E.";
  const auto problems = problems_of_map({row});
  // All but the two at the ends.
  ASSERT_THAT(problems, SizeIs(22));
  EXPECT_EQ(problems[20].code, "layout.obstructed");
  EXPECT_EQ(problems[21].text, "and 3 more stations like those above, up to station 'S24'");
}

TEST(LayoutProblems, state_how_many_stations_were_examined) {
  const auto problems = problems_of_map({"E.E.E.E"}, {.work_max = 0});
  ASSERT_THAT(problems, SizeIs(2));
  EXPECT_EQ(problems[1].code, "layout.cut");
  EXPECT_THAT(problems[1].text, HasSubstr("examined for the first 0 of 4 stations only"));
}

}  // namespace
}  // namespace cosiva::planning
