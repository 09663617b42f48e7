#include "cosiva/physical/plant/trip_counter.h"

#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::physical {
namespace {

using namespace std::chrono_literals;

TEST(TripCounter, counts_the_distance_in_both_directions_and_complete_laps) {
  TripCounter trip{2.0};
  trip.add(3.0);
  trip.add(-1.5);
  EXPECT_EQ(trip.distance_m(), 4.5);
  EXPECT_EQ(trip.laps(), 2U);
}

TEST(TripCounter, counts_the_laps_of_each_floor_for_itself) {
  TripCounter trip{2.0};
  trip.add(3.0);
  trip.begin_floor(0.0);
  trip.add(10.0);
  EXPECT_EQ(trip.laps(), 1U) << "this floor forms no loop";
  trip.begin_floor(5.0);
  trip.add(5.5);
  EXPECT_EQ(trip.laps(), 2U);
  EXPECT_EQ(trip.distance_m(), 18.5);
}

TEST(TripCounter, measures_the_longest_wait_from_the_first_motion_on) {
  TripCounter trip{0.0};
  trip.on_waiting(9s);
  EXPECT_EQ(trip.longest_wait_s(), 0.0);
  trip.on_moving();
  trip.on_waiting(2s);
  trip.on_waiting(1s);
  trip.on_moving();
  trip.on_waiting(1s);
  EXPECT_EQ(trip.longest_wait_s(), 3.0);
}

}  // namespace
}  // namespace cosiva::physical
