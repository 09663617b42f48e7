#include "cosiva/hmi/stop_calls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::HttpResponse;
using fixture::PageFixture;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* stop_one = R"({"command":"stop","vehicle":"CoSiVA/AIV1"})";

/// A page whose store makes a Stop durable when the test requests it.
struct StopPage : PageFixture {
  StopPage() {
    PageHost host = this->host();
    host.stop = [this, command = host.command](const std::string& source, std::string json,
                                               std::shared_ptr<const virtual_side::DecodedCommand> decoded,
                                               std::function<void()> durable) {
      command(source, std::move(json), std::move(decoded), [](const Result<void>&) {});
      make_durable = std::move(durable);
    };
    calls.emplace(std::move(host));
  }
  std::function<void()> make_durable;
};

TEST(StopCalls, give_the_core_the_stop_with_an_action_of_the_same_id) {
  StopPage page;
  const std::string id = PageFixture::field_of(page.send_request("POST", "/api/v1/commands", stop_one), "id");
  EXPECT_THAT(id, StartsWith("S-"));
  EXPECT_THAT(page.commands, ElementsAre(R"({"id":")" + id +
                                         R"(","command":"stop","vehicle":"CoSiVA/AIV1","actionId":")" + id + R"("})"));
  page.server.run_for(std::chrono::seconds{2});
  EXPECT_EQ(page.server.command_entry(id).text("state"), "materialised");
}

TEST(StopCalls, respond_before_the_record_is_durable_and_report_when_it_is) {
  StopPage page;
  const HttpResponse response = page.send_request("POST", "/api/v1/commands", stop_one);
  EXPECT_EQ(response.status, 202U);
  const std::string id = PageFixture::field_of(response, "id");
  EXPECT_EQ(response.body, R"({"id":")" + id + R"(","durable":false,"reason":"not yet durable"})");
  EXPECT_EQ(page.send_request("GET", "/api/v1/commands/" + id).body,
            R"({"id":")" + id + R"(","durable":false,"reason":"not yet durable","unconfirmed":[]})");
  page.make_durable();
  EXPECT_EQ(page.send_request("GET", "/api/v1/commands/" + id).body,
            R"({"id":")" + id + R"(","durable":true,"unconfirmed":[]})");
}

TEST(StopCalls, are_durable_at_once_where_nothing_is_stored) {
  PageFixture page;
  const HttpResponse response = page.send_request("POST", "/api/v1/commands", stop_one);
  EXPECT_EQ(response.body, R"({"id":")" + PageFixture::field_of(response, "id") + R"(","durable":true})");
}

TEST(StopCalls, refuse_a_stop_without_vehicle_and_one_to_a_vehicle_that_is_not_known) {
  StopPage page;
  EXPECT_EQ(page.send_request("POST", "/api/v1/commands", R"({"command":"stop"})").status, 400U);
  const HttpResponse unknown =
      page.send_request("POST", "/api/v1/commands", R"({"command":"stop","vehicle":"CoSiVA/AIV9"})");
  EXPECT_EQ(unknown.status, 400U);
  EXPECT_THAT(PageFixture::sentence(unknown), HasSubstr("CoSiVA/AIV9"));
  EXPECT_THAT(page.commands, ElementsAre());
}

TEST(StopCalls, know_no_progress_of_other_commands) {
  StopPage page;
  EXPECT_EQ(page.send_request("GET", "/api/v1/commands/c1").status, 404U);
}

TEST(StopCalls, list_the_vehicles_that_have_not_confirmed) {
  StopBook stops;
  const std::string id = stops.begin();
  StopLine line;
  line.unconfirmed = [&](const std::string& requested) {
    return requested == id ? std::vector<std::string>{"CoSiVA/AIV1"} : std::vector<std::string>{};
  };
  EXPECT_THAT(stop_progress(stops, line, id).body, HasSubstr(R"("unconfirmed":["CoSiVA/AIV1"])"));
}

TEST(StopRequest, names_its_vehicles) {
  const auto several = read_stop(*JsonValue::parse(R"({"command":"stop","vehicles":["a/b","c/d"]})"), "S-1");
  ASSERT_TRUE(several);
  EXPECT_THAT(several->vehicles, ElementsAre("a/b", "c/d"));
  const auto all = read_stop(*JsonValue::parse(R"({"command":"stop","vehicle":"*"})"), "S-2");
  ASSERT_TRUE(all);
  EXPECT_THAT(all->vehicles, ElementsAre("*"));
  EXPECT_FALSE(read_stop(*JsonValue::parse(R"({"command":"stop","vehicles":[]})"), "S-3"));
}

}  // namespace
}  // namespace cosiva::app
