// Scenarios played over the whole platform in virtual time: the promises of the shipped scenarios, and the times of
// steps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string file_text(const std::string& below_root) {
  std::ifstream file{source_dir() + "/" + below_root};
  EXPECT_TRUE(file) << below_root;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Scenario scenario_of(const std::string& text, const std::string& origin = "test.toml") {
  auto scenario = scenario_from_toml(text, origin);
  EXPECT_TRUE(scenario) << (scenario ? "" : to_string(scenario.error()));
  return scenario ? std::move(*scenario) : Scenario{};
}

/// A world that plays a scenario, and records each step with its time since the beginning.
struct Stage {
  explicit Stage(const Scenario& s) : scenario{s} {
    WorldOptions options;
    options.zone = {"toml", "zones/" + s.zone + ".toml", file_text("zones/" + s.zone + ".toml")};
    options.aivs = s.aivs;
    options.seed = s.seed;
    auto made = World::make(std::move(options));
    EXPECT_TRUE(made) << (made ? "" : to_string(made.error()));
    world = std::move(*made);
    world->play(s);
    world->tap([this](SimTime, const std::string&, const wire::Publish& message) {
      if (!message.topic.starts_with(wire::virtual_obstacles_ack_topic_prefix)) return;
      const auto perceived = wire::virtual_obstacles_ack_from_json(message.payload);
      if (perceived && perceived->braking) braked_for.insert(perceived->body);
    });
    world->on_step([this](SimTime at, const Scenario::Step& step) {
      played.push_back(step.what);
      times.push_back(at - world->scenario_began().value());
    });
  }
  [[nodiscard]] JsonValue snapshot() const { return *JsonValue::parse(world->server().snapshot_json()); }
  /// The position of each AIV, including virtual ones, by id.
  [[nodiscard]] std::map<std::string, Point2> positions() const {
    std::map<std::string, Point2> all;
    const JsonValue shown = snapshot();
    for (const JsonValue& aiv : *shown.find("aivs")->array())
      all[*aiv.text("id")] = {aiv.number("x").value_or(0.0), aiv.number("y").value_or(0.0)};
    return all;
  }
  [[nodiscard]] std::vector<std::string> refused() const {
    std::vector<std::string> lines;
    for (const std::string& line : world->log()) {
      if (line.find("refused") != std::string::npos) lines.push_back(line);
    }
    return lines;
  }

  Scenario scenario;
  std::unique_ptr<World> world;
  std::vector<std::string> played;
  std::vector<SimDuration> times;
  std::multiset<std::string> braked_for;  ///< virtual objects that vehicles reported braking for
};

/// Plays a shipped scenario for its length; at the end all vehicles have moved, without collisions and refused
/// commands.
std::unique_ptr<Stage> play_shipped(const std::string& name, SimDuration length) {
  auto stage = std::make_unique<Stage>(scenario_of(file_text("scenarios/" + name + ".toml"), name + ".toml"));
  stage->world->run_for(length - 30s);
  const auto before = stage->positions();
  std::map<std::string, double> moved_m;
  for (int i = 0; i < 30; ++i) {
    stage->world->run_for(1s);
    for (const auto& [id, position] : stage->positions())
      moved_m[id] = std::max(moved_m[id], distance(position, before.contains(id) ? before.at(id) : position));
  }
  EXPECT_TRUE(stage->world->scenario_done());
  EXPECT_EQ(stage->played.size(), stage->scenario.steps.size());
  EXPECT_THAT(stage->refused(), IsEmpty());
  EXPECT_THAT(stage->world->plant().collisions(), IsEmpty());
  for (const auto& [id, metres] : moved_m) EXPECT_GT(metres, 0.5) << id << " stopped moving";
  return stage;
}

JsonValue metrics_of(const World& world) {
  JsonWriter json;
  world.server().write_bijection(json);
  return *JsonValue::parse(json.text());
}

TEST(WorldScenario, showroom_runs_without_incidents_and_vehicles_brake_for_virtual_persons) {
  const auto stage = play_shipped("showroom", 120s);
  EXPECT_EQ(stage->positions().size(), 5U) << "four AIVs and a virtual one";
  for (const char* person : {"P1", "P2"}) EXPECT_GE(stage->braked_for.count(person), 3U) << person;
  for (const auto& vehicle : stage->world->plant().vehicles()) EXPECT_GE(vehicle.laps, 1U) << "AIV" << vehicle.number;
}

TEST(WorldScenario, laboratory_shows_the_obstacle_while_present_and_its_radio_recovers) {
  const Scenario scenario = scenario_of(file_text("scenarios/laboratory.toml"));
  {
    Stage stage{scenario};
    stage.world->run_for(39s);
    const JsonValue shown = stage.snapshot();
    ASSERT_EQ(shown.find("obstacles")->array()->size(), 1U) << "the box has been detected by now";
    const JsonValue& box = shown.find("obstacles")->array()->at(0);
    EXPECT_LT(distance(Point2{*box.number("x"), *box.number("y")}, Point2{-1.068, 1.259}), 0.1);
  }
  const auto stage = play_shipped("laboratory", from_seconds(*scenario.duration_s + 3.0));
  EXPECT_THAT(*stage->snapshot().find("obstacles")->array(), IsEmpty());
  EXPECT_GT(stage->world->network().counters().lost, 0U);
  EXPECT_EQ(metrics_of(*stage->world).number("matched"), 4.0);
}

TEST(WorldScenario, rush_hour_flows_again_after_all_vehicles_were_stopped) {
  const auto stage = play_shipped("rush_hour", 183s);
  EXPECT_EQ(stage->positions().size(), 11U);
  EXPECT_THAT(*stage->snapshot().find("virtualObjects")->array(), IsEmpty()) << "all virtual objects have been removed";
}

// --- times of steps
// --------------------------------------------------------------------------------------------------

const std::string three_steps =
    "name = \"t\"\naivs = 1\n[[at]]\nt_s = 0\ncommand = \"slow\"\nvehicle = \"*\"\n[[at]]\nt_s = 1.234\ncommand = "
    "\"medium\"\nvehicle = \"*\"\n[[at]]\nt_s = 3\ncommand = \"fast\"\nvehicle = \"*\"\n";

TEST(WorldScenario, steps_are_played_to_the_nanosecond_however_the_run_is_divided) {
  std::vector<std::string> digests;
  for (const auto piece : {10ms, 333ms, 10'000ms}) {
    Stage stage{scenario_of(three_steps)};
    for (SimDuration done{}; done < 10s; done += piece) stage.world->run_for(std::min<SimDuration>(piece, 10s - done));
    EXPECT_THAT(stage.times, ElementsAre(0s, 1234ms, 3s));
    EXPECT_TRUE(stage.world->scenario_done());
    digests.push_back(stage.world->digest().hex());
  }
  EXPECT_THAT(digests, ElementsAre(digests[0], digests[0], digests[0]));
}

TEST(WorldScenario, begins_only_when_the_fleet_is_complete) {
  Stage stage{scenario_of(three_steps)};
  stage.world->kill_server();
  stage.world->run_for(5s);
  EXPECT_FALSE(stage.world->scenario_began());
  EXPECT_THAT(stage.played, IsEmpty());
  stage.world->start_server();
  stage.world->run_for(10s);
  EXPECT_TRUE(stage.world->scenario_began());
  EXPECT_EQ(stage.played.size(), 3U);
}

TEST(WorldScenario, steps_due_while_the_server_is_down_are_played_when_it_is_back) {
  Stage stage{scenario_of(three_steps)};
  while (!stage.world->scenario_began()) stage.world->run_for(100ms);
  stage.world->run_for(2s);
  EXPECT_EQ(stage.played.size(), 2U);
  stage.world->kill_server();
  stage.world->run_for(5s);
  EXPECT_EQ(stage.played.size(), 2U);
  stage.world->start_server();
  stage.world->run_for(5s);
  EXPECT_EQ(stage.played.size(), 3U) << "earlier steps are not repeated";
  EXPECT_GT(stage.times.back(), 7s);
}

TEST(WorldScenario, a_run_without_a_scenario_does_not_wait) {
  Stage stage{scenario_of("name = \"t\"\naivs = 1\n")};
  stage.world->run_for(3s);
  EXPECT_TRUE(stage.world->scenario_done());
  EXPECT_TRUE(stage.refused().empty());
}

// --- the ether
// --------------------------------------------------------------------------------------------------------

TEST(WorldRadio, a_vehicle_with_complete_message_loss_stops_and_continues_afterwards) {
  Stage stage{
      scenario_of("name = \"t\"\naivs = 1\n[[at]]\nt_s = 8\nradio = { vehicle = \"AIV1\", loss = 1, for_s = 4 }\n")};
  while (!stage.world->scenario_began()) stage.world->run_for(100ms);
  stage.world->run_for(8s);
  EXPECT_GT(stage.world->plant().vehicles()[0].speed_mps, 0.1);
  stage.world->run_for(2s);
  EXPECT_NEAR(stage.world->plant().vehicles()[0].speed_mps, 0.0, 1e-3) << "no heartbeat for 500 ms";
  EXPECT_TRUE(*stage.snapshot().find("aivs")->array()->at(0).find("lost")->flag());
  const double stopped_at = stage.world->plant().vehicles()[0].distance_m;
  stage.world->run_for(8s);
  EXPECT_GT(stage.world->plant().vehicles()[0].distance_m, stopped_at + 0.5);
  EXPECT_FALSE(*stage.snapshot().find("aivs")->array()->at(0).find("lost")->flag());
}

TEST(WorldRadio, the_ether_around_a_vehicle_outlives_its_program) {
  Stage stage{scenario_of("name = \"t\"\naivs = 1\n[[at]]\nt_s = 2\nradio = { vehicle = \"*\", loss = 1 }\n")};
  while (!stage.world->scenario_done()) stage.world->run_for(100ms);
  stage.world->kill_aiv(1);
  stage.world->start_aiv(1);
  stage.world->run_for(3s);
  EXPECT_TRUE(*stage.snapshot().find("aivs")->array()->at(0).find("lost")->flag());
}

TEST(WorldRadio, messages_of_unknown_senders_about_the_ether_are_used_unless_invalid) {
  Stage stage{scenario_of("name = \"t\"\naivs = 1\n")};
  stage.world->run_for(3s);
  stage.world->faults().publish_from_outside({"cosiva/v1/plant/radio", "nonsense", 0, false});
  stage.world->faults().publish_from_outside(
      {"cosiva/v1/plant/radio", R"({"vehicle":"CoSiVA/AIV1","loss":7})", 0, false});
  stage.world->run_for(3s);
  EXPECT_EQ(stage.world->network().counters().lost, 0U);
  stage.world->faults().publish_from_outside(
      {"cosiva/v1/plant/radio", R"({"vehicle":"CoSiVA/AIV1","loss":0.5})", 0, false});
  stage.world->run_for(3s);
  EXPECT_GT(stage.world->network().counters().lost, 10U);
}

}  // namespace
}  // namespace cosiva::experiments
