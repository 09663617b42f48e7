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

/// How a pack of a type is made.
struct PackDesign {
  std::uint32_t series{1};
  std::uint32_t parallel{1};
  /// Cells of another size of the same make: capacity and heat capacity times this, resistance divided by it.
  double scale{1.0};
};

/// One battery as it came from the factory and what happened to it since: two of one type differ by their seed.
struct PackHistory {
  std::string id;
  std::uint64_t seed{1};  ///< of its cells' spread
  bool spread{true};      ///< else every cell is the type's own
  double cycles{0.0};     ///< full ones, before now
};

enum class PackEvent : std::uint8_t {
  none,
  brown_out,  ///< the load asked for more power than the pack can give at any current
  floor,      ///< a cell came below the type's voltage floor
  empty,      ///< a cell has nothing left
};
[[nodiscard]] std::string_view to_string(PackEvent event);

/// What a load got out of a step.
struct PackStep {
  double voltage_v;  ///< at the terminals, at the step's end
  double current_a;  ///< positive discharges
  PackEvent event;   ///< what is worst of this step
};

/// The truth of one battery: Ns × Np cells, each a voltage source behind a resistance and two RC pairs, each with its
/// own charge and heat (Chen and Rincón-Mora 2006; notes on the numerics in the folder's README). Cells of one group
/// share a voltage, groups share the current, so the weakest cell ends the pack.
class Pack {
 public:
  /// Full, rested, at the temperature given.
  Pack(std::shared_ptr<const CellTable> table, PackDesign design, PackHistory history, double temperature_c = 25.0);

  /// Draws a power for one step, as a regulator does: I = (e − √(e² − 4 R P)) / 2R. Negative charges it.
  /// After a brown-out nothing flows: the step is one of rest, and says so.
  PackStep draw_power(double power_w, double ambient_c, double dt_s);
  PackStep draw_current(double current_a, double ambient_c, double dt_s);

  /// Back to full, rested and at this temperature, after the cycle that it was: fade and growth count from now on.
  void renew(double temperature_c);
  /// All cells at this charge, rested.
  void set_charge(double charge);

  /// Of the weakest group, as a share of what it can hold: 0 empty, 1 full.
  [[nodiscard]] double charge() const;
  /// What it could give from full, slowly: the weakest group's [Ah].
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

  /// All that moves, to go on from: what made the pack is not in it.
  [[nodiscard]] std::string state_json() const;
  /// Fails ("battery.state") when it is not this pack's.
  [[nodiscard]] Result<void> restore(std::string_view state_json);
  void fold(Digest& digest) const;

 private:
  struct Cell {
    double charge;
    double fast_v;  ///< over the two pairs
    double slow_v;
    double temperature_c;
    double new_capacity_ah;    ///< as it left the factory
    double resistance_factor;  ///< likewise, over the table's
    double charge_per_as;      ///< as it is now
    // Of this step, between its two passes:
    double source_v;
    double siemens;  ///< 1/R0 as it is now
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
  std::vector<Cell> cells_;  ///< a group's beside each other
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
