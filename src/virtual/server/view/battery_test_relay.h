#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/battery_exchange.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// How a vehicle's battery fared, in as many points as a picture has room for: when they are full every other one goes,
/// and from then on they come half as often. Hence it always reaches back to its beginning, however long that is.
class BatteryCurve {
 public:
  static constexpr std::size_t points_max = 240;
  struct Point {
    SimTime at{};
    float charge_percent{};  ///< as the gauge believes
    float voltage_v{};
    float temperature_c{};
  };
  void add(const Point& point);
  /// What was before belongs to another test.
  void forget_before(SimTime at);
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }

 private:
  std::vector<Point> points_;
  SimDuration every_{std::chrono::seconds{1}};
};

/// What is heard of battery tests (A37, A38). The tests run elsewhere: here it is only known which batteries they want
/// changed and how they stand, so that a person can be shown it, and can answer.
class BatteryTestRelay {
 public:
  static constexpr std::size_t changes_max = 256;  ///< a flood of made-up names must not take the memory

  [[nodiscard]] static std::vector<std::string> subscriptions();
  [[nodiscard]] static bool handles(std::string_view topic) { return topic.starts_with("cosiva/v1/battery/"); }
  /// Fails ("own.…", "json.…", "battery.many") and then keeps what it knew.
  /// @return  in a few words, what is worth showing among the communications; empty: nothing
  [[nodiscard]] Result<std::string> on_message(const wire::Input& input);
  /// The broker says anew all that it keeps.
  void link_up();
  void on_power(SimTime at, const std::string& vehicle, const wire::Power& power);

  /// batteryReady, for the test that asked: {"vehicle","battery","type"?,"cycles"?,"rest_s"?,"temperature"?,"charge"?}.
  /// Fails ("battery.not_requested", "battery.<field>").
  [[nodiscard]] Result<wire::Publish> ready(const JsonValue& command) const;

  /// The snapshot's "battery": null where nothing was heard.
  void write(JsonWriter& json) const;
  /// Nothing where the vehicle never told of its battery.
  [[nodiscard]] std::optional<std::string> curve_json(const std::string& vehicle) const;

 private:
  struct Change {
    wire::VehicleId vehicle;
    wire::BatteryChange wanted;
    SimTime since{};
  };
  void write_test(JsonWriter& json) const;

  std::map<std::string, Change> changes_;  ///< by vehicle
  std::optional<wire::BatteryTest> test_;
  std::map<std::string, BatteryCurve> curves_;
};

}  // namespace cosiva::virtual_side
