#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/random.h"
#include "cosiva/base/result.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/gauge/gauge.h"
#include "cosiva/battery/gauge/monitor.h"
#include "cosiva/battery/pack.h"
#include "cosiva/physical/boards/boards.h"

namespace cosiva::physical {

/// The consumption of a vehicle's drive and electronics.
struct CartModel {
  double idle_w{3.0};  ///< Raspberry Pi and boards
  double mass_kg{1.2};
  double rolling_force_n{0.6};
  double half_track_m{0.05};
  double drive_efficiency{0.6};  ///< battery to wheel; no regeneration when braking
  double ambient_c{22.0};

  /// Energy that the drive takes for one step of motion, idle load excluded [J].
  [[nodiscard]] double drive_energy_j(double distance_m, double speed_mps, double acceleration_mps2, double dt_s) const;
  /// For one step of a manoeuvre: in a turn on the spot the two wheels travel half the track's circle, each under half
  /// the weight.
  [[nodiscard]] double manoeuvre_energy_j(double turned_rad, double traversed_m) const;
};

/// The battery in a vehicle, as the plant's command `changeBattery` defines it.
struct BatteryChange {
  battery::BatteryType type;
  battery::PackDesign design;
  battery::PackHistory history;
  double temperature_c{22.0};
  double charge{1.0};
  battery::GaugeMethod gauge{battery::GaugeMethod::rest};
};
/// {"vehicle":1,"id":"B7","seed"?,"spread"?,"cycles"?,"temperature"?,"charge"?,"scale"?,"gauge"?,"type"?: one of the
/// shipped types' names, or a whole type as an object}. Fails ("plant.battery").
[[nodiscard]] Result<BatteryChange> battery_change_from_json(const JsonValue& json);

/// A vehicle's battery, RALI's monitor on it, and its gauge. The gauge is given the monitor's readings and nothing
/// else. Invariant: the load is not negative: no energy is recovered.
class PowerTrain {
 public:
  /// With the usual battery: two lithium-polymer cells of 2.2 Ah in series, full.
  /// @param random  the monitor's
  PowerTrain(const std::shared_ptr<const battery::CellTable>& table, Random random);

  /// The usual battery's table.
  [[nodiscard]] static std::shared_ptr<const battery::CellTable> usual_table();

  /// Draws `energy_j` evenly over `dt_s`, besides the idle load; then updates the gauge.
  void draw(double energy_j, double dt_s);
  /// Another battery, full unless stated otherwise; the gauge is informed of the change.
  void change(const BatteryChange& change);
  /// This vehicle's consumption relative to the others, driving and stopped.
  void set_load_factor(double factor) { load_factor_ = factor; }

  /// The pack's protection has cut the load off: a brown-out, or a cell at its minimum voltage or empty. Lasts until
  /// the battery is changed.
  [[nodiscard]] bool cut_off() const { return cut_off_; }
  [[nodiscard]] const battery::Pack& pack() const { return pack_; }
  [[nodiscard]] const CartModel& cart() const { return cart_; }
  [[nodiscard]] double load_w() const { return load_w_; }  ///< that was drawn last
  [[nodiscard]] battery::GaugeReading gauge() const { return gauge_.reading(); }
  /// What RALI sends.
  [[nodiscard]] PowerReadings readings() const;
  void archive(Archive& archive);  ///< battery and gauge, for a restart of the emulation

 private:
  CartModel cart_;
  battery::Pack pack_;
  battery::Monitor monitor_;
  battery::Gauge gauge_;
  battery::Measured measured_;
  std::optional<BatteryChange> changed_;  ///< the last change; nothing: the usual battery
  double load_factor_{1.0};
  double load_w_{0.0};
  bool cut_off_{false};
};

}  // namespace cosiva::physical
