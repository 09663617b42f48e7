#include "cosiva/aiv/onboard/error_log.h"

#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

TEST(ErrorLog, has_one_line_per_kind_until_it_is_cleared) {
  ErrorLog errors;
  wire::Effects effects;
  errors.report("map", "another map", effects);
  errors.report("map", "yet another map", effects);
  errors.report("json", "no JSON", effects);
  ASSERT_EQ(effects.size(), 2U);
  EXPECT_EQ(std::get<wire::Log>(effects[0]).text, "another map");
  EXPECT_EQ(std::get<wire::Log>(effects[1]).text, "no JSON");
  errors.clear();
  errors.report("map", "another map", effects);
  EXPECT_EQ(effects.size(), 3U);
}

TEST(ErrorLog, has_at_most_sixteen_kinds) {
  ErrorLog errors;
  wire::Effects effects;
  for (int i = 0; i < 20; ++i) errors.report(std::to_string(i), "text", effects);
  EXPECT_EQ(effects.size(), ErrorLog::kinds_max);
}

}  // namespace
}  // namespace cosiva::aiv
