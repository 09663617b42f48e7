#include "cosiva/experiments/runs/scenario/scenario.h"

#include <gmock/gmock.h>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/runs/scenario/scenario_check.h"
#include "cosiva/experiments/runs/scenario/scenario_player.h"
#include "cosiva/experiments/runs/scenario/test_scenarios.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::at;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::read;
using ::testing::StartsWith;

std::vector<std::string> commands(const std::string& body) {
  const auto scenario = read(body);
  EXPECT_TRUE(scenario) << to_string(scenario.error());
  std::vector<std::string> all;
  if (scenario) {
    for (const auto& step : scenario->steps) all.push_back(step.command);
  }
  return all;
}

std::vector<std::string> phrase(const std::string& body) {
  const auto scenario = read(body);
  EXPECT_TRUE(scenario) << to_string(scenario.error());
  std::vector<std::string> all;
  if (scenario) {
    for (const auto& step : scenario->steps) all.push_back(step.what);
  }
  return all;
}

TEST(Scenario, of_a_name_alone_has_four_AIVs_on_lacet4_and_no_steps) {
  const auto scenario = read("");
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  EXPECT_EQ(scenario->name, "test");
  EXPECT_EQ(scenario->description, "");
  EXPECT_EQ(scenario->zone, "lacet4");
  EXPECT_EQ(scenario->aivs, 4U);
  EXPECT_EQ(scenario->seed, 1U);
  EXPECT_FALSE(scenario->duration_s);
  EXPECT_THAT(scenario->steps, IsEmpty());
}

TEST(Scenario, defines_vehicles_zone_duration_and_seed) {
  const auto scenario = read(
      "description = \"\"\"two\nlines\"\"\"\nzone = \"mine.toml\"\naivs = 8\nseed = 9007199254740993\nduration_s = "
      "60.5\n");
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  EXPECT_EQ(scenario->description, "two\nlines");
  EXPECT_EQ(scenario->zone, "mine.toml");
  EXPECT_EQ(scenario->aivs, 8U);
  EXPECT_EQ(scenario->seed, 9007199254740993U) << "not converted to a double";
  EXPECT_EQ(scenario->duration_s, 60.5);
}

TEST(Scenario, sorts_steps_by_time_and_equal_times_by_the_file) {
  const auto scenario = read(at(5, R"(command = "stop"
vehicle = "*")") + at(1.5, R"(command = "slow"
vehicle = "*")") + at(5, R"(command = "fast"
vehicle = "*")"));
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  ASSERT_EQ(scenario->steps.size(), 3U);
  EXPECT_EQ(scenario->steps[0].at, 1500ms);
  EXPECT_EQ(scenario->steps[0].what, "all AIVs: slow");
  EXPECT_EQ(scenario->steps[0].line, 6U);
  EXPECT_EQ(scenario->steps[1].what, "all AIVs: stop");
  EXPECT_EQ(scenario->steps[2].what, "all AIVs: fast");
}

TEST(Scenario, commands_are_sent_to_one_to_several_and_to_all) {
  EXPECT_THAT(commands(at(0, "command = \"stop\"\nvehicle = \"AIV2\"")),
              ElementsAre(R"({"command":"stop","vehicle":"CoSiVA/AIV2"})"));
  EXPECT_THAT(commands(at(0, "command = \"restart\"\nvehicle = \"CoSiVA/AIV2\"")),
              ElementsAre(R"({"command":"restart","vehicle":"CoSiVA/AIV2"})"));
  EXPECT_THAT(commands(at(0, "command = \"cancel\"\nvehicle = \"*\"")),
              ElementsAre(R"({"command":"cancel","vehicle":"*"})"));
  EXPECT_THAT(commands(at(0, "command = \"medium\"\nvehicles = [\"AIV1\", \"AIV3\"]")),
              ElementsAre(R"({"command":"medium","vehicle":"CoSiVA/AIV1"})",
                          R"({"command":"medium","vehicle":"CoSiVA/AIV3"})"));
}

TEST(Scenario, faults_of_a_vehicle_s_modules_are_commands_to_the_emulated_plant) {
  EXPECT_THAT(
      commands(at(0, R"(fault = { vehicle = "AIV2", kind = "stuck_sensor", sensor = 3, reading = 0, for_s = 5 })") +
               at(1, R"(fault = { vehicle = "AIV1", kind = "dead_motor", motor = "right" })") +
               at(2, R"(fault = { vehicle = "AIV1", kind = "brown_out", for_s = 1.5 })") +
               at(3, R"(fault = { vehicle = "AIV1", kind = "none" })")),
      ElementsAre(
          R"({"command":"plant","plant":{"setFault":{"vehicle":"CoSiVA/AIV2","fault":"stuck_sensor","sensor":3,"reading":0,"for_s":5}}})",
          R"({"command":"plant","plant":{"setFault":{"vehicle":"CoSiVA/AIV1","fault":"dead_motor","motor":"right"}}})",
          R"({"command":"plant","plant":{"setFault":{"vehicle":"CoSiVA/AIV1","fault":"brown_out","for_s":1.5}}})",
          R"({"command":"plant","plant":{"setFault":{"vehicle":"CoSiVA/AIV1","fault":"none"}}})"));
  EXPECT_THAT(phrase(at(0, R"(fault = { vehicle = "AIV2", kind = "failed_reader", for_s = 5 })")),
              ElementsAre("AIV2: failed_reader for 5 s"));
}

TEST(Scenario, a_fault_with_a_wrong_field_names_it) {
  const auto error = [](const std::string& fields) {
    const auto scenario = read(at(0, "fault = { vehicle = \"AIV1\", " + fields + " }"));
    return scenario ? std::string("none") : to_string(scenario.error());
  };
  EXPECT_THAT(error(R"(kind = "dead_moter")"), HasSubstr("did you mean \"dead_motor\"?"));
  EXPECT_THAT(error(R"(kind = "brown_out")"), HasSubstr("for_s"));
  EXPECT_THAT(error(R"(kind = "brown_out", for_s = 11)"), HasSubstr("seconds over 0, at most 10"));
  EXPECT_THAT(error(R"(kind = "stuck_sensor", sensor = 8)"), HasSubstr("sensor"));
  EXPECT_THAT(error(R"(kind = "dead_motor", motor = "both")"), HasSubstr("motor"));
  EXPECT_THAT(error(R"(kind = "dead_motor", sensor = 1)"), HasSubstr("this field belongs to stuck_sensor"));
}

TEST(Scenario, crossing_units_are_there_from_the_start_or_are_added_and_switched) {
  const auto scenario =
      read("crossing_units = [\"X1\"]\n" + at(3, R"(unit = { crossing = "X1", on = false })") +
           at(8, R"(unit = { crossing = "X1", on = true })") + at(9, R"(unit = { crossing = "X2", on = true })"));
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  EXPECT_THAT(scenario->crossing_units, ElementsAre("X1"));
  EXPECT_THAT(scenario->switched_units, ElementsAre("X1", "X2"));
  ASSERT_EQ(scenario->steps.size(), 3U);
  EXPECT_EQ(scenario->steps[0].command, R"({"command":"plant","plant":{"setUnit":{"crossing":"X1","on":false}}})");
  EXPECT_EQ(scenario->steps[0].what, "the unit of crossing X1 is switched off");
  const auto error = [](const std::string& fields) {
    const auto bad = read(at(0, "unit = { " + fields + " }"));
    return bad ? std::string("none") : to_string(bad.error());
  };
  EXPECT_THAT(error(R"(crossing = "X1")"), HasSubstr("on = true or on = false"));
  EXPECT_THAT(error(R"(on = true)"), HasSubstr("crossing"));
  EXPECT_THAT(error(R"(crossing = "X1", on = 1)"), HasSubstr("on"));
}

TEST(Scenario, a_virtual_AIV_is_referred_to_by_its_id_anywhere_in_the_file) {
  EXPECT_THAT(commands(at(9, "command = \"fast\"\nvehicle = \"V1\"") + at(1, "virtual_aiv = { id = \"V1\" }")),
              ElementsAre(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv"}})",
                          R"({"command":"fast","vehicle":"CoSiVA.virtual/V1"})"));
}

TEST(Scenario, virtual_AIVs_join_anywhere_on_a_section_or_near_a_point) {
  EXPECT_THAT(commands(at(0, R"(virtual_aiv = { id = "V1", section = "east", s_m = 0.5 })") +
                       at(1, R"(virtual_aiv = { id = "V2", at = [0.1, -0.15] })")),
              ElementsAre(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"east","s":0.5}})",
                          R"({"command":"add","virtualObject":{"id":"V2","kind":"aiv","x":0.1,"y":-0.15}})"));
  EXPECT_THAT(phrase(at(0, R"(virtual_aiv = { id = "V1", section = "east", s_m = 0.5 })") +
                     at(1, R"(virtual_aiv = { id = "V2" })")),
              ElementsAre("virtual AIV V1 joins on east at 0.5 m", "virtual AIV V2 joins where there is room"));
}

TEST(Scenario, persons_are_stationary_or_walk) {
  EXPECT_THAT(
      commands(
          at(0, R"(person = { id = "P1", at = [0.4, 0.1], radius_m = 0.06 })") +
          at(1, R"(person = { id = "P2", path = [[0, 1], [0, 2.5]], speed_mps = 0.3, repeat = "back and forth" })")),
      ElementsAre(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":0.4,"y":0.1,"radius":0.06}})",
                  R"({"command":"add","virtualObject":{"id":"P2","kind":"person","path":[[0,1],[0,2.5]],"speed":0.3,)"
                  R"("repeat":"back and forth"}})"));
  EXPECT_THAT(
      phrase(at(0, R"(person = { id = "P1", at = [0.4, 0.1] })") +
             at(1, R"(person = { id = "P2", path = [[0, 1], [0, 2.5]], speed_mps = 0.3, repeat = "loop" })")),
      ElementsAre("person P1 is at (0.4, 0.1)", "person P2 walks 1.5 m from (0, 1) at 0.3 m/s, round and round"));
}

TEST(Scenario, obstacles_are_virtual_or_physical_and_are_removed_accordingly) {
  EXPECT_THAT(
      commands(at(0, R"(virtual_obstacle = { id = "O1", at = [1, 2] })") +
               at(1, R"(physical_obstacle = { id = "box", at = [3, 4], radius_m = 0.1 })") + at(2, R"(remove = "O1")") +
               at(3, R"(remove = "box")")),
      ElementsAre(R"({"command":"add","virtualObject":{"id":"O1","kind":"obstacle","x":1,"y":2,"radius":0.05}})",
                  R"({"command":"plant","plant":{"addObstacle":{"id":"box","x":3,"y":4,"radius":0.1}}})",
                  R"({"command":"remove","id":"O1"})", R"({"command":"plant","plant":{"removeObstacle":"box"}})"));
}

TEST(Scenario, moved_objects_keep_their_size_and_kind) {
  EXPECT_THAT(commands(at(0, R"(physical_obstacle = { id = "box", at = [3, 4], radius_m = 0.1 })") +
                       at(1, R"(person = { id = "P1", at = [0, 0] })") +
                       at(2, R"(move = { id = "box", at = [5, 6] })") + at(3, R"(move = { id = "P1", at = [1, 1] })") +
                       at(4, R"(move = { id = "P1", path = [[1, 1], [2, 1]] })")),
              ElementsAre(::testing::_, ::testing::_,
                          R"({"command":"plant","plant":{"addObstacle":{"id":"box","x":5,"y":6,"radius":0.1}}})",
                          R"({"command":"move","virtualObject":{"id":"P1","x":1,"y":1}})",
                          R"({"command":"move","virtualObject":{"id":"P1","path":[[1,1],[2,1]],"repeat":"once"}})"));
}

TEST(Scenario, a_star_removes_everything_virtual_and_each_physical_object) {
  EXPECT_THAT(commands(at(0, R"(physical_obstacle = { id = "b", at = [3, 4] })") +
                       at(0, R"(physical_obstacle = { id = "a", at = [3, 4] })") +
                       at(0, R"(physical_obstacle = { id = "gone", at = [3, 4] })") + at(1, R"(remove = "gone")") +
                       at(2, R"(remove = "*")")),
              ElementsAre(::testing::_, ::testing::_, ::testing::_, ::testing::_, R"({"command":"remove","id":"*"})",
                          R"({"command":"plant","plant":{"removeObstacle":"a"}})",
                          R"({"command":"plant","plant":{"removeObstacle":"b"}})"));
}

TEST(Scenario, a_radio_loss_ends_by_itself) {
  const auto scenario = read(at(3, R"(radio = { vehicle = "AIV2", loss = 0.3, for_s = 10 })"));
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  ASSERT_EQ(scenario->steps.size(), 2U);
  EXPECT_EQ(scenario->steps[0].command, R"({"command":"radio","vehicle":"CoSiVA/AIV2","loss":0.3})");
  EXPECT_EQ(scenario->steps[0].what, "AIV2 loses 30 % of its messages for 10 s");
  EXPECT_EQ(scenario->steps[1].at, 13s);
  EXPECT_EQ(scenario->steps[1].command, R"({"command":"radio","vehicle":"CoSiVA/AIV2","loss":0})");
}

TEST(Scenario, a_loss_ends_before_the_next_begins_whatever_their_order_in_the_file) {
  EXPECT_THAT(phrase(at(13, R"(radio = { vehicle = "*", loss = 0.1 })") +
                     at(3, R"(radio = { vehicle = "AIV2", loss = 0.3, for_s = 10 })")),
              ElementsAre(StartsWith("AIV2 loses 30 %"), "AIV2 receives and sends again",
                          "every vehicle loses 10 % of its messages"));
}

TEST(Scenario, missions_send_one_vehicle_to_a_goal_or_let_one_or_all_circulate) {
  EXPECT_THAT(commands(at(0, "go = { vehicle = \"AIV2\", to = \"dock\" }")),
              ElementsAre(R"({"command":"go","vehicle":"CoSiVA/AIV2","to":"dock"})"));
  EXPECT_THAT(commands(at(0, "circulate = { vehicle = \"AIV2\", loop = \"outer\" }")),
              ElementsAre(R"({"command":"circulate","vehicle":"CoSiVA/AIV2","loop":"outer"})"));
  EXPECT_THAT(commands(at(0, "circulate = {}")), ElementsAre(R"({"command":"circulate","vehicle":"*"})"));
}

TEST(Scenario, sections_are_closed_and_opened_again) {
  EXPECT_THAT(commands(at(0, "close = \"east\"") + at(1, "open = \"east\"")),
              ElementsAre(R"({"command":"close","section":"east"})", R"({"command":"open","section":"east"})"));
}

TEST(Scenario, a_switch_contains_the_complete_zone_in_its_command) {
  auto scenario = read(at(2, "switch = \"other\"") + at(1, "command = \"stop\"\nvehicle = \"*\""));
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  EXPECT_EQ(scenario->steps[0].zone, "");
  EXPECT_EQ(scenario->steps[1].zone, "other");
  EXPECT_EQ(scenario->steps[1].what, "the zone is switched to other");
  std::vector<std::string> requested;
  const auto load = [&](const std::string& name) -> Result<zone::ZoneConfiguration> {
    requested.push_back(name);
    return zone::ZoneConfiguration{"f", "other.f", "the \"text\"", "more"};
  };
  ASSERT_TRUE(resolve_zones(*scenario, load, "test.toml"));
  EXPECT_THAT(requested, ElementsAre("other"));
  EXPECT_EQ(scenario->steps[1].command,
            R"({"command":"switch","zone":{"format":"f","origin":"other.f","text":"the \"text\"","sidecar":"more"}})");
  EXPECT_EQ(scenario->steps[0].command, R"({"command":"stop","vehicle":"*"})");
}

TEST(BadScenario, that_switches_to_an_unknown_zone_names_file_and_line) {
  auto scenario = read(at(2, "switch = \"other\""));
  ASSERT_TRUE(scenario);
  const auto load = [](const std::string& name) -> Result<zone::ZoneConfiguration> {
    return fail("zone.missing", "there is no zone of this name", name);
  };
  const auto resolved = resolve_zones(*scenario, load, "test.toml");
  ASSERT_FALSE(resolved);
  EXPECT_EQ(resolved.error().code, "zone.missing");
  EXPECT_EQ(to_string(resolved.error()), "test.toml:2: switch: other: there is no zone of this name");
}

TEST(BadScenario, with_invalid_missions_is_refused_with_file_line_and_field) {
  const auto location_of = [](const std::string& action) {
    const auto scenario = read(at(0, action));
    return scenario ? std::string("good") : scenario.error().location;
  };
  EXPECT_THAT(location_of("go = { vehicle = \"*\", to = \"dock\" }"), HasSubstr("at[1].go.vehicle"));
  EXPECT_THAT(location_of("go = { vehicle = \"AIV1\" }"), HasSubstr("at[1].go"));
  EXPECT_THAT(location_of("go = { vehicle = \"AIV1\", too = \"dock\" }"), HasSubstr("at[1].go.too"));
  EXPECT_THAT(location_of("circulate = { vehicle = \"a/b c\" }"), HasSubstr("at[1].circulate.vehicle"));
  EXPECT_THAT(location_of("close = 3"), HasSubstr("at[1].close"));
  EXPECT_THAT(location_of("open = \"\""), HasSubstr("at[1].open"));
  EXPECT_THAT(location_of("switch = { zone = \"x\" }"), HasSubstr("at[1].switch"));
}

TEST(Scenario, priorities_edit_the_zone) {
  EXPECT_THAT(commands(at(0, "priority = { AIV1 = 3, \"CoSiVA.virtual/V1\" = 0 }")),
              ElementsAre(R"({"command":"edit","edit":{"priorities":{"CoSiVA/AIV1":3,"CoSiVA.virtual/V1":0}}})"));
}

TEST(Scenario, actions_may_be_written_as_separate_tables) {
  EXPECT_THAT(phrase("[[at]]\nt_s = 1\n[at.person]\nid = \"P1\"\nat = [0, 1]\n"),
              ElementsAre("person P1 is at (0, 1)"));
}

TEST(Scenario, every_command_is_one_JSON_object_with_a_command) {
  const auto scenario = read(at(0, R"(person = { id = "P1", path = [[0, 1], [1, 1]] })") +
                             at(0, R"(radio = { vehicle = "*", loss = 1 })") + at(0, R"(priority = { AIV1 = 1 })"));
  ASSERT_TRUE(scenario);
  for (const auto& step : scenario->steps) {
    const auto json = JsonValue::parse(step.command);
    ASSERT_TRUE(json) << step.command;
    EXPECT_TRUE(json->text("command")) << step.command;
  }
}

// --- bad files ----------------------------------------------------------------------------------------------------

struct Bad {
  std::string body;
  std::string location;  ///< the beginning of the error's location
  std::string message;   ///< a part of it
};

void expect_refused(const std::vector<Bad>& all) {
  for (const Bad& bad : all) {
    const auto scenario = read(bad.body);
    ASSERT_FALSE(scenario) << bad.body;
    EXPECT_THAT(scenario.error().location, StartsWith("test.toml:" + bad.location)) << bad.body;
    EXPECT_THAT(scenario.error().message, HasSubstr(bad.message)) << bad.body;
    EXPECT_THAT(scenario.error().code, StartsWith("scenario.")) << bad.body;
  }
}

TEST(BadScenario, with_an_invalid_head_is_refused_with_file_line_and_field) {
  expect_refused(
      {Bad{"aivs = 0\n", "2: aivs", "from 1 to 200, found 0"}, Bad{"aivs = 201\n", "2: aivs", "found 201"},
       Bad{"aivs = 4.0\n", "2: aivs", "a whole number"}, Bad{"aivs = \"four\"\n", "2: aivs", "found \"four\""},
       Bad{"seed = -1\n", "2: seed", "a whole number from 0"},
       Bad{"duration_s = 0\n", "2: duration_s", "seconds over 0"},
       Bad{"duration_s = inf\n", "2: duration_s", "seconds over 0"}, Bad{"zone = \"\"\n", "2: zone", "a text of 1"},
       Bad{"zone = 3\n", "2: zone", "found 3"}, Bad{"description = []\n", "2: description", "an array of 0"},
       Bad{"duration = 3\n", "2: duration", "did you mean \"duration_s\"?"},
       Bad{"ad = 3\n", "2: ad", "did you mean \"at\"?"}, Bad{"at = 3\n", "2: at", "each under [[at]]"},
       Bad{"at = [1]\n", "2: at", "each under [[at]]"}, Bad{"name = \"again\"\n", "2", ""}, Bad{"name = \n", "2", ""},
       Bad{"[[at]\n", "2", ""}});
}

TEST(BadScenario, with_invalid_entries_is_refused_with_file_line_and_field) {
  expect_refused(
      {Bad{"[[at]]\nremove = \"*\"\n", "2: at[1].t_s", "found nothing"},
       Bad{at(-1, "remove = \"*\""), "3: at[1].t_s", "found -1"},
       Bad{"[[at]]\nt_s = nan\nremove = \"*\"\n", "3: at[1].t_s", "found nan"},
       Bad{"[[at]]\nt_s = \"soon\"\nremove = \"*\"\n", "3: at[1].t_s", "found \"soon\""},
       Bad{at(0, ""), "2: at[1]", "expected exactly one action, found none. There are: command, go, circulate, person"},
       Bad{at(0, "remove = \"a\"\nradio = { vehicle = \"*\", loss = 0 }"), "", "\"remove\" and \"radio\""},
       Bad{at(0, "persn = { id = \"P1\", at = [0, 0] }"), "4: at[1].persn", "did you mean \"person\"?"},
       Bad{at(0, "vehicle = \"AIV1\""), "4: at[1].vehicle", "unknown key"},
       Bad{at(0, "xyzzy_plugh = 1"), "4: at[1].xyzzy_plugh", "Known here: t_s, command"},
       Bad{at(0, "person = 3"), "4: at[1].person", "expected a table"},
       Bad{at(0, "remove = \"a\"") + at(1, "remove = 3"), "7: at[2].remove", "found 3"}});
}

TEST(BadScenario, with_invalid_commands_is_refused_with_file_line_and_field) {
  expect_refused(
      {Bad{at(0, "command = \"stpo\"\nvehicle = \"*\""), "4: at[1].command", "did you mean \"stop\"?"},
       Bad{at(0, "command = \"fly\"\nvehicle = \"*\""), "4: at[1].command", "one of stop, slow"},
       Bad{at(0, "command = 1\nvehicle = \"*\""), "4: at[1].command", "found 1"},
       Bad{at(0, "command = \"stop\""), "4: at[1].command", "expected vehicle ="},
       Bad{at(0, "command = \"stop\"\nvehicle = \"*\"\nvehicles = [\"AIV1\"]"), "4: at[1].command",
           "expected vehicle ="},
       Bad{at(0, "command = \"stop\"\nvehicle = 2"), "5: at[1].vehicle", "found 2"},
       Bad{at(0, "command = \"stop\"\nvehicle = \"A B\""), "5: at[1].vehicle", "found \"A B\""},
       Bad{at(0, "command = \"stop\"\nvehicle = \"/AIV1\""), "5: at[1].vehicle", "expected a vehicle"},
       Bad{at(0, "command = \"stop\"\nvehicles = []"), "5: at[1].vehicles", "an array of 0"},
       Bad{at(0, "command = \"stop\"\nvehicles = [1]"), "5: at[1].vehicles", "found 1"},
       Bad{at(0, "radio = { vehicle = \"*\", loss = 1.5 }"), "4: at[1].radio.loss", "a ratio from 0 to 1"},
       Bad{at(0, "radio = { loss = 0.5 }"), "4: at[1].radio.vehicle", "found nothing"},
       Bad{at(0, "radio = { vehicle = \"*\" }"), "4: at[1].radio.loss", "found nothing"},
       Bad{at(0, "radio = { vehicle = \"*\", loss = 0.5, for_s = 0 }"), "4: at[1].radio.for_s", "seconds over 0"},
       Bad{at(0, "radio = { vehicle = \"*\", loss = 0.5, for = 3 }"), "4: at[1].radio.for", "did you mean \"for_s\"?"},
       Bad{at(0, "priority = {}"), "4: at[1].priority", "{ AIV1 = 3 }"},
       Bad{at(0, "priority = { AIV1 = 1000 }"), "4: at[1].priority.AIV1", "from 0 to 999, found 1000"},
       Bad{at(0, "priority = { \"A B\" = 1 }"), "4: at[1].priority", "expected a vehicle"}});
}

TEST(BadScenario, with_impossible_objects_is_refused_with_file_line_and_field) {
  expect_refused(
      {Bad{at(0, "person = { id = \"P1\" }"), "4: at[1].person", "either at"},
       Bad{at(0, "person = { id = \"P1\", at = [0, 0], path = [[0, 0], [1, 1]] }"), "4: at[1].person.path",
           "either at"},
       Bad{at(0, "person = { at = [0, 0] }"), "4: at[1].person.id", "found nothing"},
       Bad{at(0, "person = { id = \"P 1\", at = [0, 0] }"), "4: at[1].person.id", "A-Z a-z 0-9"},
       Bad{at(0, "person = { id = \"S12\", at = [0, 0] }"), "4: at[1].person.id", "detected obstacles"},
       Bad{at(0, "person = { id = \"*\", at = [0, 0] }"), "4: at[1].person.id", "A-Z a-z 0-9"},
       Bad{at(0, "person = { id = \"P1\", at = [0] }"), "4: at[1].person.at", "two numbers of metres"},
       Bad{at(0, "person = { id = \"P1\", at = [0, \"a\"] }"), "4: at[1].person.at", "two numbers of metres"},
       Bad{at(0, "person = { id = \"P1\", at = [nan, 0] }"), "4: at[1].person.at", "two numbers of metres"},
       Bad{at(0, "person = { id = \"P1\", at = [1e6, 0] }"), "4: at[1].person.at", "within ±100000"},
       Bad{at(0, "person = { id = \"P1\", path = [[0, 0]] }"), "4: at[1].person.path", "2 to 64 points"},
       Bad{at(0, "person = { id = \"P1\", path = [[0, 0], 3] }"), "4: at[1].person.path", "two numbers"},
       Bad{at(0, "person = { id = \"P1\", path = [[0, 0], [0, 0]] }"), "4: at[1].person.path", "apart"},
       Bad{at(0, "person = { id = \"P1\", at = [0, 0], speed_mps = 1 }"), "4: at[1].person.speed_mps", "stationary"},
       Bad{at(0, "person = { id = \"P1\", at = [0, 0], repeat = \"loop\" }"), "4: at[1].person.repeat", "stationary"},
       Bad{at(0, "person = { id = \"P1\", path = [[0, 0], [1, 1]], speed_mps = 0 }"), "4: at[1].person.speed_mps",
           "over 0 m/s"},
       Bad{at(0, "person = { id = \"P1\", path = [[0, 0], [1, 1]], repeat = \"lop\" }"), "4: at[1].person.repeat",
           "did you mean \"loop\"?"},
       Bad{at(0, "person = { id = \"P1\", at = [0, 0], radius_m = 2 }"), "4: at[1].person.radius_m",
           "from 0.02 to 1 m"},
       Bad{at(0, "virtual_aiv = { id = \"V1\", section = \"east\" }"), "4: at[1].virtual_aiv", "go together"},
       Bad{at(0, "virtual_aiv = { id = \"V1\", at = [0, 0], section = \"east\", s_m = 1 }"), "4: at[1].virtual_aiv.at",
           "either section and s_m"},
       Bad{at(0, "virtual_aiv = { id = \"V1\", section = \"east\", s_m = -1 }"), "4: at[1].virtual_aiv.s_m", "from 0"},
       Bad{at(0, "virtual_obstacle = { id = \"O1\" }"), "4: at[1].virtual_obstacle.at", "found nothing"},
       Bad{at(0, "physical_obstacle = { id = \"b\", at = [0, 0], radius_m = 0 }"),
           "4: at[1].physical_obstacle.radius_m", "from 0.02 to 1 m"},
       Bad{at(0, "physical_obstacle = { id = \"b\", at = [0, 0] }") +
               at(1, "physical_obstacle = { id = \"b\", at = [0, 1] }"),
           "7: at[2].physical_obstacle.id", "since line 2; use move"},
       Bad{at(0, "physical_obstacle = { id = \"b\", at = [0, 0] }") +
               at(1, "move = { id = \"b\", path = [[0, 0], [1, 1]] }"),
           "7: at[2].move.path", "does not walk"},
       Bad{at(0, "move = { id = \"P1\" }"), "4: at[1].move", "either at"},
       Bad{at(0, "move = { id = \"P1\", at = [0, 0], radius_m = 1 }"), "4: at[1].move.radius_m", "unknown key"}});
}

TEST(Scenario, without_a_name_or_too_large_is_refused) {
  EXPECT_EQ(scenario_from_toml("", "x.toml").error().location, "x.toml:1: name");
  EXPECT_EQ(scenario_from_toml(std::string((1U << 20U) + 1, '#'), "x.toml").error().code, "scenario.size");
}

// --- playing --------------------------------------------------------------------------------------------------------

TEST(ScenarioPlayer, returns_each_step_once_at_its_time_and_none_before_it_began) {
  const auto scenario =
      read(at(0, "remove = \"a\"") + at(1, "remove = \"b\"") + at(1, "remove = \"c\"") + at(3, "remove = \"d\""));
  ASSERT_TRUE(scenario);
  ScenarioPlayer player{*scenario};
  const SimTime start{10s};
  EXPECT_FALSE(player.begun());
  EXPECT_FALSE(player.next_due());
  EXPECT_THAT(player.due(start + 100s), IsEmpty());
  player.begin(start);
  EXPECT_EQ(player.next_due(), start);
  EXPECT_EQ(player.due(start).size(), 1U);
  EXPECT_THAT(player.due(start + 999ms), IsEmpty());
  EXPECT_EQ(player.next_due(), start + 1s);
  EXPECT_EQ(player.due(start + 1s).size(), 2U);
  EXPECT_FALSE(player.done());
  EXPECT_EQ(player.due(start + 60s).size(), 1U) << "an overdue step is played late";
  EXPECT_TRUE(player.done());
  EXPECT_FALSE(player.next_due());
}

}  // namespace
}  // namespace cosiva::experiments
