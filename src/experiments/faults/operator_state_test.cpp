#include "cosiva/experiments/faults/operator_state.h"

#include <gtest/gtest.h>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/commands/intentions.h"

namespace cosiva::experiments {
namespace {

TEST(OperatorState, a_restart_of_one_vehicle_leaves_the_others_stopped) {
  OperatorState state;
  state.take(R"({"command":"stop","vehicle":"*"})");
  state.take(R"({"command":"restart","vehicle":"CoSiVA/AIV2"})");
  EXPECT_TRUE(state.stopped("CoSiVA/AIV1"));
  EXPECT_FALSE(state.stopped("CoSiVA/AIV2"));
}

TEST(OperatorState, equals_what_the_server_persists_for_the_same_commands) {
  virtual_side::Intentions intentions;
  intentions.take_for_all(virtual_side::OperatorCommandKind::slow, 0.0);
  intentions.take("CoSiVA/AIV3", virtual_side::OperatorCommandKind::stop, 0.0);
  JsonWriter json;
  intentions.write(json.begin_object().key("intentions"));
  json.key("virtualObjects").begin_array().begin_object().field("id", "P1").end_object().end_array().end_object();
  OperatorState state;
  state.take(R"({"command":"slow","vehicle":"*"})");
  state.take(R"({"command":"add","virtualObject":{"id":"P1","kind":"person"}})");
  state.take(R"({"command":"stop","vehicle":"CoSiVA/AIV3"})");
  const auto read = OperatorState::from_persisted(json.take());
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, state) << read->text() << "\n" << state.text();
  state.take(R"({"command":"remove","id":"P1"})");
  EXPECT_NE(*read, state);
}

TEST(OperatorState, knows_the_virtual_aivs_that_may_be_in_the_zone) {
  OperatorState state;
  state.take(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"a","s":0.3}})");
  state.take(R"({"command":"add","virtualObject":{"id":"V2","kind":"aiv","section":"b","s":0.3}})");
  state.take(R"({"command":"remove","id":"V1"})");
  EXPECT_EQ(state.aivs(), std::set<std::string>{"V2"});
  const auto read = OperatorState::from_persisted(R"({"aivs":[{"id":"V2","section":"b","s":0.3}]})");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->aivs(), state.aivs());
  state.take(R"({"command":"remove","id":"*"})");
  EXPECT_TRUE(state.aivs().empty());
  EXPECT_EQ(*read, state) << "there may have been no room for V2";
}

TEST(OperatorState, cannot_be_read_from_another_text) {
  EXPECT_EQ(OperatorState::from_persisted("stopped").error().code, "simulate.state");
}

}  // namespace
}  // namespace cosiva::experiments
