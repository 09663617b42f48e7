#include "cosiva/hmi/openapi.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <set>
#include <string>

#include "cosiva/base/json_text.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/page_calls.h"
#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::HttpResponse;
using fixture::PageFixture;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(OpenApi, describes_every_call_and_no_other) {
  const auto document = JsonValue::parse(openapi_json());
  ASSERT_TRUE(document);
  std::set<std::string> described;
  for (const auto& [path, item] : *document->find("paths")->object()) {
    for (const auto& [method, operation] : *item.object()) {
      if (method == "parameters") continue;
      std::string upper = method;
      std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
      described.insert(upper + " " + path);
      EXPECT_NE(operation.find("summary"), nullptr) << path;
    }
  }
  std::set<std::string> there;
  for (const auto& route : PageCalls::routes())
    there.insert(std::string(route.method) + " " + std::string(route.pattern));
  EXPECT_EQ(described, there);
  PageFixture page;
  EXPECT_EQ(page.send_request("GET", "/api").body, openapi_json());
  EXPECT_EQ(page.send_request("GET", "/api/").body, openapi_json());
}

/// A page with everything that an example needs.
struct PreparedPage : PageFixture {
  PreparedPage() {
    send_request("POST", "/api/v1/virtual-objects", R"({"kind":"person","x":0.4,"y":0.5})");
    calls->know_plant({});
    server.feed(wire::InputKind::message, "cosiva/v1/battery/change/CoSiVA/AIV1",
                R"({"battery":"red","run":1,"reason":""})", true);
    clock.running = false;
  }
};

TEST(OpenApi, examples_are_accepted_or_refused_as_described) {
  const auto document = JsonValue::parse(openapi_json());
  PreparedPage unchanged;  // for requests that are refused
  std::size_t tried = 0;
  for (const auto& [path, item] : *document->find("paths")->object()) {
    for (const auto& [method, operation] : *item.object()) {
      const JsonValue* body = operation.find("requestBody");
      if (body == nullptr) continue;
      const JsonValue* content = body->find("content")->find("application/json");
      std::string upper = method;
      std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
      std::string target = path;
      if (const std::size_t at = target.find("{id}"); at != std::string::npos) target.replace(at, 4, "P1");
      for (const char* list : {"examples", "x-refused"}) {
        const JsonValue* examples = content->find(list);
        ASSERT_NE(examples, nullptr) << path;
        for (const auto& [name, example] : *examples->object()) {
          JsonWriter json;
          write_json(json, *example.find("value"));
          const bool good = list == std::string("examples");
          const HttpResponse response = good ? PreparedPage{}.send_request(upper, target, json.text())
                                             : unchanged.send_request(upper, target, json.text());
          ++tried;
          EXPECT_NE(operation.find("responses")->find(std::to_string(response.status)), nullptr)
              << path << " responds " << response.status << ", which it does not list";
          if (good) {
            EXPECT_LT(response.status, 300U) << upper << " " << target << " " << json.text() << ": " << response.body;
          } else {
            EXPECT_EQ(response.status, 400U) << upper << " " << target << " " << json.text() << ": " << response.body;
            EXPECT_THAT(PageFixture::sentence(response), Not(IsEmpty()));
          }
        }
      }
    }
  }
  EXPECT_GT(tried, 30U);
}

}  // namespace
}  // namespace cosiva::app
