#include "cosiva/virtual/server/missions/persisted_missions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;

/// The fork zone, and a server that has been started anew.
class PersistedText : public testing::Test {
 protected:
  void restore(const std::string& json) { persisted.restore(*JsonValue::parse(json)); }
  [[nodiscard]] std::string text() const {
    JsonWriter json;
    persisted.write(json);
    return json.text();
  }
  VehicleIndex add(const std::string& serial) {
    const VehicleIndex vehicle = orders.add(serial);
    persisted.registered(vehicle);
    return vehicle;
  }
  OrdersFixture orders{fork()};
  PersistedMissions persisted{orders.server.registry, orders.missions};
};

TEST_F(PersistedText, is_nothing_while_all_vehicles_have_their_default_missions) {
  add("AIV1");
  EXPECT_FALSE(persisted.worth_remembering());
  EXPECT_EQ(text(), R"({"zone":"fork","closed":[],"missions":[]})");
}

TEST_F(PersistedText, are_missions_and_closed_sections_as_json) {
  const VehicleIndex first = add("AIV1");
  add("AIV2");
  const VehicleIndex third = add("AIV3");
  orders.missions.give(first, {Mission::Kind::go, "dock"});
  EXPECT_TRUE(persisted.worth_remembering());
  orders.missions.give(third, {Mission::Kind::go, "gate", "area_b/rack"});
  orders.missions.set_closed({orders.section("south")});
  EXPECT_EQ(text(), R"({"zone":"fork","closed":["south"],"missions":[)"
                    R"({"vehicle":"CoSiVA/AIV1","kind":"go","name":"dock"},)"
                    R"({"vehicle":"CoSiVA/AIV3","kind":"go","name":"gate","beyond":"area_b/rack"}]})");
}

TEST_F(PersistedText, are_closed_sections_alone) {
  orders.missions.set_closed({orders.section("south")});
  EXPECT_TRUE(persisted.worth_remembering());
}

TEST_F(PersistedText, missions_are_given_back_to_vehicles_known_and_to_vehicles_that_register_later) {
  const VehicleIndex known = add("AIV1");
  const std::string persisted_json = R"({"zone":"fork","closed":["bypass3"],"missions":[)"
                                     R"({"vehicle":"CoSiVA/AIV1","kind":"go","name":"dock"},)"
                                     R"({"vehicle":"CoSiVA/AIV2","kind":"circulate","name":""},)"
                                     R"({"vehicle":"CoSiVA/AIV3","kind":"go","name":"gate","beyond":"b/x"}]})";
  restore(persisted_json);
  EXPECT_EQ(orders.missions.mission(known), (Mission{Mission::Kind::go, "dock"}));
  EXPECT_THAT(orders.missions.closed().all(), ElementsAre(orders.section("bypass3")));
  EXPECT_EQ(orders.missions.revision(known), 1U + 1U + 1U) << "zone, mission, and closed sections";
  const VehicleIndex later = add("AIV3");
  EXPECT_EQ(orders.missions.mission(later), (Mission{Mission::Kind::go, "gate", "b/x"}));
  orders.missions.give(later, {});
  EXPECT_TRUE(persisted.worth_remembering());
  EXPECT_EQ(text(), R"({"zone":"fork","closed":["bypass3"],"missions":[)"
                    R"({"vehicle":"CoSiVA/AIV1","kind":"go","name":"dock"},)"
                    R"({"vehicle":"CoSiVA/AIV2","kind":"circulate","name":""}]})")
      << "AIV2 has not registered yet";
}

TEST_F(PersistedText, missions_of_vehicles_that_have_not_registered_are_worth_remembering) {
  restore(R"({"zone":"fork","closed":[],"missions":[{"vehicle":"CoSiVA/AIV2","kind":"go","name":"dock"}]})");
  EXPECT_TRUE(persisted.worth_remembering());
}

TEST_F(PersistedText, missions_to_a_goal_that_the_zone_does_not_have_are_dropped) {
  restore(R"({"missions":[{"vehicle":"CoSiVA/AIV1","kind":"go","name":"nowhere"}]})");
  EXPECT_EQ(orders.missions.mission(add("AIV1")), Mission{});
  EXPECT_FALSE(persisted.worth_remembering());
}

TEST_F(PersistedText, missions_are_given_back_before_there_is_a_zone) {
  orders.missions.set_map(nullptr);
  restore(R"({"zone":"fork","closed":["south"],"missions":[{"vehicle":"CoSiVA/AIV1","kind":"go","name":"nowhere"}]})");
  EXPECT_EQ(orders.missions.mission(add("AIV1")).name, "nowhere") << "the zone decides later";
  EXPECT_EQ(text(), R"({"zone":"","closed":[],"missions":[{"vehicle":"CoSiVA/AIV1","kind":"go","name":"nowhere"}]})");
  EXPECT_FALSE(persisted.take_closed(nullptr));
  EXPECT_THAT(persisted.take_closed(&*orders.map), testing::Optional(ElementsAre(orders.section("south"))));
  EXPECT_FALSE(persisted.take_closed(&*orders.map)) << "only once";
}

TEST_F(PersistedText, closed_sections_of_another_zone_do_not_count) {
  orders.missions.set_closed({orders.section("south")});
  restore(R"({"zone":"oval","closed":["bypass3"],"missions":[]})");
  EXPECT_THAT(orders.missions.closed().all(), ElementsAre(orders.section("south")));
  EXPECT_FALSE(persisted.take_closed(&*orders.map));
}

TEST_F(PersistedText, sections_that_the_zone_does_not_have_are_left_out) {
  restore(R"({"zone":"fork","closed":["gone","south",7],"missions":[]})");
  EXPECT_THAT(orders.missions.closed().all(), ElementsAre(orders.section("south")));
}

TEST_F(PersistedText, entries_that_are_no_missions_are_left_out) {
  restore(R"({"zone":"fork","closed":"south","missions":[{"kind":"go","name":"dock"},)"
          R"({"vehicle":"CoSiVA/AIV1"},{"vehicle":")" +
          std::string(mission_name_bytes_max, 'a') + R"("},{"vehicle":")" +
          std::string(mission_name_bytes_max + 1, 'b') + R"("}]})");
  EXPECT_THAT(orders.missions.closed().all(), IsEmpty());
  EXPECT_EQ(text(), R"({"zone":"fork","closed":[],"missions":[{"vehicle":"CoSiVA/AIV1","kind":"circulate","name":""},)"
                    R"({"vehicle":")" +
                        std::string(mission_name_bytes_max, 'a') + R"(","kind":"circulate","name":""}]})");
}

TEST_F(PersistedText, missions_are_at_most_as_many_as_the_registry_can_have_vehicles) {
  constexpr std::size_t vehicles_max = Registry::vehicles_max_default;
  std::string persisted_json = R"({"missions":[)";
  for (std::size_t i = 0; i <= vehicles_max; ++i)
    persisted_json +=
        (i == 0 ? "" : ",") + std::string(R"({"vehicle":"V/)") + std::to_string(i) + R"(","kind":"go","name":"dock"})";
  restore(persisted_json + "]}");
  const std::string written = text();
  EXPECT_NE(written.find("\"V/" + std::to_string(vehicles_max - 1) + '"'), std::string::npos);
  EXPECT_EQ(written.find("\"V/" + std::to_string(vehicles_max) + '"'), std::string::npos);
}

}  // namespace
}  // namespace cosiva::virtual_side
