#include "cosiva/app/vehicle/vehicle_boards_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using testing::HasSubstr;

constexpr const char* snapshot =
    R"j({"aivs":[{"id":"CoSiVA/AIV1","number":1,"boards":[{"board":"PILS","health":"faulty","selfTest":50,)j"
    R"j("fault":"DEMS: implausible readings","parts":{"BRAC":"passed","DEMS":"implausible readings"}},)j"
    R"j({"board":"RALI","health":"absent","selfTest":0}],"pils":{"supply":4.987,"plugs":7,)j"
    R"j("dems":[0,0,96,255,255,32,0,255],"leftSpeed":0.31,"leftCurrent":0.14,"rightSpeed":0.325,"rightCurrent":0.135},)j"
    R"j("affi":"AIV1 normal 0.3","proxies":[{"agent":"AIV_Server","sent":1204,"delivered":531}]},{"id":"ACME/7","number":7}]})j";

TEST(VehicleBoards, are_printed_with_health_self_test_readings_and_the_display_s_text) {
  EXPECT_EQ(*boards_in(snapshot, {"AIV1"}, false),
            "CoSiVA/AIV1\n"
            "  PILS  faulty, DEMS: implausible readings; self-test: BRAC passed, DEMS implausible readings\n"
            "  RALI  absent\n"
            "  BRAC  4.99 V\n"
            "  DEMS  0 0 96 255 255 32 0 255\n"
            "  PMOT  left 0.310 m/s 0.140 A right 0.325 m/s 0.135 A\n"
            "  AFFI  AIV1 normal 0.3\n"
            "  proxy of AIV_Server  1204 sent, 531 delivered");
}

TEST(VehicleBoards, are_printed_of_all_vehicles_and_of_those_that_report_none) {
  EXPECT_THAT(*boards_in(snapshot, {}, false), HasSubstr("\nACME/7\n  reports no boards"));
  EXPECT_EQ(*boards_in(R"({"aivs":[]})", {}, false), "no vehicle");
}

TEST(VehicleBoards, are_written_as_json) {
  const auto json = JsonValue::parse(*boards_in(snapshot, {"ACME/7", "AIV1"}, true));
  ASSERT_TRUE(json && json->array() != nullptr);
  ASSERT_EQ(json->array()->size(), 2U);
  EXPECT_EQ((*json->array())[0].text("affi"), "AIV1 normal 0.3");
  EXPECT_EQ((*json->array())[1].find("boards"), nullptr);
}

TEST(VehicleBoards, of_an_unknown_vehicle_or_another_page_are_refused) {
  EXPECT_EQ(boards_in(snapshot, {"AIV2"}, false).error().code, "vehicle.unknown");
  EXPECT_EQ(boards_in("no json", {}, false).error().code, "vehicle.snapshot");
}

}  // namespace
}  // namespace cosiva::app
