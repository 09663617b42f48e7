#include "cosiva/aiv/v2x/fleet_proxies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>
#include <variant>

#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/v2x_port.h"

namespace cosiva::aiv {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

struct FleetProxiesTest : ::testing::Test {
  FleetProxies proxies{{"CoSiVA", "AIV1"}};
  wire::Effects effects;
  void send(SimTime now, FleetProxies::Links links = {}) {
    wire::Intent intent;
    intent.map_id = "m";
    proxies.send(now, wire::Cell{3, -4}, std::move(intent), links, effects);
  }
  void deliver(SimTime now, const std::string& serial) { proxies.deliver(now, {"CoSiVA", serial}); }
};

TEST_F(FleetProxiesTest, send_one_intent_for_all_near_its_cell) {
  send(virtual_epoch);
  send(virtual_epoch);
  ASSERT_THAT(effects, SizeIs(2));
  const auto& last = std::get<wire::Publish>(effects.back());
  EXPECT_EQ(last.topic, "cosiva/v1/v2x/m/3_-4/CoSiVA/AIV1");
  EXPECT_EQ(last.qos, 0);
  EXPECT_FALSE(last.retained);
  EXPECT_THAT(last.payload, HasSubstr(R"("headerId":1,)"));
  EXPECT_THAT(last.payload, HasSubstr(R"("timestamp":"2023-07-11T00:00:00.000Z")"));
}

TEST_F(FleetProxiesTest, send_the_same_intent_by_both_links_and_none_where_there_is_no_link) {
  send(virtual_epoch, {.broker = true, .direct = true});
  ASSERT_THAT(effects, SizeIs(2));
  const auto& direct = std::get<wire::SendBytes>(effects[0]);
  EXPECT_EQ(direct.port, wire::v2x_port);
  EXPECT_EQ(direct.bytes, std::get<wire::Publish>(effects[1]).payload);
  send(virtual_epoch, {.broker = false, .direct = false});
  EXPECT_THAT(effects, SizeIs(2));
  send(virtual_epoch, {.broker = false, .direct = true});
  EXPECT_THAT(std::get<wire::SendBytes>(effects.back()).bytes, HasSubstr(R"("headerId":1,)")) << "no number is skipped";
}

TEST_F(FleetProxiesTest, pass_intents_on_as_values_in_one_process) {
  FleetProxies inside{{"CoSiVA", "AIV1"}, true};
  inside.send(virtual_epoch, wire::Cell{}, wire::Intent{}, {}, effects);
  const auto& last = std::get<wire::Publish>(effects.back());
  EXPECT_EQ(last.topic, "cosiva/v1/v2x/_/0_0/CoSiVA/AIV1");
  EXPECT_TRUE(last.typed);
  EXPECT_TRUE(last.payload.empty());
}

TEST_F(FleetProxiesTest, count_the_messages_of_each_known_AIV_alone) {
  EXPECT_THAT(proxies.counts(), IsEmpty());
  send(virtual_epoch);  // no other AIV is known yet
  deliver(virtual_epoch, "AIV3");
  deliver(virtual_epoch, "AIV2");
  deliver(virtual_epoch + 900ms, "AIV3");
  send(virtual_epoch + 1s);
  send(virtual_epoch + 1500ms);  // AIV2 has sent nothing for more than a second
  EXPECT_THAT(proxies.counts(),
              ElementsAre(wire::ProxyCounts{"CoSiVA/AIV2", 1, 1}, wire::ProxyCounts{"CoSiVA/AIV3", 2, 2}));
}

TEST_F(FleetProxiesTest, remove_the_proxy_unused_for_longest_when_there_is_no_room_for_a_new_one) {
  for (std::size_t i = 0; i < FleetProxies::count_max; ++i)
    deliver(virtual_epoch + i * 1ms, "AIV" + std::to_string(100 + i));
  deliver(virtual_epoch + 1s, "AIV100");
  deliver(virtual_epoch + 1s, "AIV099");
  const auto counts = proxies.counts();
  ASSERT_THAT(counts, SizeIs(FleetProxies::count_max));
  EXPECT_EQ(counts[0], (wire::ProxyCounts{"CoSiVA/AIV099", 0, 1}));
  EXPECT_EQ(counts[1], (wire::ProxyCounts{"CoSiVA/AIV100", 0, 2}));
  EXPECT_EQ(counts[2].agent, "CoSiVA/AIV102") << "AIV101's was unused for longest";
}

}  // namespace
}  // namespace cosiva::aiv
