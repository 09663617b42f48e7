#include "cosiva/hmi/queries.h"

#include <gtest/gtest.h>

#include <string>

#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

TEST(Queries, show_the_parts_of_the_platform_in_the_snapshot) {
  fixture::PageFixture page;
  PageHost host = page.host();
  host.parts_json = [] {
    return std::string(R"([{"name":"plant","state":"failing","restarts":7,"last_error":null}])");
  };
  const auto snapshot = JsonValue::parse(snapshot_json(host));
  ASSERT_TRUE(snapshot);
  const JsonValue::Array& parts = *snapshot->find("parts")->array();
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].text("name"), "plant");
  EXPECT_EQ(parts[0].number("restarts"), 7.0);
  EXPECT_EQ(snapshot->find("aivs")->array()->size(), 2U);
}

TEST(Queries, show_no_parts_where_they_are_not_known) {
  fixture::PageFixture page;
  PageHost host = page.host();
  EXPECT_EQ(snapshot_json(host), host.core->snapshot_json());
  for (const char* unreadable : {"", "[{", "7", R"({"name":"plant"})"}) {
    host.parts_json = [unreadable] { return std::string(unreadable); };
    EXPECT_EQ(snapshot_json(host), host.core->snapshot_json()) << unreadable;
  }
}

}  // namespace
}  // namespace cosiva::app
