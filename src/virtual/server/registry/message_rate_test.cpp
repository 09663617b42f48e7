#include "cosiva/virtual/server/registry/message_rate.h"

#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using Decision = MessageRate::Decision;

constexpr double per_s_max = 500.0;

struct Fed {
  MessageRate rate{};
  SimTime now{virtual_epoch};

  /// The number of accepted messages of those that arrive in `duration`, one every `gap`.
  int feed(SimDuration duration, SimDuration gap, double max = per_s_max) {
    int accepted = 0;
    for (const SimTime end = now + duration; now < end; now += gap)
      if (rate.on_message(now, max) == Decision::accepted) ++accepted;
    return accepted;
  }
};

TEST(MessageRate, accepts_every_message_of_a_vehicle_that_keeps_its_usual_rate) {
  Fed vehicle;
  EXPECT_EQ(vehicle.feed(60s, 33ms), 1819);
  EXPECT_FALSE(vehicle.rate.flooding(vehicle.now));
}

TEST(MessageRate, limits_a_vehicle_of_30_messages_per_second_to_five_times_that) {
  Fed vehicle;
  vehicle.feed(60s, 33ms);
  EXPECT_NEAR(vehicle.rate.limit_per_s(per_s_max), 5.0 / 0.033, 1.0);
  // 100 times the usual rate: the burst of 2 s, and the limit for 60 s, of 181 818 messages.
  const int accepted = vehicle.feed(60s, 330us);
  EXPECT_NEAR(accepted, (2.0 + 60.0) * 5.0 / 0.033, 60.0);
  EXPECT_TRUE(vehicle.rate.flooding(vehicle.now));
}

TEST(MessageRate, is_not_raised_by_a_flood) {
  Fed vehicle;
  vehicle.feed(60s, 33ms);
  vehicle.feed(600s, 3ms);
  // The burst before the first dropped message may be in a window of its own.
  EXPECT_LT(vehicle.rate.limit_per_s(per_s_max), 1.1 * 5.0 / 0.033);
}

TEST(MessageRate, of_a_vehicle_that_floods_from_its_first_message_on_is_the_largest_permitted) {
  Fed vehicle;
  EXPECT_NEAR(vehicle.feed(60s, 330us), (2.0 + 60.0) * per_s_max, 500.0);
}

TEST(MessageRate, accepts_at_least_100_messages_per_second_of_a_slow_vehicle) {
  Fed vehicle;
  vehicle.feed(60s, 1s);
  EXPECT_EQ(vehicle.rate.limit_per_s(per_s_max), 100.0);
  EXPECT_EQ(vehicle.feed(10s, 11ms), 910);
}

TEST(MessageRate, follows_the_rate_that_the_factsheet_announces) {
  Fed vehicle;
  vehicle.rate.on_announced(60.0);
  vehicle.feed(60s, 1s);
  EXPECT_EQ(vehicle.rate.limit_per_s(per_s_max), 300.0);
  vehicle.rate.on_announced(1e9);
  EXPECT_EQ(vehicle.rate.limit_per_s(per_s_max), per_s_max) << "the options limit what can be announced";
}

TEST(MessageRate, accepts_messages_together_that_were_held_up_for_seconds) {
  Fed vehicle;
  vehicle.feed(60s, 33ms);
  vehicle.now += 10s;
  int accepted = 0;
  for (int i = 0; i < 303; ++i)
    if (vehicle.rate.on_message(vehicle.now, per_s_max) == Decision::accepted) ++accepted;
  EXPECT_EQ(accepted, 303) << "10 s of messages at 33 ms";
}

TEST(MessageRate, reports_the_beginning_of_a_flood_once_until_ten_calm_seconds_have_passed) {
  Fed vehicle;
  int begun = 0;
  const auto flood = [&] {
    for (int i = 0; i < 5'000; ++i)
      if (vehicle.rate.on_message(vehicle.now, per_s_max) == Decision::flood_begins) ++begun;
  };
  flood();
  vehicle.now += 5s;
  flood();
  EXPECT_EQ(begun, 1);
  vehicle.now += 11s;
  EXPECT_FALSE(vehicle.rate.flooding(vehicle.now));
  flood();
  EXPECT_EQ(begun, 2);
}

TEST(MessageRate, without_a_limit_accepts_everything) {
  Fed vehicle;
  EXPECT_EQ(vehicle.feed(1s, 100us, 0.0), 10'000);
}

TEST(MessageRate, refuses_a_time_before_the_last_message) {
  MessageRate rate;
  rate.on_message(virtual_epoch + 1s, per_s_max);
  EXPECT_DEATH(rate.on_message(virtual_epoch, per_s_max), "refilled_at_");
}

}  // namespace
}  // namespace cosiva::virtual_side
