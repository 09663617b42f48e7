#include "cosiva/aiv/decision/hold.h"

#include <gtest/gtest.h>

#include <set>

namespace cosiva::aiv {
namespace {

constexpr Hold all[] = {Hold::paused,       Hold::broker_lost, Hold::server_lost, Hold::board_lost,
                        Hold::board_faulty, Hold::line_lost,   Hold::zone_change};

TEST(HoldSet, keeps_each_hold_apart_from_the_others) {
  for (const Hold hold : all) {
    HoldSet holds;
    EXPECT_FALSE(holds.any());
    holds.set(hold, true);
    for (const Hold other : all) EXPECT_EQ(holds.has(other), other == hold) << to_string(other);
    EXPECT_TRUE(holds.any());
    holds.set(hold, false);
    EXPECT_EQ(holds.bits(), 0);
  }
}

TEST(HoldSet, keeps_the_rest_when_one_hold_ends) {
  HoldSet holds;
  for (const Hold hold : all) holds.set(hold, true);
  holds.set(Hold::paused, false);
  for (const Hold hold : all) EXPECT_EQ(holds.has(hold), hold != Hold::paused) << to_string(hold);
}

TEST(HoldSet, has_a_name_for_each_hold) {
  std::set<std::string_view> names;
  for (const Hold hold : all) names.insert(to_string(hold));
  EXPECT_EQ(names.size(), std::size(all));
  EXPECT_FALSE(names.contains("?"));
}

}  // namespace
}  // namespace cosiva::aiv
