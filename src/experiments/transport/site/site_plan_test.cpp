#include "cosiva/experiments/transport/site/site_plan.h"

#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

TEST(SitePlan, reads_zones_and_transfer_points_in_one_direction_or_both) {
  const auto plan = read_site_plan(R"([[zone]]
name = "area"
file = "lacet4"
aivs = 8
[[zone]]
file = "indus8"
[[transfer_point]]
from = "area/S1"
to = "indus8"
takes_s = 25
bidirectional = "yes"
)",
                                   "site.toml");
  ASSERT_TRUE(plan) << to_string(plan.error());
  EXPECT_EQ(plan->zones, (std::vector<SitePlan::Zone>{{"area", "lacet4", 8}, {"indus8", "indus8", 12}}));
  EXPECT_EQ(plan->transfer_points, (std::vector<SitePlan::TransferPoint>{{"area", "S1", "indus8", "", 25.0},
                                                                         {"indus8", "", "area", "S1", 25.0}}));
}

TEST(SitePlan, of_a_list_joins_each_zone_with_the_next_and_back) {
  const auto two = site_plan_of_list("lacet4,indus8", 5, 10.0);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->zones.size(), 2U);
  EXPECT_EQ(two->transfer_points.size(), 2U);
  const auto four = site_plan_of_list("3*lacet4,indus8", 5, 10.0);
  ASSERT_TRUE(four);
  ASSERT_EQ(four->zones.size(), 4U);
  EXPECT_EQ(four->zones[3].file, "indus8");
  EXPECT_EQ(four->transfer_points.size(), 8U);
  const auto one = site_plan_of_list("lacet4", 5, 10.0);
  ASSERT_TRUE(one);
  EXPECT_TRUE(one->transfer_points.empty());
}

struct Bad {
  const char* text;
  const char* message;
};
class BadSitePlan : public testing::TestWithParam<Bad> {};

TEST_P(BadSitePlan, is_refused_with_the_file_the_line_and_what_is_wrong) {
  const auto plan = read_site_plan(GetParam().text, "site.toml");
  ASSERT_FALSE(plan);
  EXPECT_NE(to_string(plan.error()).find("site.toml"), std::string::npos) << to_string(plan.error());
  EXPECT_NE(to_string(plan.error()).find(GetParam().message), std::string::npos) << to_string(plan.error());
}
INSTANTIATE_TEST_SUITE_P(
    Files, BadSitePlan,
    testing::Values(Bad{"", "at least one [[zone]]"}, Bad{"[[zone]]\naivs = 3\n", "file"},
                    Bad{"[[zone]]\nfile = \"a\"\n[[zone]]\nfile = \"a\"\n", "two zones"},
                    Bad{"[[zone]]\nfile = \"a/b\"\n", "'/'"},
                    Bad{"[[zone]]\nfile = \"area\"\n[[transfer_point]]\nfrom = \"arae\"\nto = \"area\"\n",
                        "is \"area\" meant?"},
                    Bad{"[[zone]]\nfile = \"a\"\n[[transfer_point]]\nfrom = \"a\"\nto = \"a\"\n", "another zone"},
                    Bad{"[[zone]]\nfile = \"a\"\naivs = -1\n", "aivs"},
                    Bad{"[[zone]]\nfile = \"a\"\nspeed = 3\n", "speed"}, Bad{"[[zone]\n", "site.toml:1"}));

TEST(SitePlan, of_an_invalid_list_is_refused) {
  for (const char* list : {"", "0*lacet4", "x*lacet4", "lacet4,,indus8", "99999999*lacet4"}) {
    const auto plan = site_plan_of_list(list, 5, 10.0);
    ASSERT_FALSE(plan) << list;
    EXPECT_EQ(plan.error().code, "site.list");
  }
}

}  // namespace
}  // namespace cosiva::experiments
