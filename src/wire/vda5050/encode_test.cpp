#include "cosiva/wire/vda5050/encode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <string>

#include "cosiva/base/math.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::wire::vda5050 {
namespace {

using testing::HasSubstr;
using testing::Not;

Header header(std::string version = "") {
  return {7, virtual_epoch + std::chrono::milliseconds{120}, std::move(version), "M", "S"};
}
constexpr std::string_view header_json =
    R"("headerId":7,"timestamp":"2023-07-11T00:00:00.120Z","version":"2.1.0","manufacturer":"M","serialNumber":"S")";

/// An order with all that an order may have.
Order whole_order(std::string version = "") {
  Order order{header(std::move(version)), "O", 3, "Z", {}, {}};
  order.nodes.push_back({"n", 0, true, NodePosition{1.5, -2.0, 0.5, 0.25, 0.125, "m"}, {}});
  order.nodes.back().actions.push_back({"pick",
                                        "A",
                                        "a box",
                                        BlockingType::hard,
                                        {{"k", 1.5}, {"l", true}, {"m", std::string("x")}, {"n", RawJson{"[1]"}}}});
  order.edges.push_back({"e", 1, false, "n", "o", 0.75, 2.5, {{"wait", "B", "", BlockingType::soft, {}}}, true, {}});
  return order;
}

TEST(Encode, writes_an_order_field_by_field) {
  EXPECT_EQ(
      encode(whole_order()),
      "{" + std::string(header_json) +
          R"(,"orderId":"O","orderUpdateId":3,"zoneSetId":"Z","nodes":[{"nodeId":"n","sequenceId":0,)"
          R"("released":true,"nodePosition":{"x":1.5,"y":-2,"theta":0.5,"allowedDeviationXY":0.25,)"
          R"("allowedDeviationTheta":0.125,"mapId":"m"},"actions":[{"actionType":"pick","actionId":"A",)"
          R"("actionDescription":"a box","blockingType":"HARD","actionParameters":[{"key":"k","value":1.5},)"
          R"({"key":"l","value":true},{"key":"m","value":"x"},{"key":"n","value":[1]}]}]}],)"
          R"("edges":[{"edgeId":"e","sequenceId":1,"released":false,"startNodeId":"n","endNodeId":"o",)"
          R"("maxSpeed":0.75,"orientationType":"TANGENTIAL","orientation":3.141592653589793,"length":2.5,"actions":[{"actionType":"wait","actionId":"B",)"
          R"("blockingType":"SOFT"}]}]})");
}

TEST(Encode, leaves_out_what_an_order_does_not_have) {
  Order order{header(), "O", 3, "", {}, {}};
  order.nodes.push_back({"n", 0, true, {}, {}});
  order.nodes.push_back({"o", 2, true, NodePosition{1, 2, {}, {}, {}, "m"}, {}});
  order.edges.push_back({"e", 1, true, "n", "o", {}, {}, {}, {}, {}});
  EXPECT_EQ(encode(order), "{" + std::string(header_json) +
                               R"(,"orderId":"O","orderUpdateId":3,"nodes":[{"nodeId":"n","sequenceId":0,)"
                               R"("released":true,"actions":[]},{"nodeId":"o","sequenceId":2,"released":true,)"
                               R"("nodePosition":{"x":1,"y":2,"mapId":"m"},"actions":[]}],"edges":[{"edgeId":"e",)"
                               R"("sequenceId":1,"released":true,"startNodeId":"n","endNodeId":"o","actions":[]}]})");
}

TEST(Encode, repeats_for_a_peer_of_2_0_the_deviation_but_not_the_names_of_an_order_s_actions) {
  const std::string for_2_0 = encode(whole_order("2.0.0"));
  EXPECT_THAT(for_2_0, HasSubstr(R"("allowedDeviationXY":0.25,"allowedDeviationXy":0.25,)"));
  EXPECT_THAT(for_2_0, Not(HasSubstr("actionName")));
  EXPECT_THAT(encode(whole_order("2.1.0")), Not(HasSubstr("allowedDeviationXy")));
}

TEST(Encode, writes_instant_actions_under_both_names_for_a_peer_of_2_0) {
  const InstantActions actions{header(), {{"startPause", "1", "", BlockingType::none, {}}}};
  EXPECT_EQ(encode(actions), "{" + std::string(header_json) +
                                 R"(,"actions":[{"actionType":"startPause","actionId":"1","blockingType":"NONE"}]})");
  InstantActions old = actions;
  old.header.version = "2.0";
  const std::string action =
      R"([{"actionType":"startPause","actionId":"1","actionName":"startPause","blockingType":"NONE"}])";
  EXPECT_THAT(encode(old), HasSubstr(R"("actions":)" + action + R"(,"instantActions":)" + action + "}"));
}

/// A state with all that a state may have.
State whole_state() {
  State state;
  state.header = header();
  state.maps = {{"m", "2", "east", true}, {"o", "1", "", false}};
  state.order_id = "O";
  state.order_update_id = 3;
  state.zone_set_id = "Z";
  state.last_node_id = "n";
  state.last_node_sequence_id = 4;
  state.driving = true;
  state.new_base_request = true;
  state.distance_since_last_node_m = 0.5;
  state.operating_mode = OperatingMode::semiautomatic;
  state.node_states = {{"p", 6, true, NodePosition{1, 2, {}, 0.25, {}, "m"}}, {"q", 8, false, {}}};
  state.edge_states = {{"e", 5, true}};
  state.position = AgvPosition{{1.5, -2, 0.5}, "m", true, 0.75, 0.125};
  state.velocity = Velocity{0.5, 0.25, -0.125};
  state.action_states = {{"A", "pick", ActionStatus::paused, "waits"}, {"B", "", ActionStatus::finished, ""}};
  state.battery = {80.5, 7.5, 12.0, true};
  state.errors = {{"orderError", ErrorLevel::fatal, "no route", {{"k", "v"}, {"l", "w"}}},
                  {"e", ErrorLevel::warning, "", {}}};
  state.information = {{"i", "text", {{"k", "v"}}}, {"j", "", {}}};
  state.e_stop = EStop::autoack;
  state.field_violation = true;
  return state;
}

TEST(Encode, writes_a_state_field_by_field) {
  EXPECT_EQ(
      encode(whole_state()),
      "{" + std::string(header_json) +
          R"(,"maps":[{"mapId":"m","mapVersion":"2","mapDescription":"east","mapStatus":"ENABLED"},)"
          R"({"mapId":"o","mapVersion":"1","mapStatus":"DISABLED"}],"orderId":"O","orderUpdateId":3,"zoneSetId":"Z",)"
          R"("lastNodeId":"n","lastNodeSequenceId":4,"driving":true,"paused":false,"newBaseRequest":true,)"
          R"("distanceSinceLastNode":0.5,"operatingMode":"SEMIAUTOMATIC","agvPosition":{"x":1.5,"y":-2,"theta":0.5,)"
          R"("mapId":"m","positionInitialized":true,"localizationScore":0.75,"deviationRange":0.125},)"
          R"("velocity":{"vx":0.5,"vy":0.25,"omega":-0.125},"nodeStates":[{"nodeId":"p","sequenceId":6,)"
          R"("released":true,"nodePosition":{"x":1,"y":2,"allowedDeviationXY":0.25,"mapId":"m"}},)"
          R"({"nodeId":"q","sequenceId":8,"released":false}],)"
          R"("edgeStates":[{"edgeId":"e","sequenceId":5,"released":true}],)"
          R"("actionStates":[{"actionId":"A","actionType":"pick","actionStatus":"PAUSED","resultDescription":"waits"},)"
          R"({"actionId":"B","actionStatus":"FINISHED"}],"batteryState":{"batteryCharge":80.5,"batteryVoltage":7.5,)"
          R"("charging":true,"reach":12},"errors":[{"errorType":"orderError",)"
          R"("errorReferences":[{"referenceKey":"k","referenceValue":"v"},{"referenceKey":"l","referenceValue":"w"}],)"
          R"("errorDescription":"no route","errorLevel":"FATAL"},{"errorType":"e","errorLevel":"WARNING"}],)"
          R"("information":[{"infoType":"i","infoReferences":[{"referenceKey":"k","referenceValue":"v"}],)"
          R"("infoDescription":"text","infoLevel":"INFO"},{"infoType":"j","infoLevel":"INFO"}],)"
          R"("safetyState":{"eStop":"AUTOACK","fieldViolation":true}})");
}

TEST(Encode, leaves_out_what_a_state_does_not_have) {
  State state;
  state.header = header();
  EXPECT_EQ(encode(state),
            "{" + std::string(header_json) +
                R"(,"orderId":"","orderUpdateId":0,"lastNodeId":"","lastNodeSequenceId":0,"driving":false,)"
                R"("paused":false,"newBaseRequest":false,"operatingMode":"AUTOMATIC","nodeStates":[],"edgeStates":[],)"
                R"("actionStates":[],"batteryState":{"batteryCharge":0,"charging":false},"errors":[],)"
                R"("information":[],"safetyState":{"eStop":"NONE","fieldViolation":false}})");
}

TEST(Encode, states_the_nodes_of_a_state_in_the_spelling_of_2_1_to_any_peer) {
  State state = whole_state();
  state.header.version = "2.0.0";
  EXPECT_THAT(encode(state), Not(HasSubstr("allowedDeviationXy")));
}

TEST(Encode, writes_visualization_and_connection_field_by_field) {
  const Visualization visualization{header(), AgvPosition{{1.5, -2, 0.5}, "m", false, {}, {}}, Velocity{0.5, 0, 0}};
  EXPECT_EQ(encode(visualization),
            "{" + std::string(header_json) +
                R"(,"agvPosition":{"x":1.5,"y":-2,"theta":0.5,"mapId":"m","positionInitialized":false},)"
                R"("velocity":{"vx":0.5,"vy":0,"omega":0}})");
  EXPECT_EQ(encode(Visualization{header(), {}, {}}), "{" + std::string(header_json) + "}");
  EXPECT_EQ(encode(Connection{header(), ConnectionState::connection_broken}),
            "{" + std::string(header_json) + R"(,"connectionState":"CONNECTIONBROKEN"})");
}

TEST(Encode, brings_values_into_the_bounds_of_the_schemas) {
  const auto position = [](double theta, double xy, double deviation_theta) {
    Order order{header(), "O", 0, "", {}, {}};
    order.nodes.push_back({"n", 0, true, NodePosition{0, 0, theta, xy, deviation_theta, "m"}, {}});
    return decode_order(encode(order)).value().nodes[0].position.value();
  };
  EXPECT_EQ(position(pi, 0.0, 0.0).theta_rad, pi);
  EXPECT_NEAR(*position(4.0, 0.0, 0.0).theta_rad, 4.0 - 2.0 * pi, 1e-12);
  EXPECT_EQ(position(0.0, -1.0, 0.0).allowed_deviation_xy_m, 0.0);
  EXPECT_EQ(position(0.0, 0.5, 0.0).allowed_deviation_xy_m, 0.5);
  EXPECT_EQ(position(0.0, 0.0, 7.0).allowed_deviation_theta_rad, pi);
  EXPECT_EQ(position(0.0, 0.0, -7.0).allowed_deviation_theta_rad, -pi);
  const auto score = [](double number) {
    return decode_visualization(encode(Visualization{header(), AgvPosition{{}, "m", true, number, {}}, {}}))
        ->position->localization_score;
  };
  EXPECT_EQ(score(-0.5), 0.0);
  EXPECT_EQ(score(0.5), 0.5);
  EXPECT_EQ(score(1.5), 1.0);
  const auto reach = [](double reach_m) {
    State state;
    state.battery.reach_m = reach_m;
    return decode_state(encode(state))->battery.reach_m;
  };
  EXPECT_EQ(reach(-1.0), 0.0);
  EXPECT_EQ(reach(0.5), 0.5);
}

TEST(Encode, leaves_an_angle_of_half_a_turn_as_it_is_on_both_sides) {
  // The schemas' bounds include both: no reason to turn −π into π, which another reader might take for a jump.
  for (const double theta : {pi, -pi}) {
    const std::string json = encode(Visualization{header(), AgvPosition{{0, 0, theta}, "m", true, {}, {}}, {}});
    EXPECT_THAT(json, HasSubstr(theta < 0.0 ? R"("theta":-3.14159)" : R"("theta":3.14159)"));
  }
}

TEST(Encode, gives_each_enumerator_its_term_of_the_standard) {
  EXPECT_EQ(to_string(ConnectionState::online), "ONLINE");
  EXPECT_EQ(to_string(ConnectionState::offline), "OFFLINE");
  EXPECT_EQ(to_string(ConnectionState::connection_broken), "CONNECTIONBROKEN");
  EXPECT_EQ(to_string(ActionStatus::waiting), "WAITING");
  EXPECT_EQ(to_string(ActionStatus::initializing), "INITIALIZING");
  EXPECT_EQ(to_string(ActionStatus::running), "RUNNING");
  EXPECT_EQ(to_string(ActionStatus::paused), "PAUSED");
  EXPECT_EQ(to_string(ActionStatus::finished), "FINISHED");
  EXPECT_EQ(to_string(ActionStatus::failed), "FAILED");
  EXPECT_EQ(to_string(BlockingType::none), "NONE");
  EXPECT_EQ(to_string(BlockingType::soft), "SOFT");
  EXPECT_EQ(to_string(BlockingType::hard), "HARD");
  EXPECT_EQ(to_string(OperatingMode::teachin), "TEACHIN");
}

TEST(EncodeDeathTest, writes_no_number_that_is_not_finite_and_no_empty_json) {
  Visualization visualization{header(), {}, Velocity{std::numeric_limits<double>::quiet_NaN(), 0, 0}};
  EXPECT_DEATH(static_cast<void>(encode(visualization)), "isfinite");
  const InstantActions actions{header(), {{"t", "1", "", BlockingType::none, {{"k", RawJson{""}}}}}};
  EXPECT_DEATH(static_cast<void>(encode(actions)), "empty");
}

}  // namespace
}  // namespace cosiva::wire::vda5050
