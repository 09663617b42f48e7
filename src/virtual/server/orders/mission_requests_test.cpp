#include "cosiva/virtual/server/orders/mission_requests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;

std::string go(const std::string& to, const std::string& vehicle = "CoSiVA/AIV1") {
  return R"({"command":"go","vehicle":")" + vehicle + R"(","to":")" + to + "\"}";
}
std::string on_section(const std::string& command, const std::string& section) {
  return R"({"command":")" + command + R"(","section":")" + section + "\"}";
}

TEST(Missions, are_refused_with_a_message_that_lists_similar_names) {
  ServerFixture fixture{fork()};
  fixture.add("AIV1", {0, 0.1});
  fixture.run_for(300ms);
  EXPECT_THAT(fixture.refusal(go("duck")), HasSubstr("dock"));
  EXPECT_THAT(fixture.refusal(go("")), HasSubstr("state the destination"));
  EXPECT_THAT(fixture.refusal(go("dock", "CoSiVA/AIV9")), HasSubstr("no vehicle 'CoSiVA/AIV9'"));
  EXPECT_THAT(fixture.refusal(R"({"command":"go","to":"dock"})"), HasSubstr("state which vehicle"));
  EXPECT_THAT(fixture.refusal(R"({"command":"circulate","vehicle":"*","loop":"outer"})"), HasSubstr("no loops"));
  EXPECT_THAT(fixture.refusal(on_section("close", "soth")), HasSubstr("south"));
  EXPECT_THAT(fixture.refusal(on_section("open", "south")), HasSubstr("open already"));
  EXPECT_THAT(fixture.refusal(R"({"command":"close"})"), HasSubstr("which section"));
  EXPECT_EQ(fixture.refusal(go("gate")), "");
  ServerCore nowhere{ServerOptions{}};
  EXPECT_THAT(nowhere.check_command(DecodedCommand{go("dock")}).error().message, HasSubstr("no zone yet"));
}

}  // namespace
}  // namespace cosiva::virtual_side
