#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/wire/own/battery_exchange.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// The history of a vehicle's battery in a bounded number of points. When all points are used, every second point is
/// removed and the sampling interval doubles, so the curve always reaches back to its beginning.
///
/// Invariant: at most points_max points, in the order of time, and at least the sampling interval apart.
class BatteryCurve {
 public:
  static constexpr std::size_t points_max = 240;
  struct Point {
    SimTime at{};
    float charge_percent{};  ///< as estimated by the gauge
    float voltage_v{};
    float temperature_c{};
  };
  void add(const Point& point);
  /// Removes the points of an earlier test.
  void forget_before(SimTime at);
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<Point> points_;
  SimDuration every_{std::chrono::seconds{1}};
};

/// The battery tests (A37, A38) as received in messages. The tests run elsewhere; the relay stores which battery
/// changes the tests request and the state of each test, so that an operator can view and confirm a change.
///
/// Invariant: at most changes_max changes are stored, one for each vehicle.
class BatteryTestRelay {
 public:
  static constexpr std::size_t changes_max = 256;  ///< bounds the memory if many invented names are received

  [[nodiscard]] static std::vector<std::string> subscriptions();
  [[nodiscard]] static bool handles(std::string_view topic) { return topic.starts_with("cosiva/v1/battery/"); }
  /// Fails ("own.…", "json.…", "battery.many") and then keeps its state. @return  a short summary for the traces of
  /// communications; empty: nothing to show
  [[nodiscard]] Result<std::string> on_message(const wire::Input& input);
  /// The broker sends all retained messages again.
  void link_up();
  void on_power(SimTime at, const std::string& vehicle, const wire::Power& power);

  /// batteryReady, for the test that requested the battery. Fails ("battery.not_requested",
  /// "battery.<field>").
  [[nodiscard]] Result<wire::Publish> ready(const BatteryReadyCommand& command) const;

  /// The snapshot's "battery": null if no message about a test was received.
  void write(JsonWriter& json) const;
  /// Nothing if the vehicle never reported its battery.
  [[nodiscard]] std::optional<std::string> curve_json(const std::string& vehicle) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

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
