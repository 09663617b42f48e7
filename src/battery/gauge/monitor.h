#pragma once

#include <cstdint>

#include "cosiva/base/random.h"

namespace cosiva::battery {

/// The values of a battery monitor, all with errors.
struct Measured {
  double voltage_v;
  double current_a;  ///< positive discharges
  double temperature_c;
};

/// The errors of a usual monitor (a shunt and an INA219 on I²C).
struct MonitorErrors {
  double current_gain_sd{0.01};       ///< of each monitor, drawn once
  double current_offset_sd_a{0.005};  ///< likewise
  double current_noise_a{0.01};
  double current_step_a{0.001};
  double voltage_gain_sd{0.001};
  double voltage_noise_v{0.003};
  double voltage_step_v{0.004};
  double temperature_offset_sd_c{0.5};
  double temperature_noise_c{0.2};
};

/// One monitor on one battery's wires: converts true values to measured ones.
class Monitor {
 public:
  Monitor(const MonitorErrors& errors, Random random);
  /// Other noise from now on, with the same constant errors: a run can be resumed from any of its parts.
  void renew_noise(Random random) { random_ = random; }
  [[nodiscard]] Measured measure(double voltage_v, double current_a, double temperature_c);

 private:
  MonitorErrors errors_;
  Random random_;
  double current_gain_;
  double current_offset_a_;
  double voltage_gain_;
  double temperature_offset_c_;
};

}  // namespace cosiva::battery
