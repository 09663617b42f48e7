// Changes are responded to once they are durable, one after the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "cosiva/hmi/page_calls.h"
#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::HttpRequest;
using adapters::HttpResponse;
using fixture::PageFixture;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The page's calls with a disk that decides when the test is true.
class SlowDisk : public ::testing::Test {
 protected:
  SlowDisk() {
    PageHost host = page.host();
    auto command = std::exchange(host.command, {});
    host.command = [this, command](const std::string& source, std::string json,
                                   std::shared_ptr<const virtual_side::DecodedCommand> decoded,
                                   PageHost::Decided decided) {
      const auto give = [command, source, json, decoded] {
        command(source, json, decoded, [](const Result<void>&) {});
      };
      if (is_stop(*decoded)) {
        give();
        return decided({});
      }
      waiting.push_back([give, decided = std::move(decided)](const Result<void>& kept) {
        if (kept) give();
        decided(kept);
      });
    };
    calls.emplace(std::move(host));
  }
  /// Sends a request; its response is added to `statuses` when it comes.
  void send(const std::string& method, const std::string& path, const std::string& body = {}) {
    const auto arrived = [this](const HttpResponse& response) { statuses.push_back(response.status); };
    auto read =
        PageCalls::read({method, path, "", body, *adapters::http_rules::path_segments(path)}, *calls->host().zones);
    if (read)
      calls->handle(std::move(*read), arrived);
    else
      arrived(read.error());
  }
  void decide(const Result<void>& kept = {}) {
    ASSERT_FALSE(waiting.empty());
    const auto first = waiting.front();
    waiting.erase(waiting.begin());
    first(kept);
  }
  PageFixture page;
  std::vector<std::function<void(const Result<void>&)>> waiting;  ///< for the disk
  std::vector<unsigned> statuses;
  std::optional<PageCalls> calls;
};

constexpr const char* person = R"({"kind":"person","x":0.9,"y":-0.9})";

TEST_F(SlowDisk, delays_the_response_to_a_change_until_the_change_is_durable) {
  send("POST", "/api/v1/commands", R"({"command":"slow","vehicle":"CoSiVA/AIV1"})");
  EXPECT_THAT(statuses, ElementsAre());
  EXPECT_THAT(page.commands, ElementsAre());
  decide();
  EXPECT_THAT(statuses, ElementsAre(202U));
  EXPECT_EQ(page.commands.size(), 1U);
}

TEST_F(SlowDisk, delays_no_query) {
  send("POST", "/api/v1/virtual-objects", person);
  send("GET", "/api/v1/snapshot");
  EXPECT_THAT(statuses, ElementsAre(200U));
}

TEST_F(SlowDisk, does_not_delay_a_stop_behind_other_changes) {
  send("POST", "/api/v1/virtual-objects", person);
  send("POST", "/api/v1/commands", R"({"command":"stop","vehicle":"*"})");
  EXPECT_THAT(statuses, ElementsAre(202U));
  EXPECT_EQ(page.commands.size(), 1U);
}

constexpr const char* stop_first = R"({"command":"stop","vehicle":"CoSiVA/AIV1"})";
constexpr const char* restart_first = R"({"command":"restart","vehicle":"CoSiVA/AIV1"})";

TEST_F(SlowDisk, does_not_let_an_earlier_restart_lift_a_stop) {
  send("POST", "/api/v1/commands", restart_first);
  send("POST", "/api/v1/commands", stop_first);
  EXPECT_THAT(statuses, ElementsAre(202U)) << "the Stop";
  ASSERT_EQ(page.commands.size(), 1U);
  const std::string first = page.commands.front();
  decide();
  EXPECT_THAT(statuses, ElementsAre(202U, 202U));
  ASSERT_EQ(page.commands.size(), 3U);
  EXPECT_THAT(page.commands[1], HasSubstr("restart"));
  EXPECT_THAT(page.commands[2], HasSubstr(R"("command":"stop")"));
  EXPECT_NE(page.commands[2], first) << "a vehicle performs an action once";
  page.server.run_for(std::chrono::seconds{3});
  EXPECT_EQ(page.server.aiv("CoSiVA/AIV1").flag("paused"), true);
}

TEST_F(SlowDisk, refuses_an_earlier_restart_that_waits_for_its_turn) {
  send("POST", "/api/v1/virtual-objects", person);
  send("POST", "/api/v1/commands", restart_first);
  send("POST", "/api/v1/commands", R"({"command":"restart","vehicle":"CoSiVA/AIV2"})");
  send("POST", "/api/v1/commands", stop_first);
  EXPECT_THAT(statuses, ElementsAre(409U, 202U));
  decide();
  decide();
  EXPECT_THAT(statuses, ElementsAre(409U, 202U, 201U, 202U)) << "another vehicle's Restart is not refused";
  EXPECT_EQ(page.commands.size(), 3U);
}

TEST_F(SlowDisk, lets_a_later_restart_lift_a_stop) {
  send("POST", "/api/v1/commands", stop_first);
  send("POST", "/api/v1/commands", restart_first);
  decide();
  EXPECT_THAT(statuses, ElementsAre(202U, 202U));
  EXPECT_THAT(page.commands.back(), HasSubstr("restart"));
}

TEST_F(SlowDisk, has_each_change_checked_against_what_the_one_before_has_made) {
  send("POST", "/api/v1/virtual-objects", person);
  send("DELETE", "/api/v1/virtual-objects/P1");
  send("DELETE", "/api/v1/virtual-objects/P1");
  EXPECT_EQ(waiting.size(), 1U) << "only the first has been handled";
  decide();
  EXPECT_THAT(statuses, ElementsAre(201U));
  decide();
  EXPECT_THAT(statuses, ElementsAre(201U, 200U, 404U)) << "the person exists once";
}

TEST_F(SlowDisk, gives_different_ids_to_changes_that_wait_at_the_same_time) {
  send("POST", "/api/v1/virtual-objects", person);
  send("POST", "/api/v1/virtual-objects", person);
  decide();
  decide();
  EXPECT_THAT(statuses, ElementsAre(201U, 201U));
  EXPECT_EQ(page.server.snapshot().find("virtualObjects")->array()->size(), 2U);
}

/// A page whose core has still to be given the commands of an earlier process.
struct EarlierCommands : PageFixture {
  EarlierCommands() {
    PageHost host = this->host();
    host.gives_earlier_commands = [this] { return gives; };
    calls.emplace(std::move(host));
  }
  /// The responses are added to `responses` when they come.
  void post(const std::string& path, const std::string& body) {
    auto read =
        PageCalls::read({"POST", path, "", body, *adapters::http_rules::path_segments(path)}, *calls->host().zones);
    ASSERT_TRUE(read.has_value());
    calls->handle(std::move(*read), [this](const HttpResponse& response) { responses.push_back(response); });
  }
  bool gives{true};
  std::vector<HttpResponse> responses;
};

TEST(EarlierCommandsOfAProcess, are_executed_before_changes_are_handled_so_that_no_object_has_the_id_of_another) {
  EarlierCommands page;
  page.post("/api/v1/virtual-objects", person);
  page.calls->continue_changes();
  EXPECT_THAT(page.responses, ::testing::SizeIs(0));
  page.server.send_command(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":0.9,"y":-0.9}})");
  page.gives = false;
  page.calls->continue_changes();
  ASSERT_THAT(page.responses, ::testing::SizeIs(1));
  EXPECT_EQ(PageFixture::field_of(page.responses[0], "id"), "P2");
  EXPECT_EQ(page.server.snapshot().find("virtualObjects")->array()->size(), 2U);
}

TEST(EarlierCommandsOfAProcess, delay_no_stop) {
  EarlierCommands page;
  page.post("/api/v1/commands", R"({"command":"stop","vehicle":"*"})");
  ASSERT_THAT(page.responses, ::testing::SizeIs(1));
  EXPECT_EQ(page.responses[0].status, 202U);
}

TEST_F(SlowDisk, that_refuses_has_the_change_refused_with_its_reason_and_not_executed) {
  send("POST", "/api/v1/virtual-objects", person);
  decide(fail("disk.full", "No space left on device", "store"));
  EXPECT_THAT(statuses, ElementsAre(503U));
  EXPECT_THAT(page.commands, ElementsAre());
  send("POST", "/api/v1/virtual-objects", person);
  decide();
  EXPECT_THAT(statuses, ElementsAre(503U, 201U));
}

TEST_F(SlowDisk, does_not_delay_the_refusal_of_a_change_that_is_wrong) {
  send("POST", "/api/v1/virtual-objects", R"({"kind":"tree"})");
  EXPECT_THAT(statuses, ElementsAre(400U));
}

}  // namespace
}  // namespace cosiva::app
