#include "cosiva/wire/vda5050/factsheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::wire::vda5050 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Factsheet whole_factsheet() {
  Factsheet sheet;
  sheet.header = {7, virtual_epoch, "", "M", "S"};
  sheet.series_name = "CoSiVA AIV";
  sheet.series_description = "small";
  sheet.agv_kinematic = "OMNI";
  sheet.agv_class = "TUGGER";
  sheet.speed_min_mps = 0.125;
  sheet.speed_max_mps = 0.5;
  sheet.acceleration_max_mps2 = 0.75;
  sheet.deceleration_max_mps2 = 1.5;
  sheet.height_m = 0.25;
  sheet.width_m = 0.375;
  sheet.length_m = 0.625;
  sheet.min_order_interval_s = 2;
  sheet.min_state_interval_s = 3;
  sheet.default_state_interval_s = 4;
  sheet.visualization_interval_s = 5;
  sheet.actions = {{"a", "does", true, true, true, {{"k", std::string("NUMBER")}, {"l", std::string("STRING")}}},
                   {"b", "", false, false, true, {}}};
  return sheet;
}

TEST(Factsheet, is_written_field_by_field) {
  // The limits are those of the reader: 256 KiB, 1024 bytes, 4096 entries.
  EXPECT_EQ(
      encode(whole_factsheet()),
      R"({"headerId":7,"timestamp":"2023-07-11T00:00:00.000Z","version":"2.1.0","manufacturer":"M","serialNumber":"S",)"
      R"("typeSpecification":{"seriesName":"CoSiVA AIV","seriesDescription":"small","agvKinematic":"OMNI",)"
      R"("agvClass":"TUGGER","maxLoadMass":0,"localizationTypes":["RFID","SPOT"],)"
      R"("navigationTypes":["PHYSICAL_LINE_GUIDED"]},"physicalParameters":{"speedMin":0.125,"speedMax":0.5,)"
      R"("accelerationMax":0.75,"decelerationMax":1.5,"heightMin":0.25,"heightMax":0.25,"width":0.375,"length":0.625},)"
      R"("protocolLimits":{"maxStringLens":{"msgLen":262144,"topicSerialLen":64,"idLen":1024},)"
      R"("maxArrayLens":{"order.nodes":4096,"order.edges":4096,"node.actions":4096,"edge.actions":4096,)"
      R"("actions.actionsParameters":4096,"instantActions":4096},"timing":{"minOrderInterval":2,)"
      R"("minStateInterval":3,"defaultStateInterval":4,"visualizationInterval":5}},)"
      R"("protocolFeatures":{"optionalParameters":[],"agvActions":[{"actionType":"a","actionDescription":"does",)"
      R"("actionScopes":["INSTANT","NODE","EDGE"],"actionParameters":[{"key":"k","valueDataType":"NUMBER"},)"
      R"({"key":"l","valueDataType":"STRING"}]},{"actionType":"b","actionScopes":["EDGE"]}]},)"
      R"("agvGeometry":{},"loadSpecification":{}})");
}

TEST(Factsheet, is_written_with_a_term_of_the_standard_where_the_value_is_none) {
  Factsheet sheet = whole_factsheet();
  sheet.agv_kinematic = "LEGS";
  sheet.agv_class = "";
  sheet.actions = {
      {"a", "", true, false, false, {{"k", 3.0}, {"l", std::string("number")}, {"m", std::string("BOOL")}}}};
  const std::string json = encode(sheet);
  EXPECT_THAT(json, HasSubstr(R"("agvKinematic":"DIFF","agvClass":"CARRIER")"));
  EXPECT_THAT(json, HasSubstr(R"([{"key":"k","valueDataType":"STRING"},{"key":"l","valueDataType":"STRING"},)"
                              R"({"key":"m","valueDataType":"BOOL"}])"));
}

TEST(Factsheet, reads_each_scope_of_an_action_and_ignores_unknown_ones) {
  const auto scopes = [](const std::string& list) {
    const auto sheet =
        decode_factsheet(R"({"protocolFeatures":{"agvActions":[{"actionType":"a","actionScopes":)" + list + "}]}}");
    if (!sheet) return sheet.error().location;
    const auto& action = sheet->actions.at(0);
    return std::string(action.instant ? "I" : "-") + (action.node ? "N" : "-") + (action.edge ? "E" : "-");
  };
  EXPECT_EQ(scopes("[]"), "---");
  EXPECT_EQ(scopes(R"(["INSTANT"])"), "I--");
  EXPECT_EQ(scopes(R"(["NODE"])"), "-N-");
  EXPECT_EQ(scopes(R"(["EDGE"])"), "--E");
  EXPECT_EQ(scopes(R"(["EDGE","INSTANT","ZONE","NODE"])"), "INE");
  EXPECT_EQ(scopes(R"([7])"), "factsheet.protocolFeatures.agvActions[0].actionScopes");
  EXPECT_EQ(scopes(R"({})"), "factsheet.protocolFeatures.agvActions[0].actionScopes");
}

TEST(Factsheet, takes_a_parameter_without_type_for_a_text) {
  const auto sheet =
      decode_factsheet(R"({"protocolFeatures":{"agvActions":[{"actionType":"a","actionParameters":[{"key":"k"}]}]}})");
  ASSERT_TRUE(sheet);
  EXPECT_THAT(sheet->actions.at(0).parameters, ElementsAre(Parameter{"k", std::string("STRING")}));
}

TEST(Factsheet, requires_only_the_names_of_its_actions_and_parameters) {
  const auto location = [](const char* action) {
    const auto sheet = decode_factsheet(R"({"protocolFeatures":{"agvActions":[)" + std::string(action) + "]}}");
    return sheet ? "accepted" : sheet.error().location;
  };
  EXPECT_EQ(location("{}"), "factsheet.protocolFeatures.agvActions[0].actionType");
  EXPECT_EQ(location(R"({"actionType":"a","actionParameters":[{}]})"),
            "factsheet.protocolFeatures.agvActions[0].actionParameters[0].key");
  EXPECT_EQ(location(R"({"actionType":"a"})"), "accepted");
}

}  // namespace
}  // namespace cosiva::wire::vda5050
