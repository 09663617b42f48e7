#include "cosiva/virtual/server/registry/reordering.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

TEST(Reordering, takes_a_message_from_just_before_the_last_one_as_late) {
  EXPECT_TRUE(is_late(virtual_epoch - 1ns, virtual_epoch));
  EXPECT_TRUE(is_late(virtual_epoch - 4999ms, virtual_epoch));
}

TEST(Reordering, takes_a_time_stamp_of_five_seconds_before_the_last_one_as_a_clock_that_was_set) {
  EXPECT_FALSE(is_late(virtual_epoch - 5s, virtual_epoch));
}

TEST(Reordering, does_not_take_the_same_or_a_newer_time_stamp_as_late) {
  EXPECT_FALSE(is_late(virtual_epoch, virtual_epoch));
  EXPECT_FALSE(is_late(virtual_epoch + 1ns, virtual_epoch));
}

}  // namespace
}  // namespace cosiva::virtual_side
