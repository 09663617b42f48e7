#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/battery/fit/log.h"

namespace cosiva::battery {

/// From one full charge on: where in a log a fit and a prediction begin, and what has been taken out since.
struct Discharge {
  const Log* log{};
  std::size_t first{};          ///< of its samples: the first one of the discharge
  std::size_t last{};           ///< past its last
  std::vector<double> used_ah;  ///< at each sample from `first` on
  /// How far what was taken out may be off, as a share of it: where the current changed between two samples, nobody
  /// knows when. 0 where the tester counted by itself.
  double uncertain{0.0};
  bool is_counted{false};  ///< `used_ah` is the tester's own count
  double scale{1.0};       ///< what the samples' count was multiplied by, as the capacity is known
};
/// The discharges of a log that begin full: at the log's begin where it says so, and after every charge up to the
/// highest voltage; each until it is charged again by more than a twentieth of what was taken out.
/// @param full_v  from 1 % below this on a battery is full; at a log's begin from 4 % below, which a load may take
/// @param full_ohm  what a load at the log's begin takes off besides, where it is known
[[nodiscard]] std::vector<Discharge> discharges_from_full(const Log& log, double full_v, double full_ohm = 0.0);

/// Whoever knows the capacity knows better than a log whose samples lie too far apart. Where a discharge goes to the
/// floor and its count is off by no more than its samples leave open, the count is scaled to the capacity.
void scale_to_capacity(std::vector<Discharge>& discharges, double capacity_ah, double floor_v);

/// Each of a log's discharges that begin full as a log of its own, "rates.csv, discharge 2", so that some may be fitted
/// and others foretold; the log itself where there are fewer than two.
[[nodiscard]] std::vector<Log> split_at_charges(const Log& log, double full_v);

/// The highest voltage of all, but for those under brief charges: a pulse test's regeneration goes above a full
/// battery's. 0 of nothing.
[[nodiscard]] double highest_voltage_v(const std::vector<Log>& logs);
/// Between the least and the most charged that a log has its battery [Ah].
[[nodiscard]] double charge_moved_ah(const Log& log);
/// The lowest one under a discharging current; infinite where there is none.
[[nodiscard]] double lowest_under_load_v(const Discharge& discharge);

/// When its load came on: a usual sample's time before the first one under load.
[[nodiscard]] double load_on_s(const Discharge& discharge);
/// When the voltage first fell to this, from the first load on, between samples [s]; NaN where it did not.
[[nodiscard]] double seconds_to_voltage(const Discharge& discharge, double voltage_v);

}  // namespace cosiva::battery
