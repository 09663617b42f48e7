#include "cosiva/virtual/server/orders/wait_records.h"

#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

/// One vehicle, which may wait for vehicle 7 or for crossing 3.
class OneVehicle : public testing::Test {
 protected:
  OneVehicle() { records.resize(1); }
  static constexpr SimTime start{100s};
  WaitRecords records;
};

TEST_F(OneVehicle, waits_from_the_tick_in_which_it_gets_no_base) {
  records.wait_for(0, 7, WaitReason::off_path);
  records.record(0, true, start);
  EXPECT_EQ(records[0].blocker, 7U);
  EXPECT_EQ(records[0].why, WaitReason::off_path);
  EXPECT_EQ(records[0].since, start);
  EXPECT_EQ(records.longest(), 0s);
  records.begin(0);
  EXPECT_EQ(records[0].blocker, no_vehicle);
  EXPECT_EQ(records[0].since, start) << "the tick has not ended yet";
  records.wait_for(0, 7, WaitReason::off_path);
  records.record(0, true, start + 3s);
  EXPECT_EQ(records[0].since, start);
  EXPECT_EQ(records.longest(), 3s);
}

TEST_F(OneVehicle, does_not_wait_while_it_still_gets_a_base) {
  records.wait_for(0, 7, WaitReason::off_path);
  records.record(0, false, start);
  EXPECT_EQ(records[0].blocker, 7U) << "it is informed early";
  EXPECT_FALSE(records[0].since);
}

TEST_F(OneVehicle, waits_for_a_crossing_or_for_a_vehicle_and_otherwise_not) {
  records.wait_for(0, Traffic::Response{false, 3, no_vehicle, WaitReason::crossing});
  records.record(0, true, start);
  EXPECT_EQ(records[0].crossing, 3U);
  EXPECT_EQ(records[0].since, start);
  records.begin(0);
  EXPECT_FALSE(records[0].crossing);
  records.record(0, true, start + 1s);
  EXPECT_FALSE(records[0].since) << "nothing blocks it";
}

TEST_F(OneVehicle, begins_a_new_wait_after_a_tick_without_one) {
  records.wait_for(0, Traffic::Response{false, 3, 7, WaitReason::turn});
  EXPECT_EQ(records[0].blocker, 7U);
  EXPECT_EQ(records[0].why, WaitReason::turn);
  records.record(0, true, start);
  records.record(0, true, start + 5s);
  records.record(0, false, start + 6s);
  EXPECT_FALSE(records[0].since);
  records.record(0, true, start + 8s);
  EXPECT_EQ(records[0].since, start + 8s);
  records.record(0, true, start + 9s);
  EXPECT_EQ(records.longest(), 5s) << "the longest wait never becomes shorter";
  records.end(0);
  EXPECT_FALSE(records[0].since);
  records.forget(0);
  EXPECT_EQ(records[0].blocker, no_vehicle);
}

}  // namespace
}  // namespace cosiva::virtual_side
