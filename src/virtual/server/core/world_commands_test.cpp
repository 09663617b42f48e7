#include "cosiva/virtual/server/core/world_commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::SizeIs;

class World : public testing::Test {
 protected:
  [[nodiscard]] static std::string add(const std::string& id, const std::string& more = "") {
    return R"({"command":"plant","plant":{"addObstacle":{"id":")" + id + R"(","x":0.5,"y":0.25)" + more + "}}}";
  }
  [[nodiscard]] static std::string remove(const std::string& id) {
    return R"({"command":"plant","plant":{"removeObstacle":")" + id + "\"}}";
  }
  [[nodiscard]] static std::string radio(const std::string& vehicle, const std::string& loss) {
    return R"({"command":"radio","vehicle":")" + vehicle + R"(","loss":)" + loss + "}";
  }
  ServerFixture fixture;
};

TEST_F(World, obstacle_has_a_radius_from_two_centimetres_to_a_metre) {
  const std::string refused = "radius: give a radius from 0.02 m to 1 m";
  EXPECT_EQ(fixture.refusal(add("box", R"(,"radius":0.02)")), "");
  EXPECT_EQ(fixture.refusal(add("box", R"(,"radius":0.0199)")), refused);
  EXPECT_EQ(fixture.refusal(add("box", R"(,"radius":1.0)")), "");
  EXPECT_EQ(fixture.refusal(add("box", R"(,"radius":1.001)")), refused);
  EXPECT_EQ(fixture.refusal(add("box", R"(,"radius":"wide")")), refused);
}

TEST_F(World, obstacle_has_a_name_of_one_to_64_bytes) {
  const std::string refused = "id: give the obstacle a name of 1 to 64 bytes, as \"id\"";
  EXPECT_EQ(fixture.refusal(add(std::string(64, 'a'))), "");
  EXPECT_EQ(fixture.refusal(add(std::string(65, 'a'))), refused);
  EXPECT_EQ(fixture.refusal(add("")), refused);
  EXPECT_EQ(fixture.refusal(remove(std::string(64, 'a'))), "");
  EXPECT_EQ(fixture.refusal(remove(std::string(65, 'a'))), refused);
  EXPECT_EQ(fixture.refusal(remove("")), refused);
  EXPECT_THAT(fixture.refusal(R"({"command":"plant","plant":{}})"), HasSubstr("state what to do"));
}

TEST_F(World, obstacle_is_as_wide_as_a_vehicle_where_no_radius_is_stated) {
  fixture.send_command(add("box"));
  fixture.send_command(add("pole", R"(,"radius":0.04)"));
  fixture.send_command(remove("box"));
  const auto sent = fixture.published_on(wire::plant_command_topic);
  ASSERT_THAT(sent, SizeIs(3));
  const JsonValue box = *JsonValue::parse(sent[0].payload);
  EXPECT_EQ(box.find("addObstacle")->text("id"), "box");
  EXPECT_EQ(box.find("addObstacle")->number("x"), 0.5);
  EXPECT_EQ(box.find("addObstacle")->number("y"), 0.25);
  EXPECT_EQ(box.find("addObstacle")->number("radius"), 0.06);
  EXPECT_EQ(JsonValue::parse(sent[1].payload)->find("addObstacle")->number("radius"), 0.04);
  EXPECT_EQ(JsonValue::parse(sent[2].payload)->text("removeObstacle"), "box");
  EXPECT_EQ(sent[0].qos, 1);
  EXPECT_FALSE(sent[0].retained);
}

TEST_F(World, radio_loses_a_ratio_of_the_messages_of_a_known_vehicle_or_of_all) {
  fixture.add("AIV1", {0, 0.5});
  const std::string refused = "loss: give the ratio of lost messages, from 0 to 1";
  EXPECT_EQ(fixture.refusal(radio("CoSiVA/AIV1", "0")), "");
  EXPECT_EQ(fixture.refusal(radio("*", "1")), "");
  EXPECT_EQ(fixture.refusal(radio("*", "-0.001")), refused);
  EXPECT_EQ(fixture.refusal(radio("*", "1.001")), refused);
  EXPECT_EQ(fixture.refusal(R"({"command":"radio","vehicle":"*"})"), refused);
  EXPECT_EQ(fixture.refusal(radio("CoSiVA/AIV2", "0.5")),
            "vehicle: no vehicle 'CoSiVA/AIV2' is known; name it as manufacturer/serial number, or * for all");
  fixture.send_command(radio("*", "0.5"));
  const auto sent = fixture.published_on(wire::plant_radio_topic);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(JsonValue::parse(sent[0].payload)->number("loss"), 0.5);
}

TEST_F(World, fault_is_sent_with_the_number_of_its_vehicle) {
  fixture.add("AIV1", {0, 0.5});
  const auto fault = [](const std::string& rest) {
    return R"({"command":"plant","plant":{"setFault":{)" + rest + "}}}";
  };
  EXPECT_EQ(fixture.refusal(fault(R"("vehicle":"CoSiVA/AIV1","fault":"stuck_sensor","sensor":3,"for_s":5)")), "");
  fixture.send_command(fault(R"("vehicle":"CoSiVA/AIV1","fault":"stuck_sensor","sensor":3,"for_s":5)"));
  const auto sent = fixture.published_on(wire::plant_command_topic);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0].payload, R"({"setFault":{"vehicle":1,"fault":"stuck_sensor","for_s":5,"sensor":3}})");
  EXPECT_THAT(fixture.refusal(fault(R"("vehicle":"CoSiVA/AIV7","fault":"none")")), HasSubstr("is no vehicle of the"));
  EXPECT_THAT(fixture.refusal(fault(R"("vehicle":"CoSiVA/AIV1","fault":"flat_tyre")")), HasSubstr("give the fault: "));
  EXPECT_THAT(fixture.refusal(fault(R"("vehicle":"CoSiVA/AIV1","fault":"dead_motor","for_s":"long")")),
              HasSubstr("for_s: give a number"));
}

TEST(WorldCommands, switch_the_unit_of_a_crossing_of_the_zone) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  const auto unit = [](const std::string& rest) { return R"({"command":"plant","plant":{"setUnit":{)" + rest + "}}}"; };
  fixture.send_command(unit(R"("crossing":"X1","on":false)"));
  const auto sent = fixture.published_on(wire::plant_unit_topic);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0].payload, R"({"crossing":"X1","on":false})");
  EXPECT_THAT(fixture.refusal(unit(R"("crossing":"X99","on":true)")), HasSubstr("no crossing 'X99'"));
  EXPECT_THAT(fixture.refusal(unit(R"("crossing":"X1")")), HasSubstr("true or false"));
}

TEST(WorldCommands, are_refused_while_there_is_no_zone) {
  const ServerCore server{ServerOptions{}};
  const auto checked = server.check_command(DecodedCommand{R"({"command":"plant","plant":{"removeObstacle":"box"}})"});
  ASSERT_FALSE(checked.has_value());
  EXPECT_EQ(checked.error().code, "plant.zone");
}

TEST_F(World, radio_command_is_sent_once_and_names_its_vehicle) {
  fixture.add("AIV1", {0, 0.5});
  fixture.send_command(radio("CoSiVA/AIV1", "0.25"));
  const auto sent = fixture.published_on(wire::plant_radio_topic);
  ASSERT_THAT(sent, SizeIs(1));
  EXPECT_EQ(sent[0].payload, R"({"vehicle":"CoSiVA/AIV1","loss":0.25})");
  EXPECT_EQ(sent[0].qos, 1);
  EXPECT_FALSE(sent[0].retained);
}

TEST_F(World, radio_command_for_a_long_name_is_refused_with_its_first_eighty_bytes) {
  EXPECT_EQ(fixture.refusal(radio(std::string(90, 'x'), "0.5")),
            "vehicle: no vehicle '" + std::string(80, 'x') +
                "' is known; name it as manufacturer/serial number, or * for all");
}

TEST_F(World, commands_are_traced_with_their_content) {
  fixture.send_command(remove("box"));
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 1000));
  const JsonValue& trace = traces.find("traces")->array()->back();
  EXPECT_EQ(trace.text("from"), "AIV_Server");
  EXPECT_EQ(trace.text("to"), "emulated world");
  EXPECT_EQ(trace.text("kind"), "plant");
  EXPECT_EQ(trace.text("content"), R"({"removeObstacle":"box"})");
}

}  // namespace
}  // namespace cosiva::virtual_side
