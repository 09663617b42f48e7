#include "cosiva/base/likeness.h"

#include <gtest/gtest.h>

#include <rapidcheck/gtest.h>
#include <algorithm>
#include <string>

namespace cosiva {
namespace {

TEST(EditDistance, counts_letters_changed_added_and_left_out) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("dock", "deck"), 1U);
  EXPECT_EQ(edit_distance("speed", "sped"), 1U);
  EXPECT_EQ(edit_distance("", "four"), 4U);
  EXPECT_EQ(edit_distance("four", ""), 4U);
  EXPECT_EQ(edit_distance("", ""), 0U);
}

RC_GTEST_PROP(EditDistance, is_a_distance, ()) {
  const auto word = rc::gen::container<std::string>(rc::gen::inRange('a', 'd'));
  const auto a = *word;
  const auto b = *word;
  const auto c = *word;
  RC_ASSERT((edit_distance(a, b) == 0) == (a == b));
  RC_ASSERT(edit_distance(a, b) == edit_distance(b, a));
  RC_ASSERT(edit_distance(a, c) <= edit_distance(a, b) + edit_distance(b, c));
  RC_ASSERT(edit_distance(a, b) <= std::max(a.size(), b.size()));
}

}  // namespace
}  // namespace cosiva
