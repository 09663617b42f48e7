#pragma once

#include <array>
#include <vector>

#include "cosiva/battery/type.h"

namespace cosiva::battery {

/// A cell's quantities at one state of charge, of a new cell at the reference temperature.
struct CellRow {
  double open_circuit_v;
  double series_ohm;
  double fast_ohm;
  double slow_ohm;
  double fast_per_s;  ///< 1/τ of the two pairs
  double slow_per_s;
};

/// A type's tables on a thousand even steps of charge, where a row is found without searching. Rows of the file at
/// whole thousandths are reproduced exactly; between two thousandths the tables are linear.
class CellTable {
 public:
  explicit CellTable(const BatteryType& type);

  /// @param charge  below 0 and above 1 the end rows apply
  [[nodiscard]] CellRow at(double charge) const;
  /// Ratio of the resistances to those at the reference temperature: exp(Ea/R (1/T − 1/T0)). Above the reference the
  /// factor is 1: measured cells gain much less there than the law predicts.
  [[nodiscard]] double heat_factor(double temperature_c) const;
  /// The charge at which a rested cell has this voltage, in [0, 1].
  [[nodiscard]] double charge_of(double open_circuit_v) const;
  [[nodiscard]] double volt_per_charge(double charge) const;  ///< dOCV/ds
  [[nodiscard]] const BatteryType& type() const { return type_; }

 private:
  static constexpr int steps = 1000;
  static constexpr int coldest_c = -40;
  static constexpr int temperatures = 126;
  BatteryType type_;
  std::vector<CellRow> rows_;  ///< steps + 2, the last twice
  std::array<double, temperatures + 1> heat_factors_{};
};

}  // namespace cosiva::battery
