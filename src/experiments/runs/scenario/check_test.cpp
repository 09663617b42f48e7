#include <gmock/gmock.h>

#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/experiments/runs/scenario/scenario_check.h"
#include "cosiva/experiments/runs/scenario/test_scenarios.h"

namespace cosiva::experiments {
namespace {

using testing::at;
using ::testing::HasSubstr;
using testing::read;
using ::testing::StartsWith;

Result<void> checked(const std::string& body) {
  static const zone::TrafficZone zone = testing::lacet4();
  const auto scenario = read(body);
  EXPECT_TRUE(scenario) << to_string(scenario.error());
  return scenario ? check(*scenario, zone, "test.toml") : Result<void>{};
}

void expect_good(const std::string& body) {
  const auto good = checked(body);
  EXPECT_TRUE(good) << to_string(good.error());
}

void expect_bad(const std::string& body, const std::string& location, const std::string& message) {
  const auto good = checked(body);
  ASSERT_FALSE(good) << body;
  EXPECT_THAT(good.error().location, StartsWith("test.toml:" + location)) << body;
  EXPECT_THAT(good.error().message, HasSubstr(message)) << body;
  EXPECT_THAT(good.error().code, StartsWith("scenario."));
}

TEST(ScenarioCheck, a_scenario_that_fits_its_zone_is_good) {
  expect_good("");
  expect_good(at(0, "command = \"stop\"\nvehicle = \"*\"") + at(1, "command = \"stop\"\nvehicle = \"AIV4\"") +
              at(2, "virtual_aiv = { id = \"V1\", section = \"loop_se\", s_m = 2 }") +
              at(3, "command = \"fast\"\nvehicle = \"V1\"") + at(4, "priority = { V1 = 2, AIV1 = 3 }") +
              at(5, "person = { id = \"P1\", path = [[0.4, 0.1], [0.4, -0.4]] }") +
              at(6, "move = { id = \"P1\", at = [0, 1] }") + at(7, "remove = \"P1\"") +
              at(8, "person = { id = \"P1\", at = [0, 1] }") + at(9, "remove = \"*\"") +
              at(10, "physical_obstacle = { id = \"P1\", at = [0, 1] }") +
              at(11, "move = { id = \"P1\", at = [0, 1.1] }") + at(12, "remove = \"P1\""));
}

TEST(ScenarioCheck, more_AIVs_than_start_positions_are_refused) {
  expect_bad("aivs = 200\n", "1: aivs", "has room for");
}

TEST(ScenarioCheck, unknown_vehicles_are_refused_with_the_existing_ones) {
  expect_bad(at(0, "command = \"stop\"\nvehicle = \"AIV5\""), "2: vehicle", "this scenario has AIV1 to AIV4");
  expect_bad(at(0, "command = \"stop\"\nvehicle = \"AVI2\""), "2: vehicle", "did you mean \"AIV2\"?");
  expect_bad(at(0, "command = \"stop\"\nvehicle = \"AIV02\""), "2: vehicle", "there is no vehicle \"AIV02\"");
  expect_bad(at(0, "command = \"stop\"\nvehicle = \"CoSiva/AIV2\""), "2: vehicle", "\"CoSiva/AIV2\"");
  expect_bad("aivs = 1\n" + at(0, "priority = { AIV2 = 1 }"), "3: priority", "this scenario has AIV1");
}

TEST(ScenarioCheck, a_virtual_AIV_is_commanded_only_while_present) {
  const std::string joins = at(5, "virtual_aiv = { id = \"V1\" }");
  expect_bad(joins + at(4, "command = \"stop\"\nvehicle = \"V1\""), "5: vehicle", "it is only added at 5 s");
  expect_bad(joins + at(6, "remove = \"V1\"") + at(7, "command = \"stop\"\nvehicle = \"V1\""), "8: vehicle",
             "removed before");
  expect_bad(at(4, "command = \"stop\"\nvehicle = \"CoSiVA.virtual/V9\""), "2: vehicle", "ever added");
}

TEST(ScenarioCheck, positions_off_the_zone_or_off_its_paths_are_refused) {
  expect_bad(at(0, "person = { id = \"P1\", at = [0, 40] }"), "2: at", "is off the zone lacet4");
  expect_bad(at(0, "person = { id = \"P1\", path = [[0, 0], [0, 40]] }"), "2: path", "is off the zone");
  expect_bad(at(0, "physical_obstacle = { id = \"b\", at = [-40, 0] }"), "2: at", "is off the zone");
  expect_bad(at(0, "virtual_aiv = { id = \"V1\", at = [0.75, 0.75] }"), "2: virtual_aiv.at", "m away");
  expect_bad(at(0, "virtual_aiv = { id = \"V1\", section = \"esat\", s_m = 0 }"), "2: virtual_aiv.section",
             "did you mean \"east\"?");
  expect_bad(at(0, "virtual_aiv = { id = \"V1\", section = \"east\", s_m = 1.6 }"), "2: virtual_aiv.s_m",
             "east is 1.5 m long");
  // Straights cross at ±0.15 m from the centre of a straight of 1.5 m.
  expect_bad(at(0, "virtual_aiv = { id = \"V1\", section = \"east\", s_m = 0.6 }"), "2: virtual_aiv",
             "no vehicle may stop");
  expect_bad(at(0, "virtual_aiv = { id = \"V1\", at = [0.15, -0.15] }"), "2: virtual_aiv", "no vehicle may stop");
}

TEST(ScenarioCheck, ids_name_one_object_at_a_time) {
  const std::string person = at(1, "person = { id = \"P1\", at = [0, 1] }");
  expect_bad(person + at(2, "person = { id = \"P1\", at = [0, 1] }"), "5: id", "a person \"P1\" already, since line 2");
  expect_bad(person + at(2, "physical_obstacle = { id = \"P1\", at = [0, 1] }"), "5: id", "already, since line 2");
  expect_bad(at(1, "virtual_aiv = { id = \"V1\" }") + at(2, "virtual_obstacle = { id = \"V1\", at = [0, 1] }"), "5: id",
             "already");
  expect_bad(at(0, "remove = \"P1\"") + person, "2: remove", "no object \"P1\" at 0 s");
  expect_bad(person + at(2, "remove = \"P2\""), "5: remove", "did you mean \"P1\"?");
  expect_bad(person + at(0, "move = { id = \"P1\", at = [0, 1] }"), "5: move.id", "no object");
  expect_bad(at(1, "virtual_aiv = { id = \"V1\" }") + at(2, "move = { id = \"V1\", at = [0, 1] }"), "5: move.id",
             "drives by itself");
  expect_bad(at(1, "virtual_obstacle = { id = \"O1\", at = [0, 1] }") +
                 at(2, "move = { id = \"O1\", path = [[0, 1], [1, 1]] }"),
             "5: move.path", "does not walk");
}

TEST(ScenarioCheck, radio_losses_belong_to_vehicles_with_a_radio_and_do_not_overlap) {
  expect_bad(at(1, "virtual_aiv = { id = \"V1\" }") + at(2, "radio = { vehicle = \"V1\", loss = 0.5 }"),
             "5: radio.vehicle", "has no radio");
  expect_bad(at(2, "radio = { vehicle = \"AIV9\", loss = 0.5 }"), "2: radio.vehicle", "no vehicle \"AIV9\"");
  const std::string ten_seconds = at(2, "radio = { vehicle = \"AIV2\", loss = 0.5, for_s = 10 }");
  expect_bad(ten_seconds + at(5, "radio = { vehicle = \"AIV2\", loss = 0.1 }"), "5: radio", "line 2 is not over yet");
  expect_bad(ten_seconds + at(5, "radio = { vehicle = \"*\", loss = 0.1 }"), "5: radio", "is not over yet");
  expect_good(ten_seconds + at(5, "radio = { vehicle = \"AIV3\", loss = 0.1 }"));
  expect_good(ten_seconds + at(12, "radio = { vehicle = \"*\", loss = 0.1 }"));
  expect_good(ten_seconds + at(5, "radio = { vehicle = \"*\", loss = 0 }"));
}

TEST(ScenarioCheck, crossing_units_belong_to_crossings_of_the_zone) {
  expect_good("crossing_units = [\"all\"]\n" + at(0, R"(unit = { crossing = "X1", on = false })"));
  expect_bad("crossing_units = [\"X9\"]\n", "1: crossing_units", "lacet4 has no crossing \"X9\"");
  expect_bad(at(0, R"(unit = { crossing = "X11", on = false })"), "2: unit.crossing", "did you mean \"X1\"?");
}

TEST(ScenarioCheck, steps_after_the_end_are_refused) {
  expect_bad("duration_s = 10\n" + at(11, "remove = \"*\""), "3: t_s", "at 11 s the scenario is over");
  expect_good("duration_s = 10\n" + at(10, "remove = \"*\""));
}

/// The zones of the source tree, for scenarios that switch to them.
Result<zone::ZoneConfiguration> ready_zone(const std::string& name) {
  return zone::ZoneConfiguration{"toml", name, testing::file_text("zones/" + name + ".toml"), {}};
}

TEST(ScenarioCheck, the_ready_scenarios_are_valid) {
  const zone::TrafficZone zone = testing::lacet4();
  for (const char* name : {"showroom", "laboratory", "rush_hour", "two_zones"}) {
    const std::string file = std::string("scenarios/") + name + ".toml";
    auto scenario = scenario_from_toml(testing::file_text(file), file);
    ASSERT_TRUE(scenario) << to_string(scenario.error());
    ASSERT_TRUE(resolve_zones(*scenario, ready_zone, file));
    EXPECT_EQ(scenario->name, name);
    EXPECT_EQ(scenario->zone, "lacet4");
    EXPECT_NE(scenario->description, "");
    const auto good = check(*scenario, zone, file);
    EXPECT_TRUE(good) << to_string(good.error());
  }
}

TEST(ScenarioCheck, the_guide_s_examples_are_valid) {
  const std::string guide = testing::file_text("docs/guide/scenarios.md");
  const std::string begin = "```toml\n";
  std::size_t at = guide.find(begin);
  const std::string whole = guide.substr(at + begin.size(), guide.find("```", at + begin.size()) - at - begin.size());
  auto scenario = scenario_from_toml(whole, "scenarios.md");
  ASSERT_TRUE(scenario) << to_string(scenario.error());
  ASSERT_TRUE(resolve_zones(*scenario, ready_zone, "scenarios.md"));
  const auto good = check(*scenario, testing::lacet4(), "scenarios.md");
  EXPECT_TRUE(good) << to_string(good.error());
  for (const char* action : {"command", "vehicles", "person", "virtual_aiv", "virtual_obstacle", "physical_obstacle",
                             "move", "remove", "radio", "priority", "go", "circulate", "close", "open", "switch"})
    EXPECT_THAT(whole, HasSubstr(std::string("\n") + action + " = "));

  at = guide.find(begin, at + 1);
  const std::string part = guide.substr(at + begin.size(), guide.find("```", at + begin.size()) - at - begin.size());
  const auto written_out = read(part);
  EXPECT_TRUE(written_out) << to_string(written_out.error());
}

Result<void> checked_with_zones(const std::string& body) {
  static const zone::TrafficZone zone = testing::lacet4();
  auto scenario = read(body);
  EXPECT_TRUE(scenario) << to_string(scenario.error());
  EXPECT_TRUE(resolve_zones(*scenario, ready_zone, "test.toml"));
  return check(*scenario, zone, "test.toml");
}

TEST(ScenarioCheck, positions_are_validated_in_the_zone_in_force_at_that_step) {
  const std::string to_shelf = "go = { vehicle = \"AIV1\", to = \"shelf_a\" }";
  const auto good = checked_with_zones(at(1, "close = \"east\"") + at(2, "switch = \"indus8\"") + at(3, to_shelf) +
                                       at(4, "circulate = { loop = \"round\" }") + at(5, "close = \"aisle_2\"") +
                                       at(6, "switch = \"lacet4\"") + at(7, "close = \"east\""));
  EXPECT_TRUE(good) << to_string(good.error());
  // The shelf is in indus8, the section east in lacet4.
  EXPECT_FALSE(checked_with_zones(at(1, to_shelf) + at(2, "switch = \"indus8\"")));
  EXPECT_FALSE(checked_with_zones(at(1, "switch = \"indus8\"") + at(2, "close = \"east\"")));
}

TEST(ScenarioCheck, unknown_goals_loops_and_sections_are_refused_with_the_nearest) {
  expect_bad(at(0, "close = \"eats\""), "2: close", "did you mean \"east\"?");
  expect_bad(at(0, "open = \"east\""), "2: open", "is not closed at 0 s");
  expect_bad(at(0, "close = \"east\"") + at(1, "close = \"east\""), "5: close", "is closed already at 1 s");
  expect_bad(at(0, "go = { vehicle = \"AIV1\", to = \"nowhere\" }"), "2: go.to", "no station or waypoint");
  expect_bad(at(0, "go = { vehicle = \"AIV9\", to = \"east@0\" }"), "2: ", "");
  expect_bad(at(0, "circulate = { loop = \"inner\" }"), "2: circulate.loop", "no loop");
}

TEST(ScenarioCheck, an_unusable_zone_is_refused_at_the_step_that_switches_to_it) {
  static const zone::TrafficZone zone = testing::lacet4();
  auto scenario = read(at(3, "switch = \"bad\""));
  ASSERT_TRUE(scenario);
  const auto unresolved = check(*scenario, zone, "test.toml");
  ASSERT_FALSE(unresolved) << "the zone has not been resolved";
  const auto load = [](const std::string&) -> Result<zone::ZoneConfiguration> {
    return zone::ZoneConfiguration{"toml", "bad.toml", "name = \"bad\"\n", {}};
  };
  ASSERT_TRUE(resolve_zones(*scenario, load, "test.toml"));
  const auto evaluated = check(*scenario, zone, "test.toml");
  ASSERT_FALSE(evaluated);
  EXPECT_THAT(evaluated.error().location, StartsWith("test.toml:2: switch"));
  EXPECT_THAT(evaluated.error().message, HasSubstr("bad.toml"));
}

}  // namespace
}  // namespace cosiva::experiments
