#include "cosiva/virtual/server/exchange/agent_proxy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <variant>

#include "cosiva/base/archive.h"
#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

using testing::SizeIs;

struct AgentProxyTest : ::testing::Test {
  Traces traces{100};
  wire::Effects effects;
  AgentProxy proxy{"CoSiVA/AIV1"};

  void send(AgentProxy& to) {
    to.send(traces, virtual_epoch, "order", "first", wire::Publish{"uagv/v2/CoSiVA/AIV1/order", "{}", 0, false},
            effects);
  }
  [[nodiscard]] std::optional<std::string> last(const char* field) const {
    return JsonValue::parse(*traces.one_json(traces.next() - 1))->text(field);
  }
  [[nodiscard]] std::optional<std::string> last_listed(const char* field) const {
    const JsonValue listed = *JsonValue::parse(traces.to_json(traces.next() - 1, 1));
    return listed.find("traces")->array()->at(0).text(field);
  }
};

TEST_F(AgentProxyTest, sends_what_a_local_agent_hands_to_it_and_the_trace_has_the_hop) {
  send(proxy);
  ASSERT_THAT(effects, SizeIs(1));
  EXPECT_EQ(std::get<wire::Publish>(effects[0]).topic, "uagv/v2/CoSiVA/AIV1/order");
  EXPECT_EQ(last("from"), "AIV_Server");
  EXPECT_EQ(last("via"), "proxy of CoSiVA/AIV1");
  EXPECT_EQ(last_listed("via"), "proxy of CoSiVA/AIV1");
  EXPECT_EQ(last("to"), "CoSiVA/AIV1");
  EXPECT_EQ(last("kind"), "order");
  EXPECT_EQ(last("content"), "first");
  EXPECT_EQ(last("topic"), "uagv/v2/CoSiVA/AIV1/order");
  EXPECT_EQ(last("raw"), "{}");
  EXPECT_EQ(proxy.messages_sent(), 1U);
  EXPECT_EQ(proxy.messages_delivered(), 0U);
}

TEST_F(AgentProxyTest, delivers_what_the_remote_agent_sent_and_the_trace_has_the_hop) {
  proxy.deliver(traces, virtual_epoch, {"state", "driving", "uagv/v2/CoSiVA/AIV1/state", "{}"});
  EXPECT_EQ(last("from"), "CoSiVA/AIV1");
  EXPECT_EQ(last("via"), "proxy of CoSiVA/AIV1");
  EXPECT_EQ(last("to"), "AIV_Server");
  proxy.deliver_position(traces, virtual_epoch, {"visualization", {}, {}, {}}, Pose2{1.0, 2.0, 0.0}, 0.3);
  EXPECT_EQ(last_listed("via"), "proxy of CoSiVA/AIV1");
  EXPECT_EQ(last("content"), R"({"x":1,"y":2,"theta":0,"speed":0.3})");
  proxy.deliver_untraced();
  EXPECT_EQ(traces.next(), 3U);
  EXPECT_EQ(proxy.messages_delivered(), 3U);
  EXPECT_EQ(proxy.messages_sent(), 0U);
}

TEST_F(AgentProxyTest, does_not_count_a_refused_message_but_shows_where_it_ended) {
  proxy.refuse(traces, virtual_epoch, {"state", "refused: it is no JSON", {}, "{"});
  EXPECT_EQ(proxy.messages_delivered(), 0U);
  EXPECT_EQ(last("via"), "proxy of CoSiVA/AIV1");
}

TEST_F(AgentProxyTest, is_stored_with_its_counts) {
  send(proxy);
  proxy.deliver_untraced();
  proxy.deliver_untraced();
  std::string bytes;
  Archive writing{bytes};
  proxy.archive(writing);
  AgentProxy read{"CoSiVA/AIV1"};
  Archive reading{std::string_view{bytes}};
  read.archive(reading);
  EXPECT_FALSE(reading.failed());
  EXPECT_EQ(read.messages_sent(), 1U);
  EXPECT_EQ(read.messages_delivered(), 2U);
}

}  // namespace
}  // namespace cosiva::virtual_side
