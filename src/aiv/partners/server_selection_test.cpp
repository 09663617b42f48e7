#include "cosiva/aiv/partners/server_selection.h"

#include <gtest/gtest.h>

#include "cosiva/wire/messages/topics.h"

namespace cosiva::aiv {
namespace {

std::string owner(const std::string& area) { return wire::to_json({area, 1, SimTime{}, std::nullopt, std::nullopt}); }

TEST(ServerSelection, begins_with_the_broker_s_only_server) {
  const ServerSelection server;
  EXPECT_EQ(server.topics().heartbeat, wire::server_heartbeat_topic);
  EXPECT_TRUE(server.filters().empty());
}

TEST(ServerSelection, follows_its_owner_there_and_back) {
  ServerSelection server;
  wire::Effects effects;
  EXPECT_TRUE(server.on_owner(owner("north"), effects));
  EXPECT_EQ(server.topics(), wire::server_topics("north"));
  EXPECT_EQ(server.filters().size(), 3U) << "zone, connection and heartbeat";
  EXPECT_FALSE(server.on_owner(owner("north"), effects)) << "the same owner again";
  EXPECT_TRUE(server.has_area());
  EXPECT_TRUE(server.on_owner("", effects));
  EXPECT_FALSE(server.has_area());
  EXPECT_TRUE(server.filters().empty());
  EXPECT_EQ(effects.size(), 2U) << "one line per change";
}

TEST(ServerSelection, stays_with_its_server_when_the_owner_cannot_be_read) {
  ServerSelection server;
  wire::Effects effects;
  ASSERT_TRUE(server.on_owner(owner("north"), effects));
  EXPECT_FALSE(server.on_owner("{", effects));
  EXPECT_EQ(server.topics(), wire::server_topics("north"));
  EXPECT_EQ(std::get<wire::Log>(effects.back()).level, 'w');
}

TEST(ServerSelection, logs_what_it_does) {
  ServerSelection server;
  wire::Effects effects;
  EXPECT_FALSE(server.on_owner("", effects)) << "there was no area before";
  EXPECT_TRUE(effects.empty());
  EXPECT_TRUE(server.on_owner(owner("north"), effects));
  EXPECT_EQ(std::get<wire::Log>(effects.back()), (wire::Log{'i', "belongs to control area north"}));
  EXPECT_EQ(server.filters(),
            (std::vector<std::string>{"cosiva/v1/area/north/zone/+", "cosiva/v1/area/north/server/connection",
                                      "cosiva/v1/area/north/server/heartbeat"}));
  EXPECT_TRUE(server.on_owner("", effects));
  EXPECT_EQ(std::get<wire::Log>(effects.back()), (wire::Log{'i', "belongs to no control area any more"}));
  EXPECT_EQ(server.topics(), wire::server_topics(""));
}

}  // namespace
}  // namespace cosiva::aiv
