#include "cosiva/app/cli/seed_range.h"

#include <gtest/gtest.h>

namespace cosiva::app {
namespace {

TEST(SeedRange, is_one_seed_or_the_first_and_the_last_one) {
  const auto one = read_seed_range("7", "--seeds", "x.seeds");
  ASSERT_TRUE(one);
  EXPECT_EQ(one->first, 7U);
  EXPECT_EQ(one->count(), 1U);
  const auto many = read_seed_range("3774873600..3774873799", "--seeds", "x.seeds");
  ASSERT_TRUE(many);
  EXPECT_EQ(many->first, 3774873600U);
  EXPECT_EQ(many->count(), 200U);
}

TEST(SeedRange, refuses_anything_else_with_the_option_s_name) {
  for (const char* text : {"", "x", "9..3", "1..", "..3", "1...3", "-1", "1..20000001"}) {
    const auto range = read_seed_range(text, "--train", "x.seeds");
    ASSERT_FALSE(range) << text;
    EXPECT_EQ(range.error().code, "x.seeds");
    EXPECT_EQ(range.error().location, "--train");
  }
}

}  // namespace
}  // namespace cosiva::app
