#include "cosiva/virtual/server/core/command_router.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "cosiva/base/json_parse_count.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;

TEST(CommandTexts, are_parsed_once_and_not_at_all_where_the_sender_has_decoded_them) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  wire::Effects effects;
  for (const std::string json :
       {R"({"command":"stop","vehicle":"CoSiVA/AIV1"})", R"({"command":"dance","vehicle":"*"})",
        R"({"command":"circulate","vehicle":"*"})", R"({"command":"close","section":"east"})",
        R"({"command":"add","virtualObject":{"kind":"person","x":0.5,"y":0.2}})",
        R"({"command":"edit","edit":{"addTags":[{"number":77,"section":"south","s":0.3}]}})", R"({"command":"undo"})",
        R"({"command":"plant","plant":{"addObstacle":{"id":"box","x":0.1,"y":0.1}}})",
        R"({"command":"switch","zone":{"format":"toml","text":"name = 7"}})", R"({"command":"switch"})", "no json"}) {
    wire::Input input{fixture.now, wire::InputKind::command, "test", json};
    std::uint64_t before = json_parse_count();
    fixture.server->handle(input, effects);
    EXPECT_EQ(json_parse_count() - before, 1U) << json;
    const auto decoded = std::make_shared<const DecodedCommand>(json);
    input.typed = decoded;
    before = json_parse_count();
    (void)fixture.server->check_command(*decoded);
    fixture.server->handle(input, effects);
    EXPECT_EQ(json_parse_count(), before) << json;
  }
}

TEST(CommandRouter, sends_the_virtual_obstacles_that_are_due_after_each_command_but_most_refused_ones) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5}).blocked = true;
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":1.5,"y":0.5}})");
  fixture.run_for(1s);
  const auto sends = [&](const std::string& command) {
    fixture.now += 100ms;  // the next message is due
    const std::size_t before = fixture.published_on("cosiva/v1/virtual_obstacles/CoSiVA/AIV1").size();
    fixture.send_command(command);
    const std::size_t after = fixture.published_on("cosiva/v1/virtual_obstacles/CoSiVA/AIV1").size();
    fixture.run_for(20ms);
    return after != before;
  };
  for (const char* command :
       {R"({"command":"slow","vehicle":"CoSiVA/AIV1"})", R"({"command":"dance","vehicle":"*"})", "no json",
        R"({"command":"radio","vehicle":"*","loss":0.5})", R"({"command":"close","section":"north"})",
        R"({"command":"circulate","vehicle":"CoSiVA/AIV1"})", R"({"command":"switch"})",
        R"({"command":"switch","zone":{"format":"toml","origin":"x","text":"name = 7"}})", R"({"command":"undo"})",
        R"({"command":"edit"})"})
    EXPECT_TRUE(sends(command)) << command;
  for (const char* command :
       {R"({"command":"close","section":"nowhere"})", R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"nowhere"})",
        R"({"command":"plant","plant":{}})", R"({"command":"radio","vehicle":"*","loss":2})",
        R"({"command":"remove","id":"P9"})", R"({"command":"remove"})",
        R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":1.0,"y":0.5}})"})
    EXPECT_FALSE(sends(command)) << command;
}

TEST(CommandRouter, logs_a_refused_command_with_the_reason) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"remove","id":"P9"})");
  EXPECT_TRUE(
      fixture.logged("command refused: id: no virtual object is called 'P9'; there is none yet; add one first"));
  fixture.send_command(R"({"command":"remove"})");
  EXPECT_TRUE(fixture.logged("command refused: id: give the id of the virtual object to remove, or * for all"));
  fixture.logs.clear();
  fixture.send_command(R"({"command":"switch","zone":{"format":"toml","origin":"x","text":"name = 7"}})");
  EXPECT_FALSE(fixture.logged("command refused")) << "a refused zone is shown instead";
  EXPECT_TRUE(fixture.logged("zone configuration refused"));
}

TEST(CommandRouter, traces_each_command_from_its_sender) {
  ServerFixture fixture;
  const std::string command = R"({"command":"undo"})";
  fixture.feed(wire::InputKind::command, "", command);
  fixture.feed(wire::InputKind::command, "page", command);
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 1000));
  std::string senders;
  for (const JsonValue& trace : *traces.find("traces")->array()) {
    if (trace.text("kind") != "command") continue;
    senders += *trace.text("from") + ";";
    EXPECT_EQ(trace.text("content"), command);
    EXPECT_EQ(trace.text("to"), "AIV_Server");
  }
  EXPECT_EQ(senders, "operator;page;");
}

TEST(CommandRouter, sends_a_command_again_that_the_vehicle_does_not_acknowledge_until_it_fails) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.deaf_to = {"cancelOrder"};
  fixture.run_for(3s);
  const auto received = [&] {
    return std::ranges::count_if(aiv.actions, [](const wire::InstantActions& message) {
      return message.actions.front().action_type == "cancelOrder";
    });
  };
  fixture.command("cancel", "CoSiVA/AIV1", "c1");
  EXPECT_EQ(received(), 1);
  fixture.run_for(280ms);
  EXPECT_EQ(received(), 1);
  fixture.run_for(20ms);
  EXPECT_EQ(received(), 2);
  fixture.run_for(4680ms);
  EXPECT_EQ(fixture.command_entry("c1").text("state"), "issued");
  fixture.run_for(20ms);
  EXPECT_EQ(fixture.command_entry("c1").text("state"), "failed");
  EXPECT_THAT(*fixture.command_entry("c1").text("reason"), HasSubstr("did not respond within 5 s"));
}

}  // namespace
}  // namespace cosiva::virtual_side
