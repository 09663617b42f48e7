#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

/// Construction of a pack of a type.
struct PackDesign {
  std::uint32_t series{1};
  std::uint32_t parallel{1};
  /// Cells of another size of the same series: capacity and heat capacity times this, resistance divided by it.
  double scale{1.0};
};

/// One individual battery and its history: two batteries of one type differ by their seed.
struct PackHistory {
  std::string id;
  std::uint64_t seed{1};  ///< of its cells' spread
  bool spread{true};      ///< else every cell is the type's own
  double cycles{0.0};     ///< full cycles before now
};

enum class PackEvent : std::uint8_t {
  none,
  brown_out,  ///< the load requested more power than the pack can deliver at any current
  floor,      ///< a cell fell below the type's voltage floor
  empty,      ///< a cell is empty
};
[[nodiscard]] std::string_view to_string(PackEvent event);

/// The result of a step for the load.
struct PackStep {
  double voltage_v;  ///< at the terminals, at the step's end
  double current_a;  ///< positive discharges
  PackEvent event;   ///< the most severe event of this step
};

/// The ground truth of one battery: Ns × Np cells, each a voltage source behind a resistance and two RC pairs, each
/// with its own charge and heat (Chen and Rincón-Mora 2006; notes on the numerics in the folder's README). Cells of one
/// group have a common voltage, groups a common current, so the weakest cell ends the discharge.
///
/// Invariant: the pack has as many cells as its design, and each cell's charge is from 0 to 1.
class Pack {
 public:
  /// Full, rested, at the given temperature.
  Pack(std::shared_ptr<const CellTable> table, PackDesign design, PackHistory history, double temperature_c = 25.0);

  /// Draws a power for one step, like a regulator: I = (e − √(e² − 4 R P)) / 2R. Negative charges the pack. At a
  /// brown-out no current flows: the step is one of rest, with the event.
  PackStep draw_power(double power_w, double ambient_c, double dt_s);
  PackStep draw_current(double current_a, double ambient_c, double dt_s);

  /// Sets the pack to full, rested and at this temperature, after a cycle: fade and growth take effect from now on.
  void renew(double temperature_c);
  /// Sets all cells to this charge, rested.
  void set_charge(double charge);

  /// Of the weakest group, as a ratio of its capacity: 0 empty, 1 full.
  [[nodiscard]] double charge() const;
  /// Capacity from full in a slow discharge: the weakest group's [Ah].
  [[nodiscard]] double capacity_ah() const;
  [[nodiscard]] double temperature_c() const;  ///< of the hottest cell
  [[nodiscard]] double voltage_v() const { return voltage_v_; }
  [[nodiscard]] double current_a() const { return current_a_; }
  [[nodiscard]] double open_circuit_v() const;
  [[nodiscard]] double cycles() const { return history_.cycles; }
  [[nodiscard]] double delivered_j() const { return delivered_j_; }
  [[nodiscard]] double lost_j() const { return lost_j_; }
  [[nodiscard]] double delivered_ah() const { return delivered_ah_; }
  [[nodiscard]] const PackHistory& history() const { return history_; }
  [[nodiscard]] const PackDesign& design() const { return design_; }
  [[nodiscard]] const CellTable& table() const { return *table_; }
  [[nodiscard]] const BatteryType& type() const { return table_->type(); }

  /// The dynamic state, from which a run can continue: the construction of the pack is not included.
  [[nodiscard]] std::string state_json() const;
  /// Fails ("battery.state") if the state belongs to another pack.
  [[nodiscard]] Result<void> restore(std::string_view state_json);
  void fold(Digest& digest) const;

 private:
  struct Cell {
    double charge;
    double fast_v;  ///< over the two pairs
    double slow_v;
    double temperature_c;
    double new_capacity_ah;    ///< as manufactured
    double resistance_factor;  ///< likewise, relative to the table's
    double charge_per_as;      ///< present value
    // Of this step, between its two passes:
    double source_v;
    double siemens;  ///< 1/R0 at present
    double heat_factor;
    CellRow row;
  };

  void update();
  PackStep flow(double current_a, double ambient_c, double dt_s, PackEvent event);
  void age();
  PackEvent advance(Cell& cell, double current_a, double voltage_v, double ambient_c, double dt_s);

  std::shared_ptr<const CellTable> table_;
  PackDesign design_;
  PackHistory history_;
  std::vector<Cell> cells_;  ///< the cells of a group are adjacent
  double fade_{1.0};
  double growth_{1.0};
  double kelvin_per_j_{0.0};  ///< of a cell
  double source_v_{0.0};      ///< of the pack, of this step
  double ohm_{0.0};
  double voltage_v_;
  double current_a_{0.0};
  double delivered_j_{0.0};
  double lost_j_{0.0};
  double delivered_ah_{0.0};
  double discharged_since_full_ah_{0.0};
};

}  // namespace cosiva::battery
