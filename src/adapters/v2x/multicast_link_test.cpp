// The direct link over real sockets of this machine.
#include "cosiva/adapters/v2x/multicast_link.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/adapters/v2x/direct_ports.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const wire::DirectKey key{1, 2, 3};

/// The port depends on the process, so that two runs of the tests do not receive from each other.
std::uint16_t test_port(int offset) { return static_cast<std::uint16_t>(20'000 + (::getpid() * 8 + offset) % 30'000); }

/// IPv4: the loopback interface. IPv6: another one, whose datagrams return to this machine, since Linux has no route of
/// IPv6 multicast over the loopback interface; empty: there is none.
std::string interface_of(bool ipv6) {
  if (!ipv6) return "lo";
  std::ifstream interfaces{"/proc/net/if_inet6"};
  for (std::string line; std::getline(interfaces, line);)
    if (const std::string name = line.substr(line.rfind(' ') + 1); name != "lo") return name;
  return {};
}

/// One participant.
struct Participant {
  Participant(EventLoop& loop, const std::string& serial, bool ipv6, int offset, const wire::DirectKey& with = key,
              bool repeats = false) {
    PortHandlers handlers;
    handlers.on_bytes = [this](const std::string& port, std::string_view bytes) {
      received.push_back(port + " " + std::string(bytes));
    };
    const MulticastAddress address{ipv6 ? "ff15::c051:7a" : "239.192.7.50", test_port(offset), ipv6};
    auto opened = open_multicast(loop, {address, interface_of(ipv6), {"CoSiVA", serial}, with, repeats}, handlers);
    EXPECT_TRUE(opened) << to_string(opened.error());
    if (opened) link = std::move(*opened);
  }
  void send(const std::string& payload) const { link->send("v2x", payload); }
  std::vector<std::string> received;
  std::unique_ptr<MulticastLink> link;
};

/// Sends bytes as they are, to the group on the loopback interface.
void send_raw(const std::string& bytes, std::uint16_t port) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  ip_mreqn interface {};
  interface.imr_ifindex = static_cast<int>(::if_nametoindex("lo"));
  ASSERT_EQ(::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface), 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  ::inet_pton(AF_INET, "239.192.7.50", &to.sin_addr);
  ASSERT_EQ(::sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to),
            static_cast<ssize_t>(bytes.size()));
  ::close(fd);
}

/// IPv4, and IPv6 where an interface of this machine has it.
std::vector<bool> versions() {
  if (interface_of(true).empty()) return {false};
  return {false, true};
}

class MulticastLinkTest : public ::testing::TestWithParam<bool> {};

TEST_P(MulticastLinkTest, carries_messages_to_all_others_on_this_machine) {
  EventLoop loop;
  Participant one{loop, "AIV1", GetParam(), 0};
  Participant two{loop, "AIV2", GetParam(), 0};
  Participant three{loop, "AIV3", GetParam(), 0};
  one.send("hello");
  two.send("there");
  EXPECT_TRUE(loop.run_until([&] { return three.received.size() == 2 && !one.received.empty(); }, 2s));
  EXPECT_THAT(one.received, ElementsAre("v2x/CoSiVA/AIV2 there"));
  EXPECT_THAT(two.received, ElementsAre("v2x/CoSiVA/AIV1 hello"));
  EXPECT_THAT(three.received, ElementsAre("v2x/CoSiVA/AIV1 hello", "v2x/CoSiVA/AIV2 there"));
  EXPECT_EQ(one.link->counters().own, 1U);
  EXPECT_EQ(one.link->unsent(), 0U);
}

TEST_P(MulticastLinkTest, ignores_and_counts_participants_with_another_key) {
  EventLoop loop;
  Participant one{loop, "AIV1", GetParam(), 1};
  Participant unknown{loop, "AIV2", GetParam(), 1, {9}};
  unknown.send("hello");
  EXPECT_TRUE(loop.run_until([&] { return one.link->counters().forged == 1; }, 2s));
  EXPECT_THAT(one.received, IsEmpty());
}

TEST_P(MulticastLinkTest, repeats_what_another_participant_sent_and_nothing_else_in_its_name) {
  EventLoop loop;
  auto one = std::make_unique<Participant>(loop, "AIV1", GetParam(), 6);
  Participant unit{loop, "X1", GetParam(), 6, key, true};
  one->send("hello");
  ASSERT_TRUE(loop.run_until([&] { return unit.received.size() == 1; }, 2s));
  one.reset();
  // A participant that was out of the sender's reach.
  Participant late{loop, "AIV2", GetParam(), 6};
  unit.link->send("v2x/CoSiVA/AIV1", "changed");
  unit.link->send("v2x/CoSiVA/AIV3", "hello");
  EXPECT_EQ(unit.link->unsent(), 2U);
  unit.link->send("v2x/CoSiVA/AIV1", "hello");
  unit.link->send("v2x/CoSiVA/AIV1", "hello");
  EXPECT_TRUE(loop.run_until([&] { return late.link->counters().replayed == 1; }, 2s));
  EXPECT_THAT(late.received, ElementsAre("v2x/CoSiVA/AIV1 hello")) << "with the sender's own tag, and once";
  EXPECT_EQ(late.link->counters().forged, 0U);
}

TEST_P(MulticastLinkTest, continues_with_a_participant_that_was_started_again) {
  EventLoop loop;
  Participant one{loop, "AIV1", GetParam(), 2};
  auto two = std::make_unique<Participant>(loop, "AIV2", GetParam(), 2);
  two->send("before");
  EXPECT_TRUE(loop.run_until([&] { return one.received.size() == 1; }, 2s));
  two = std::make_unique<Participant>(loop, "AIV2", GetParam(), 2);
  two->send("after");
  EXPECT_TRUE(loop.run_until([&] { return one.received.size() == 2; }, 2s));
  EXPECT_EQ(one.link->counters().replayed, 0U);
}

INSTANTIATE_TEST_SUITE_P(Each, MulticastLinkTest, ::testing::ValuesIn(versions()),
                         [](const auto& which) { return which.param ? "ipv6" : "ipv4"; });

TEST(MulticastLink, ignores_and_counts_replayed_and_malformed_datagrams) {
  EventLoop loop;
  Participant one{loop, "AIV1", false, 3};
  wire::DirectLink sender{{"CoSiVA", "AIV2"}, key, 1};
  const std::string good = *sender.seal(0, "hello");
  for (int i = 0; i < 3; ++i) send_raw(good, test_port(3));
  send_raw("nonsense", test_port(3));
  send_raw(std::string(20'000, 'x'), test_port(3));
  EXPECT_TRUE(loop.run_until([&] { return one.link->counters().refused() == 4; }, 2s));
  EXPECT_EQ(one.link->counters().replayed, 2U);
  EXPECT_EQ(one.link->counters().malformed, 2U);
  EXPECT_THAT(one.received, ElementsAre("v2x/CoSiVA/AIV2 hello"));
}

TEST(MulticastLink, cannot_be_opened_on_an_interface_that_does_not_exist) {
  EventLoop loop;
  const auto opened =
      open_multicast(loop, {{"239.192.7.50", test_port(4), false}, "no-such-if", {"CoSiVA", "AIV1"}, key}, {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, "v2x.interface");
  EXPECT_EQ(opened.error().location, "no-such-if");
}

struct SentPorts final : Ports {
  explicit SentPorts(std::vector<std::string>& to) : sent{to} {}
  void send(const std::string& port, std::string_view) override { sent.push_back(port); }
  std::vector<std::string>& sent;
};

TEST(DirectPorts, send_to_boards_and_to_other_vehicles) {
  EventLoop loop;
  Participant two{loop, "AIV2", false, 5};
  Participant one{loop, "AIV1", false, 5};
  std::vector<std::string> sent;
  DirectPorts ports{std::make_unique<SentPorts>(sent), std::move(one.link)};
  ports.send("1/PILS", "drive");
  ports.send("v2x", "hello");
  EXPECT_THAT(sent, ElementsAre("1/PILS"));
  EXPECT_TRUE(loop.run_until([&] { return two.received.size() == 1; }, 2s));
}

}  // namespace
}  // namespace cosiva::adapters
