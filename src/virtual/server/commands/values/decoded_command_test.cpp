#include "cosiva/virtual/server/commands/values/decoded_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/base/json_parse_count.h"

namespace cosiva::virtual_side {
namespace {

using testing::ElementsAre;
using By = DecodedCommand::Fault::By;

template <typename Command>
Command decoded(std::string_view json) {
  const DecodedCommand command{json};
  if (!command.command()) {
    ADD_FAILURE() << to_string(command.command().error().error);
    return {};
  }
  const auto* found = std::get_if<Command>(&*command.command());
  if (found == nullptr) ADD_FAILURE() << "another command: " << json;
  return found == nullptr ? Command{} : *found;
}
DecodedCommand::Fault fault_of(std::string_view json) {
  const DecodedCommand command{json};
  return command.command() ? DecodedCommand::Fault{} : command.command().error();
}

TEST(DecodedCommand, reads_each_text_once) {
  for (const char* json :
       {R"({"command":"stop","vehicle":"*"})", R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"dock"})",
        R"({"command":"add","virtualObject":{"kind":"person","x":1,"y":2}})", R"({"command":"edit","edit":{}})",
        R"({"command":"switch","zone":{"format":"toml","origin":"a","text":"b"}})", R"({"command":"switch"})",
        "no json"}) {
    const std::uint64_t before = json_parse_count();
    const DecodedCommand command{json};
    EXPECT_EQ(json_parse_count() - before, 1U) << json;
  }
}

TEST(DecodedCommand, reads_commands_to_vehicles) {
  const auto limit = decoded<VehicleCommand>(R"({"id":"c1","command":"limit","vehicle":"CoSiVA/AIV1","speed":0.25})");
  EXPECT_EQ(limit.id, "c1");
  EXPECT_EQ(limit.verb, OperatorCommandKind::limit);
  EXPECT_EQ(limit.speed_mps, 0.25);
  EXPECT_FALSE(limit.several);
  const auto all = decoded<VehicleCommand>(R"({"command":"dance","vehicle":"*"})");
  EXPECT_TRUE(all.all());
  EXPECT_FALSE(all.verb) << "the list of commands shows also an unknown one";
  EXPECT_EQ(all.command_text, "dance");
  EXPECT_THAT(decoded<VehicleCommand>(R"({"command":"stop","vehicles":["a/b",7]})").vehicle_names,
              ElementsAre("a/b", ""));
}

TEST(DecodedCommand, names_what_is_missing_and_who_refuses_it) {
  EXPECT_EQ(fault_of("[]").error.code, "command.syntax");
  EXPECT_EQ(fault_of(R"({"vehicle":"*"})").error.code, "command.missing");
  EXPECT_EQ(fault_of(R"({"command":"stop"})").error.code, "command.vehicle");
  EXPECT_EQ(fault_of(R"({"command":"limit","vehicle":"*","speed":9})").error.code, "command.speed");
  EXPECT_EQ(fault_of(R"({"command":"stop"})").by, By::vehicles);
  EXPECT_EQ(fault_of(R"({"command":"remove"})").error.code, "virtual_object.id");
  EXPECT_EQ(fault_of(R"({"command":"add","virtualObject":7})").error.code, "virtual_object.missing");
  EXPECT_EQ(fault_of(R"({"command":"plant"})").error.code, "plant.missing");
  EXPECT_EQ(fault_of(R"({"command":"plant"})").by, By::log);
  EXPECT_EQ(fault_of(R"({"command":"switch"})").error.code, "switch.zone");
  const auto zone = fault_of(R"({"command":"switch","zone":{"origin":"yard.toml"}})");
  EXPECT_EQ(zone.error.code, "zone.configuration");
  EXPECT_EQ(zone.by, By::zone_switch);
  EXPECT_EQ(zone.origin, "yard.toml");
}

TEST(DecodedCommand, refuses_a_command_to_vehicles_that_is_too_long_but_takes_a_long_zone) {
  const std::string text(DecodedCommand::vehicle_command_bytes_max, 'x');
  EXPECT_EQ(fault_of(R"({"command":"stop","vehicle":")" + text + "\"}").error.code, "command.syntax");
  EXPECT_EQ(decoded<SwitchCommand>(R"({"command":"switch","zone":{"format":"toml","text":")" + text + "\"}}").zone.text,
            text);
}

TEST(DecodedCommand, distinguishes_a_field_without_a_number_from_an_absent_one) {
  const auto add = decoded<AddCommand>(
      R"({"command":"add","virtualObject":{"kind":"person","x":null,"radius":null,"s":"far","path":[[1,2],[3],["a",4]]}})");
  EXPECT_TRUE(std::isnan(add.object.x_m.value()));
  EXPECT_FALSE(add.object.y_m);
  EXPECT_FALSE(add.object.radius_m);
  EXPECT_TRUE(std::isnan(add.object.s_m.value()));
  ASSERT_EQ(add.object.path.value().size(), 3U);
  EXPECT_EQ((*add.object.path)[0], (Point2{1.0, 2.0}));
  EXPECT_FALSE((*add.object.path)[1]);
  EXPECT_TRUE(std::isnan((*add.object.path)[2]->x_m));
  const auto ready =
      decoded<BatteryReadyCommand>(R"({"command":"batteryReady","vehicle":"a/b","battery":"x","type":7})");
  EXPECT_FALSE(ready.type_is_text);
}

}  // namespace
}  // namespace cosiva::virtual_side
