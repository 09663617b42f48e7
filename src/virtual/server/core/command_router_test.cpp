#include "cosiva/virtual/server/core/command_router.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "cosiva/base/json_parse_count.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

TEST(CommandTexts, are_parsed_once_and_not_at_all_where_the_sender_has_decoded_them) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  wire::Effects effects;
  for (const std::string json :
       {R"({"command":"stop","vehicle":"CoSiVA/AIV1"})", R"({"command":"dance","vehicle":"*"})",
        R"({"command":"circulate","vehicle":"*"})", R"({"command":"close","section":"east"})",
        R"({"command":"add","virtualObject":{"kind":"person","x":0.5,"y":0.2}})",
        R"({"command":"edit","edit":{"addTags":[{"number":77,"section":"south","s":0.3}]}})", R"({"command":"undo"})",
        R"({"command":"plant","plant":{"addObstacle":{"id":"box","x":0.1,"y":0.1}}})",
        R"({"command":"switch","zone":{"format":"toml","text":"name = 7"}})", R"({"command":"switch"})", "no json"}) {
    wire::Input input{fixture.now, wire::InputKind::command, "test", json};
    std::uint64_t before = json_parse_count();
    fixture.server->handle(input, effects);
    EXPECT_EQ(json_parse_count() - before, 1U) << json;
    const auto decoded = std::make_shared<const DecodedCommand>(json);
    input.typed = decoded;
    before = json_parse_count();
    (void)fixture.server->check_command(*decoded);
    fixture.server->handle(input, effects);
    EXPECT_EQ(json_parse_count(), before) << json;
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
