// The state that the server restores after it was killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// What the server would restore if it were killed now.
std::string& state_file(ServerFixture& fixture) { return fixture.persisted; }

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
  EXPECT_EQ(state_file(fixture), "") << "nothing to persist";
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","x":1.0,"y":0.5}})");
  const std::string with = state_file(fixture);
  EXPECT_THAT(with, HasSubstr("O1"));
  fixture.send_command(R"({"command":"remove","id":"O1"})");
  EXPECT_THAT(state_file(fixture), testing::Not(HasSubstr("O1")));
}

TEST(PersistedState, of_a_virtual_aiv_is_renewed_each_second) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":0.3}})");
  fixture.run_for(5s);
  const std::string then = state_file(fixture);
  fixture.run_for(900ms);
  const std::string soon = state_file(fixture);
  fixture.run_for(1200ms);
  EXPECT_NE(state_file(fixture), then);
  EXPECT_NE(state_file(fixture), soon);
}

TEST(PersistedState, survives_two_kills_before_the_zone_and_the_vehicles_are_known) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"north","s":0.3}})");
  fixture.run_for(1s);
  fixture.restart_server(true);
  fixture.run_for(100ms);  // startup synchronisation is not done yet
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","x":1.0,"y":0.5}})");
  EXPECT_THAT(state_file(fixture), HasSubstr("V1"));
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
    state_file(fixture) = broken;
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

TEST(PersistedState, has_the_ids_that_clients_chose_and_skips_those_that_cannot_be_read) {
  constexpr const char* close = R"({"id":"mine","once":true,"command":"close","section":"east"})";
  ServerFixture fixture;
  EXPECT_FALSE(fixture.server->was_given(DecodedCommand{close}));
  fixture.send_command(close);
  EXPECT_TRUE(fixture.server->was_given(DecodedCommand{close}));
  const std::string good = fixture.persisted;
  fixture.restart_server(true);
  EXPECT_TRUE(fixture.server->was_given(DecodedCommand{close}));
  EXPECT_FALSE(fixture.logged("some persisted ids of commands cannot be read; they are skipped"));
  const std::size_t at = good.find(R"([["mine")");
  ASSERT_NE(at, std::string::npos);
  fixture.persisted = std::string(good).insert(at + 1, R"(7,)");
  fixture.restart_server(true);
  EXPECT_TRUE(fixture.server->was_given(DecodedCommand{close}));
  EXPECT_TRUE(fixture.logged("some persisted ids of commands cannot be read; they are skipped"));
}

TEST(PersistedState, of_edits_waits_for_the_zone_of_the_physical_side) {
  ServerFixture fixture;
  fixture.send_command(edit);
  const std::string edited = fixture.server->zone_configuration()->text;
  ServerCore server{ServerOptions{}};
  wire::Effects effects;
  server.handle({fixture.now, wire::InputKind::restore, "", state_file(fixture), false}, effects);
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
    feed(wire::InputKind::restore, "", state_file(fixture));
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
  state_file(other) = state_file(fixture);
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

/// The state that the server writes, and what it restores of a state whose items are written by the test.
class StateFile : public testing::Test {
 protected:
  /// A person, with the fields that a test gives instead of or besides its own.
  static std::string person(const std::string& id, const std::string& name = "", const std::string& value = "") {
    std::vector<std::pair<std::string, std::string>> fields{
        {"id", '"' + id + '"'},  {"kind", R"("person")"}, {"radius", "0.1"},     {"speed", "0.2"},
        {"repeat", R"("once")"}, {"since", R"("0")"},     {"started", R"("7")"}, {"path", "[[0,1.2],[2,1.2]]"}};
    std::string text;
    for (const auto& [field, usual] : fields) {
      if (field == name && value.empty()) continue;
      text += (text.empty() ? "{\"" : ",\"") + field + "\":" + (field == name ? value : usual);
    }
    return text + "}";
  }
  static std::string path_of(std::size_t points) {
    std::string text = "[[0,0]";
    for (std::size_t i = 1; i < points; ++i) text += ",[" + std::to_string(i) + ",0]";
    return text + "]";
  }
  void restore(const std::string& objects, const std::string& aivs = "") {
    fixture.logs.clear();
    state_file(fixture) = R"({"version":1,"virtualObjects":[)" + objects + R"(],"aivs":[)" + aivs + R"(],"paused":[]})";
    fixture.restart_server(true);
  }
  [[nodiscard]] std::size_t restored() const { return fixture.snapshot().find("virtualObjects")->array()->size(); }
  /// Whether a person with this field is restored; an empty value: without the field.
  bool accepts(const std::string& name, const std::string& value) {
    restore(person("P1", name, value));
    const bool skipped = fixture.logged("a persisted virtual object cannot be read; it is skipped");
    EXPECT_EQ(restored(), skipped ? 0U : 1U) << name << " " << value;
    return !skipped;
  }
  ServerFixture fixture;
};

TEST_F(StateFile, has_all_that_the_server_needs_and_nothing_else) {
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"obstacle","id":"box","x":1.0,"y":0.5}})");
  fixture.now += 10ms;
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"person","path":[[0,1.2],[2,0.2]],"speed":0.2,)"
                       R"("repeat":"loop","radius":0.1}})");
  EXPECT_EQ(state_file(fixture),
            R"({"version":1,"virtualObjects":[{"id":"box","kind":"obstacle","radius":0.06,"speed":0,"repeat":"once",)"
            R"("since":"1689033600000000000","started":"1689033600000000000","path":[[1,0.5]]},)"
            R"({"id":"P1","kind":"person","radius":0.1,"speed":0.2,"repeat":"loop","since":"1689033600010000000",)"
            R"("started":"1689033600010000000","path":[[0,1.2],[2,0.2]]}],"aivs":[],"paused":[]})");
}

TEST_F(StateFile, of_an_object_that_was_moved_has_both_of_its_times) {
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"person","id":"P1","x":1.0,"y":0.5}})");
  fixture.now += 1s;
  fixture.send_command(R"({"command":"move","virtualObject":{"id":"P1","x":0.5,"y":0.5}})");
  EXPECT_THAT(state_file(fixture), HasSubstr(R"("since":"1689033600000000000","started":"1689033601000000000")"));
}

TEST_F(StateFile, restores_an_object_with_a_name_of_one_to_sixty_four_bytes) {
  EXPECT_TRUE(accepts("id", R"("P")"));
  EXPECT_TRUE(accepts("id", '"' + std::string(64, 'p') + '"'));
  EXPECT_FALSE(accepts("id", '"' + std::string(65, 'p') + '"'));
  EXPECT_FALSE(accepts("id", R"("")"));
  EXPECT_FALSE(accepts("id", ""));
}

TEST_F(StateFile, restores_an_object_of_a_known_kind_that_repeats_its_path_in_a_known_manner) {
  EXPECT_TRUE(accepts("kind", R"("obstacle")"));
  EXPECT_TRUE(accepts("repeat", R"("back and forth")"));
  for (const std::string field : {"kind", "repeat"}) {
    EXPECT_FALSE(accepts(field, R"("other")"));
    EXPECT_FALSE(accepts(field, ""));
  }
}

TEST_F(StateFile, restores_an_object_with_times_in_whole_nanoseconds) {
  for (const std::string field : {"since", "started"}) {
    EXPECT_TRUE(accepts(field, R"("0")"));
    EXPECT_TRUE(accepts(field, R"("1689033600000000001")"));
    for (const char* bad : {R"("-1")", R"("12x")", R"("x")", R"("")", R"("99999999999999999999")", "12", ""})
      EXPECT_FALSE(accepts(field, bad)) << bad;
  }
}

TEST_F(StateFile, restores_an_object_whose_radius_and_speed_a_command_could_give) {
  for (const char* good : {"0.02", "1"}) EXPECT_TRUE(accepts("radius", good)) << good;
  for (const char* bad : {"0.0199", "1.001", "-0.1", R"("0.1")", ""}) EXPECT_FALSE(accepts("radius", bad)) << bad;
  for (const char* good : {"0", "3"}) EXPECT_TRUE(accepts("speed", good)) << good;
  for (const char* bad : {"-0.001", "3.001", R"("0.1")", ""}) EXPECT_FALSE(accepts("speed", bad)) << bad;
}

TEST_F(StateFile, restores_an_object_on_a_path_of_one_to_sixty_four_points_within_a_hundred_kilometres) {
  EXPECT_TRUE(accepts("path", "[[1,1]]"));
  EXPECT_TRUE(accepts("path", path_of(64)));
  EXPECT_TRUE(accepts("path", "[[100000,-100000],[-100000,100000]]"));
  for (const std::string& bad :
       {path_of(65), std::string("[]"), std::string("7"), std::string("[7]"), std::string("[[1]]"),
        std::string("[[1,1,1]]"), std::string(R"([["1",1]])"), std::string(R"([[1,"1"]])"),
        std::string("[[100000.5,1]]"), std::string("[[-100000.5,1]]"), std::string("[[1,100000.5]]"),
        std::string("[[1,-100000.5]]"), std::string("[[1,1],[1]]"), std::string("[[1,1],[1,1,1]]"), std::string()})
    EXPECT_FALSE(accepts("path", bad)) << bad;
}

TEST_F(StateFile, restores_each_object_once_and_the_others_where_one_cannot_be_read) {
  restore(person("P1") + "," + person("P1", "radius", "0.5") + ",7," + person("P2"));
  ASSERT_EQ(restored(), 2U);
  EXPECT_EQ((*fixture.snapshot().find("virtualObjects")->array())[0].number("radius"), 0.1);
  EXPECT_EQ(std::ranges::count(fixture.logs, std::string("a persisted virtual object cannot be read; it is skipped")),
            2);
  EXPECT_TRUE(fixture.logged("restored 2 virtual objects and 0 virtual AIVs"));
}

TEST_F(StateFile, restores_no_more_objects_than_a_server_accepts) {
  std::string objects = person("P1");
  for (int i = 2; i <= 65; ++i) objects += "," + person("P" + std::to_string(i));
  restore(objects);
  EXPECT_EQ(restored(), 64U);
}

TEST_F(StateFile, restores_virtual_aivs_with_a_permitted_name_a_section_and_a_position) {
  restore("", R"({"id":"V1","section":"north","s":0},{"id":"V2","section":"south","s":100000})");
  EXPECT_TRUE(fixture.logged("restored 0 virtual objects and 2 virtual AIVs"));
  for (const char* bad :
       {R"({"id":"V 1","section":"north","s":0})", R"({"section":"north","s":0})", R"({"id":"V1","s":0})",
        R"({"id":"V1","section":"north"})", R"({"id":"V1","section":"north","s":-0.1})",
        R"({"id":"V1","section":"north","s":100000.5})", R"({"id":7,"section":"north","s":0})"}) {
    restore("", bad);
    EXPECT_TRUE(fixture.logged("a persisted virtual AIV cannot be read; it is skipped")) << bad;
    EXPECT_TRUE(fixture.logged("restored 0 virtual objects and 0 virtual AIVs")) << bad;
  }
}

TEST_F(StateFile, of_a_virtual_aiv_is_written_again_exactly_a_second_later) {
  fixture.run_for(400ms);
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":0.3}})");
  EXPECT_THAT(state_file(fixture), HasSubstr(R"("s":0.3)"));
  fixture.run_for(2s);
  const std::string first = state_file(fixture);
  fixture.run_for(980ms);
  EXPECT_EQ(state_file(fixture), first);
  fixture.run_for(20ms);
  const std::string second = state_file(fixture);
  EXPECT_NE(second, first);
  fixture.run_for(980ms);
  EXPECT_EQ(state_file(fixture), second);
  fixture.run_for(20ms);
  EXPECT_NE(state_file(fixture), second);
}

TEST_F(StateFile, gives_a_vehicle_its_mission_again_when_it_is_registered_but_no_virtual_aiv) {
  const std::string goal = fixture.zone->waypoints[fixture.zone->waypoint_behind({2, 1.0})].id;
  const std::string mission = R"(","kind":"go","name":")" + goal + "\"}";
  state_file(fixture) =
      R"({"version":1,"aivs":[{"id":"V1","section":"north","s":1.5}],"traffic":{"zone":"oval","closed":[],)"
      R"("missions":[{"vehicle":"CoSiVA/AIV1)" +
      mission + R"(,{"vehicle":"CoSiVA.virtual/V1)" + mission + "]}}";
  fixture.restart_server(true);
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  const auto kind = [&](const std::string& name) { return fixture.aiv(name).find("mission")->text("kind"); };
  EXPECT_EQ(kind("CoSiVA/AIV1"), "go");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("mission")->text("to"), goal);
  EXPECT_EQ(kind("CoSiVA.virtual/V1"), "circulate");
}

TEST_F(StateFile, has_a_mission_as_soon_as_it_is_given) {
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  const std::string goal = fixture.zone->waypoints[fixture.zone->waypoint_behind({2, 1.0})].id;
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":")" + goal + "\"}");
  EXPECT_THAT(state_file(fixture),
              HasSubstr(R"("missions":[{"vehicle":"CoSiVA/AIV1","kind":"go","name":")" + goal + "\"}]"));
}

}  // namespace
}  // namespace cosiva::virtual_side
