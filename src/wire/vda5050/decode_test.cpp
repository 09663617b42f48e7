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
  EXPECT_EQ(read->edges[0], (OrderEdge{"e", 1, true, "a", "b", 0.4, 2.0, {}, {}, {}}));
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

TEST(Reading, accepts_numbers_up_to_a_milliard_and_refuses_larger_ones) {
  const auto position = [](const char* x) {
    return code(decode_visualization(
        visualization(R"({"y":0,"theta":0,"mapId":"m","positionInitialized":true,"x":)" + std::string(x) + "}")));
  };
  for (const char* good : {"1e9", "-1e9", "0", "-0.0"}) EXPECT_EQ(position(good), "accepted") << good;
  for (const char* bad : {"1000000001", "-1000000001"}) EXPECT_EQ(position(bad), "vda.range") << bad;
}

TEST(Reading, accepts_optional_numbers_at_the_limits_of_the_schema) {
  const auto node_code = [](const std::string& field) {
    return code(decode_order(order(node(R"(,"nodePosition":{"x":0,"y":0,"mapId":"m",)" + field + "}"))));
  };
  for (const char* key : {"allowedDeviationXY", "allowedDeviationXy"}) {
    EXPECT_EQ(node_code("\"" + std::string(key) + "\":0"), "accepted");
    EXPECT_EQ(node_code("\"" + std::string(key) + "\":0.5"), "accepted");
    EXPECT_EQ(node_code("\"" + std::string(key) + "\":-0.001"), "vda.range");
  }
  for (const char* key : {"maxSpeed", "length"}) {
    const std::string field = ",\"" + std::string(key) + "\":";
    EXPECT_EQ(code(decode_order(order("", edge(field + "0")))), "accepted") << key;
    EXPECT_EQ(code(decode_order(order("", edge(field + "0.5")))), "accepted") << key;
    EXPECT_EQ(code(decode_order(order("", edge(field + "-0.001")))), "vda.range") << key;
  }
  const auto score = [](const char* number) {
    return code(decode_visualization(
        visualization(R"({"x":0,"y":0,"theta":0,"mapId":"m","positionInitialized":true,"localizationScore":)" +
                      std::string(number) + "}")));
  };
  for (const char* good : {"0", "0.5", "1"}) EXPECT_EQ(score(good), "accepted") << good;
  for (const char* bad : {"-0.001", "1.001"}) EXPECT_EQ(score(bad), "vda.range") << bad;
}

TEST(Reading, distinguishes_a_vehicle_without_loads_from_one_that_does_not_know_them) {
  const auto loads = [](const std::string& more) {
    return decode_state(state(R"(,"nodeStates":[],"batteryState":{"batteryCharge":80,"charging":false})" + more));
  };
  EXPECT_FALSE(loads("")->loads);
  EXPECT_FALSE(loads(R"(,"loads":null)")->loads);
  EXPECT_EQ(loads(R"(,"loads":[])")->loads, std::vector<Load>{});
  EXPECT_EQ(loads(R"(,"loads":[{"loadId":"L1","loadType":"EPAL","loadPosition":"front","weight":0},{}])")->loads,
            (std::vector<Load>{{"L1", "EPAL", "front", 0.0}, {}}));
  EXPECT_EQ(code(loads(R"(,"loads":[{"weight":-0.001}])")), "vda.range");
  EXPECT_EQ(code(loads(R"(,"loads":{})")), "vda.type");
  EXPECT_EQ(code(loads(R"(,"loads":[{"loadId":7}])")), "vda.type");
}

TEST(Reading, accepts_counts_of_32_bits) {
  const auto sequence = [](const std::string& number) {
    const auto read = decode_order(order(R"({"nodeId":"n","sequenceId":)" + number + R"(,"released":true})"));
    return read ? std::to_string(read->nodes[0].sequence_id) : read.error().code;
  };
  EXPECT_EQ(sequence("0"), "0");
  EXPECT_EQ(sequence("4294967295"), "4294967295");
  EXPECT_EQ(sequence("4294967295.0"), "4294967295");
  EXPECT_EQ(sequence("4294967296"), "vda.range");
  EXPECT_EQ(sequence("-1"), "vda.range");
  EXPECT_EQ(sequence("0.5"), "vda.type");
  EXPECT_EQ(sequence("true"), "vda.type");
}

TEST(Reading, accepts_texts_lists_and_messages_up_to_their_longest) {
  const std::string longest(text_bytes_max, 'x');
  EXPECT_EQ(decode_visualization(R"({"manufacturer":")" + longest + "\"}").value().header.manufacturer, longest);
  EXPECT_EQ(
      decode_factsheet(R"({"typeSpecification":{"seriesDescription":")" + longest + "\"}}").value().series_description,
      longest);
  const auto parameter = [](std::size_t bytes) {
    return code(decode_instant_actions(
        instant("actions", R"({"actionType":"t","actionId":"1","actionParameters":[{"key":"k","value":")" +
                               std::string(bytes, 'x') + "\"}]}")));
  };
  EXPECT_EQ(parameter(text_bytes_max), "accepted");
  EXPECT_EQ(parameter(text_bytes_max + 1), "vda.size");

  std::string many = node("");
  for (std::size_t i = 1; i < array_items_max; ++i) many += ",7";
  EXPECT_EQ(code(decode_order(order(many))), "vda.type") << "the list is not too long, but its second item is no node";
  EXPECT_EQ(location(decode_order(order(many))), "order.nodes[1]");

  const std::string whole = "{}" + std::string(payload_bytes_max - 2, ' ');
  EXPECT_EQ(code(decode_visualization(whole)), "accepted");
  EXPECT_EQ(code(decode_visualization(whole + " ")), "vda.size");
}

TEST(Reading, accepts_31_levels_of_nesting_below_the_message) {
  const auto nested = [](std::size_t levels) {
    return code(decode_visualization(R"({"a":)" + std::string(levels, '[') + std::string(levels, ']') + "}"));
  };
  EXPECT_EQ(nested(31), "accepted");
  EXPECT_EQ(nested(32), "vda.json");
}

TEST(Reading, quotes_at_most_60_bytes_of_a_refused_text_and_no_half_character) {
  const auto message_about = [](const std::string& word) {
    return decode_connection("{" + header + R"(,"connectionState":")" + word + "\"}").error().message;
  };
  const std::string rest = " is not a term of the standard here";
  EXPECT_EQ(message_about(std::string(60, 'w')), "'" + std::string(60, 'w') + "'" + rest);
  EXPECT_EQ(message_about(std::string(61, 'w')), "'" + std::string(60, 'w') + "'" + rest);
  EXPECT_EQ(message_about(std::string(59, 'w') + "\xC3\xBC"), "'" + std::string(59, 'w') + "'" + rest);
  EXPECT_EQ(decode_visualization(R"({"version":"1.1"})").error().message, "'1.1' is not a version 2 of VDA 5050");
}

TEST(Reading, states_what_was_expected_and_what_was_found) {
  const auto message_about = [](const std::string& fields) {
    const auto read = decode_state(state(R"(,"nodeStates":[],)" + fields));
    return read ? "accepted" : read.error().message;
  };
  EXPECT_EQ(message_about(R"("batteryState":[])"), "expected an object, found an array");
  EXPECT_EQ(message_about(R"("batteryState":{"batteryCharge":"full"})"), "expected a number, found a text");
  EXPECT_EQ(message_about(R"("batteryState":{"batteryCharge":80,"charging":1})"), "expected a flag, found a number");
  EXPECT_EQ(message_about(R"("batteryState":{"batteryCharge":80,"charging":false},"zoneSetId":true)"),
            "expected a text, found a flag");
  EXPECT_EQ(message_about(R"("batteryState":{"batteryCharge":80,"charging":false},"information":{})"),
            "expected an array, found an object");
  EXPECT_EQ(message_about(R"("batteryState":{"charging":false})"), "required, but not there");
  EXPECT_EQ(decode_visualization("[]").error().message, "expected an object, found an array");
  EXPECT_EQ(decode_visualization("").error().message, "an empty message");
  EXPECT_EQ(decode_visualization(std::string(payload_bytes_max + 1, ' ')).error().message,
            "262145 bytes, at most 262144 are read");
  EXPECT_EQ(decode_order(order(R"({"nodeId":"n","sequenceId":[],"released":true})")).error().message,
            "expected a whole number, found an array");
}

TEST(Reading, reports_the_first_fault_only) {
  const auto read = decode_order("{" + header + R"(,"orderId":1,"orderUpdateId":"x","nodes":7})");
  EXPECT_EQ(location(read), "order.orderId");
}

TEST(Reading, requires_the_fields_that_the_schemas_require) {
  const auto missing = [](const std::string& json, const std::string& key, auto decode) {
    std::string without = json;
    const std::size_t at = without.rfind("\"" + key + "\":");
    EXPECT_NE(at, std::string::npos) << key;
    without.replace(at, 2, "\"~");
    const auto read = decode(without);
    EXPECT_EQ(code(read), "vda.missing") << key;
    return location(read);
  };
  const auto of_order = [&](const std::string& key) {
    return missing(order(node(R"(,"nodePosition":{"x":1,"y":2,"mapId":"m"})")), key, decode_order);
  };
  for (const char* key : {"headerId", "timestamp", "version", "manufacturer", "serialNumber", "orderId",
                          "orderUpdateId", "nodes", "edges"})
    EXPECT_EQ(of_order(key), "order." + std::string(key));
  for (const char* key : {"nodeId", "sequenceId", "released"})
    EXPECT_EQ(of_order(key), "order.nodes[0]." + std::string(key));
  for (const char* key : {"x", "y", "mapId"})
    EXPECT_EQ(of_order(key), "order.nodes[0].nodePosition." + std::string(key));
  for (const char* key : {"edgeId", "sequenceId", "released", "startNodeId", "endNodeId"})
    EXPECT_EQ(missing(order("", edge("")), key, decode_order), "order.edges[0]." + std::string(key));

  const std::string whole_state =
      "{" + header + "," + state_tail +
      R"(,"batteryState":{"batteryCharge":80,"charging":false},"agvPosition":{"x":1,"y":2,"theta":0,"mapId":"m",)"
      R"("positionInitialized":true},"nodeStates":[]})";
  for (const char* key :
       {"headerId", "orderId", "orderUpdateId", "lastNodeId", "lastNodeSequenceId", "driving", "edgeStates",
        "actionStates", "operatingMode", "errors", "safetyState", "batteryState", "nodeStates"})
    EXPECT_EQ(missing(whole_state, key, decode_state), "state." + std::string(key));
  for (const char* key : {"x", "y", "theta", "mapId", "positionInitialized"})
    EXPECT_EQ(missing(whole_state, key, decode_state), "state.agvPosition." + std::string(key));
  for (const char* key : {"batteryCharge", "charging"})
    EXPECT_EQ(missing(whole_state, key, decode_state), "state.batteryState." + std::string(key));
  for (const char* key : {"eStop", "fieldViolation"})
    EXPECT_EQ(missing(whole_state, key, decode_state), "state.safetyState." + std::string(key));
}

TEST(Reading, requires_the_fields_of_the_entries_of_a_state) {
  const auto at = [](const std::string& from, const std::string& list) {
    std::string json = state();
    const std::string empty = "\"" + from + "\":[]";
    const std::string filled = "\"" + from + "\":[" + list + "]";
    if (const std::size_t found = json.find(empty); found != std::string::npos)
      json.replace(found, empty.size(), filled);
    else
      json.insert(1, filled + ",");
    return location(decode_state(json));
  };
  EXPECT_EQ(at("edgeStates", R"({"edgeId":"e","sequenceId":1,"released":true})"), "accepted");
  EXPECT_EQ(at("edgeStates", R"({"sequenceId":1,"released":true})"), "state.edgeStates[0].edgeId");
  EXPECT_EQ(at("edgeStates", R"({"edgeId":"e","released":true})"), "state.edgeStates[0].sequenceId");
  EXPECT_EQ(at("edgeStates", R"({"edgeId":"e","sequenceId":1})"), "state.edgeStates[0].released");
  EXPECT_EQ(at("nodeStates", R"({"sequenceId":1,"released":true})"), "state.nodeStates[0].nodeId");
  EXPECT_EQ(at("nodeStates", R"({"nodeId":"n","released":true})"), "state.nodeStates[0].sequenceId");
  EXPECT_EQ(at("nodeStates", R"({"nodeId":"n","sequenceId":1})"), "state.nodeStates[0].released");
  EXPECT_EQ(at("actionStates", R"({"actionId":"a","actionStatus":"RUNNING"})"), "accepted");
  EXPECT_EQ(at("actionStates", R"({"actionStatus":"RUNNING"})"), "state.actionStates[0].actionId");
  EXPECT_EQ(at("actionStates", R"({"actionId":"a"})"), "state.actionStates[0].actionStatus");
  EXPECT_EQ(at("errors", R"({"errorType":"t","errorLevel":"FATAL"})"), "accepted");
  EXPECT_EQ(at("errors", R"({"errorLevel":"FATAL"})"), "state.errors[0].errorType");
  EXPECT_EQ(at("errors", R"({"errorType":"t"})"), "state.errors[0].errorLevel");
  const std::string reference = R"("errorReferences":[{"referenceKey":"k"}])";
  EXPECT_EQ(at("errors", R"({"errorType":"t","errorLevel":"FATAL",)" + reference + "}"),
            "state.errors[0].errorReferences[0].referenceValue");
  EXPECT_EQ(at("information", R"({"infoDescription":"d"})"), "state.information[0].infoType");
  EXPECT_EQ(at("information", R"({"infoType":"t","infoReferences":[{"referenceValue":"v"}]})"),
            "state.information[0].infoReferences[0].referenceKey");
  EXPECT_EQ(at("maps", R"({"mapVersion":"1","mapStatus":"ENABLED"})"), "state.maps[0].mapId");
  EXPECT_EQ(at("maps", R"({"mapId":"m","mapVersion":"1"})"), "state.maps[0].mapStatus");
}

TEST(Reading, requires_type_and_id_of_an_action_and_key_and_value_of_its_parameters) {
  const auto at = [](const std::string& action) {
    return location(decode_instant_actions(instant("actions", action)));
  };
  EXPECT_EQ(at(R"({"actionId":"1"})"), "instantActions.actions[0].actionType");
  EXPECT_EQ(at(R"({"actionType":"t"})"), "instantActions.actions[0].actionId");
  EXPECT_EQ(at(R"({"actionType":"t","actionName":"n","actionId":"1"})"), "accepted");
  EXPECT_EQ(at(R"({"actionType":"t","actionId":"1","actionParameters":[{"value":1}]})"),
            "instantActions.actions[0].actionParameters[0].key");
  EXPECT_EQ(at(R"({"actionType":"t","actionId":"1","actionParameters":[{"key":"k"}]})"),
            "instantActions.actions[0].actionParameters[0].value");
  const auto both = decode_instant_actions(instant("actions", R"({"actionType":"t","actionName":"n","actionId":"1"})"));
  EXPECT_EQ(both->actions[0].action_type, "t") << "the name of 2.1 counts where there are both";
  std::string two = instant("actions", R"({"actionType":"t","actionId":"1"})");
  two.insert(two.size() - 1, R"(,"instantActions":[])");
  EXPECT_EQ(decode_instant_actions(two)->actions.size(), 1U);
}

TEST(Reading, knows_an_edge_driven_backwards_by_its_orientation_of_half_a_turn) {
  const auto backwards = [](const std::string& field) {
    return decode_order(order("", edge(field)))->edges[0].backwards;
  };
  EXPECT_EQ(backwards(""), std::nullopt);
  EXPECT_EQ(backwards(R"(,"orientation":0)"), false);
  for (const char* half : {"3.14159", "-3.14159265359", "3.1415926535"})
    EXPECT_EQ(backwards(std::string(R"(,"orientationType":"TANGENTIAL","orientation":)") + half), true) << half;
  EXPECT_EQ(backwards(R"(,"orientation":1.5)"), std::nullopt);
}

TEST(Reading, takes_an_orientation_up_to_a_hundredth_of_a_degree_for_zero) {
  const auto unsupported = [](const std::string& orientation) {
    return decode_order(order("", edge(R"(,"orientation":)" + orientation)))->edges[0].unsupported;
  };
  for (const char* negligible : {"0", "0.00017", "-0.00017"}) EXPECT_THAT(unsupported(negligible), IsEmpty());
  for (const char* turned : {"0.00018", "-0.00018", "3.1", "1.57"})
    EXPECT_THAT(unsupported(turned), ElementsAre("orientation")) << turned;
  const auto type_alone = decode_order(order("", edge(R"(,"orientationType":"GLOBAL")")));
  EXPECT_THAT(type_alone->edges[0].unsupported, IsEmpty());
}

TEST(Reading, lists_requirements_of_an_edge_that_a_line_guided_vehicle_cannot_fulfil) {
  const auto unsupported = [](const std::string& field) {
    const auto read = decode_order(order("", edge("," + field)));
    return read ? read->edges.at(0).unsupported : std::vector<std::string>{to_string(read.error())};
  };
  EXPECT_THAT(unsupported(R"("trajectory":{"degree":1})"), ElementsAre("trajectory"));
  EXPECT_THAT(unsupported(R"("corridor":{"leftWidth":1,"rightWidth":1})"), ElementsAre("corridor"));
  EXPECT_THAT(unsupported(R"("maxHeight":1.5,"minHeight":0.5)"), ElementsAre("maxHeight", "minHeight"));
  EXPECT_THAT(unsupported(R"("orientation":1.5707963)"), ElementsAre("orientation"));
  EXPECT_THAT(unsupported(R"("orientation":0,"orientationType":"GLOBAL")"), ElementsAre("orientation"));
}

TEST(Reading, accepts_requirements_that_a_body_tangential_to_its_line_fulfils) {
  const auto read = decode_order(
      order("", edge(R"(,"orientation":0.0,"orientationType":"TANGENTIAL","rotationAllowed":false,"direction":"left",)"
                     R"("maxRotationSpeed":1,"trajectory":null)")));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_THAT(read->edges[0].unsupported, IsEmpty());
}

TEST(Reading, refuses_a_required_header_of_another_version) {
  const auto read = decode_connection(
      R"({"headerId":1,"timestamp":"2023-07-11T10:00:00Z","version":"3.0.0","manufacturer":"M","serialNumber":"S",)"
      R"("connectionState":"ONLINE"})");
  EXPECT_EQ(code(read), "vda.version");
  EXPECT_EQ(location(read), "connection.version");
}

TEST(Reading, leaves_what_is_absent_as_it_is_by_default) {
  const auto read = decode_state(state());
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_FALSE(read->paused);
  EXPECT_FALSE(read->new_base_request);
  EXPECT_EQ(read->distance_since_last_node_m, std::nullopt);
  EXPECT_EQ(read->position, std::nullopt);
  EXPECT_EQ(read->velocity, std::nullopt);
  EXPECT_EQ(read->battery.voltage_v, std::nullopt);
  EXPECT_EQ(read->battery.reach_m, std::nullopt);
  EXPECT_EQ(read->zone_set_id, "");
  const auto moving = decode_visualization(R"({"velocity":{"vy":0.5}})");
  ASSERT_TRUE(moving);
  EXPECT_EQ(moving->velocity, (Velocity{0.0, 0.5, 0.0}));
}

TEST(Reading, takes_the_deviation_of_2_1_where_there_are_both_spellings) {
  const auto read = decode_order(
      order(node(R"(,"nodePosition":{"x":0,"y":0,"allowedDeviationXY":0.2,"allowedDeviationXy":0.7,"mapId":"m"})")));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->nodes[0].position->allowed_deviation_xy_m, 0.2);
}

TEST(Reading, names_the_second_entry_of_a_list_in_a_list) {
  const std::string action =
      R"({"actionType":"t","actionId":"1","actionParameters":[{"key":"k","value":1},{"key":7}]})";
  const auto read = decode_order(order(node("") + R"(,{"nodeId":"n","sequenceId":2,"released":true,"actions":[)" +
                                       R"({"actionType":"t","actionId":"1"},)" + action + "]}"));
  EXPECT_EQ(code(read), "vda.type");
  EXPECT_EQ(location(read), "order.nodes[1].actions[1].actionParameters[1].key");
}

}  // namespace
}  // namespace cosiva::wire::vda5050
