#include "cosiva/app/platform/keep_option.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::app {
namespace {

using namespace std::chrono_literals;

TEST(KeepOption, takes_an_age_a_size_or_both_in_any_order) {
  EXPECT_EQ(parse_keep("30d")->age, 720h);
  EXPECT_EQ(parse_keep("30d")->bytes, std::nullopt);
  EXPECT_EQ(parse_keep("12h")->age, 12h);
  EXPECT_EQ(parse_keep("500MB")->bytes, 500'000'000U);
  EXPECT_EQ(parse_keep("2TB")->bytes, 2'000'000'000'000U);
  for (const char* both : {"7d/20GB", "20GB/7d"}) {
    EXPECT_EQ(parse_keep(both)->age, 168h) << both;
    EXPECT_EQ(parse_keep(both)->bytes, 20'000'000'000U) << both;
  }
}

TEST(KeepOption, retains_all_where_that_is_requested) {
  EXPECT_EQ(parse_keep("all")->age, std::nullopt);
  EXPECT_EQ(parse_keep("all")->bytes, std::nullopt);
}

TEST(KeepOption, has_a_default_that_it_takes) { EXPECT_TRUE(parse_keep(keep_default)); }

TEST(KeepOption, refuses_anything_else_with_the_possible_forms) {
  for (const char* text : {"", "/", "d", "30", "0d", "-1d", "30d/", "/20GB", "30d/12h", "1GB/2GB", "30 d",
                           "30d/20GB/1h", "1000001d", "99999999999999999999GB", "30D", "20gb"}) {
    const auto keep = parse_keep(text);
    ASSERT_FALSE(keep) << text;
    EXPECT_THAT(keep.error().message, testing::HasSubstr("30d/20GB")) << text;
  }
}

}  // namespace
}  // namespace cosiva::app
