#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::battery {

/// What one kind of battery is: the constants and tables of its cell, and how many cells make a pack. Tables run over
/// the state of charge, 0 empty to 1 full; between two of their rows all is straight.
struct BatteryType {
  std::string name;
  std::string description;
  std::string source;   ///< who measured or published it
  std::string licence;  ///< of what stands in it
  std::string chemistry;

  double capacity_ah{};                  ///< of a new cell
  double coulombic_efficiency{1.0};      ///< charge kept of charge put in, 0…1
  double voltage_floor_v{};              ///< of a cell: below it the load is cut off
  double voltage_full_v{};               ///< of a cell: where a charger stops
  double heat_capacity_j_per_k{};        ///< of a cell
  double heat_loss_w_per_k{};            ///< of a cell, to what is around it
  double activation_j_per_mol{};         ///< of the resistances' heat law
  double reference_temperature_c{25.0};  ///< at which the resistances were measured
  double temperature_min_c{};            ///< may be discharged from here …
  double temperature_max_c{};            ///< … to here
  double capacity_fade_per_cycle{};      ///< share of the new capacity that a full cycle takes
  double resistance_growth_per_cycle{};  ///< share of the new resistance that a full cycle adds
  double capacity_spread{};              ///< relative standard deviation from cell to cell
  double resistance_spread{};
  double series_cells{1.0};
  double parallel_cells{1.0};

  std::vector<double> charge;  ///< rows of the tables, growing strictly from 0 to 1
  std::vector<double> open_circuit_v;
  std::vector<double> series_ohm;  ///< R0
  std::vector<double> fast_ohm;    ///< R1, in parallel with a capacitor
  std::vector<double> slow_ohm;    ///< R2, likewise
  std::vector<double> fast_s;      ///< time constants of the two pairs
  std::vector<double> slow_s;

  friend bool operator==(const BatteryType&, const BatteryType&) = default;
};

/// What every type's file says in "format".
inline constexpr std::string_view type_format = "cosiva-battery-type/1";

/// The types that come with the platform, by name: "lipo850" and "leaf33".
[[nodiscard]] std::vector<std::string> shipped_types();
/// One of them; fails ("battery.missing") naming those there are.
[[nodiscard]] Result<BatteryType> shipped_type(std::string_view name);

}  // namespace cosiva::battery
