#include "cosiva/battery/gauge/monitor.h"

#include <cmath>

namespace cosiva::battery {
namespace {

double stepped(double value, double step) { return step > 0.0 ? step * std::nearbyint(value / step) : value; }

}  // namespace

Monitor::Monitor(const MonitorErrors& errors, Random random)
    : errors_{errors},
      random_{random},
      current_gain_{1.0 + random_.gaussian(0.0, errors.current_gain_sd)},
      current_offset_a_{random_.gaussian(0.0, errors.current_offset_sd_a)},
      voltage_gain_{1.0 + random_.gaussian(0.0, errors.voltage_gain_sd)},
      temperature_offset_c_{random_.gaussian(0.0, errors.temperature_offset_sd_c)} {}

Measured Monitor::measure(double voltage_v, double current_a, double temperature_c) {
  const double volt = voltage_gain_ * voltage_v + random_.gaussian(0.0, errors_.voltage_noise_v);
  const double ampere = current_gain_ * current_a + current_offset_a_ + random_.gaussian(0.0, errors_.current_noise_a);
  const double celsius = temperature_c + temperature_offset_c_ + random_.gaussian(0.0, errors_.temperature_noise_c);
  return {stepped(volt, errors_.voltage_step_v), stepped(ampere, errors_.current_step_a), celsius};
}

}  // namespace cosiva::battery
