#include "cosiva/battery/cell_table.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::battery {
namespace {

constexpr double gas_constant_j_per_mol_k = 8.314462618;
constexpr double zero_celsius_k = 273.15;

CellRow between(const CellRow& a, const CellRow& b, double t) {
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  return {mix(a.open_circuit_v, b.open_circuit_v),
          mix(a.series_ohm, b.series_ohm),
          mix(a.fast_ohm, b.fast_ohm),
          mix(a.slow_ohm, b.slow_ohm),
          mix(a.fast_per_s, b.fast_per_s),
          mix(a.slow_per_s, b.slow_per_s)};
}

/// One column of the type's tables, linear between rows.
double column(const std::vector<double>& charge, const std::vector<double>& values, double at) {
  const auto above = std::ranges::upper_bound(charge, at);
  if (above == charge.end()) return values.back();
  const auto i = static_cast<std::size_t>(above - charge.begin());
  const double t = (at - charge[i - 1]) / (charge[i] - charge[i - 1]);
  return values[i - 1] + t * (values[i] - values[i - 1]);
}

}  // namespace

CellTable::CellTable(const BatteryType& type) : type_{type} {
  COSIVA_EXPECT(type.charge.size() >= 2);
  rows_.reserve(steps + 2);
  for (int i = 0; i <= steps; ++i) {
    const double s = i / static_cast<double>(steps);
    const auto of = [&](const std::vector<double>& values) { return column(type.charge, values, s); };
    rows_.push_back({of(type.open_circuit_v), of(type.series_ohm), of(type.fast_ohm), of(type.slow_ohm),
                     1.0 / of(type.fast_s), 1.0 / of(type.slow_s)});
  }
  rows_.push_back(rows_.back());
  const double reference_k = type.reference_temperature_c + zero_celsius_k;
  for (int i = 0; i <= temperatures; ++i) {
    const double kelvin = std::min(coldest_c + i + zero_celsius_k, reference_k);
    heat_factors_[static_cast<std::size_t>(i)] =
        det_exp(type.activation_j_per_mol / gas_constant_j_per_mol_k * (1.0 / kelvin - 1.0 / reference_k));
  }
}

CellRow CellTable::at(double charge) const {
  const double x = std::clamp(charge, 0.0, 1.0) * steps;
  const auto i = static_cast<std::size_t>(x);
  return between(rows_[i], rows_[i + 1], x - static_cast<double>(i));
}

double CellTable::heat_factor(double temperature_c) const {
  const double x = std::clamp(temperature_c - coldest_c, 0.0, temperatures - 1e-9);
  const auto i = static_cast<std::size_t>(x);
  return heat_factors_[i] + (x - static_cast<double>(i)) * (heat_factors_[i + 1] - heat_factors_[i]);
}

double CellTable::charge_of(double open_circuit_v) const {
  const auto is_below = [](const CellRow& row, double volt) { return row.open_circuit_v < volt; };
  const auto last = rows_.end() - 1;  // the duplicated row
  const auto above = std::lower_bound(rows_.begin(), last, open_circuit_v, is_below);
  if (above == rows_.begin()) return 0.0;
  if (above == last) return 1.0;
  const double low = (above - 1)->open_circuit_v;
  const double t = (open_circuit_v - low) / (above->open_circuit_v - low);
  return (static_cast<double>(above - 1 - rows_.begin()) + t) / steps;
}

double CellTable::volt_per_charge(double charge) const {
  const double x = std::clamp(charge, 0.0, 1.0) * steps;
  const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(steps - 1));
  return (rows_[i + 1].open_circuit_v - rows_[i].open_circuit_v) * steps;
}

}  // namespace cosiva::battery
