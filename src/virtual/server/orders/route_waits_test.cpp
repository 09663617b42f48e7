#include "cosiva/virtual/server/orders/route_waits.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>

#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

class RecordedWaits : public ::testing::Test {
 protected:
  RecordedWaits() { waits.resize(2); }
  void record(std::optional<RouteWaits::Route> route, SimDuration at, VehicleIndex vehicle = 0) {
    waits.record(vehicle, route, SimTime{} + at);
  }
  [[nodiscard]] double number(const std::string& field) const {
    JsonWriter json;
    waits.write(json);
    return JsonValue::parse(json.text())->number(field).value();
  }
  RouteWaits waits;
};

TEST_F(RecordedWaits, begin_when_the_remaining_route_was_shortest) {
  record(RouteWaits::Route{7, 5, 5}, 0s);
  record(RouteWaits::Route{7, 4, 4}, 2s);
  record(RouteWaits::Route{7, 4, 4}, 9s);
  EXPECT_EQ(waits.longest(), 7s);
  record(RouteWaits::Route{7, 3, 3}, 10s);
  EXPECT_EQ(waits.longest(), 7s);
  EXPECT_EQ(number("waits"), 2.0) << "of two and of eight seconds";
}

TEST_F(RecordedWaits, go_on_while_a_vehicle_drives_away_from_its_goal_and_back) {
  record(RouteWaits::Route{7, 5, 5}, 0s);
  record(RouteWaits::Route{7, 6, 5}, 10s);
  record(RouteWaits::Route{7, 5, 5}, 20s);
  EXPECT_EQ(waits.longest(), 20s);
}

TEST_F(RecordedWaits, are_none_while_the_vehicle_drives_nearer) {
  for (SimDuration at{}; at < 1min; at += 20ms) record(RouteWaits::Route{7, 5, 4}, at);
  EXPECT_EQ(waits.longest(), 0s);
  EXPECT_EQ(number("waits"), 0.0);
}

TEST_F(RecordedWaits, end_with_another_goal_and_at_the_goal) {
  record(RouteWaits::Route{7, 5, 5}, 0s);
  record(RouteWaits::Route{8, 5, 5}, 4s);
  record(std::nullopt, 10s);
  record(RouteWaits::Route{8, 5, 5}, 100s);
  record(RouteWaits::Route{8, 5, 5}, 101s);
  EXPECT_EQ(waits.longest(), 1s) << "the first two ended when something else began";
  EXPECT_EQ(number("waits"), 2.0);
}

TEST_F(RecordedWaits, have_a_percentile_that_one_long_wait_among_a_hundred_does_not_change) {
  SimDuration at{};
  const auto wait = [&](SimDuration duration) {
    record(RouteWaits::Route{1, 5, 5}, at);
    record(RouteWaits::Route{1, 5, 5}, at + duration - 20ms);
    record(std::nullopt, at + duration);
    at += duration;
  };
  for (int i = 0; i < 99; ++i) wait(3s);
  wait(500s);
  EXPECT_EQ(waits.p99_s(), 4U) << "3 s, rounded up";
  EXPECT_EQ(waits.longest(), 500s - 20ms);
  wait(400s);
  EXPECT_EQ(waits.p99_s(), 401U) << "two of 101 are more than one in a hundred";
}

TEST_F(RecordedWaits, count_the_arrivals_of_the_vehicle_with_the_fewest) {
  record(RouteWaits::Route{7, 5, 5}, 0s);
  EXPECT_EQ(number("least_arrivals"), 0.0);
  waits.arrive(0);
  waits.arrive(0);
  EXPECT_EQ(number("least_arrivals"), 2.0) << "the other vehicle has had no route";
  record(RouteWaits::Route{7, 5, 5}, 0s, 1);
  EXPECT_EQ(number("least_arrivals"), 0.0);
  EXPECT_EQ(number("arrivals"), 2.0);
}

}  // namespace
}  // namespace cosiva::virtual_side
