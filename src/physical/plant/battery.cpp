#include "physical/plant/battery.h"

#include <algorithm>
#include <cmath>

#include "base/math.h"

namespace cosiva::physical {

Battery::Battery(BatteryModel model, double charge)
    : model_{model}, charge_{charge}, voltage_v_{open_circuit_v(charge)}, temperature_c_{model.ambient_c} {}

double Battery::open_circuit_v(double charge) const {
  const double s = charge;
  return model_.cells * (-1.031 * det_exp(-35.0 * s) + 3.685 + 0.2156 * s - 0.1178 * s * s + 0.3201 * s * s * s);
}

double Battery::resistance_ohm(double charge) const {
  const double series = 0.1562 * det_exp(-24.37 * charge) + 0.07446;
  const double fast = 0.3208 * det_exp(-29.14 * charge) + 0.04669;
  const double slow = 6.603 * det_exp(-155.2 * charge) + 0.04984;
  return model_.cells * (series + fast + slow) * model_.published_capacity_ah / model_.capacity_ah;
}

double Battery::drive_energy_j(double distance_m, double speed_mps, double acceleration_mps2, double dt_s) const {
  const double friction_j = model_.rolling_force_n * std::fabs(distance_m);
  const double speeding_up_j = model_.mass_kg * acceleration_mps2 * std::fabs(speed_mps) * dt_s;
  return std::max(0.0, friction_j + speeding_up_j) / model_.drive_efficiency;
}

double Battery::manoeuvre_energy_j(double turned_rad, double gone_m) const {
  const double rolled_m = std::fabs(gone_m) + model_.half_track_m * std::fabs(turned_rad);
  return model_.rolling_force_n * rolled_m / model_.drive_efficiency;
}

void Battery::draw(double energy_j, double dt_s) {
  // The load asks for power P: P = I (V₀ − R I), of which the smaller root is the working point.
  const double open_v = open_circuit_v(charge_);
  const double ohm = resistance_ohm(charge_);
  const double power_w = model_.idle_w + energy_j / dt_s;
  const double root_sq = open_v * open_v - 4.0 * ohm * power_w;
  // Below zero the cells cannot give it at all: the voltage breaks down, and the regulator cuts off for good.
  if (root_sq < 0.0) empty_ = true;
  current_a_ = empty_ ? 0.0 : (open_v - std::sqrt(root_sq)) / (2.0 * ohm);
  voltage_v_ = open_v - ohm * current_a_;

  charge_ -= current_a_ * dt_s / (3600.0 * model_.capacity_ah);
  if (charge_ <= 0.0) {
    charge_ = 0.0;
    empty_ = true;
  }
  const double heat_w = ohm * current_a_ * current_a_;
  delivered_j_ += voltage_v_ * current_a_ * dt_s;
  lost_j_ += heat_w * dt_s;
  temperature_c_ +=
      (heat_w - model_.heat_loss_w_per_k * (temperature_c_ - model_.ambient_c)) * dt_s / model_.heat_capacity_j_per_k;
}

void BatteryGauge::count(const Battery& battery, double dt_s) {
  used_ah_ += gain_ * battery.current_a() * dt_s / 3600.0;
}

PowerReadings BatteryGauge::read(const Battery& battery) {
  constexpr double voltage_sd_v = 0.004;  // one step of the usual monitor
  constexpr double current_sd_a = 0.010;
  constexpr double temperature_sd_c = 0.2;
  return {battery.voltage_v() + random_.gaussian(0.0, voltage_sd_v),
          gain_ * battery.current_a() + random_.gaussian(0.0, current_sd_a),
          battery.temperature_c() + random_.gaussian(0.0, temperature_sd_c),
          std::clamp(1.0 - used_ah_ / battery.model().capacity_ah, 0.0, 1.0)};
}

}  // namespace cosiva::physical
