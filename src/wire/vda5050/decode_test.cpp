#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "cosiva/base/math.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::wire::vda5050 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string header =
    R"("headerId":7,"timestamp":"2023-07-11T10:00:00.12Z","version":"2.0.0","manufacturer":"M","serialNumber":"S")";

std::string node(const std::string& more) {
  return R"({"nodeId":"n","sequenceId":0,"released":true,"actions":[])" + more + "}";
}
std::string edge(const std::string& more) {
  return R"({"edgeId":"e","sequenceId":1,"released":true,"startNodeId":"a","endNodeId":"b","actions":[])" + more + "}";
}
std::string order(const std::string& nodes, const std::string& edges = "") {
  return "{" + header + R"(,"orderId":"O","orderUpdateId":0,"nodes":[)" + nodes + R"(],"edges":[)" + edges + "]}";
}
std::string instant(const std::string& array, const std::string& action) {
  return "{" + header + ",\"" + array + "\":[" + action + "]}";
}
const std::string state_tail =
    R"("orderId":"","orderUpdateId":0,"lastNodeId":"","lastNodeSequenceId":0,"driving":false,"edgeStates":[],)"
    R"("actionStates":[],"operatingMode":"AUTOMATIC","errors":[],"safetyState":{"eStop":"NONE","fieldViolation":false})";
std::string state(
    const std::string& more = R"(,"nodeStates":[],"batteryState":{"batteryCharge":80,"charging":false})") {
  return "{" + header + "," + state_tail + more + "}";
}
std::string visualization(const std::string& position) { return R"({"agvPosition":)" + position + "}"; }

template <typename T>
std::string code(const Result<T>& result) {
  return result ? "accepted" : result.error().code;
}
template <typename T>
std::string location(const Result<T>& result) {
  return result ? "accepted" : result.error().location;
}

TEST(Reading, gives_the_values_of_the_message) {
  const auto read = decode_order(order(
      node(
          R"(,"nodePosition":{"x":1.5,"y":-2,"theta":0.5,"allowedDeviationXY":0.1,"mapId":"m"},"nodeDescription":"?")"),
      edge(R"(,"maxSpeed":0.4,"length":2)")));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_EQ(read->header.header_id, 7U);
  EXPECT_EQ(read->header.version, "2.0.0");
  EXPECT_EQ(read->header.timestamp, SimTime{std::chrono::milliseconds{1'689'069'600'120}});
  ASSERT_EQ(read->nodes.size(), 1U);
  EXPECT_EQ(read->nodes[0].position, (NodePosition{1.5, -2.0, 0.5, 0.1, {}, "m"}));
  ASSERT_EQ(read->edges.size(), 1U);
  EXPECT_EQ(read->edges[0], (OrderEdge{"e", 1, true, "a", "b", 0.4, 2.0, {}, {}}));
}

TEST(Reading, ignores_unknown_fields) {
  EXPECT_TRUE(decode_state(state(
      R"(,"nodeStates":[],"batteryState":{"batteryCharge":80,"charging":false,"colour":3},"loads":[{}],"maps":null)")));
}

TEST(Reading, takes_null_as_absent) {
  EXPECT_TRUE(decode_order(order(node(R"(,"nodePosition":null)"))));
  EXPECT_EQ(code(decode_order(order("null"))), "vda.type");
  EXPECT_EQ(code(decode_connection("{" + header + R"(,"connectionState":null})")), "vda.missing");
}

TEST(Reading, accepts_any_number_of_decimals_of_a_second) {
  for (const char* decimals : {"", ".1", ".12", ".123", ".123456", ".123456789", ".1234567891234567891234"}) {
    const std::string json = R"({"timestamp":"2023-07-11T10:00:00)" + std::string(decimals) + R"(Z"})";
    EXPECT_TRUE(decode_visualization(json)) << json;
  }
  EXPECT_EQ(code(decode_visualization(R"({"timestamp":"yesterday"})")), "vda.time");
  EXPECT_EQ(location(decode_visualization(R"({"timestamp":"yesterday"})")), "visualization.timestamp");
}

TEST(Reading, accepts_any_version_two_and_no_other) {
  for (const char* version : {"2", "2.0", "2.0.0", "2.1.0", "v2", "V2", "v2.1"})
    EXPECT_TRUE(decode_visualization(R"({"version":")" + std::string(version) + R"("})")) << version;
  for (const char* version : {"1.1.0", "3.0.0", "20.0", "", "two", "v", "22"})
    EXPECT_EQ(code(decode_visualization(R"({"version":")" + std::string(version) + R"("})")), "vda.version") << version;
}

TEST(Reading, requires_the_header_where_order_depends_on_it_and_not_for_display) {
  EXPECT_TRUE(decode_visualization("{}"));
  EXPECT_TRUE(decode_factsheet("{}"));
  const auto connection = decode_connection(R"({"connectionState":"ONLINE"})");
  EXPECT_EQ(code(connection), "vda.missing");
  EXPECT_EQ(location(connection), "connection.headerId");
}

TEST(Reading, accepts_instant_actions_under_the_names_of_older_peers) {
  const std::string old_action = R"({"actionName":"startPause","actionId":"1"})";
  for (const char* array : {"actions", "instantActions"}) {
    const auto read = decode_instant_actions(instant(array, old_action));
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_THAT(read->actions, ElementsAre(Action{"startPause", "1", "", BlockingType::none, {}}));
  }
  EXPECT_EQ(location(decode_instant_actions("{" + header + "}")), "instantActions.actions");
}

TEST(Reading, accepts_the_deviation_in_both_spellings) {
  const auto read = decode_order(order(node(R"(,"nodePosition":{"x":0,"y":0,"allowedDeviationXy":0.7,"mapId":"m"})")));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->nodes[0].position->allowed_deviation_xy_m, 0.7);
}

TEST(Writing, gives_a_peer_of_2_0_both_spellings) {
  InstantActions actions{{0, {}, "2.0.0", "M", "S"}, {{"startPause", "1", "", BlockingType::none, {}}}};
  EXPECT_THAT(encode(actions), HasSubstr(R"("instantActions":[{"actionType":"startPause")"));
  EXPECT_THAT(encode(actions), HasSubstr(R"("actionName":"startPause")"));
  actions.header.version = "2.1.0";
  EXPECT_THAT(encode(actions), testing::Not(HasSubstr("instantActions")));
  Order o;
  o.header.version = "2.0.0";
  o.nodes.push_back({"n", 0, true, NodePosition{0, 0, {}, 0.5, {}, "m"}, {}});
  EXPECT_THAT(encode(o), HasSubstr(R"("allowedDeviationXY":0.5,"allowedDeviationXy":0.5)"));
}

TEST(Writing, states_our_version_where_none_is_given_and_the_peers_own_otherwise) {
  EXPECT_THAT(encode(Connection{}), HasSubstr(R"("version":"2.1.0")"));
  EXPECT_THAT(encode(Connection{{0, {}, "v2", "", ""}, {}}), HasSubstr(R"("version":"v2")"));
}

TEST(Reading, preserves_parameters_of_any_type) {
  const auto read = decode_instant_actions(instant(
      "actions",
      R"({"actionType":"t","actionId":"1","blockingType":"HARD","actionParameters":[{"key":"a","value":1.5},)"
      R"({"key":"b","value":true},{"key":"c","value":"x"},{"key":"d","value":{ "e" : [1, 2] }},{"key":"f","value":1689033600000}]})"));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_THAT(read->actions[0].parameters,
              ElementsAre(Parameter{"a", 1.5}, Parameter{"b", true}, Parameter{"c", std::string("x")},
                          Parameter{"d", RawJson{R"({"e":[1,2]})"}}, Parameter{"f", 1689033600000.0}));
  EXPECT_EQ(location(decode_instant_actions(instant(
                "actions", R"({"actionType":"t","actionId":"1","actionParameters":[{"key":"a","value":null}]})"))),
            "instantActions.actions[0].actionParameters[0].value");
}

TEST(Reading, reads_the_maps_of_2_1_and_does_not_require_them_of_a_peer_of_2_0) {
  const std::string rest = R"(,"nodeStates":[],"batteryState":{"batteryCharge":80,"charging":false})";
  EXPECT_TRUE(decode_state(state()).value().maps.empty());
  const auto read = decode_state(
      state(rest + R"(,"maps":[{"mapId":"area","mapVersion":"2","mapDescription":"east","mapStatus":"ENABLED"},)"
                   R"({"mapId":"yard","mapVersion":"1","mapStatus":"DISABLED"}])"));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_THAT(read->maps, ElementsAre(MapInfo{"area", "2", "east", true}, MapInfo{"yard", "1", "", false}));
  EXPECT_EQ(location(decode_state(state(rest + R"(,"maps":[{"mapId":"area","mapStatus":"ENABLED"}])"))),
            "state.maps[0].mapVersion");
  EXPECT_EQ(location(decode_state(state(rest + R"(,"maps":[{"mapId":"area","mapVersion":"1","mapStatus":"ON"}])"))),
            "state.maps[0].mapStatus");
}

TEST(Reading, names_the_location_of_a_fault) {
  const auto read = decode_state(state(
      R"(,"batteryState":{"batteryCharge":80,"charging":false},"nodeStates":[{"nodeId":"a","sequenceId":0,"released":true},)"
      R"({"nodeId":"b","sequenceId":"two","released":true}])"));
  EXPECT_EQ(code(read), "vda.type");
  EXPECT_EQ(location(read), "state.nodeStates[1].sequenceId");
  EXPECT_EQ(location(decode_state(state(R"(,"nodeStates":[],"batteryState":{"charging":false})"))),
            "state.batteryState.batteryCharge");
  EXPECT_EQ(location(decode_state(state(R"(,"nodeStates":{},"batteryState":{"batteryCharge":1,"charging":false})"))),
            "state.nodeStates");
}

TEST(Reading, refuses_numbers_out_of_range) {
  for (const char* sequence : {"-1", "4294967296", "1e300"})
    EXPECT_EQ(code(decode_order(order(R"({"nodeId":"n","sequenceId":)" + std::string(sequence) +
                                      R"(,"released":true,"actions":[]})"))),
              "vda.range")
        << sequence;
  EXPECT_EQ(code(decode_order(order(R"({"nodeId":"n","sequenceId":1.5,"released":true,"actions":[]})"))), "vda.type");
  EXPECT_TRUE(decode_order(order(R"({"nodeId":"n","sequenceId":2.0,"released":true,"actions":[]})")));
  EXPECT_EQ(code(decode_order(order(node(R"(,"nodePosition":{"x":1e10,"y":0,"mapId":"m"})")))), "vda.range");
  EXPECT_EQ(code(decode_order(order(node(R"(,"nodePosition":{"x":0,"y":0,"allowedDeviationXY":-1,"mapId":"m"})")))),
            "vda.range");
  EXPECT_EQ(code(decode_order(order("", edge(R"(,"maxSpeed":-0.1)")))), "vda.range");
  EXPECT_EQ(code(decode_visualization(
                visualization(R"({"x":1e400,"y":0,"theta":0,"mapId":"m","positionInitialized":true})"))),
            "vda.json");
  EXPECT_EQ(code(decode_visualization(visualization(
                R"({"x":0,"y":0,"theta":0,"mapId":"m","positionInitialized":true,"localizationScore":1.1})"))),
            "vda.range");
}

TEST(Reading, brings_angles_into_one_turn) {
  const auto read =
      decode_visualization(visualization(R"({"x":0,"y":0,"theta":3.2,"mapId":"m","positionInitialized":true})"));
  ASSERT_TRUE(read);
  EXPECT_NEAR(read->position->pose.heading_rad, 3.2 - 2 * pi, 1e-12);
}

TEST(Reading, refuses_terms_that_are_not_the_standards) {
  EXPECT_EQ(code(decode_connection("{" + header + R"(,"connectionState":"ASLEEP"})")), "vda.value");
  EXPECT_EQ(code(decode_connection("{" + header + R"(,"connectionState":"online"})")), "vda.value");
  EXPECT_EQ(code(decode_connection("{" + header + R"(,"connectionState":1})")), "vda.type");
}

TEST(Reading, is_bounded) {
  EXPECT_EQ(code(decode_visualization(std::string(payload_bytes_max + 1, ' '))), "vda.size");
  const std::string long_text(text_bytes_max + 1, 'x');
  EXPECT_EQ(code(decode_visualization(R"({"manufacturer":")" + long_text + "\"}")), "vda.size");
  std::string many = node("");
  for (std::size_t i = 0; i < array_items_max; ++i) many += ",0";
  const auto read = decode_order(order(many));
  EXPECT_EQ(code(read), "vda.size");
  EXPECT_EQ(location(read), "order.nodes");
}

TEST(Reading, cuts_long_descriptions_instead_of_refusing_the_state) {
  std::string phrase;
  while (phrase.size() < text_bytes_max + 10) phrase += "\xC3\xBC\xE2\x82\xAC";
  const auto read = decode_factsheet(R"({"typeSpecification":{"seriesDescription":")" + phrase + "\"}}");
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_LE(read->series_description.size(), text_bytes_max);
  EXPECT_GT(read->series_description.size(), text_bytes_max - 4);
  EXPECT_EQ(phrase.substr(0, read->series_description.size()), read->series_description);
  EXPECT_TRUE(decode_factsheet(encode(*read)));
}

TEST(Reading, refuses_what_is_not_one_json_object) {
  for (const std::string& text :
       {std::string{}, std::string("{"), std::string("[]"), std::string("3"), std::string("{}{}"),
        std::string("\xFF\xFE"), std::string("{\"a\":\"\xC3\x28\"}"), std::string(1000, '['),
        R"({"a":)" + std::string(100, '[') + std::string(100, ']') + "}"})
    EXPECT_EQ(code(decode_visualization(text)), "vda.json") << text.substr(0, 20);
  EXPECT_EQ(code(decode_visualization(std::string_view{})), "vda.json");
  EXPECT_TRUE(decode_visualization("{}")) << "and the parser still works";
}

TEST(Reading, lists_requirements_of_an_edge_that_a_line_guided_vehicle_cannot_fulfil) {
  const auto unsupported = [](const std::string& field) {
    const auto read = decode_order(order("", edge("," + field)));
    return read ? read->edges.at(0).unsupported : std::vector<std::string>{to_string(read.error())};
  };
  EXPECT_THAT(unsupported(R"("trajectory":{"degree":1})"), ElementsAre("trajectory"));
  EXPECT_THAT(unsupported(R"("corridor":{"leftWidth":1,"rightWidth":1})"), ElementsAre("corridor"));
  EXPECT_THAT(unsupported(R"("maxHeight":1.5,"minHeight":0.5)"), ElementsAre("maxHeight", "minHeight"));
  EXPECT_THAT(unsupported(R"("orientation":3.14159)"), ElementsAre("orientation"));
  EXPECT_THAT(unsupported(R"("orientation":0,"orientationType":"GLOBAL")"), ElementsAre("orientation"));
}

TEST(Reading, accepts_requirements_that_a_body_tangential_to_its_line_fulfils) {
  const auto read = decode_order(
      order("", edge(R"(,"orientation":0.0,"orientationType":"TANGENTIAL","rotationAllowed":false,"direction":"left",)"
                     R"("maxRotationSpeed":1,"trajectory":null)")));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_THAT(read->edges[0].unsupported, IsEmpty());
}

}  // namespace
}  // namespace cosiva::wire::vda5050
