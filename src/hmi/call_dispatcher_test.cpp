#include "cosiva/hmi/call_dispatcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cosiva/adapters/http/http_rules.h"
#include "cosiva/adapters/loop_thread.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/json_parse_count.h"
#include "cosiva/base/json_text.h"
#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::HttpRequest;
using adapters::HttpResponse;
using adapters::testing::timeout;
using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* one_stop = R"({"command":"stop","vehicle":"CoSiVA/AIV1"})";

/// A dispatcher between three loops: the page's and the worker's have a thread each, the core's is handled where the
/// test runs it, and so it stalls as long as the test likes.
class CallDispatcherTest : public ::testing::Test {
 protected:
  void open(PageHost host) {
    calls = std::make_shared<PageCalls>(std::move(host));
    dispatcher.emplace(CallDispatcher::Loops{page.loop(), core, worker.loop()}, calls);
    page.start();
    worker.start();
  }
  ~CallDispatcherTest() override {
    worker.stop();
    page.stop();
  }
  /// Sends a request on the page's thread.
  std::future<HttpResponse> send(const std::string& method, const std::string& path, std::string body = {}) {
    auto response = std::make_shared<std::promise<HttpResponse>>();
    auto request = std::make_shared<HttpRequest>(
        HttpRequest{method, path, "", std::move(body), *adapters::http_rules::path_segments(path)});
    page.loop().post([this, request, response] {
      HttpResponse now = dispatcher->respond(std::move(*request));
      if (now.later)
        now.later([response](HttpResponse later) { response->set_value(std::move(later)); });
      else
        response->set_value(std::move(now));
    });
    return response->get_future();
  }
  /// The response, without the core.
  static std::optional<HttpResponse> at_once(std::future<HttpResponse> response) {
    if (response.wait_for(timeout) != std::future_status::ready) return std::nullopt;
    return response.get();
  }
  /// The response, while the core's loop runs.
  HttpResponse with_core(std::future<HttpResponse> response) {
    EXPECT_TRUE(core.run_until([&] { return response.wait_for(0s) == std::future_status::ready; }, timeout));
    return response.get();
  }
  /// A Stop line that knows AIV1 and records what it is given.
  StopLine line() {
    StopLine made;
    made.send = [this](const std::string& id, const std::vector<std::string>& vehicles) {
      published.push_back(id);
      return vehicles == std::vector<std::string>{"CoSiVA/AIV1"} || vehicles == std::vector<std::string>{"*"};
    };
    made.lift = [this](const std::vector<std::string>& vehicles) { lifted = vehicles; };
    made.unconfirmed = [](const std::string&) { return std::vector<std::string>{"CoSiVA/AIV1"}; };
    return made;
  }
  PageHost host_with_line() {
    PageHost host = fixture.host();
    host.stop_line = line();
    return host;
  }

  fixture::PageFixture fixture;
  adapters::EventLoop core;
  adapters::LoopThread page;
  adapters::LoopThread worker;
  std::vector<std::string> published;  ///< ids of Stops
  std::vector<std::string> lifted;
  std::shared_ptr<PageCalls> calls;
  std::optional<CallDispatcher> dispatcher;
};

TEST_F(CallDispatcherTest, has_calls_handled_on_the_loop_of_the_core) {
  open(fixture.host());
  auto zone = send("GET", "/api/v1/zone");
  EXPECT_EQ(zone.wait_for(50ms), std::future_status::timeout) << "the core's loop does not run";
  EXPECT_EQ(with_core(std::move(zone)).status, 200U);
}

TEST_F(CallDispatcherTest, reads_no_body_on_the_loop_of_the_core) {
  open(fixture.host());
  auto bad = send("POST", "/api/v1/virtual-objects", "nonsense");
  const auto refused = at_once(std::move(bad));
  ASSERT_TRUE(refused) << "needs no core";
  EXPECT_EQ(refused->status, 400U);
  auto slow = send("POST", "/api/v1/commands", R"({"command":"slow","vehicle":"CoSiVA/AIV1"})");
  std::this_thread::sleep_for(50ms);
  const std::uint64_t before = json_parse_count();
  EXPECT_EQ(with_core(std::move(slow)).status, 202U);
  EXPECT_EQ(json_parse_count() - before, 1U)
      << "the text of the command for the journal, which the core's thread makes";
}

TEST_F(CallDispatcherTest, publishes_a_stop_and_responds_while_the_core_is_stalled) {
  open(host_with_line());
  const auto response = at_once(send("POST", "/api/v1/commands", one_stop));
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 202U);
  EXPECT_THAT(response->body, HasSubstr(R"("durable":false,"reason":"not yet durable")"));
  ASSERT_EQ(published.size(), 1U);
  const std::string id = published.front();
  const auto progress = at_once(send("GET", "/api/v1/commands/" + id));
  ASSERT_TRUE(progress);
  EXPECT_EQ(progress->body,
            R"({"id":")" + id + R"(","durable":false,"reason":"not yet durable","unconfirmed":["CoSiVA/AIV1"]})");
  EXPECT_THAT(fixture.commands, IsEmpty());

  core.run_for(50ms);  // the core gets the same Stop
  EXPECT_THAT(fixture.commands, ElementsAre(HasSubstr(R"("actionId":")" + id + "\"")));
  EXPECT_THAT(at_once(send("GET", "/api/v1/commands/" + id))->body, HasSubstr(R"("durable":true)"));
}

TEST_F(CallDispatcherTest, publishes_a_stop_before_changes_that_were_sent_earlier) {
  open(host_with_line());
  auto person = send("POST", "/api/v1/virtual-objects", R"({"kind":"person","x":0.9,"y":-0.9})");
  EXPECT_TRUE(at_once(send("POST", "/api/v1/commands", one_stop)));
  EXPECT_EQ(published.size(), 1U);
  EXPECT_EQ(with_core(std::move(person)).status, 201U);
}

TEST_F(CallDispatcherTest, queries_the_core_where_the_sender_does_not_know_the_vehicle) {
  open(host_with_line());
  auto known = send("POST", "/api/v1/commands", R"({"command":"stop","vehicle":"CoSiVA/AIV2"})");
  EXPECT_EQ(known.wait_for(50ms), std::future_status::timeout);
  EXPECT_EQ(with_core(std::move(known)).status, 202U);
  auto unknown = send("POST", "/api/v1/commands", R"({"command":"stop","vehicle":"CoSiVA/AIV9"})");
  EXPECT_EQ(with_core(std::move(unknown)).status, 400U);
}

TEST_F(CallDispatcherTest, works_without_a_sender_of_stops) {
  open(fixture.host());
  const HttpResponse response = with_core(send("POST", "/api/v1/commands", one_stop));
  EXPECT_EQ(response.status, 202U);
  EXPECT_THAT(response.body, HasSubstr(R"("durable":true)"));
}

TEST_F(CallDispatcherTest, ends_the_repetition_of_stops_with_a_restart_and_with_nothing_else) {
  open(host_with_line());
  (void)with_core(send("POST", "/api/v1/commands", R"({"command":"slow","vehicle":"CoSiVA/AIV1"})"));
  EXPECT_THAT(lifted, IsEmpty());
  (void)with_core(
      send("POST", "/api/v1/commands", R"({"command":"restart","vehicles":["CoSiVA/AIV1","CoSiVA/AIV2"]})"));
  EXPECT_THAT(lifted, ElementsAre("CoSiVA/AIV1", "CoSiVA/AIV2"));
}

/// A switch whose zone is a text of this length, which is no zone.
std::string switch_of(std::size_t bytes) {
  return R"({"format":"toml","origin":"long.toml","text":")" + std::string(bytes, 'x') + "\"}";
}

TEST_F(CallDispatcherTest, reads_a_long_body_and_builds_its_zone_on_the_worker) {
  open(host_with_line());
  auto release = std::make_shared<std::promise<void>>();
  worker.loop().post([released = std::shared_future<void>{release->get_future()}] { released.wait(); });
  auto long_one = send("POST", "/api/v1/zone/switch", switch_of(std::size_t{1} << 20U));
  // The worker is busy: neither a Stop nor a call of the core waits for it.
  EXPECT_TRUE(at_once(send("POST", "/api/v1/commands", one_stop)));
  EXPECT_EQ(with_core(send("GET", "/api/v1/snapshot")).status, 200U);
  EXPECT_EQ(long_one.wait_for(0s), std::future_status::timeout);
  const std::uint64_t builds = zone::Rtm::initialised_count();
  const std::uint64_t parses = json_parse_count();
  release->set_value();
  const HttpResponse refused = with_core(std::move(long_one));
  EXPECT_EQ(refused.status, 422U) << refused.body;
  EXPECT_LT(fixture.commands.back().size(), 1000U) << "the core gets the reason, not the text";
  EXPECT_THAT(fixture.server.server->snapshot_json(), HasSubstr(R"("origin":"long.toml")"));
  EXPECT_EQ(zone::Rtm::initialised_count(), builds) << "of this thread, the core's";
  EXPECT_EQ(json_parse_count(), parses);
}

TEST_F(CallDispatcherTest, brings_a_zone_into_force_that_the_worker_has_built) {
  open(fixture.host());
  const std::uint64_t builds = zone::Rtm::initialised_count();
  const HttpResponse switched = with_core(send("POST", "/api/v1/zone/switch", R"({"name":"indus8"})"));
  EXPECT_EQ(switched.status, 200U) << switched.body;
  EXPECT_EQ(zone::Rtm::initialised_count() - builds, fixture.server.vehicles.size())
      << "on this thread: each vehicle has built it, and the core has not";
}

TEST_F(CallDispatcherTest, ends_with_calls_that_have_no_response) {
  open(fixture.host());
  auto zone = send("GET", "/api/v1/zone");
  EXPECT_EQ(zone.wait_for(20ms), std::future_status::timeout);
  worker.stop();
  page.stop();
  EXPECT_EQ(dispatcher->waiting(), 1U);
  calls.reset();
  core.run_for(10ms);  // the call finds no calls any more
}

}  // namespace
}  // namespace cosiva::app
