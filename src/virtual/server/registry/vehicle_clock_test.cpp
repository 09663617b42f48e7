#include "cosiva/virtual/server/registry/vehicle_clock.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

TEST(VehicleClock, is_correct_within_two_seconds) {
  VehicleClock clock;
  EXPECT_EQ(clock.on_stamp(virtual_epoch - 2s, virtual_epoch), virtual_epoch - 2s);
  EXPECT_FALSE(clock.is_off());
  EXPECT_EQ(clock.off_s(), 0.0);
}

TEST(VehicleClock, never_leads_into_the_future) {
  VehicleClock clock;
  EXPECT_EQ(clock.on_stamp(virtual_epoch + 2s, virtual_epoch), virtual_epoch);
  EXPECT_FALSE(clock.is_off());
}

TEST(VehicleClock, is_replaced_by_the_time_of_arrival_when_it_is_off) {
  VehicleClock clock;
  EXPECT_EQ(clock.on_stamp(virtual_epoch - 2500ms, virtual_epoch), virtual_epoch);
  EXPECT_TRUE(clock.is_off());
  EXPECT_DOUBLE_EQ(clock.off_s(), 2.5);
  EXPECT_EQ(clock.on_stamp(virtual_epoch + 3s, virtual_epoch), virtual_epoch);
  EXPECT_DOUBLE_EQ(clock.off_s(), -3.0);
}

TEST(VehicleClock, is_correct_again_when_it_was_set) {
  VehicleClock clock;
  EXPECT_EQ(clock.on_stamp(virtual_epoch - 1h, virtual_epoch), virtual_epoch);
  EXPECT_EQ(clock.on_stamp(virtual_epoch - 1s, virtual_epoch), virtual_epoch - 1s);
  EXPECT_FALSE(clock.is_off());
}

TEST(VehicleClock, is_off_by_a_nanosecond_more_than_two_seconds) {
  VehicleClock clock;
  EXPECT_EQ(clock.on_stamp(virtual_epoch - 2s - 1ns, virtual_epoch), virtual_epoch);
  EXPECT_TRUE(clock.is_off());
  EXPECT_EQ(clock.on_stamp(virtual_epoch + 2s + 1ns, virtual_epoch), virtual_epoch);
  EXPECT_TRUE(clock.is_off());
  EXPECT_EQ(clock.on_stamp(virtual_epoch, virtual_epoch), virtual_epoch);
  EXPECT_FALSE(clock.is_off());
  EXPECT_EQ(clock.on_stamp(virtual_epoch - 1ms, virtual_epoch), virtual_epoch - 1ms);
}

}  // namespace
}  // namespace cosiva::virtual_side
