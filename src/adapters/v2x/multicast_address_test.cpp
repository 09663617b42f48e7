#include "cosiva/adapters/v2x/multicast_address.h"

#include <gtest/gtest.h>

namespace cosiva::adapters {
namespace {

TEST(MulticastAddress, is_a_group_of_either_version_and_a_port) {
  EXPECT_EQ(*parse_multicast("239.192.7.50:7500"), (MulticastAddress{"239.192.7.50", 7500, false}));
  EXPECT_EQ(*parse_multicast("[ff15::c051:7a]:1"), (MulticastAddress{"ff15::c051:7a", 1, true}));
  EXPECT_EQ(*parse_multicast("[ff02::1]:65535"), (MulticastAddress{"ff02::1", 65535, true}));
}

TEST(MulticastAddress, is_refused_where_it_names_no_group_or_no_port) {
  for (const char* text : {"", ":", "239.192.7.50", "239.192.7.50:", "239.192.7.50:0", "239.192.7.50:65536",
                           "10.0.0.5:7500", "127.0.0.1:7500", "240.0.0.1:7500", "[fe80::1]:7500", "ff15::1:7500",
                           "[ff15::1]", "group:7500", "239.192.7.50:75x", "[239.192.7.50]:7500"}) {
    const auto parsed = parse_multicast(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, "v2x.multicast");
    EXPECT_EQ(parsed.error().location, "--v2x-multicast");
  }
}

}  // namespace
}  // namespace cosiva::adapters
