#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/digest.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/gauge/monitor.h"
#include "cosiva/battery/pack.h"

namespace cosiva::battery {

/// The layers of a gauge; each includes those before it.
enum class GaugeMethod : std::uint8_t {
  counter,  ///< counts the charge that flows
  rest,     ///< and corrects it by the open-circuit voltage after a rest
  kalman,   ///< and by the voltage under load, an extended Kalman filter over the type's tables
};
[[nodiscard]] std::optional<GaugeMethod> parse_method(std::string_view word);
[[nodiscard]] std::string_view to_string(GaugeMethod method);

/// The data that a gauge has from its maker: about the type, never about the individual battery.
struct GaugeOptions {
  GaugeMethod method{GaugeMethod::rest};
  PackDesign design;
  MonitorErrors errors;      ///< the gauge's assumptions about its monitor
  double capacity_sd{0.01};  ///< relative deviation of a battery's capacity from the type's
};

/// The gauge's estimate.
struct GaugeReading {
  double charge;           ///< 0 empty to 1 full
  double charge_sd;        ///< one standard deviation of its error
  bool needs_full_charge;  ///< the uncertainty is so large that only a full charge restores the estimate
};

/// RALI's gauge: computes a charge with its standard deviation from a monitor's voltage, current and temperature. The
/// gauge has the type's tables and no access to the battery.
///
/// Invariant: counting charge never reduces the variance of the estimate; only an absolute estimate does.
class Gauge {
 public:
  Gauge(std::shared_ptr<const CellTable> table, GaugeOptions options, double charge = 1.0, double charge_sd = 0.005);

  /// A battery was inserted, or the charger has finished: the charge is full.
  void full();
  /// A battery of unknown charge was inserted.
  void unknown();
  void see(const Measured& measured, double dt_s);

  [[nodiscard]] GaugeReading reading() const;
  [[nodiscard]] double rested_s() const { return rested_s_; }
  [[nodiscard]] std::string state_json() const;
  [[nodiscard]] Result<void> restore(std::string_view state_json);
  void fold(Digest& digest) const;

 private:
  void start_from(double charge, double variance);
  double count(double current_a, double dt_s);
  void rest(const Measured& measured, double dt_s);
  void filter(const Measured& measured, double added_variance, double dt_s);
  [[nodiscard]] double cell_error_v(double cell_v) const;

  std::shared_ptr<const CellTable> table_;
  GaugeOptions options_;
  double charge_;
  double variance_;
  double used_{0.0};       ///< charge counted since the last absolute estimate
  double counted_s_{0.0};  ///< duration of this count
  // State of the rest layer: the estimate at the start of the rest.
  double rested_s_{0.0};
  double rest_v_{0.0};  ///< voltage at rest, smoothed
  double before_rest_{1.0};
  double variance_before_rest_{0.0};
  // State of the filter layer: a cell's voltages over its pairs, and the covariance with the charge: s, u1, u2.
  std::array<double, 2> pair_v_{};
  std::array<std::array<double, 3>, 3> covariance_{};
};

}  // namespace cosiva::battery
