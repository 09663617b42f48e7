#include "cosiva/app/vehicle/listed_vehicles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using testing::HasSubstr;

constexpr const char* snapshot =
    R"j({"aivs":[{"id":"CoSiVA/AIV1","number":1,"connection":"ONLINE","status":"normal","section":"loop_sw","augmented":false,)j"
    R"j("excluded":true,"absent":null},{"id":"ACME/7","number":7,"connection":"CONNECTIONBROKEN","status":"stopped",)j"
    R"j("section":null,"augmented":false,"excluded":false,"absent":"its connection has ended (CONNECTIONBROKEN)"},)j"
    R"j({"id":"CoSiVA.virtual/7","number":8,"connection":"ONLINE","status":"normal","section":"loop_sw","augmented":true}]})j";

TEST(ListedVehicles, are_read_from_a_snapshot) {
  const auto vehicles = vehicles_in(snapshot);
  ASSERT_TRUE(vehicles && vehicles->size() == 3);
  EXPECT_TRUE((*vehicles)[0].excluded);
  EXPECT_EQ((*vehicles)[0].absent, "");
  EXPECT_EQ((*vehicles)[1].section, "");
  EXPECT_EQ((*vehicles)[1].absent, "its connection has ended (CONNECTIONBROKEN)");
  EXPECT_TRUE((*vehicles)[2].is_virtual);
}

TEST(ListedVehicles, have_the_order_of_the_page_whatever_the_order_of_their_arrival) {
  const auto vehicles = vehicles_in(
      R"j({"aivs":[{"id":"CoSiVA.virtual/V1","number":1,"augmented":true},{"id":"CoSiVA/AIV10","number":10},)j"
      R"j({"id":"CoSiVA/AIV9","number":9}]})j");
  ASSERT_TRUE(vehicles && vehicles->size() == 3);
  EXPECT_EQ((*vehicles)[0].id, "CoSiVA/AIV9");
  EXPECT_EQ((*vehicles)[1].id, "CoSiVA/AIV10");
  EXPECT_EQ((*vehicles)[2].id, "CoSiVA.virtual/V1");
}

TEST(ListedVehicles, cannot_be_read_from_anything_else) {
  for (const char* other : {"", "no json", "[]", R"({"aivs":7})"}) {
    const auto vehicles = vehicles_in(other);
    ASSERT_FALSE(vehicles) << other;
    EXPECT_EQ(vehicles.error().code, "vehicle.snapshot") << other;
  }
}

TEST(ListedVehicles, have_a_line_each_that_states_how_they_match) {
  const std::string text = to_text(*vehicles_in(snapshot));
  EXPECT_THAT(text, HasSubstr("CoSiVA/AIV1       ONLINE            normal   loop_sw     matched, excluded\n"));
  EXPECT_THAT(text, HasSubstr("-           orphan: its connection has ended (CONNECTIONBROKEN)\n"));
  EXPECT_THAT(text, HasSubstr("virtual only"));
  EXPECT_EQ(to_text({}), "no vehicle");
}

TEST(ListedVehicles, are_written_as_json) {
  const auto json = JsonValue::parse(to_json(*vehicles_in(snapshot)));
  ASSERT_TRUE(json && json->array() != nullptr && json->array()->size() == 3);
  EXPECT_EQ((*json->array())[1].text("id"), "ACME/7");
  EXPECT_EQ((*json->array())[0].flag("excluded"), true);
}

TEST(VehicleName, is_an_id_or_a_serial_number_that_one_vehicle_has) {
  const auto vehicles = *vehicles_in(snapshot);
  EXPECT_EQ(id_of("AIV1", vehicles), "CoSiVA/AIV1");
  EXPECT_EQ(id_of("ACME/7", vehicles), "ACME/7");
  EXPECT_EQ(id_of("ACME/9", vehicles), "ACME/9") << "the platform decides";
}

TEST(VehicleName, of_several_vehicles_or_of_none_is_refused_with_those_that_exist) {
  const auto vehicles = *vehicles_in(snapshot);
  const auto ambiguous = id_of("7", vehicles);
  ASSERT_FALSE(ambiguous);
  EXPECT_EQ(ambiguous.error().code, "vehicle.ambiguous");
  EXPECT_THAT(ambiguous.error().message, HasSubstr("ACME/7 and CoSiVA.virtual/7"));
  const auto mistyped = id_of("AIV2", vehicles);
  ASSERT_FALSE(mistyped);
  EXPECT_THAT(mistyped.error().message, HasSubstr("did you mean AIV1?"));
  EXPECT_THAT(id_of("truck", vehicles).error().message,
              HasSubstr("the platform has CoSiVA/AIV1, ACME/7, CoSiVA.virtual/7"));
  EXPECT_THAT(id_of("AIV1", {}).error().message, HasSubstr("the platform has no vehicle"));
}

}  // namespace
}  // namespace cosiva::app
