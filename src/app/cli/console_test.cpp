#include "cosiva/app/cli/console.h"

#include <gmock/gmock.h>

namespace cosiva::app {
namespace {

TEST(NearestWord, is_the_nearest_candidate_of_a_typing_error) {
  const std::vector<std::string> commands{"up", "server", "plant", "aiv", "replay", "zone"};
  EXPECT_EQ(nearest_word("serve", commands), "server");
  EXPECT_EQ(nearest_word("relpay", commands), "replay");
  EXPECT_EQ(nearest_word("zones", commands), "zone");
  EXPECT_EQ(nearest_word("--duraton", {"--duration", "--json"}), "--duration");
}

TEST(NearestWord, is_empty_without_a_near_candidate) {
  EXPECT_EQ(nearest_word("dance", {"server", "replay"}), "");
  EXPECT_EQ(nearest_word("x", {}), "");
}

TEST(Decimals, round_to_the_requested_digits) {
  EXPECT_EQ(decimals(1.25, 1), "1.2");
  EXPECT_EQ(decimals(0.9996, 3), "1.000");
  EXPECT_EQ(decimals(12.0, 0), "12");
}

TEST(StepLine, aligns_the_times) {
  EXPECT_EQ(step_line(1.25, "x"), "     1.2 s  x");
  EXPECT_EQ(step_line(12345.0, "y"), " 12345.0 s  y");
}

}  // namespace
}  // namespace cosiva::app
