#pragma once

#include "base/random.h"
#include "physical/boards/boards.h"

namespace cosiva::physical {

/// Two lithium-polymer cells in series, and the cart they drive. The cell is M. Chen and G. Rincón-Mora's (IEEE Trans.
/// Energy Conversion 21(2), 2006), scaled from 850 mAh to ours; its three resistances count as one, so it recovers at
/// once where a real cell takes minutes.
struct BatteryModel {
  double capacity_ah{2.2};
  double cells{2.0};
  double published_capacity_ah{0.85};
  double ambient_c{22.0};
  double heat_capacity_j_per_k{80.0};
  double heat_loss_w_per_k{0.12};
  double idle_w{3.0};  ///< Raspberry Pi and boards
  double mass_kg{1.2};
  double rolling_force_n{0.6};
  double half_track_m{0.05};
  double drive_efficiency{0.6};  ///< battery to wheel; braking gives nothing back
};

/// State of charge, heat and voltage under a load given in watts, as a regulator draws it.
class Battery {
 public:
  explicit Battery(BatteryModel model = {}, double charge = 1.0);

  /// Energy that the drive takes for one step of motion, idle load excluded [J].
  [[nodiscard]] double drive_energy_j(double distance_m, double speed_mps, double acceleration_mps2, double dt_s) const;
  /// For one step of a manoeuvre: on the spot the two wheels roll half the track's circle, each under half the weight.
  [[nodiscard]] double manoeuvre_energy_j(double turned_rad, double gone_m) const;
  /// Draws `energy_j` evenly over `dt_s`, besides the idle load.
  void draw(double energy_j, double dt_s);

  [[nodiscard]] double charge() const { return charge_; }
  /// Nothing left, or asked for more than it can give (near 1 % of charge): the load is cut off.
  [[nodiscard]] bool empty() const { return empty_; }
  [[nodiscard]] double voltage_v() const { return voltage_v_; }
  [[nodiscard]] double current_a() const { return current_a_; }
  [[nodiscard]] double temperature_c() const { return temperature_c_; }
  [[nodiscard]] double delivered_j() const { return delivered_j_; }  ///< to the load, since the start
  [[nodiscard]] double lost_j() const { return lost_j_; }            ///< as heat in the cells

  [[nodiscard]] double open_circuit_v(double charge) const;
  [[nodiscard]] double resistance_ohm(double charge) const;
  [[nodiscard]] const BatteryModel& model() const { return model_; }

 private:
  BatteryModel model_;
  double charge_;
  bool empty_{false};
  double voltage_v_;
  double current_a_{0.0};
  double temperature_c_;
  double delivered_j_{0.0};
  double lost_j_{0.0};
};

/// RALI's gauge: a monitor with gain error and noise, and a coulomb counter that started full. It never sees the truth.
class BatteryGauge {
 public:
  explicit BatteryGauge(Random random) : random_{random} { gain_ = 1.0 + random_.gaussian(0.0, 0.01); }

  void count(const Battery& battery, double dt_s);
  [[nodiscard]] PowerReadings read(const Battery& battery);

 private:
  Random random_;
  double gain_;
  double used_ah_{0.0};
};

}  // namespace cosiva::physical
