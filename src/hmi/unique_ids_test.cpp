#include "cosiva/hmi/unique_ids.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace cosiva::app {
namespace {

TEST(UniqueIds, differ_within_a_process_and_over_restarts_within_a_millisecond) {
  std::set<std::string> all;
  constexpr std::size_t processes = 20;
  for (std::size_t process = 0; process < processes; ++process) {
    UniqueIds ids{'C'};
    for (int i = 0; i < 3; ++i) all.insert(ids.next());
  }
  EXPECT_EQ(all.size(), 3 * processes);
  for (const std::string& id : all) EXPECT_TRUE(id.starts_with("C-")) << id;
}

TEST(ClientId, is_refused_where_the_server_may_give_it_to_another_command) {
  for (const char* id : {"c12", "C-mif3k2q9x1z4a-7", "S-1", "c-mif3k2q9-1"}) EXPECT_FALSE(valid_client_id(id)) << id;
  EXPECT_FALSE(valid_client_id(UniqueIds{'C'}.next()));
  EXPECT_FALSE(valid_client_id(UniqueIds{'S'}.next()));
}

TEST(ClientId, has_1_to_64_permitted_characters) {
  for (const char* id : {"c", "order_7.a:b-c", "c0ffee12-9b1d-4f0a-8a52-0123456789ab", "7"})
    EXPECT_TRUE(valid_client_id(id)) << id;
  EXPECT_TRUE(valid_client_id(std::string(64, 'x')));
  EXPECT_FALSE(valid_client_id(std::string(65, 'x')));
  for (const char* id : {"", "a b", "a/b", "a\"b", "é"}) EXPECT_FALSE(valid_client_id(id)) << id;
}

}  // namespace
}  // namespace cosiva::app
