#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::battery {

/// One type of battery: the constants and tables of its cell, and the number of cells of a pack. Tables are functions
/// of the state of charge, 0 empty to 1 full, linear between their rows.
struct BatteryType {
  std::string name;
  std::string description;
  std::string source;   ///< author of the measurement or publication
  std::string licence;  ///< of the file's content
  std::string chemistry;

  double capacity_ah{};                  ///< of a new cell
  double coulombic_efficiency{1.0};      ///< ratio of stored charge to supplied charge, 0…1
  double voltage_floor_v{};              ///< of a cell: below it the load is disconnected
  double voltage_full_v{};               ///< of a cell: where a charger stops
  double heat_capacity_j_per_k{};        ///< of a cell
  double heat_loss_w_per_k{};            ///< of a cell, to its surroundings
  double activation_j_per_mol{};         ///< of the resistances' temperature law
  double reference_temperature_c{25.0};  ///< at which the resistances were measured
  double temperature_min_c{};            ///< lowest temperature for discharges
  double temperature_max_c{};            ///< highest temperature for discharges
  double capacity_fade_per_cycle{};      ///< ratio of the new capacity that a full cycle consumes
  double resistance_growth_per_cycle{};  ///< ratio of the new resistance that a full cycle adds
  double capacity_spread{};              ///< relative standard deviation from cell to cell
  double resistance_spread{};
  double series_cells{1.0};
  double parallel_cells{1.0};

  std::vector<double> charge;  ///< rows of the tables, strictly increasing from 0 to 1
  std::vector<double> open_circuit_v;
  std::vector<double> series_ohm;  ///< R0
  std::vector<double> fast_ohm;    ///< R1, in parallel with a capacitor
  std::vector<double> slow_ohm;    ///< R2, likewise
  std::vector<double> fast_s;      ///< time constants of the two pairs
  std::vector<double> slow_s;

  friend bool operator==(const BatteryType&, const BatteryType&) = default;
};

/// The value of "format" in every type's file.
inline constexpr std::string_view type_format = "cosiva-battery-type/1";

/// The platform's own types, by name: "lipo850" and "leaf33".
[[nodiscard]] std::vector<std::string> shipped_types();
/// One of these types; fails ("battery.missing") naming the available ones.
[[nodiscard]] Result<BatteryType> shipped_type(std::string_view name);

}  // namespace cosiva::battery
