#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/battery/fit/log.h"

namespace cosiva::battery {

/// A discharge from one full charge on: the part of a log that a fit or a prediction uses, and the charge taken out
/// since.
struct Discharge {
  const Log* log{};
  std::size_t first{};          ///< index of the first sample of the discharge
  std::size_t last{};           ///< index past the last sample
  std::vector<double> used_ah;  ///< at each sample from `first` on
  /// Uncertainty of the charge taken out, as a ratio of it: if the current changed between two samples, the time of the
  /// change is unknown. 0 if the tester counted the charge.
  double uncertain{0.0};
  bool is_counted{false};  ///< `used_ah` is the tester's own count
  double scale{1.0};       ///< factor that scaled the samples' count to the known capacity
};
/// The discharges of a log that begin full: at the log's start if its voltage shows this, and after every charge up to
/// the highest voltage; each until the battery is recharged by more than a twentieth of the charge taken out.
/// @param full_v  a battery is full from 1 % below this voltage on; at a log's start from 4 % below, because of a
/// possible load
/// @param full_ohm  resistance for the voltage drop of a load at the log's start, if known
[[nodiscard]] std::vector<Discharge> discharges_from_full(const Log& log, double full_v, double full_ohm = 0.0);

/// A known capacity is more accurate than a log with infrequent samples. If a discharge reaches the floor and its count
/// deviates by no more than its uncertainty, the count is scaled to the capacity.
void scale_to_capacity(std::vector<Discharge>& discharges, double capacity_ah, double floor_v);

/// Each of a log's discharges that begin full as a separate log, "rates.csv, discharge 2", so that some may be fitted
/// and others predicted; the log itself if there are fewer than two.
[[nodiscard]] std::vector<Log> split_at_charges(const Log& log, double full_v);

/// The highest voltage of all, except during brief charges: a pulse test's regeneration exceeds a full battery's
/// voltage. 0 if there are no logs.
[[nodiscard]] double highest_voltage_v(const std::vector<Log>& logs);
/// Between the lowest and the highest charge of the battery in a log [Ah].
[[nodiscard]] double charge_moved_ah(const Log& log);
/// The lowest voltage under a discharging current; infinite if there is none.
[[nodiscard]] double lowest_under_load_v(const Discharge& discharge);

/// Start of its load: a usual sampling interval before the first sample under load.
[[nodiscard]] double load_on_s(const Discharge& discharge);
/// When the voltage first fell to this value, from the first load on, interpolated between samples [s]; NaN if it did
/// not.
[[nodiscard]] double seconds_to_voltage(const Discharge& discharge, double voltage_v);

}  // namespace cosiva::battery
