#include "physical/plant/battery.h"

#include <algorithm>
#include <cmath>

#include "base/math.h"

namespace cosiva::physical {

Battery::Battery(BatteryModel model, double charge)
    : model_{model}, charge_{charge}, voltage_V_{open_circuit_V(charge)}, temperature_C_{model.ambient_C} {}

double Battery::open_circuit_V(double charge) const {
  const double s = charge;
  return model_.cells * (-1.031 * det_exp(-35.0 * s) + 3.685 + 0.2156 * s - 0.1178 * s * s + 0.3201 * s * s * s);
}

double Battery::resistance_ohm(double charge) const {
  const double series = 0.1562 * det_exp(-24.37 * charge) + 0.07446;
  const double fast = 0.3208 * det_exp(-29.14 * charge) + 0.04669;
  const double slow = 6.603 * det_exp(-155.2 * charge) + 0.04984;
  return model_.cells * (series + fast + slow) * model_.published_capacity_Ah / model_.capacity_Ah;
}

double Battery::drive_energy_J(double distance_m, double speed_mps, double acceleration_mps2, double dt_s) const {
  const double friction_J = model_.rolling_force_N * std::fabs(distance_m);
  const double speeding_up_J = model_.mass_kg * acceleration_mps2 * std::fabs(speed_mps) * dt_s;
  return std::max(0.0, friction_J + speeding_up_J) / model_.drive_efficiency;
}

void Battery::draw(double energy_J, double dt_s) {
  // The load asks for power P: P = I (V₀ − R I), of which the smaller root is the working point.
  const double open_V = open_circuit_V(charge_);
  const double ohm = resistance_ohm(charge_);
  const double power_W = model_.idle_W + energy_J / dt_s;
  const double root_sq = open_V * open_V - 4.0 * ohm * power_W;
  // Below zero the cells cannot give it at all: the voltage breaks down, and the regulator cuts off for good.
  if (root_sq < 0.0) empty_ = true;
  current_A_ = empty_ ? 0.0 : (open_V - std::sqrt(root_sq)) / (2.0 * ohm);
  voltage_V_ = open_V - ohm * current_A_;

  charge_ -= current_A_ * dt_s / (3600.0 * model_.capacity_Ah);
  if (charge_ <= 0.0) {
    charge_ = 0.0;
    empty_ = true;
  }
  const double heat_W = ohm * current_A_ * current_A_;
  delivered_J_ += voltage_V_ * current_A_ * dt_s;
  lost_J_ += heat_W * dt_s;
  temperature_C_ +=
      (heat_W - model_.heat_loss_W_per_K * (temperature_C_ - model_.ambient_C)) * dt_s / model_.heat_capacity_J_per_K;
}

void BatteryGauge::count(const Battery& battery, double dt_s) {
  used_Ah_ += gain_ * battery.current_A() * dt_s / 3600.0;
}

PowerReadings BatteryGauge::read(const Battery& battery) {
  constexpr double voltage_sd_V = 0.004;  // one step of the usual monitor
  constexpr double current_sd_A = 0.010;
  constexpr double temperature_sd_C = 0.2;
  return {battery.voltage_V() + random_.gaussian(0.0, voltage_sd_V),
          gain_ * battery.current_A() + random_.gaussian(0.0, current_sd_A),
          battery.temperature_C() + random_.gaussian(0.0, temperature_sd_C),
          std::clamp(1.0 - used_Ah_ / battery.model().capacity_Ah, 0.0, 1.0)};
}

}  // namespace cosiva::physical
