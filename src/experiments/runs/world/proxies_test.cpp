// Each host has a proxy of each remote agent with which it communicates (A26): every message passes through the proxies
// of both hosts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <string>

#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::snapshot;
using testing::world_of;

/// The counts that a vehicle reports of its proxy of `agent`.
const JsonValue& on_board(const JsonValue& aiv, const std::string& agent) {
  static const JsonValue none;
  const JsonValue* proxies = aiv.find("proxies");
  if (proxies == nullptr) return none;
  const auto found =
      std::ranges::find_if(*proxies->array(), [&](const JsonValue& proxy) { return proxy.text("agent") == agent; });
  return found == proxies->array()->end() ? none : *found;
}

TEST(ProxiesOfBothHosts, count_the_same_messages) {
  const auto world = world_of(4);
  world->run_for(30s);
  const JsonValue page = snapshot(*world);
  const auto& aivs = *page.find("aivs")->array();
  ASSERT_EQ(aivs.size(), 4U);
  for (const JsonValue& aiv : aivs) {
    SCOPED_TRACE(aiv.text("id").value_or("?"));
    const JsonValue& server_s = *aiv.find("proxy");
    const JsonValue& vehicle_s = on_board(aiv, "AIV_Server");
    // The vehicle counted when it composed its last report, at most half a second ago.
    const double since = server_s.number("delivered").value() - vehicle_s.number("sent").value();
    EXPECT_GE(vehicle_s.number("sent").value(), 30 * 11.0) << "positions, states and boards of 30 s";
    EXPECT_GE(since, 1.0) << "the report itself";
    EXPECT_LE(since, 30.0);
    // Heartbeats and zones go to all vehicles, and so the server counts them with none.
    EXPECT_GE(server_s.number("sent").value(), 3.0);
    EXPECT_GE(vehicle_s.number("delivered").value(), server_s.number("sent").value() + 30 * 9.0 - 20.0);
    double received = 0.0;
    for (const JsonValue& other : aivs)
      received += on_board(aiv, other.text("id").value()).number("delivered").value_or(0.0);
    EXPECT_GE(received, 30.0) << "intents of the other vehicles";
    EXPECT_FALSE(on_board(aiv, aiv.text("id").value()).number("delivered")) << "a vehicle has no proxy of itself";
  }
}

TEST(ProxiesOfBothHosts, are_in_the_traces_of_all_messages_between_hosts_and_of_no_other) {
  const auto world = world_of(2);
  world->run_for(5s);
  world->command_server(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":0.0,"y":-0.15}})");
  world->command_server(R"({"command":"stop","vehicle":"CoSiVA/AIV2"})");
  world->run_for(5s);
  const std::set<std::string> remote{"CoSiVA/AIV1", "CoSiVA/AIV2", "physical side", "emulated world", "GVS"};
  const auto is_remote = [&](const std::string& agent) {
    return remote.contains(agent) || agent.starts_with("CoSiVA.virtual/");
  };
  const std::set<std::string> decisions{"route", "convoy"};
  std::map<std::string, int> hops;
  const JsonValue traces = *JsonValue::parse(world->server().traces_json(0, 100'000), std::size_t{1} << 24U);
  for (const JsonValue& trace : *traces.find("traces")->array()) {
    const std::string from = trace.text("from").value();
    const std::string to = trace.text("to").value();
    const std::string kind = trace.text("kind").value();
    const auto via = trace.text("via");
    SCOPED_TRACE(from + " to " + to + ": " + kind);
    const bool sends = is_remote(from) && to == "AIV_Server";
    const bool receives = is_remote(to) && from == "AIV_Server" && !decisions.contains(kind);
    EXPECT_EQ(via.value_or("none"), sends ? "proxy of " + from : receives ? "proxy of " + to : "none");
    if (via) ++hops[kind];
  }
  for (const char* kind : {"connection", "state", "visualization", "order", "instantActions", "zone",
                           "virtual_obstacles", "virtual_obstacles_ack", "boards", "factsheet"})
    EXPECT_GE(hops[kind], 1) << kind;
}

}  // namespace
}  // namespace cosiva::experiments
