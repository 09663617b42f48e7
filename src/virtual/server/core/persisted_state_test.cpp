// The state that the server restores after it was killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string edit = R"({"command":"edit","edit":{"addTags":[{"number":5,"section":"south","s":1.0}]}})";

TEST(PersistedState, restores_virtual_objects_virtual_aivs_and_edits) {
  ServerFixture fixture;
  fixture.send_command(
      R"({"command":"add","virtualObject":{"kind":"person","path":[[0,1.2],[2,1.2]],"speed":0.2,"repeat":"loop","radius":0.1}})");
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","id":"box","x":1.0,"y":0.5}})");
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"north","s":0.3}})");
  fixture.send_command(edit);
  fixture.run_for(5s);
  const JsonValue before = fixture.snapshot();
  const JsonValue aiv = fixture.aiv("CoSiVA.virtual/V1");
  fixture.restart_server(true);
  const JsonValue after = fixture.snapshot();
  ASSERT_THAT(*after.find("virtualObjects")->array(), SizeIs(2));
  for (std::size_t i = 0; i < 2; ++i) {
    const JsonValue& was = (*before.find("virtualObjects")->array())[i];
    const JsonValue& is = (*after.find("virtualObjects")->array())[i];
    for (const char* field : {"id", "kind", "repeat"}) EXPECT_EQ(is.text(field), was.text(field));
    for (const char* field : {"x", "y", "heading", "radius", "speed", "since_ms"})
      EXPECT_EQ(is.number(field), was.number(field)) << "continues as without a restart: " << field;
  }
  EXPECT_EQ(*after.find("zoneEdits")->number("undo"), 1.0) << "back to the file";
  EXPECT_EQ(after.find("zoneEdits")->flag("unsaved"), true);
  EXPECT_THAT(fixture.server->zone_configuration()->text, HasSubstr("5"));
  fixture.run_for(1s);
  const JsonValue again = fixture.aiv("CoSiVA.virtual/V1");
  ASSERT_FALSE(again.is_null());
  const double moved_m = norm(*again.number("x") - *aiv.number("x"), *again.number("y") - *aiv.number("y"));
  EXPECT_LT(moved_m, 1.0) << "near its position of at most a second before";
  fixture.run_for(4s);
  EXPECT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.1) << "and it drives";
}

TEST(PersistedState, is_written_when_something_changes_and_not_otherwise) {
  ServerFixture fixture;
  fixture.run_for(5s);
  EXPECT_EQ(fixture.memory, "") << "nothing to persist";
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","x":1.0,"y":0.5}})");
  const std::string with = fixture.memory;
  EXPECT_THAT(with, HasSubstr("O1"));
  fixture.send_command(R"({"command":"remove","id":"O1"})");
  EXPECT_THAT(fixture.memory, testing::Not(HasSubstr("O1")));
}

TEST(PersistedState, of_a_virtual_aiv_is_renewed_each_second) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":0.3}})");
  fixture.run_for(5s);
  const std::string then = fixture.memory;
  fixture.run_for(900ms);
  const std::string soon = fixture.memory;
  fixture.run_for(1200ms);
  EXPECT_NE(fixture.memory, then);
  EXPECT_NE(fixture.memory, soon);
}

TEST(PersistedState, survives_two_kills_before_the_zone_and_the_vehicles_are_known) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"north","s":0.3}})");
  fixture.run_for(1s);
  fixture.restart_server(true);
  fixture.run_for(100ms);  // startup synchronisation is not done yet
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","x":1.0,"y":0.5}})");
  EXPECT_THAT(fixture.memory, HasSubstr("V1"));
  fixture.restart_server(true);
  fixture.run_for(3s);
  EXPECT_FALSE(fixture.aiv("CoSiVA.virtual/V1").is_null());
}

TEST(PersistedState, that_is_malformed_is_logged_and_skipped) {
  for (const std::string& broken :
       {std::string("rubbish"), std::string("[]"), std::string("{}"), std::string(R"({"version":2})"),
        std::string(R"({"version":1,"virtualObjects":7,"aivs":{},"paused":"x","zone":[]})"),
        std::string(R"({"version":1,"virtualObjects":[7,{"id":"P1"},{"id":"P1","kind":"person","radius":1e9,"speed":0,)"
                    R"("repeat":"once","since":"1","started":"1","path":[[0,0]]}],"aivs":[{"id":"a b","section":"x",)"
                    R"("s":0},{"id":"V1","section":"nowhere"}],"paused":[7],"zone":{"base":"0"}})"),
        std::string(R"({"version":1,"zone":{"base":{"format":"toml","text":"name = "},"made":"x"}})")}) {
    ServerFixture fixture;
    fixture.memory = broken;
    fixture.restart_server(true);
    fixture.run_for(3s);
    EXPECT_THAT(*fixture.snapshot().find("virtualObjects")->array(), IsEmpty()) << broken;
    EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty()) << broken;
    EXPECT_EQ(fixture.server->zone_revision(), 1U) << broken;
    EXPECT_FALSE(fixture.logs.empty());
    fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","x":1.0,"y":0.5}})");
    EXPECT_THAT(*fixture.snapshot().find("virtualObjects")->array(), SizeIs(1)) << "it continues to work: " << broken;
  }
}

TEST(PersistedState, of_edits_waits_for_the_zone_of_the_physical_side) {
  ServerFixture fixture;
  fixture.send_command(edit);
  const std::string edited = fixture.server->zone_configuration()->text;
  ServerCore server{ServerOptions{}};
  wire::Effects effects;
  server.handle({fixture.now, wire::InputKind::restore, "", fixture.memory, false}, effects);
  EXPECT_FALSE(server.zone_configuration().has_value());
  server.handle({fixture.now, wire::InputKind::link, "", "up", false}, effects);
  server.handle({fixture.now, wire::InputKind::message, "cosiva/v1/zone/toml", oval().text, true}, effects);
  ASSERT_TRUE(server.zone_configuration().has_value());
  EXPECT_EQ(server.zone_configuration()->text, edited);
}

TEST(PersistedState, of_edits_recognises_them_in_the_zone_that_the_broker_retained) {
  ServerFixture fixture;
  const std::string original = fixture.server->zone_configuration()->text;
  fixture.send_command(edit);
  const zone::ZoneConfiguration edited = *fixture.server->zone_configuration();
  for (const bool saved : {false, true}) {
    if (saved) fixture.send_command(R"({"command":"saved"})");
    ServerCore server{ServerOptions{}};
    wire::Effects effects;
    const auto feed = [&](wire::InputKind kind, const char* source, const std::string& payload) {
      server.handle({fixture.now, kind, source, payload, kind == wire::InputKind::message}, effects);
    };
    feed(wire::InputKind::restore, "", fixture.memory);
    feed(wire::InputKind::link, "", "up");
    feed(wire::InputKind::message, "cosiva/v1/zone/toml", edited.text);
    const JsonValue snapshot = *JsonValue::parse(server.snapshot_json());
    EXPECT_EQ(snapshot.find("zoneEdits")->flag("unsaved"), !saved);
    EXPECT_EQ(snapshot.find("zoneEdits")->number("undo"), 1.0);
    feed(wire::InputKind::message, "cosiva/v1/zone/toml", original);
    EXPECT_EQ(server.zone_configuration()->text, edited.text) << "a restarted physical side publishes its file";
    feed(wire::InputKind::command, "test", R"({"command":"undo"})");
    EXPECT_EQ(server.zone_configuration()->text, original);
  }
}

TEST(PersistedState, of_edits_is_skipped_on_another_zone) {
  ServerFixture fixture;
  fixture.send_command(edit);
  ServerFixture other{zone_file("lacet4.toml")};
  other.memory = fixture.memory;
  other.restart_server(true);
  EXPECT_EQ(other.server->zone_revision(), 1U);
  EXPECT_TRUE(other.logged("edits"));
}

TEST(PersistedState, puts_a_virtual_aiv_next_to_its_position_when_that_is_occupied) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":1.0}})");
  fixture.run_for(100ms);
  fixture.add("AIV1", {0, 1.05}).blocked = true;
  fixture.restart_server(true);
  fixture.run_for(3s);
  const JsonValue aiv = fixture.aiv("CoSiVA.virtual/V1");
  ASSERT_FALSE(aiv.is_null());
  const double away_m = norm(*aiv.number("x") - 1.05, *aiv.number("y"));
  EXPECT_GE(away_m, 0.25);
}

}  // namespace
}  // namespace cosiva::virtual_side
