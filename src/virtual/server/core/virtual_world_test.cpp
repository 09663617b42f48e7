#include "cosiva/virtual/server/core/virtual_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// The objects that operators add to the oval, and those that a state file restores.
class Objects : public testing::Test {
 protected:
  std::string& persisted() { return fixture.persisted; }
  void add(const std::string& object) { fixture.send_command(R"({"command":"add","virtualObject":{)" + object + "}}"); }
  void remove(const std::string& id) { fixture.send_command(R"({"command":"remove","id":")" + id + "\"}"); }
  void restart_with_aivs(const std::string& aivs) {
    persisted() = R"({"version":1,"virtualObjects":[],"aivs":[)" + aivs + R"(],"paused":[]})";
    fixture.restart_server(true);
  }
  [[nodiscard]] std::vector<std::string> ids() const {
    std::vector<std::string> found;
    const JsonValue snapshot = fixture.snapshot();
    for (const JsonValue& object : *snapshot.find("virtualObjects")->array()) found.push_back(*object.text("id"));
    return found;
  }
  [[nodiscard]] double augmented() const { return *fixture.bijection().number("augmented"); }
  /// "add P1", for each change of the virtual objects.
  [[nodiscard]] std::vector<std::string> traced_changes() const {
    std::vector<std::string> found;
    const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
    for (const JsonValue& trace : *traces.find("traces")->array()) {
      const std::string kind = *trace.text("kind");
      if (kind == "add" || kind == "move" || kind == "remove") found.push_back(kind + " " + *trace.text("content"));
    }
    return found;
  }
  ServerFixture fixture;
};

TEST_F(Objects, are_added_moved_and_removed_and_each_change_is_traced) {
  add(R"("id":"P1","kind":"person","x":1.0,"y":0.5)");
  add(R"("id":"P2","kind":"person","x":1.5,"y":0.5)");
  fixture.send_command(R"({"command":"move","virtualObject":{"id":"P1","x":0.4,"y":0.6}})");
  const JsonValue moved = fixture.snapshot();
  EXPECT_EQ((*moved.find("virtualObjects")->array())[0].number("x"), 0.4);
  EXPECT_EQ((*moved.find("virtualObjects")->array())[0].number("y"), 0.6);
  remove("P1");
  EXPECT_THAT(ids(), ElementsAre("P2"));
  remove("*");
  EXPECT_THAT(ids(), IsEmpty());
  EXPECT_THAT(traced_changes(), ElementsAre("add P1", "add P2", "move P1", "remove P1", "remove everything"));
}

TEST_F(Objects, that_are_virtual_aivs_are_counted_by_the_monitor_and_removed_by_their_serial_number) {
  add(R"("id":"V1","kind":"aiv","section":"north","s":0.5)");
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V1: added at north, 0.500000 m"));
  add(R"("id":"V2","kind":"aiv","section":"north","s":1.5)");
  EXPECT_EQ(augmented(), 2.0);
  fixture.run_for(500ms);
  remove("V1");
  EXPECT_EQ(augmented(), 1.0);
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V1: removed"));
  EXPECT_TRUE(fixture.aiv("CoSiVA.virtual/V1").is_null());
  EXPECT_FALSE(fixture.aiv("CoSiVA.virtual/V2").is_null());
  add(R"("id":"P1","kind":"person","x":1.0,"y":0.5)");
  remove("*");
  EXPECT_EQ(augmented(), 0.0);
  EXPECT_TRUE(fixture.aiv("CoSiVA.virtual/V2").is_null());
  EXPECT_THAT(ids(), IsEmpty());
}

TEST_F(Objects, that_are_virtual_aivs_persist_to_the_millimetre_until_they_are_removed) {
  add(R"("id":"V1","kind":"aiv","section":"north","s":0.5004)");
  EXPECT_THAT(persisted(), HasSubstr(R"("aivs":[{"id":"V1","section":"north","s":0.5}])"));
  remove("V1");
  EXPECT_THAT(persisted(), HasSubstr(R"("aivs":[],)"));
}

TEST_F(Objects, that_return_as_a_virtual_aiv_of_the_same_name_have_no_mission_and_are_not_shown_at_the_old_position) {
  add(R"("id":"V1","kind":"aiv","section":"south","s":0.5)");
  fixture.run_for(500ms);
  const std::string goal = fixture.zone->waypoints[fixture.zone->waypoint_behind({2, 1.0})].id;
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA.virtual/V1","to":")" + goal + "\"}");
  EXPECT_EQ(fixture.aiv("CoSiVA.virtual/V1").find("mission")->text("kind"), "go");
  remove("V1");
  add(R"("id":"V1","kind":"aiv","section":"north","s":0.5)");
  fixture.run_for(500ms);
  const JsonValue again = fixture.aiv("CoSiVA.virtual/V1");
  EXPECT_EQ(again.find("mission")->text("kind"), "circulate");
  EXPECT_NEAR(*again.number("y"), 1.0, 0.01) << "on the north side";
  EXPECT_EQ(again.text("connection"), "ONLINE");
}

TEST_F(Objects, that_are_restored_virtual_aivs_are_added_at_the_synchronisation_where_they_were) {
  restart_with_aivs(R"({"id":"V1","section":"north","s":0.3},{"id":"V2","section":"south","s":7.5})");
  fixture.run_for(280ms);
  EXPECT_EQ(augmented(), 0.0);
  EXPECT_FALSE(fixture.logged("added at"));
  fixture.run_for(20ms);
  EXPECT_EQ(augmented(), 2.0);
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V1: added at north, 0.300000 m"));
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V2: added at south, 2.000000 m")) << "no further than its end";
  EXPECT_FALSE(fixture.logged("cannot be restored"));
}

TEST_F(Objects, that_are_restored_virtual_aivs_are_put_at_the_nearest_position_with_room) {
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 1.0});
  aiv.blocked = true;
  // Two vehicles are 0.3 m apart: 0.92 + 0.4 is the first position with room in front, 0.92 - 0.25 behind.
  restart_with_aivs(R"({"id":"V1","section":"south","s":0.92})");
  fixture.run_for(2s);
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V1: added at south, 0.670000 m"));
}

TEST_F(Objects, that_are_restored_virtual_aivs_have_the_roomiest_position_where_none_is_within_a_metre) {
  for (int i = 1; i <= 4; ++i) fixture.add("AIV" + std::to_string(i), {0, 0.5 * i - 0.25}).blocked = true;
  fixture.add("AIV5", {1, 0.25}).blocked = true;
  fixture.add("AIV6", {3, 1.3}).blocked = true;
  restart_with_aivs(R"({"id":"V1","section":"south","s":1.0})");
  fixture.run_for(2s);
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V1: added at north"));
}

TEST_F(Objects, that_wait_to_be_restored_are_removed_with_all_others) {
  restart_with_aivs(R"({"id":"V1","section":"north","s":0.3})");
  remove("*");
  fixture.run_for(1s);
  EXPECT_EQ(augmented(), 0.0);
  EXPECT_FALSE(fixture.logged("added at"));
}

TEST_F(Objects, that_wait_to_be_restored_are_removed_by_their_id) {
  for (const std::string id : {"V1", "CoSiVA.virtual/V1"}) {
    restart_with_aivs(R"({"id":"V1","section":"north","s":0.3},{"id":"V2","section":"south","s":0.3})");
    remove(id);
    fixture.run_for(1s);
    EXPECT_EQ(augmented(), 1.0) << id;
    EXPECT_THAT(persisted(), Not(HasSubstr("V1"))) << id;
  }
}

TEST_F(Objects, that_wait_to_be_restored_are_named_where_an_unknown_one_is_removed) {
  restart_with_aivs(R"({"id":"V1","section":"north","s":0.3})");
  remove("V7");
  EXPECT_TRUE(fixture.logged("no virtual object is called 'V7'; there are V1"));
}

TEST_F(Objects, that_wait_to_be_restored_have_their_ids_in_use) {
  restart_with_aivs(R"({"id":"V1","section":"north","s":0.3},{"id":"V2","section":"south","s":0.3})");
  add(R"("id":"V1","kind":"aiv","section":"north","s":1.5)");
  EXPECT_TRUE(fixture.logged("the id 'V1' is in use"));
  fixture.send_command(R"({"command":"move","virtualObject":{"id":"V2","x":0.4,"y":0.6}})");
  EXPECT_TRUE(fixture.logged("a virtual AIV cannot be moved"));
  add(R"("kind":"aiv","section":"north","s":1.5)");
  fixture.run_for(1s);
  EXPECT_EQ(augmented(), 3.0);
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V1: added at north, 0.300000 m"));
  EXPECT_TRUE(fixture.logged("CoSiVA.virtual/V3: added at north, 1.500000 m"));
}

TEST_F(Objects, that_are_restored_before_any_zone_is_known_are_added_when_one_is) {
  fixture.forget_zone();
  restart_with_aivs(R"({"id":"V1","section":"south","s":0.5})");
  fixture.run_for(10s);
  EXPECT_EQ(augmented(), 0.0);
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", oval().text);
  fixture.run_for(1s);
  EXPECT_EQ(augmented(), 1.0);
}

TEST_F(Objects, that_cannot_be_restored_are_logged_and_persist_no_longer) {
  restart_with_aivs(R"({"id":"V1","section":"north","s":0.3})");
  for (std::size_t i = 0; i < Registry::vehicles_max_default; ++i) {
    wire::State state;
    state.header = {0, fixture.now, "2.1.0", "Acme", "n" + std::to_string(i)};
    fixture.feed(wire::InputKind::message, "uagv/v2/Acme/" + state.header.serial_number + "/state", vda::encode(state));
  }
  fixture.run_for(320ms);
  EXPECT_TRUE(fixture.logged("virtual AIV V1 cannot be restored, as no section has room for it; add it again"));
  EXPECT_EQ(augmented(), 0.0);
  EXPECT_THAT(persisted(), HasSubstr(R"("aivs":[],)"));
}

TEST_F(Objects, that_are_physical_obstacles_are_not_removed_by_a_vehicle_that_is_offline) {
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.2});
  aiv.blocked = true;
  fixture.run_for(1s);
  const wire::DetectedObstacleReport report{0, fixture.now, "oval",
                                            wire::DetectedObstacleReport::Obstacle{1.2, 0.0, 0.05, 0.9}, 0.9};
  fixture.feed(wire::InputKind::message, "cosiva/v1/detected_obstacle/CoSiVA/AIV1", wire::to_json(report));
  const auto obstacles = [&] { return fixture.snapshot().find("obstacles")->array()->size(); };
  fixture.run_for(700ms);
  ASSERT_EQ(obstacles(), 1U);
  fixture.connection(aiv, wire::ConnectionState::offline);
  aiv.put({1.2, 0.0, 0.0});
  fixture.run_for(500ms);
  EXPECT_EQ(obstacles(), 1U);
  fixture.connection(aiv, wire::ConnectionState::online);
  fixture.run_for(500ms);
  EXPECT_EQ(obstacles(), 0U);
}

TEST_F(Objects, that_block_a_third_party_vehicle_pause_it_and_the_pause_persists) {
  FixtureVehicle& paused = fixture.add("agv-7", {0, 0.5}, "Acme");
  FixtureVehicle& other = fixture.add("agv-8", {2, 0.5}, "Acme");
  fixture.run_for(1s);
  add(R"("id":"P1","kind":"person","x":1.3,"y":0.0)");
  fixture.run_for(3s);
  ASSERT_TRUE(paused.paused);
  EXPECT_THAT(persisted(), HasSubstr(R"("paused":["Acme/agv-7"])"));
  // After a restart without the person, the server ends its own pause, and no other one.
  other.paused = true;
  persisted() = R"({"version":1,"virtualObjects":[],"aivs":[],"paused":["Acme/agv-7"]})";
  fixture.restart_server(true);
  fixture.run_for(2s);
  EXPECT_FALSE(paused.paused);
  EXPECT_TRUE(other.paused);
}

}  // namespace
}  // namespace cosiva::virtual_side
