#include "cosiva/virtual/server/zones/zone_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
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

zone::ZoneConfiguration renamed(const std::string& name) {
  zone::ZoneConfiguration configuration = oval();
  configuration.text.replace(configuration.text.find("\"oval\""), 6, "\"" + name + "\"");
  return configuration;
}

/// ZoneEdits without a server; the oval is in force.
class EditSteps : public testing::Test {
 protected:
  using Kind = EditCommand::Kind;
  using Arrival = ZoneEdits::Arrival;
  using Fit = ZoneEdits::Restored::Fit;

  EditSteps() { put(oval()); }
  void put(const zone::ZoneConfiguration& configuration) {
    EXPECT_TRUE(simulator.receive(virtual_epoch, configuration, [](auto, auto, auto, auto) {}).has_value());
  }
  void edit_from(const std::string& name) { steps.done(Kind::edit, renamed(name)); }
  [[nodiscard]] std::string result_of(Kind kind, const std::string& changes = "null") {
    const auto result = steps.after({kind, *JsonValue::parse(changes)}, simulator);
    return result ? result->text : result.error().code + " at '" + result.error().location + "'";
  }
  [[nodiscard]] static JsonValue persisted(const std::string& base, const std::string& made, const std::string& saved) {
    JsonWriter json;
    json.begin_object();
    zone::write_json(json.key("base"), renamed(base));
    zone::write_json(json.key("made"), renamed(made));
    json.key("saved").raw(saved).end_object();
    return *JsonValue::parse(json.text());
  }
  Simulator simulator{BijectionContract{}};
  ZoneEdits steps;
};

TEST_F(EditSteps, need_a_zone_and_something_to_change) {
  EXPECT_EQ(result_of(Kind::edit), "edit.missing at 'edit'");
  EXPECT_EQ(result_of(Kind::edit, "[1]"), "edit.missing at 'edit'");
  EXPECT_EQ(result_of(Kind::edit, R"({"priorities":{"CoSiVA/AIV1":0}})"), "edit.nothing at 'edit'")
      << "no entry before";
  EXPECT_EQ(result_of(Kind::undo), "edit.undo at ''");
  EXPECT_EQ(result_of(Kind::redo), "edit.redo at ''");
  Simulator nowhere{BijectionContract{}};
  for (const Kind kind : {Kind::edit, Kind::undo, Kind::redo, Kind::saved}) {
    const auto result = steps.after({kind, {}}, nowhere);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, "edit.zone");
  }
}

TEST_F(EditSteps, lead_to_the_zone_in_force_where_it_is_saved) {
  put(renamed("present"));
  edit_from("before");
  EXPECT_EQ(result_of(Kind::saved), renamed("present").text);
}

TEST_F(EditSteps, lead_back_and_forth_through_the_zones_that_were_in_force) {
  edit_from("one");
  edit_from("two");
  EXPECT_EQ(steps.undo_count(), 2U);
  EXPECT_EQ(steps.redo_count(), 0U);
  EXPECT_EQ(result_of(Kind::undo), renamed("two").text);
  steps.done(Kind::undo, renamed("three"));
  EXPECT_EQ(steps.undo_count(), 1U);
  EXPECT_EQ(steps.redo_count(), 1U);
  EXPECT_EQ(result_of(Kind::undo), renamed("one").text);
  EXPECT_EQ(result_of(Kind::redo), renamed("three").text);
  steps.done(Kind::redo, renamed("two"));
  EXPECT_EQ(steps.undo_count(), 2U);
  EXPECT_EQ(steps.redo_count(), 0U);
  EXPECT_EQ(result_of(Kind::undo), renamed("two").text);
}

TEST_F(EditSteps, that_were_undone_are_discarded_by_the_next_edit) {
  edit_from("one");
  steps.done(Kind::undo, renamed("two"));
  edit_from("one");
  EXPECT_EQ(steps.undo_count(), 1U);
  EXPECT_EQ(steps.redo_count(), 0U);
}

TEST_F(EditSteps, are_fifty_at_most_the_last_ones) {
  for (int i = 1; i <= 51; ++i) edit_from("z" + std::to_string(i));
  ASSERT_EQ(steps.undo_count(), 50U);
  for (int i = 51; i > 2; --i) steps.done(Kind::undo, renamed("z" + std::to_string(i + 1)));
  EXPECT_EQ(steps.undo_count(), 1U);
  EXPECT_EQ(result_of(Kind::undo), renamed("z2").text) << "the first one is forgotten";
  EXPECT_EQ(steps.redo_count(), 49U);
}

TEST_F(EditSteps, cannot_be_undone_where_there_are_none) {
  EXPECT_DEATH(steps.done(Kind::undo, oval()), "!undo_.empty");
  EXPECT_DEATH(steps.done(Kind::redo, oval()), "!redo_.empty");
}

TEST_F(EditSteps, are_received_back_in_the_order_of_their_publication_and_some_not_at_all) {
  steps.begin(renamed("base"), ZoneEdits::Origin::broker);
  for (const char* name : {"one", "two", "three"}) steps.published(renamed(name));
  EXPECT_EQ(steps.arrives(renamed("two")), Arrival::echo);
  EXPECT_EQ(steps.arrives(renamed("two")), Arrival::news) << "only once";
  EXPECT_EQ(steps.arrives(renamed("one")), Arrival::news) << "retained messages are never swapped";
  EXPECT_EQ(steps.arrives(renamed("base")), Arrival::stale);
  EXPECT_EQ(steps.arrives(renamed("three")), Arrival::echo);
  steps.published(renamed("four"));
  steps.link_lost();
  EXPECT_EQ(steps.arrives(renamed("four")), Arrival::news);
}

TEST_F(EditSteps, received_before_any_zone_are_news) { EXPECT_EQ(steps.arrives(oval()), Arrival::news); }

TEST_F(EditSteps, are_expected_back_up_to_fifty) {
  for (int i = 1; i <= 51; ++i) steps.published(renamed("z" + std::to_string(i)));
  EXPECT_EQ(steps.arrives(renamed("z1")), Arrival::news);
  EXPECT_EQ(steps.arrives(renamed("z2")), Arrival::echo);
  EXPECT_EQ(steps.arrives(renamed("z51")), Arrival::echo);
}

TEST_F(EditSteps, end_with_a_zone_from_the_broker_but_a_zone_of_their_own_is_received_back_after_them) {
  edit_from("one");
  steps.done(Kind::undo, renamed("two"));
  edit_from("one");
  steps.published(renamed("one"));
  steps.begin(renamed("own"), ZoneEdits::Origin::own);
  EXPECT_EQ(steps.undo_count() + steps.redo_count(), 0U);
  EXPECT_EQ(steps.arrives(renamed("one")), Arrival::echo);
  EXPECT_EQ(steps.arrives(renamed("own")), Arrival::stale);
  steps.published(renamed("two"));
  steps.begin(renamed("other"), ZoneEdits::Origin::broker);
  EXPECT_EQ(steps.arrives(renamed("two")), Arrival::news);
  EXPECT_EQ(steps.arrives(renamed("own")), Arrival::news);
}

TEST_F(EditSteps, end_with_what_was_undone_too) {
  edit_from("one");
  edit_from("two");
  steps.done(Kind::undo, renamed("three"));
  ASSERT_EQ(steps.redo_count(), 1U);
  steps.begin(renamed("other"), ZoneEdits::Origin::broker);
  EXPECT_EQ(steps.undo_count(), 0U);
  EXPECT_EQ(steps.redo_count(), 0U);
}

TEST_F(EditSteps, are_unsaved_and_edited_where_the_zone_differs_from_the_saved_one_and_from_the_first) {
  EXPECT_FALSE(steps.unsaved(simulator)) << "no zone has begun";
  EXPECT_FALSE(steps.edited(simulator));
  steps.begin(oval(), ZoneEdits::Origin::broker);
  EXPECT_FALSE(steps.unsaved(simulator));
  EXPECT_FALSE(steps.edited(simulator));
  put(renamed("two"));
  EXPECT_TRUE(steps.unsaved(simulator));
  EXPECT_TRUE(steps.edited(simulator));
  steps.saved(renamed("two"));
  EXPECT_FALSE(steps.unsaved(simulator));
  EXPECT_TRUE(steps.edited(simulator));
  const Simulator nowhere{BijectionContract{}};
  EXPECT_FALSE(steps.unsaved(nowhere));
  EXPECT_FALSE(steps.edited(nowhere));
}

TEST_F(EditSteps, are_persisted_with_the_first_zone_and_the_one_in_force) {
  const auto written = [&] {
    JsonWriter json;
    steps.write_persisted(json, simulator);
    return *JsonValue::parse(json.text());
  };
  steps.begin(renamed("first"), ZoneEdits::Origin::broker);
  EXPECT_EQ(written().find("base")->text("text"), renamed("first").text);
  EXPECT_EQ(written().find("made")->text("text"), oval().text);
  EXPECT_EQ(written().flag("saved"), false);
  steps.saved(oval());
  EXPECT_EQ(written().flag("saved"), true);
}

TEST_F(EditSteps, persisted_are_compared_with_the_zone_in_force) {
  const auto fit = [](const std::string& base, const std::string& made, const std::string& in_force) {
    return ZoneEdits::restored(persisted(base, made, "true"), renamed(in_force)).fit;
  };
  EXPECT_EQ(fit("one", "two", "one"), Fit::base);
  EXPECT_EQ(fit("one", "two", "two"), Fit::made);
  EXPECT_EQ(fit("one", "one", "one"), Fit::made);
  EXPECT_EQ(fit("one", "two", "three"), Fit::another);
  const auto restored = ZoneEdits::restored(persisted("one", "two", "true"), renamed("three"));
  EXPECT_EQ(restored.base, renamed("one"));
  EXPECT_EQ(restored.made, renamed("two"));
  EXPECT_TRUE(restored.saved);
  EXPECT_FALSE(ZoneEdits::restored(persisted("one", "two", "false"), oval()).saved);
  EXPECT_FALSE(ZoneEdits::restored(persisted("one", "two", "null"), oval()).saved);
}

TEST_F(EditSteps, persisted_that_cannot_be_read_belong_to_another_zone) {
  JsonWriter in_force;
  zone::write_json(in_force, oval());
  const std::string good = in_force.text();
  for (const std::string& wrong : {std::string("{}"), "{\"base\":" + good + "}", "{\"made\":" + good + "}",
                                   "{\"base\":7,\"made\":" + good + "}", "{\"base\":" + good + ",\"made\":7}"}) {
    const auto restored = ZoneEdits::restored(*JsonValue::parse(wrong), oval());
    EXPECT_EQ(restored.fit, Fit::another) << wrong;
    EXPECT_EQ(restored.base, zone::ZoneConfiguration{}) << wrong;
  }
}

TEST_F(EditSteps, restored_lead_back_to_their_first_zone_in_one_step) {
  edit_from("a");
  edit_from("b");
  steps.done(Kind::undo, renamed("c"));
  steps.restore({Fit::base, renamed("first"), oval(), false});
  EXPECT_EQ(steps.undo_count(), 1U);
  EXPECT_EQ(steps.redo_count(), 0U);
  EXPECT_EQ(result_of(Kind::undo), renamed("first").text);
  EXPECT_TRUE(steps.unsaved(simulator));
  EXPECT_TRUE(steps.edited(simulator));
  EXPECT_EQ(steps.arrives(renamed("first")), Arrival::stale);
  steps.restore({Fit::made, renamed("first"), oval(), true});
  EXPECT_EQ(steps.undo_count(), 1U);
  EXPECT_FALSE(steps.unsaved(simulator));
}

TEST_F(EditSteps, fold_their_numbers) {
  edit_from("one");
  edit_from("two");
  edit_from("three");
  steps.done(Kind::undo, oval());
  Digest expected;
  expected.add(std::uint64_t{2});
  expected.add(std::uint64_t{1});
  Digest folded;
  steps.fold(folded);
  EXPECT_EQ(folded.hex(), expected.hex());
}

}  // namespace
}  // namespace cosiva::virtual_side
