#include "cosiva/virtual/server/zones/zone_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string edit(const std::string& what) { return R"({"command":"edit","edit":{)" + what + "}}"; }
const std::string tag_5 = R"("addTags":[{"number":5,"section":"south","s":1.0}])";

std::vector<double> tags(const ServerFixture& fixture) {
  const JsonValue zone = *JsonValue::parse(fixture.server->zone_json());
  std::vector<double> numbers;
  if (const JsonValue* list = zone.find("tags"))
    for (const JsonValue& tag : *list->array()) numbers.push_back(*tag.number("number"));
  return numbers;
}
JsonValue edits(const ServerFixture& fixture) { return *fixture.snapshot().find("zoneEdits"); }
std::size_t published_zones(const ServerFixture& fixture) { return fixture.published_on("cosiva/v1/zone/toml").size(); }

TEST(ZoneEdits, are_in_force_at_once_and_published_retained_and_their_echo_changes_nothing) {
  ServerFixture fixture;
  fixture.run_for(100ms);
  ASSERT_EQ(fixture.server->zone_revision(), 1U);
  fixture.send_command(edit(tag_5));
  EXPECT_EQ(fixture.server->zone_revision(), 2U);
  EXPECT_THAT(tags(fixture), testing::ElementsAre(5.0));
  const auto zones = fixture.published_on("cosiva/v1/zone/toml");
  ASSERT_THAT(zones, SizeIs(2)) << "the first one at startup";
  EXPECT_TRUE(zones[1].retained);
  EXPECT_EQ(zones[1].payload, fixture.server->zone_configuration()->text);
  EXPECT_EQ(*edits(fixture).number("undo"), 1.0);
  EXPECT_EQ(edits(fixture).flag("unsaved"), true);
}

TEST(ZoneEdits, are_undone_and_redone) {
  ServerFixture fixture;
  const std::string original = fixture.server->zone_configuration()->text;
  fixture.send_command(edit(tag_5));
  const std::string edited = fixture.server->zone_configuration()->text;
  fixture.send_command(R"({"command":"undo"})");
  EXPECT_EQ(fixture.server->zone_configuration()->text, original);
  EXPECT_EQ(fixture.server->zone_revision(), 3U);
  EXPECT_EQ(edits(fixture).flag("unsaved"), false);
  EXPECT_THAT(fixture.refusal(R"({"command":"undo"})"), HasSubstr("nothing to undo"));
  fixture.send_command(R"({"command":"redo"})");
  EXPECT_EQ(fixture.server->zone_configuration()->text, edited);
  EXPECT_THAT(fixture.refusal(R"({"command":"redo"})"), HasSubstr("nothing"));
  fixture.send_command(R"({"command":"undo"})");
  fixture.send_command(edit(R"("addTags":[{"number":6,"section":"north","s":1.0}])"));
  EXPECT_THAT(fixture.refusal(R"({"command":"redo"})"), HasSubstr("nothing")) << "a new edit discards the undone ones";
}

TEST(ZoneEdits, are_undone_up_to_fifty_steps) {
  ServerFixture fixture;
  for (int i = 1; i <= 60; ++i)
    fixture.send_command(edit(R"("addTags":[{"number":)" + std::to_string(i) + R"(,"section":"south","s":)" +
                              std::to_string(0.03 * i) + "}]"));
  EXPECT_EQ(*edits(fixture).number("undo"), 50.0);
  for (int i = 0; i < 50; ++i) fixture.send_command(R"({"command":"undo"})");
  EXPECT_THAT(tags(fixture), SizeIs(10));
  EXPECT_EQ(*edits(fixture).number("redo"), 50.0);
}

TEST(ZoneEdits, that_are_invalid_are_refused_and_change_nothing) {
  ServerFixture fixture;
  fixture.send_command(edit(tag_5));
  const std::string before = fixture.server->zone_configuration()->text;
  for (const std::string& wrong :
       {edit(tag_5), edit(R"("removeTags":[99])"), edit(R"("moveTags":[{"number":99,"section":"south","s":1}])"),
        edit(R"("addTags":[{"number":6,"x":50,"y":50}])"), edit(R"("priorities":{"CoSiVA/AIV1":1000})"),
        std::string(R"({"command":"edit"})"), std::string(R"({"command":"edit","edit":[1]})"), edit("")}) {
    EXPECT_NE(fixture.refusal(wrong), "") << wrong;
    fixture.send_command(wrong);
  }
  EXPECT_EQ(fixture.server->zone_configuration()->text, before);
  EXPECT_EQ(fixture.server->zone_revision(), 2U);
  EXPECT_TRUE(fixture.logged("command refused"));
  ServerCore nowhere{ServerOptions{}};
  EXPECT_THAT(nowhere.check_command(DecodedCommand{edit(tag_5)}).error().message, HasSubstr("no zone yet"));
  EXPECT_FALSE(nowhere.zone_configuration().has_value());
}

TEST(ZoneEdits, do_not_disturb_driving_vehicles) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  FixtureVehicle& one = fixture.add("AIV1", {0, 0.1});
  FixtureVehicle& two = fixture.add("AIV2", {3, 0.5});
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":")" +
                       fixture.zone->circuit.part(6).name + R"(","s":0.2}})");
  fixture.run_for(10s);
  // The fixture's vehicles perceive no virtual objects; the pauses that the server sends for this are not tested here.
  fixture.send_command(R"({"command":"remove","id":"V1"})");
  fixture.run_for(5s);
  const auto held = [&] {
    std::vector<std::string> names;
    const JsonValue snapshot = fixture.snapshot();
    for (const JsonValue& crossing : *snapshot.find("crossings")->array())
      names.push_back(crossing.text("heldBy").value_or(""));
    return names;
  };
  const auto holds = held();
  const std::string order_id = one.book->ids().order_id;
  const JsonValue before = fixture.aiv("CoSiVA/AIV1");
  const std::uint32_t tag = fixture.zone->tags.empty() ? 1 : fixture.zone->tags.front().number;
  fixture.send_command(edit("\"removeTags\":[" + std::to_string(tag) + "]"));
  ASSERT_EQ(fixture.server->zone_revision(), 2U);
  const JsonValue after = fixture.aiv("CoSiVA/AIV1");
  EXPECT_EQ(*after.number("x"), *before.number("x"));
  EXPECT_EQ(*after.number("speed"), *before.number("speed"));
  EXPECT_EQ(after.text("section"), before.text("section"));
  EXPECT_EQ(held(), holds);
  const double driven_m = one.driven_m + two.driven_m;
  fixture.run_for(5s);
  EXPECT_EQ(one.book->ids().order_id, order_id) << "the same order continues";
  EXPECT_GT(one.driven_m + two.driven_m, driven_m + 1.5);
  EXPECT_THAT(one.refusals, IsEmpty());
  for (const wire::InstantActions& message : one.actions)
    for (const wire::Action& action : message.actions) EXPECT_NE(action.action_type, "cancelOrder");
}

TEST(ZoneEdits, do_not_stop_virtual_aivs) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":0.5}})");
  fixture.run_for(5s);
  const auto order = fixture.aiv("CoSiVA.virtual/V1").text("orderId");
  ASSERT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.1);
  fixture.send_command(edit(tag_5));
  fixture.run_for(1s);
  EXPECT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.1);
  EXPECT_EQ(fixture.aiv("CoSiVA.virtual/V1").text("orderId"), order);
}

TEST(ZoneEdits, set_priorities_that_apply_at_once) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(500ms);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("priority"), 0.0);
  fixture.send_command(edit(R"("priorities":{"CoSiVA/AIV1":3,"CoSiVA/AIV2":4})"));
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("priority"), 3.0);
  fixture.add("AIV2", {2, 0.5});
  fixture.run_for(500ms);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV2").number("priority"), 4.0) << "configured before the vehicle reported";
  fixture.send_command(R"({"command":"undo"})");
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("priority"), 0.0);
}

TEST(ZoneEdits, are_preserved_when_the_physical_side_publishes_its_old_file_again) {
  ServerFixture fixture;
  const zone::ZoneConfiguration original = *fixture.server->zone_configuration();
  fixture.send_command(edit(tag_5));
  const std::size_t before = published_zones(fixture);
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", original.text);
  EXPECT_THAT(tags(fixture), SizeIs(1));
  EXPECT_EQ(fixture.server->zone_revision(), 2U);
  ASSERT_EQ(published_zones(fixture), before + 1) << "the edited zone is published again";
  EXPECT_EQ(fixture.published_on("cosiva/v1/zone/toml").back().payload, fixture.server->zone_configuration()->text);
}

TEST(ZoneEdits, end_with_another_zone) {
  ServerFixture fixture;
  fixture.send_command(edit(tag_5));
  std::string other = oval().text;
  other.replace(other.find("\"oval\""), 6, "\"oval two\"");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", other);
  EXPECT_EQ(*edits(fixture).number("undo"), 0.0);
  EXPECT_EQ(edits(fixture).flag("unsaved"), false);
  EXPECT_EQ(fixture.server->zone_configuration()->text, other);
}

TEST(ZoneEdits, saved_are_no_longer_unsaved) {
  ServerFixture fixture;
  fixture.send_command(edit(tag_5));
  fixture.send_command(R"({"command":"saved"})");
  EXPECT_EQ(edits(fixture).flag("unsaved"), false);
  fixture.send_command(R"({"command":"undo"})");
  EXPECT_EQ(edits(fixture).flag("unsaved"), true) << "the file has the tag";
}

TEST(ZoneEdits, received_back_one_after_the_other_change_nothing) {
  ServerFixture fixture;
  fixture.run_for(100ms);
  wire::Effects effects;
  const auto act = [&](wire::InputKind kind, std::string source, std::string payload) {
    fixture.server->handle({fixture.now, kind, std::move(source), std::move(payload), false}, effects);
  };
  act(wire::InputKind::command, "test", edit(tag_5));
  act(wire::InputKind::command, "test", edit(R"("addTags":[{"number":6,"section":"north","s":1.0}])"));
  const wire::Effects published = std::exchange(effects, {});
  for (const wire::Effect& effect : published)
    if (const auto* message = std::get_if<wire::Publish>(&effect); message && message->topic == "cosiva/v1/zone/toml")
      act(wire::InputKind::message, message->topic, message->payload);
  EXPECT_EQ(fixture.server->zone_revision(), 3U);
  EXPECT_THAT(tags(fixture), SizeIs(2));
}

}  // namespace
}  // namespace cosiva::virtual_side
