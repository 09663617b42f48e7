// No two commands have the same id, whatever happens between them; a command that is sent again is recognised.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::HttpResponse;
using fixture::PageFixture;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr const char* slow = R"({"command":"slow","vehicle":"CoSiVA/AIV1"})";
constexpr const char* my_slow = R"({"command":"slow","vehicle":"CoSiVA/AIV1","id":"mine"})";

std::string posted(PageFixture& page, const std::string& body) {
  return PageFixture::field_of(page.send_request("POST", "/api/v1/commands", body), "id");
}

/// The server is killed: a new one has the state that this one persisted, as where the snapshot does not fit.
void restart(PageFixture& page) {
  page.server.restart_server(true);
  page.server.run_for(std::chrono::seconds{3});
  page.calls.reset();
}

TEST(CommandIdsOfThePage, differ_for_commands_of_all_kinds) {
  PageFixture page;
  std::set<std::string> ids;
  ids.insert(posted(page, R"({"command":"circulate","vehicle":"CoSiVA/AIV1"})"));
  ids.insert(posted(page, R"({"command":"close","section":"east"})"));
  ids.insert(posted(page, slow));
  ids.insert(posted(page, R"({"command":"stop","vehicle":"CoSiVA/AIV1"})"));
  EXPECT_THAT(ids, SizeIs(4));
}

TEST(CommandIdsOfThePage, differ_from_those_that_the_core_gives_before_the_command_is_decided) {
  PageFixture page;
  std::function<void()> decide;
  PageHost host = page.host();
  host.command = [&, command = host.command](const std::string& source, std::string json,
                                             std::shared_ptr<const virtual_side::DecodedCommand> decoded,
                                             PageHost::Decided decided) {
    decide = [=, json = std::move(json)] { command(source, json, decoded, decided); };
  };
  page.calls.emplace(std::move(host));
  const std::string id = posted(page, slow);
  page.server.command("slow", "CoSiVA/AIV2");  // from a scenario, while the disk writes
  decide();
  const auto snapshot = page.server.snapshot();
  std::set<std::string> ids;
  for (const JsonValue& command : *snapshot.find("commands")->array()) ids.insert(*command.text("id"));
  EXPECT_THAT(ids, SizeIs(2));
  EXPECT_TRUE(ids.contains(id));
}

TEST(CommandIdsOfThePage, differ_over_restarts_of_the_server) {
  PageFixture page;
  std::set<std::string> ids{posted(page, slow)};
  page.server.command("fast", "CoSiVA/AIV2");
  ids.insert(*page.server.snapshot().find("commands")->array()->back().text("id"));
  restart(page);
  ids.insert(posted(page, slow));
  page.server.command("slow", "CoSiVA/AIV2");
  ids.insert(*page.server.snapshot().find("commands")->array()->back().text("id"));
  EXPECT_THAT(ids, SizeIs(4));
}

TEST(CommandIdOfAClient, is_that_of_the_command) {
  PageFixture page;
  EXPECT_EQ(posted(page, my_slow), "mine");
  EXPECT_EQ(page.server.command_entry("mine").text("command"), "slow");
}

TEST(CommandIdOfAClient, has_a_request_that_is_sent_again_executed_once_and_responded_to_as_the_first_time) {
  PageFixture page;
  const HttpResponse first = page.send_request("POST", "/api/v1/commands", my_slow);
  posted(page, R"({"command":"fast","vehicle":"CoSiVA/AIV1"})");
  const HttpResponse again = page.send_request("POST", "/api/v1/commands", my_slow);
  EXPECT_EQ(again.status, first.status);
  EXPECT_EQ(again.body, first.body);
  EXPECT_THAT(page.commands, ElementsAre(HasSubstr("slow"), HasSubstr("fast")));
  page.server.run_for(std::chrono::seconds{2});
  EXPECT_EQ(page.server.aiv("CoSiVA/AIV1").text("status"), "fast speed");
}

TEST(CommandIdOfAClient, is_recognised_in_commands_of_all_kinds_and_although_they_could_not_be_executed_now) {
  PageFixture page;
  const std::string close = R"({"command":"close","section":"east","id":"a"})";
  const std::string go = R"({"command":"circulate","vehicle":"CoSiVA/AIV2","id":"b"})";
  for (const std::string& body : {close, go, close, go})
    EXPECT_EQ(page.send_request("POST", "/api/v1/commands", body).status, 202U) << body;
  EXPECT_THAT(page.commands, SizeIs(2));
}

TEST(CommandIdOfAClient, is_recognised_after_a_restart_of_the_server) {
  PageFixture page;
  posted(page, my_slow);
  restart(page);
  page.commands.clear();
  EXPECT_EQ(posted(page, my_slow), "mine");
  EXPECT_THAT(page.commands, ElementsAre());
}

TEST(CommandIdOfAClient, is_refused_for_another_command) {
  PageFixture page;
  posted(page, my_slow);
  const HttpResponse other =
      page.send_request("POST", "/api/v1/commands", R"({"command":"fast","vehicle":"CoSiVA/AIV1","id":"mine"})");
  EXPECT_EQ(other.status, 409U);
  EXPECT_THAT(PageFixture::sentence(other), HasSubstr("'mine' belongs to another command"));
  EXPECT_THAT(page.commands, SizeIs(1));
}

TEST(CommandIdOfAClient, may_be_used_again_after_a_refusal) {
  PageFixture page;
  const auto refused =
      page.send_request("POST", "/api/v1/commands", R"({"command":"close","section":"nowhere","id":"mine"})");
  EXPECT_GE(refused.status, 400U);
  EXPECT_EQ(page.send_request("POST", "/api/v1/commands", R"({"command":"close","section":"east","id":"mine"})").status,
            202U);
}

TEST(CommandIdOfAClient, is_refused_where_it_is_of_the_servers_own_form) {
  PageFixture page;
  for (const char* id : {R"("c12")", R"("C-1")", R"("S-1")", R"("")", R"("a b")", "7", "null"}) {
    const auto refused = page.send_request(
        "POST", "/api/v1/commands", R"({"command":"slow","vehicle":"CoSiVA/AIV1","id":)" + std::string(id) + "}");
    EXPECT_EQ(refused.status, 400U) << id;
  }
  EXPECT_THAT(page.commands, SizeIs(0));
}

TEST(CommandIdOfAClient, does_not_keep_a_stop_from_stopping_again) {
  PageFixture page;
  const std::string stop = R"({"command":"stop","vehicle":"CoSiVA/AIV1","id":"mine"})";
  const std::string first = posted(page, stop);
  page.server.run_for(std::chrono::seconds{2});
  posted(page, R"({"command":"restart","vehicle":"CoSiVA/AIV1"})");
  page.server.run_for(std::chrono::seconds{2});
  EXPECT_EQ(page.server.aiv("CoSiVA/AIV1").flag("paused"), false);
  EXPECT_NE(posted(page, stop), first);
  page.server.run_for(std::chrono::seconds{2});
  EXPECT_EQ(page.server.aiv("CoSiVA/AIV1").flag("paused"), true);
}

}  // namespace
}  // namespace cosiva::app
