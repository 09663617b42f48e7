#include "cosiva/adapters/lossy_radio.h"

#include <gmock/gmock.h>

#include "cosiva/adapters/test_fixture.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using testing::timeout;

class Radio : public ::testing::Test {
 protected:
  bool publish(const std::string& json) { return radio.take(wire::plant_radio_topic, json); }

  EventLoop loop;
  LossyRadio radio{loop, "CoSiVA/AIV2"};
};

TEST_F(Radio, obeys_commands_for_its_own_vehicle_and_for_all) {
  EXPECT_TRUE(publish(R"({"vehicle":"CoSiVA/AIV1","loss":0.5})"));
  EXPECT_EQ(radio.loss(), 0.0);
  EXPECT_TRUE(publish(R"({"vehicle":"CoSiVA/AIV2","loss":0.5})"));
  EXPECT_EQ(radio.loss(), 0.5);
  EXPECT_TRUE(publish(R"({"vehicle":"*","loss":0.1})"));
  EXPECT_EQ(radio.loss(), 0.1);
  EXPECT_FALSE(radio.take("uagv/v2/CoSiVA/AIV2/order", R"({"vehicle":"*","loss":1})"));
  EXPECT_EQ(radio.loss(), 0.1);
}

TEST_F(Radio, ignores_invalid_commands) {
  publish(R"({"vehicle":"*","loss":0.5})");
  for (const char* bad : {"", "nonsense", R"({"vehicle":"*"})", R"({"vehicle":"*","loss":2})", R"({"loss":0.1})"}) {
    EXPECT_TRUE(publish(bad)) << bad << ": it is for the radio all the same";
    EXPECT_EQ(radio.loss(), 0.5) << bad;
  }
}

TEST_F(Radio, that_is_good_passes_everything_at_once) {
  int received = 0;
  for (const int qos : {0, 1}) {
    radio.receive(qos, [&] { ++received; });
    radio.send(qos, [&] { ++received; });
  }
  EXPECT_EQ(received, 4);
}

TEST_F(Radio, loses_its_ratio_of_QoS_0_in_both_directions) {
  publish(R"({"vehicle":"*","loss":0.3})");
  int in = 0;
  int out = 0;
  for (int i = 0; i < 10'000; ++i) {
    radio.receive(0, [&] { ++in; });
    radio.send(0, [&] { ++out; });
  }
  // 7 000 with a standard deviation of 46.
  EXPECT_NEAR(in, 7000, 250);
  EXPECT_NEAR(out, 7000, 250);
}

TEST_F(Radio, delivers_QoS_1_later_but_complete_and_in_order) {
  publish(R"({"vehicle":"*","loss":0.5})");
  std::vector<int> received;
  for (int i = 0; i < 8; ++i) radio.receive(1, [&received, i] { received.push_back(i); });
  EXPECT_LT(received.size(), 8U) << "one in 256 seeds would lose none, and this is not one of them";
  publish(R"({"vehicle":"*","loss":0})");
  radio.receive(1, [&received] { received.push_back(8); });
  ASSERT_TRUE(loop.run_until([&] { return received.size() == 9; }, timeout));
  EXPECT_THAT(received, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
}

TEST_F(Radio, lets_the_farewell_through) {
  publish(R"({"vehicle":"*","loss":1})");
  std::vector<std::string> published;
  radio.send(1, [&] { published.emplace_back("state"); });
  radio.send(0, [&] { published.emplace_back("lost"); });
  EXPECT_THAT(published, ElementsAre());
  radio.end();
  radio.send(1, [&] { published.emplace_back("OFFLINE"); });
  EXPECT_THAT(published, ElementsAre("state", "OFFLINE"));
}

TEST(QosOfReceived, is_1_for_what_is_retained_and_0_for_the_rest) {
  EXPECT_EQ(qos_of_received("cosiva/v1/zone/toml"), 1);
  EXPECT_EQ(qos_of_received("cosiva/v1/server/connection"), 1);
  EXPECT_EQ(qos_of_received("cosiva/v1/server/heartbeat"), 0);
  EXPECT_EQ(qos_of_received("cosiva/v1/owner/CoSiVA/AIV1"), 1);
  EXPECT_EQ(qos_of_received("cosiva/v1/area/north/zone/toml"), 1);
  EXPECT_EQ(qos_of_received("cosiva/v1/area/north/server/connection"), 1);
  EXPECT_EQ(qos_of_received("cosiva/v1/area/north/server/heartbeat"), 0);
  EXPECT_EQ(qos_of_received("uagv/v2/CoSiVA/AIV1/order"), 0);
}

}  // namespace
}  // namespace cosiva::adapters
