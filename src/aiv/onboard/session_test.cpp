#include "cosiva/aiv/onboard/session.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>

#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {
namespace {

struct SessionTest : ::testing::Test {
  Session session{{"CoSiVA", "AIV1"}, wire::default_interface};
  wire::Effects effects;
  const wire::Publish& last() { return std::get<wire::Publish>(effects.back()); }
};

TEST_F(SessionTest, publishes_nothing_while_the_broker_is_away) {
  session.publish(SimTime{}, wire::State{}, effects);
  session.publish(SimTime{}, wire::ConnectionState::online, effects);
  EXPECT_TRUE(effects.empty());
}

TEST_F(SessionTest, counts_the_headers_of_each_topic_alone) {
  session.publish(SimTime{}, wire::State{}, effects);
  session.set_online(true);
  for (const char* id : {"\"headerId\":0", "\"headerId\":1"}) {
    session.publish(SimTime{}, wire::State{}, effects);
    EXPECT_EQ(last().topic, session.topics().state);
    EXPECT_NE(last().payload.find(id), std::string::npos) << last().payload;
    session.publish(SimTime{}, wire::BoardsReport{}, effects);
    EXPECT_EQ(last().topic, session.topics().boards);
    EXPECT_NE(last().payload.find(id), std::string::npos) << last().payload;
  }
}

TEST_F(SessionTest, retains_connection_and_factsheet) {
  session.set_online(true);
  session.publish(SimTime{}, wire::ConnectionState::online, effects);
  EXPECT_EQ(last().topic, session.topics().connection);
  EXPECT_TRUE(last().retained);
  session.publish(SimTime{}, wire::Factsheet{}, effects);
  EXPECT_EQ(last().topic, session.topics().factsheet);
  EXPECT_TRUE(last().retained);
}

TEST_F(SessionTest, refuses_a_message_for_another_vehicle_and_an_unsupported_version) {
  EXPECT_TRUE(session.accepts({0, SimTime{}, "2.1.0", "CoSiVA", "AIV1"}));
  EXPECT_TRUE(session.accepts({0, SimTime{}, "v2", "CoSiVA", "AIV1"}));
  EXPECT_FALSE(session.accepts({0, SimTime{}, "2.1.0", "CoSiVA", "AIV2"}));
  EXPECT_FALSE(session.accepts({0, SimTime{}, "3.0.0", "CoSiVA", "AIV1"}));
}

}  // namespace
}  // namespace cosiva::aiv
