#include "cosiva/app/resources/vehicle_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::app {
namespace {

using aiv::ActionCatalogue;
using aiv::ActionType;
using aiv::find_action;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;

ActionCatalogue good(std::string_view text) {
  const auto read = read_vehicle_file(text, "v.toml");
  EXPECT_TRUE(read) << to_string(read.error());
  return read.value_or(ActionCatalogue{});
}
Error bad(std::string_view text) {
  const auto read = read_vehicle_file(text, "v.toml");
  EXPECT_FALSE(read) << text;
  return read ? Error{} : read.error();
}

TEST(VehicleFile, that_is_empty_gives_the_usual_actions) { EXPECT_EQ(good(""), aiv::usual_actions()); }

TEST(VehicleFile, sets_the_times_of_predefined_actions) {
  const ActionCatalogue catalogue = good(R"(
[action.pick]
preparation_s = 0
duration_s = 2.5
[action.startCharging]
preparation_s = 3
)");
  const ActionType* pick = find_action(catalogue, "pick");
  EXPECT_EQ(pick->preparation, SimDuration::zero());
  EXPECT_EQ(pick->duration, milliseconds{2500});
  EXPECT_EQ(pick->effect, aiv::ActionEffect::pick);
  EXPECT_EQ(find_action(catalogue, "startCharging")->preparation, seconds{3});
  EXPECT_EQ(find_action(catalogue, "startCharging")->duration, seconds{0});
  EXPECT_EQ(find_action(catalogue, "waitForTrigger")->duration, std::nullopt);
}

TEST(VehicleFile, declares_actions_of_its_own) {
  const ActionCatalogue catalogue = good(R"(
[action.polish]
duration_s = 8
scopes = ["node", "edge"]
description = "polishes the floor"
[action.beep]
duration_s = 0.2
)");
  const ActionType* polish = find_action(catalogue, "polish");
  ASSERT_NE(polish, nullptr);
  EXPECT_TRUE(polish->at_nodes && polish->on_edges && polish->pausable && !polish->instant);
  EXPECT_EQ(polish->duration, seconds{8});
  EXPECT_EQ(polish->description, "polishes the floor");
  const ActionType* beep = find_action(catalogue, "beep");
  ASSERT_NE(beep, nullptr);
  EXPECT_TRUE(beep->at_nodes && !beep->on_edges);
}

TEST(VehicleFile, has_names_of_load_positions_or_none) {
  EXPECT_THAT(good(R"(load_positions = ["front", "back"])").load_positions, ElementsAre("front", "back"));
  const ActionCatalogue none = good("carries_loads = false");
  EXPECT_THAT(none.load_positions, IsEmpty());
  EXPECT_EQ(find_action(none, "pick"), nullptr);
}

TEST(VehicleFile, that_is_wrong_is_refused_with_line_and_field) {
  EXPECT_EQ(bad("[action.pick]\nduration = 3").location, "v.toml:2: action.pick.duration");
  EXPECT_EQ(bad("[action.pick]\nduration = 3").code, "vehicle.unknown_key");
  EXPECT_EQ(bad("[action.pick]\nduration_s = -1").code, "vehicle.field");
  EXPECT_EQ(bad("[action.pick]\nduration_s = 86401").code, "vehicle.field");
  EXPECT_EQ(bad("[action.pick]\nscopes = [\"edge\"]").code, "vehicle.unknown_key") << "its scopes are the standard's";
  EXPECT_EQ(bad("[action.polish]\nscopes = [\"node\"]").code, "vehicle.missing") << "no duration";
  EXPECT_EQ(bad("[action.polish]\nduration_s = 1\nscopes = [\"floor\"]").code, "vehicle.field");
  EXPECT_EQ(bad("[action.\"two words\"]\nduration_s = 1").code, "vehicle.value");
  EXPECT_EQ(bad("[action.cancelOrder]\nduration_s = 1").message,
            R"("cancelOrder" is an instant action of the vehicle)");
  EXPECT_EQ(bad("load_positions = [\"a\", \"a\"]").message, R"(there are two load positions "a")");
  EXPECT_EQ(bad("load_positions = []").code, "vehicle.field");
  EXPECT_EQ(bad("carries_loads = false\nload_positions = [\"a\"]").code, "vehicle.value");
  EXPECT_EQ(bad("action = 7").code, "vehicle.field");
  EXPECT_EQ(bad("color = 7").code, "vehicle.unknown_key");
  const Error syntax = bad("[action.pick\n");
  EXPECT_EQ(syntax.code, "vehicle.file");
  EXPECT_EQ(syntax.location, "v.toml:1");
  std::string many;
  for (int i = 0; i < 60; ++i) many += "[action.a" + std::to_string(i) + "]\nduration_s = 1\n";
  EXPECT_EQ(bad(many).message, "a vehicle has at most 64 types of action");
  EXPECT_EQ(bad(std::string((1U << 20U) + 1, '\n')).code, "vehicle.file");
  EXPECT_EQ(load_vehicle_file("/no/such/file").error().code, "file.read");
}

}  // namespace
}  // namespace cosiva::app
