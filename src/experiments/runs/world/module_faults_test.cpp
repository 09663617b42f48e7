// Faults of a vehicle's modules over the whole platform (A18): each is injected by a scenario, and the test shows how
// the platform reacts. Without the reaction the vehicle would drive on unnoticed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ModuleFaultScenario : public ::testing::Test {
 protected:
  void play(const std::string& events, WorldOptions options = {}) {
    options.zone = experiments::testing::zone_named("lacet4");
    options.aivs = 2;
    auto made = World::make(std::move(options));
    ASSERT_TRUE(made) << to_string(made.error());
    world = std::move(*made);
    const auto scenario = scenario_from_toml("name = \"faults\"\naivs = 2\n" + events, "test.toml");
    ASSERT_TRUE(scenario) << to_string(scenario.error());
    world->play(*scenario);
    world->run_for(10s);  // the fleet is complete, and drives
    EXPECT_TRUE(events.empty() || world->scenario_began());
  }
  [[nodiscard]] JsonValue aiv(const std::string& id) const {
    const JsonValue snapshot = *JsonValue::parse(world->server().snapshot_json());
    for (const JsonValue& one : *snapshot.find("aivs")->array())
      if (one.text("id") == id) return one;
    ADD_FAILURE() << id;
    return {};
  }
  [[nodiscard]] std::vector<std::string> errors(const std::string& id) const {
    const JsonValue vehicle = aiv(id);
    std::vector<std::string> texts;
    for (const JsonValue& error : *vehicle.find("errors")->array()) texts.push_back(*error.text());
    return texts;
  }
  [[nodiscard]] double true_speed_mps(std::uint32_t number) const {
    return world->plant().vehicles()[number - 1].speed_mps;
  }
  [[nodiscard]] double true_distance_m(std::uint32_t number) const {
    return world->plant().vehicles()[number - 1].distance_m;
  }
  [[nodiscard]] std::string state_of_command(const std::string& kind) const {
    const JsonValue snapshot = *JsonValue::parse(world->server().snapshot_json());
    std::string state;
    for (const JsonValue& command : *snapshot.find("commands")->array())
      if (command.text("command") == kind)
        state = command.text("state").value_or("") + command.text("reason").value_or("");
    return state;
  }

  std::unique_ptr<World> world;
};

const std::string stuck = "[[at]]\nt_s = 12\nfault = { vehicle = \"AIV1\", kind = \"stuck_sensor\", for_s = 10 }\n";

TEST_F(ModuleFaultScenario, a_stuck_sensor_stops_the_vehicle_with_an_error_that_names_dems) {
  play(stuck);
  world->run_for(10s);
  EXPECT_EQ(true_speed_mps(1), 0.0);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Contains("boardFaulty: PILS reports DEMS: implausible readings"));
  EXPECT_THAT(errors("CoSiVA/AIV2"), IsEmpty());
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
}

TEST_F(ModuleFaultScenario, a_vehicle_whose_sensor_was_stuck_drives_again_after_a_self_test) {
  play(stuck + "[[at]]\nt_s = 18\ncommand = \"self-test\"\nvehicle = \"AIV1\"\n" +
       "[[at]]\nt_s = 26\ncommand = \"self-test\"\nvehicle = \"AIV1\"\n");
  world->run_for(12s);
  EXPECT_THAT(state_of_command("self-test"),
              HasSubstr("failedthe vehicle refused the command: PILS DEMS: implausible readings, PRAV passed"));
  EXPECT_EQ(aiv("CoSiVA/AIV1").find("boards")->array()->front().find("parts")->text("DEMS"), "implausible readings");
  const double stopped_at_m = true_distance_m(1);
  world->run_for(15s);
  EXPECT_EQ(state_of_command("self-test"), "materialised");
  EXPECT_GT(true_distance_m(1), stopped_at_m + 0.5);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Not(Contains(HasSubstr("boardFaulty"))));
}

TEST_F(ModuleFaultScenario, a_dead_motor_stops_the_vehicle_with_an_error_that_names_pmot) {
  play("[[at]]\nt_s = 12\nfault = { vehicle = \"AIV1\", kind = \"dead_motor\", motor = \"left\" }\n");
  world->run_for(10s);
  EXPECT_EQ(true_speed_mps(1), 0.0);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Contains("boardFaulty: PILS reports PMOT: does not turn"));
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
}

TEST_F(ModuleFaultScenario, a_failed_reader_is_an_error_that_names_it_and_the_vehicle_drives_on) {
  play("[[at]]\nt_s = 12\nfault = { vehicle = \"AIV1\", kind = \"failed_reader\" }\n");
  world->run_for(3s);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Contains("boardFaulty: PRAV reports RFID: no response"));
  const auto tag = aiv("CoSiVA/AIV1").number("lastTag");
  const double from_m = true_distance_m(1);
  world->run_for(30s);
  EXPECT_EQ(aiv("CoSiVA/AIV1").number("lastTag"), tag) << "no tag is read any more";
  EXPECT_GT(true_distance_m(1), from_m + 3.0);
}

TEST_F(ModuleFaultScenario, a_brown_out_stops_the_vehicle_with_its_boards_lost_and_it_continues_afterwards) {
  play("[[at]]\nt_s = 12\nfault = { vehicle = \"AIV1\", kind = \"brown_out\", for_s = 4 }\n");
  world->run_for(5s);
  EXPECT_EQ(true_speed_mps(1), 0.0);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Contains("boardLost: PILS does not respond"));
  EXPECT_THAT(errors("CoSiVA/AIV1"), Contains("boardLost: RALI does not respond"));
  const double from_m = true_distance_m(1);
  world->run_for(3s);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Contains(HasSubstr("boardRestarted: PILS started anew")));
  world->run_for(20s);
  EXPECT_THAT(errors("CoSiVA/AIV1"), Not(Contains(HasSubstr("boardLost"))));
  EXPECT_GT(true_distance_m(1), from_m + 1.0);
  EXPECT_THAT(world->plant().collisions(), IsEmpty());
}

TEST_F(ModuleFaultScenario, the_page_s_snapshot_has_the_parts_of_pils_and_the_text_on_the_display) {
  play("");
  const JsonValue vehicle = aiv("CoSiVA/AIV1");
  ASSERT_NE(vehicle.find("pils"), nullptr);
  EXPECT_GT(vehicle.find("pils")->number("supply"), 4.5);
  EXPECT_EQ(vehicle.find("pils")->find("dems")->array()->size(), 8U);
  EXPECT_EQ(vehicle.text("affi"), world->plant().vehicles()[0].display);
}

TEST_F(ModuleFaultScenario, a_vehicle_without_rali_drives_and_its_charge_is_unknown) {
  WorldOptions options;
  options.equipment = *physical::read_equipment(2, {}, {"1"});
  play("", std::move(options));
  world->run_for(20s);
  EXPECT_TRUE(aiv("CoSiVA/AIV1").find("battery")->is_null());
  EXPECT_GT(aiv("CoSiVA/AIV2").number("battery"), 50.0);
  EXPECT_GT(true_distance_m(1), 3.0);
  EXPECT_THAT(errors("CoSiVA/AIV1"), IsEmpty());
  const JsonValue boards = *aiv("CoSiVA/AIV1").find("boards");
  EXPECT_EQ(boards.array()->back().text("health"), "absent");
}

}  // namespace
}  // namespace cosiva::experiments
