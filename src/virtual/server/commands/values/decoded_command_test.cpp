#include "cosiva/virtual/server/commands/values/decoded_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

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
std::optional<OperatorCommandKind> kind_of(const VehicleCommand& command) { return command.kind; }
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

TEST(DecodedCommand, builds_the_zone_of_a_switch_where_the_sender_wants_that) {
  const char* bad = R"({"command":"switch","zone":{"format":"toml","origin":"a","text":"b"}})";
  EXPECT_FALSE(std::get<SwitchCommand>(*DecodedCommand{bad}.command()).built);
  const DecodedCommand built{bad, DecodedCommand::Zone::built};
  const auto& result = std::get<SwitchCommand>(*built.command()).built;
  ASSERT_TRUE(result.has_value());
  EXPECT_FALSE(*result) << "the text is no zone; the core refuses it with this error";
  EXPECT_TRUE(DecodedCommand(R"({"command":"stop","vehicle":"*"})", DecodedCommand::Zone::built).command());
}

TEST(DecodedCommand, reads_why_the_sender_of_a_switch_could_not_build_its_zone) {
  const auto fault = fault_of(
      R"({"command":"switch","refused":{"origin":"a.toml","code":"zone.key","message":"no circuit","location":"a.toml:1"}})");
  EXPECT_EQ(fault.by, By::zone_switch);
  EXPECT_EQ(fault.origin, "a.toml");
  EXPECT_EQ(fault.error, (Error{"zone.key", "no circuit", "a.toml:1"}));
}

TEST(DecodedCommand, reads_the_action_of_a_stop_that_was_published_already) {
  EXPECT_EQ(decoded<VehicleCommand>(R"({"command":"stop","vehicle":"*","actionId":"S1"})").action_id, "S1");
  EXPECT_EQ(decoded<VehicleCommand>(R"({"command":"stop","vehicle":"*"})").action_id, "");
}

TEST(DecodedCommand, reads_commands_to_vehicles) {
  const auto limit = decoded<VehicleCommand>(R"({"id":"c1","command":"limit","vehicle":"CoSiVA/AIV1","speed":0.25})");
  EXPECT_EQ(limit.id, "c1");
  EXPECT_EQ(kind_of(limit), OperatorCommandKind::limit);
  EXPECT_EQ(limit.speed_mps, 0.25);
  EXPECT_FALSE(limit.several);
  const auto all = decoded<VehicleCommand>(R"({"command":"dance","vehicle":"*"})");
  EXPECT_TRUE(all.all());
  EXPECT_FALSE(kind_of(all)) << "the list of commands shows also an unknown one";
  EXPECT_EQ(all.command_text, "dance");
  EXPECT_THAT(decoded<VehicleCommand>(R"({"command":"stop","vehicles":["a/b",7]})").vehicle_names,
              ElementsAre("a/b", ""));
}

TEST(DecodedCommand, has_an_identity_where_a_client_has_chosen_its_id) {
  const auto identity = [](const char* json) { return DecodedCommand{json}.identity(); };
  const char* const close = R"({"id":"mine","once":true,"command":"close","section":"east"})";
  ASSERT_TRUE(identity(close));
  EXPECT_EQ(identity(close)->id, "mine");
  EXPECT_EQ(identity(close), identity(close));
  EXPECT_NE(identity(close), identity(R"({"id":"mine","once":true,"command":"open","section":"east"})"));
  for (const char* none :
       {R"({"id":"mine","command":"close","section":"east"})", R"({"once":true,"command":"close","section":"east"})",
        R"({"id":"","once":true,"command":"open"})", R"({"id":7,"once":true,"command":"open"})",
        R"({"id":"mine","once":"true","command":"open"})", "nonsense"})
    EXPECT_FALSE(identity(none)) << none;
  EXPECT_FALSE(identity((R"({"once":true,"id":")" + std::string(65, 'x') + "\"}").c_str()));
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

TEST(DecodedCommand, to_vehicles_has_one_of_seven_kinds) {
  for (const std::string name : {"stop", "slow", "medium", "fast", "restart", "cancel"}) {
    const auto command = decoded<VehicleCommand>(R"({"command":")" + name + R"(","vehicle":"a/b"})");
    ASSERT_TRUE(kind_of(command).has_value()) << name;
    EXPECT_EQ(to_string(*kind_of(command)), name);
    EXPECT_EQ(command.command_text, name);
    EXPECT_THAT(command.vehicle_names, ElementsAre("a/b"));
  }
}

TEST(DecodedCommand, limits_a_speed_above_zero_and_up_to_five_metres_per_second) {
  const auto limit = [](const std::string& speed) {
    return R"({"command":"limit","vehicle":"*","speed":)" + speed + "}";
  };
  EXPECT_EQ(decoded<VehicleCommand>(limit("5")).speed_mps, 5.0);
  EXPECT_EQ(decoded<VehicleCommand>(limit("0.001")).speed_mps, 0.001);
  for (const char* speed : {"0", "-0.1", "5.001", "\"fast\"", "null"}) {
    EXPECT_EQ(fault_of(limit(speed)).error.code, "command.speed") << speed;
    EXPECT_EQ(fault_of(limit(speed)).error.location, "speed");
  }
}

TEST(DecodedCommand, names_1_to_256_vehicles) {
  const auto stop = [](const std::string& list) { return R"({"command":"stop","vehicles":)" + list + "}"; };
  std::string names = "\"a/0\"";
  for (int i = 1; i < 256; ++i) names += ",\"a/" + std::to_string(i) + "\"";
  const auto command = decoded<VehicleCommand>(stop("[" + names + "]"));
  EXPECT_EQ(command.vehicle_names.size(), 256U);
  EXPECT_TRUE(command.several);
  EXPECT_FALSE(command.all());
  EXPECT_TRUE(decoded<VehicleCommand>(stop("[\"a/0\"]")).several) << "a list of one is a list";
  EXPECT_TRUE(decoded<VehicleCommand>(stop("[\"*\"]")).all());
  for (const std::string& list : {"[" + names + ",\"a/256\"]", std::string("[]"), std::string("\"a/0\"")}) {
    EXPECT_EQ(fault_of(stop(list)).error.code, "command.vehicle");
    EXPECT_EQ(fault_of(stop(list)).error.location, "vehicles");
  }
  EXPECT_EQ(fault_of(stop("null")).error.location, "vehicle") << "null counts as left out";
}

TEST(DecodedCommand, cuts_names_after_80_bytes) {
  const std::string long_name(100, 'n');
  const auto command = decoded<VehicleCommand>(R"({"id":")" + long_name + R"(","command":")" + long_name +
                                               R"(","vehicle":")" + long_name + "\"}");
  EXPECT_EQ(command.id, std::string(80, 'n'));
  EXPECT_EQ(command.command_text, std::string(80, 'n'));
  EXPECT_THAT(command.vehicle_names, ElementsAre(std::string(80, 'n')));
}

TEST(DecodedCommand, may_be_as_long_as_64_KiB_to_vehicles) {
  const std::string begin = R"({"command":"stop","vehicle":"a/b","id":")";
  const std::string end = "\"}";
  const std::size_t rest = 65536 - begin.size() - end.size();
  EXPECT_EQ(kind_of(decoded<VehicleCommand>(begin + std::string(rest, 'x') + end)), OperatorCommandKind::stop);
  EXPECT_EQ(fault_of(begin + std::string(rest + 1, 'x') + end).error.code, "command.syntax");
}

TEST(DecodedCommand, reads_missions) {
  const auto go = decoded<MissionCommand>(R"({"command":"go","vehicle":"a/b","to":"dock","loop":"outer"})");
  EXPECT_TRUE(go.goes);
  EXPECT_EQ(go.name, "dock");
  EXPECT_THAT(go.vehicle_names, ElementsAre("a/b"));
  const auto circulate =
      decoded<MissionCommand>(R"({"command":"circulate","vehicles":["a/b",7,"c/d"],"to":"dock","loop":"outer"})");
  EXPECT_FALSE(circulate.goes);
  EXPECT_EQ(circulate.name, "outer");
  EXPECT_THAT(circulate.vehicle_names, ElementsAre("a/b", "", "c/d"));
  const auto nothing = decoded<MissionCommand>(R"({"command":"go","vehicles":"a/b"})");
  EXPECT_EQ(nothing.name, "");
  EXPECT_THAT(nothing.vehicle_names, ElementsAre("")) << "no list";
}

TEST(DecodedCommand, reads_sections_to_close_and_to_open) {
  const auto close = decoded<SectionCommand>(R"({"command":"close","section":"east"})");
  EXPECT_TRUE(close.closes);
  EXPECT_EQ(close.section, "east");
  const auto open = decoded<SectionCommand>(R"({"command":"open"})");
  EXPECT_FALSE(open.closes);
  EXPECT_EQ(open.section, "");
}

TEST(DecodedCommand, reads_edits_with_their_changes) {
  using Kind = EditCommand::Kind;
  const auto edit = decoded<EditCommand>(R"({"command":"edit","edit":{"closed":["east"]}})");
  EXPECT_EQ(edit.kind, Kind::edit);
  EXPECT_NE(edit.changes.find("closed"), nullptr);
  EXPECT_TRUE(decoded<EditCommand>(R"({"command":"edit"})").changes.is_null());
  EXPECT_EQ(decoded<EditCommand>(R"({"command":"undo"})").kind, Kind::undo);
  EXPECT_EQ(decoded<EditCommand>(R"({"command":"redo"})").kind, Kind::redo);
  EXPECT_EQ(decoded<EditCommand>(R"({"command":"saved"})").kind, Kind::saved);
}

TEST(DecodedCommand, reads_the_fields_of_virtual_objects) {
  const auto add = decoded<AddCommand>(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"east",)"
                                       R"("s":0.5,"x":1,"y":2,"radius":0.3,"speed":0.4,"repeat":"loop"}})")
                       .object;
  EXPECT_EQ(add.id, "V1");
  EXPECT_EQ(add.kind, "aiv");
  EXPECT_EQ(add.section, "east");
  EXPECT_TRUE(add.section_is_text);
  EXPECT_EQ(add.s_m, 0.5);
  EXPECT_EQ(add.x_m, 1.0);
  EXPECT_EQ(add.y_m, 2.0);
  EXPECT_EQ(add.radius_m, 0.3);
  EXPECT_EQ(add.speed_mps, 0.4);
  EXPECT_EQ(add.repeat, "loop");
  EXPECT_FALSE(add.path.has_value());
  const auto empty = decoded<AddCommand>(R"({"command":"add","virtualObject":{"id":7,"section":7,"path":3,"s":null}})");
  EXPECT_EQ(empty.object.id, "") << "it is no text";
  EXPECT_EQ(empty.object.section, "");
  EXPECT_FALSE(empty.object.section_is_text);
  EXPECT_FALSE(empty.object.s_m.has_value());
  ASSERT_TRUE(empty.object.path.has_value());
  EXPECT_TRUE(empty.object.path->empty());
  const auto null = decoded<AddCommand>(R"({"command":"add","virtualObject":{"id":null,"section":null,"path":null}})");
  EXPECT_FALSE(null.object.id.has_value());
  EXPECT_FALSE(null.object.section.has_value());
  EXPECT_TRUE(null.object.section_is_text);
  EXPECT_FALSE(null.object.path.has_value());
  const auto move = decoded<MoveCommand>(R"({"command":"move","virtualObject":{"id":"P1","path":[[1,2],[3,4,5]]}})");
  EXPECT_EQ(move.object.id, "P1");
  ASSERT_EQ(move.object.path->size(), 2U);
  EXPECT_FALSE((*move.object.path)[1].has_value()) << "not a pair";
  EXPECT_FALSE(decoded<MoveCommand>(R"({"command":"move","virtualObject":{"id":7}})").object.id.has_value());
  EXPECT_EQ(decoded<RemoveCommand>(R"({"command":"remove","id":"P1"})").id, "P1");
}

TEST(DecodedCommand, reads_commands_to_the_emulated_world) {
  using Act = PlantCommand::Act;
  const auto add = decoded<PlantCommand>(
      R"({"command":"plant","plant":{"addObstacle":{"id":"box","x":0.5,"y":null,"radius":0.1}}})");
  EXPECT_EQ(add.act, Act::add);
  EXPECT_EQ(add.id, "box");
  EXPECT_EQ(add.x_m, 0.5);
  EXPECT_TRUE(std::isnan(add.y_m.value()));
  EXPECT_EQ(add.radius_m, 0.1);
  const auto remove = decoded<PlantCommand>(R"({"command":"plant","plant":{"removeObstacle":"box","addObstacle":{}}})");
  EXPECT_EQ(remove.act, Act::remove);
  EXPECT_EQ(remove.id, "box");
  EXPECT_FALSE(decoded<PlantCommand>(R"({"command":"plant","plant":{"removeObstacle":7}})").id.has_value());
  EXPECT_EQ(decoded<PlantCommand>(R"({"command":"plant","plant":{"addObstacle":7}})").act, Act::none);
  EXPECT_EQ(decoded<PlantCommand>(R"({"command":"plant","plant":{}})").act, Act::none);
  const auto unit = decoded<PlantCommand>(R"({"command":"plant","plant":{"setUnit":{"crossing":"X1","on":false}}})");
  EXPECT_EQ(unit.act, Act::unit);
  EXPECT_EQ(unit.unit.crossing, "X1");
  EXPECT_EQ(unit.unit.on, false);
  EXPECT_FALSE(decoded<PlantCommand>(R"({"command":"plant","plant":{"setUnit":{}}})").unit.on.has_value());
  const auto radio = decoded<RadioCommand>(R"({"command":"radio","vehicle":"*","loss":0.25})");
  EXPECT_EQ(radio.vehicle, "*");
  EXPECT_EQ(radio.loss_ratio, 0.25);
  EXPECT_EQ(decoded<RadioCommand>(R"({"command":"radio"})").loss_ratio, -1.0) << "none stated";
}

TEST(DecodedCommand, reads_that_a_battery_is_ready) {
  const auto ready =
      decoded<BatteryReadyCommand>(R"({"command":"batteryReady","vehicle":"a/b","battery":"LiFe-3","type":"LiFePO4",)"
                                   R"("cycles":12,"rest_s":600,"temperature":21.5,"charge":98})");
  EXPECT_EQ(ready.vehicle, "a/b");
  EXPECT_EQ(ready.battery, "LiFe-3");
  EXPECT_EQ(ready.type, "LiFePO4");
  EXPECT_TRUE(ready.type_is_text);
  EXPECT_EQ(ready.cycles, 12.0);
  EXPECT_EQ(ready.rest_s, 600.0);
  EXPECT_EQ(ready.temperature_c, 21.5);
  EXPECT_EQ(ready.charge_percent, 98.0);
  const auto unknown = decoded<BatteryReadyCommand>(R"({"command":"batteryReady","type":null})");
  EXPECT_FALSE(unknown.type.has_value());
  EXPECT_TRUE(unknown.type_is_text);
  EXPECT_FALSE(unknown.cycles.has_value());
}

TEST(DecodedCommand, states_what_a_command_is_and_why_a_text_is_none) {
  const std::string expected = R"(a command is a JSON object like {"command":"stop","vehicle":"*"})";
  EXPECT_EQ(fault_of("[]").error.message, expected) << "JSON, but no object";
  EXPECT_EQ(fault_of("7").error.message, expected);
  EXPECT_THAT(fault_of("no json").error.message, testing::StartsWith(expected + "; this is none: "));
  EXPECT_EQ(fault_of("no json").by, By::vehicles);
  EXPECT_EQ(fault_of(R"({"command":7,"vehicle":"*"})").error.code, "command.missing");
  EXPECT_EQ(fault_of(R"({"command":"stop","vehicle":7})").error.location, "vehicle");
}

TEST(DecodedCommand, cuts_each_name_of_a_list_after_80_bytes) {
  const std::string limit(80, 'n');
  const auto command =
      decoded<VehicleCommand>(R"({"command":"stop","vehicles":[")" + limit + "\",\"" + limit + "x\"]}");
  EXPECT_THAT(command.vehicle_names, ElementsAre(limit, limit));
}

TEST(DecodedCommand, to_all_has_one_star_alone) {
  EXPECT_FALSE(decoded<VehicleCommand>(R"({"command":"stop","vehicle":"a/b"})").all());
  EXPECT_FALSE(decoded<VehicleCommand>(R"({"command":"stop","vehicle":"**"})").several);
  EXPECT_TRUE(decoded<VehicleCommand>(R"({"command":"stop","vehicle":"*"})").several);
}

TEST(DecodedCommand, has_a_speed_only_where_it_limits) {
  EXPECT_EQ(decoded<VehicleCommand>(R"({"command":"slow","vehicle":"*","speed":0.25})").speed_mps, 0.0);
  EXPECT_EQ(decoded<VehicleCommand>(R"({"command":"dance","vehicle":"*","speed":9})").speed_mps, 0.0);
  EXPECT_EQ(fault_of(R"({"command":"limit","vehicle":"*"})").error.code, "command.speed");
}

TEST(DecodedCommand, that_a_battery_is_ready_distinguishes_wrong_numbers_from_absent_ones) {
  const auto wrong = decoded<BatteryReadyCommand>(
      R"({"command":"batteryReady","cycles":"many","rest_s":[],"temperature":true,"charge":{}})");
  EXPECT_EQ(wrong.vehicle, "");
  EXPECT_EQ(wrong.battery, "");
  for (const OptionalNumber& number : {wrong.cycles, wrong.rest_s, wrong.temperature_c, wrong.charge_percent})
    EXPECT_TRUE(std::isnan(number.value_or(0.0)));
  const auto absent = decoded<BatteryReadyCommand>(
      R"({"command":"batteryReady","cycles":null,"rest_s":null,"temperature":null,"charge":null})");
  for (const OptionalNumber& number : {absent.cycles, absent.rest_s, absent.temperature_c, absent.charge_percent})
    EXPECT_FALSE(number.has_value());
}

TEST(DecodedCommand, to_the_emulated_world_has_a_radius_that_may_be_left_out) {
  const auto add =
      decoded<PlantCommand>(R"({"command":"plant","plant":{"addObstacle":{"x":null,"radius":null,"id":7}}})");
  EXPECT_EQ(add.act, PlantCommand::Act::add);
  EXPECT_FALSE(add.id.has_value()) << "no text";
  EXPECT_TRUE(add.x_m.has_value());
  EXPECT_FALSE(add.y_m.has_value());
  EXPECT_FALSE(add.radius_m.has_value());
  EXPECT_EQ(decoded<RadioCommand>(R"({"command":"radio","loss":"all"})").loss_ratio, -1.0);
}

TEST(DecodedCommand, to_switch_states_the_origin_of_the_refused_zone_where_there_is_one) {
  EXPECT_EQ(fault_of(R"({"command":"switch"})").by, By::zone_switch);
  EXPECT_EQ(fault_of(R"({"command":"switch"})").origin, "");
  EXPECT_EQ(fault_of(R"({"command":"switch","zone":{}})").origin, "");
  EXPECT_EQ(fault_of(R"({"command":"switch","zone":{}})").by, By::zone_switch);
  const auto stated = decoded<SwitchCommand>(
                          R"({"command":"switch","zone":{"format":"toml","origin":"a.toml","text":"b","sidecar":"c"}})")
                          .zone;
  EXPECT_EQ(stated, (zone::ZoneConfiguration{"toml", "a.toml", "b", "c"}));
}

}  // namespace
}  // namespace cosiva::virtual_side
