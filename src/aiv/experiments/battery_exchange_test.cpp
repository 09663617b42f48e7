#include "cosiva/aiv/experiments/battery_exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A vehicle whose RALI reads twice a second.
struct Vehicle {
  BatteryExchange exchange;
  SimTime now = virtual_epoch;
  std::optional<double> charge{1.0};  ///< nothing: without RALI
  bool stopped{true};

  static wire::Power power(double charge) {
    wire::Power power;
    power.temperature_01C = 215;
    power.charge_permille = static_cast<std::uint16_t>(1000.0 * charge);
    return power;
  }
  void request(bool by_hand = false) {
    EXPECT_TRUE(exchange.on_request(to_json(wire::BatteryRequest{{"red", 1, ""}, by_hand})));
  }
  void confirm(double percent = 99.0) {
    EXPECT_TRUE(exchange.on_fitted(to_json(wire::BatteryReady{"red-7", "leaf33", 3.0, 3600.0, 25.0, percent})));
  }
  /// The responses within a time, with the time of the first one since its beginning.
  std::vector<std::pair<SimDuration, wire::BatteryReady>> run_for(SimDuration duration) {
    std::vector<std::pair<SimDuration, wire::BatteryReady>> responses;
    const SimTime begin = now;
    for (; now < begin + duration; now += milliseconds{50}) {
      if (charge && (now - begin) % milliseconds{500} == SimDuration::zero()) exchange.on_power(now, power(*charge));
      if (auto ready = exchange.take_ready(now, stopped)) responses.emplace_back(now - begin, std::move(*ready));
    }
    return responses;
  }
};

TEST(BatteryExchange, responds_once_when_rali_has_read_a_full_battery_for_two_seconds) {
  Vehicle vehicle;
  EXPECT_TRUE(vehicle.run_for(seconds{10}).empty()) << "without a request there is no response";
  vehicle.request();
  const auto responses = vehicle.run_for(seconds{10});
  ASSERT_EQ(responses.size(), 1U);
  EXPECT_EQ(responses[0].first, seconds{2});
  EXPECT_EQ(responses[0].second, (wire::BatteryReady{"red", "unknown", 0.0, 0.0, 21.5, 100.0}));
  vehicle.request();
  EXPECT_EQ(vehicle.run_for(seconds{10}).size(), 1U) << "a repeated request gets another response";
}

TEST(BatteryExchange, does_not_respond_with_the_old_battery) {
  Vehicle vehicle;
  vehicle.charge = 0.2;
  vehicle.request();
  EXPECT_TRUE(vehicle.run_for(seconds{60}).empty());
  vehicle.charge = 1.0;
  EXPECT_EQ(vehicle.run_for(seconds{10}).size(), 1U);
}

TEST(BatteryExchange, does_not_respond_while_the_vehicle_drives_or_after_the_request_was_withdrawn) {
  Vehicle vehicle;
  vehicle.stopped = false;
  vehicle.request();
  EXPECT_TRUE(vehicle.run_for(seconds{10}).empty());
  EXPECT_TRUE(vehicle.exchange.on_request(""));
  vehicle.stopped = true;
  EXPECT_TRUE(vehicle.run_for(seconds{10}).empty());
}

TEST(BatteryExchange, waits_for_the_person_who_fits_the_battery_and_adds_what_rali_measures) {
  Vehicle vehicle;
  vehicle.request(true);
  EXPECT_TRUE(vehicle.run_for(seconds{60}).empty()) << "a full battery on board is not yet the requested one";
  vehicle.charge = 0.8;
  vehicle.confirm();
  const auto responses = vehicle.run_for(seconds{2});
  ASSERT_EQ(responses.size(), 1U);
  // The person takes the battery for full; RALI does not, and the test refuses it.
  EXPECT_EQ(responses[0].second, (wire::BatteryReady{"red-7", "leaf33", 3.0, 3600.0, 21.5, 80.0}));
}

TEST(BatteryExchange, takes_the_word_of_a_person_that_a_battery_is_not_full) {
  Vehicle vehicle;
  vehicle.request(true);
  vehicle.run_for(seconds{2});
  vehicle.confirm(80.0);
  const auto responses = vehicle.run_for(seconds{2});
  ASSERT_EQ(responses.size(), 1U);
  EXPECT_EQ(responses[0].second.charge_percent, 80.0);
}

TEST(BatteryExchange, without_rali_repeats_what_the_person_has_stated) {
  Vehicle vehicle;
  vehicle.charge.reset();
  vehicle.request();
  EXPECT_TRUE(vehicle.run_for(seconds{60}).empty());
  vehicle.confirm(98.0);
  const auto responses = vehicle.run_for(seconds{2});
  ASSERT_EQ(responses.size(), 1U);
  EXPECT_EQ(responses[0].second, (wire::BatteryReady{"red-7", "leaf33", 3.0, 3600.0, 25.0, 98.0}));
}

TEST(BatteryExchange, refuses_a_confirmation_that_no_test_has_requested_and_messages_that_cannot_be_read) {
  BatteryExchange exchange;
  const auto refused = exchange.on_fitted(to_json(wire::BatteryReady{"red", "leaf33"}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "battery.not_requested");
  EXPECT_FALSE(exchange.on_request("{"));
  EXPECT_FALSE(exchange.on_fitted("{}"));
}

}  // namespace
}  // namespace cosiva::aiv
