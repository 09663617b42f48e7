#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace cosiva::battery {

/// What a tester wrote down of one battery, sample by sample. A sample's current flowed since the sample before it.
struct Log {
  std::string name;  ///< file, and which series of it: "rates.csv, rate=1C"
  std::vector<double> time_s;
  std::vector<double> voltage_v;
  std::vector<double> current_a;      ///< positive discharges, as everywhere here (a file's + charges)
  std::vector<double> temperature_c;  ///< empty where the file has none; a sample's that lacks it: the last one's
  std::string origin{};               ///< the file …
  std::vector<std::size_t> line{};    ///< … and each sample's line in it
};

/// Reads a CSV with the Battery Data Format's columns: `test_time_second`, `voltage_volt`, `current_ampere` (+
/// charges), optionally `temperature_t1_celsius` or `ambient_temperature_celsius`; others are looked at only to tell
/// series apart. Each value of a column that names a battery (`cell_id`, `channel`) is a series, also where their rows
/// are mixed; columns that may (`rate`, `discharge_number`, `run`) begin another one where the time starts anew.
/// Fails ("log.…") naming file and line:
///  log.column   one is missing or has another unit; log.number  a field is none; log.time  goes back within a series
///  log.gap      charge went by unseen; log.sign  it is discharged where the file says charged, or the reverse
///  log.percent  a column called percent holds fractions, or the reverse; log.short  fewer than ten samples
///  log.unit     times that no battery keeps: hours or minutes called seconds
[[nodiscard]] Result<std::vector<Log>> read_logs(std::string_view csv, const std::string& origin);

/// From one full charge on: where in a log a fit and a prediction begin, and what has been taken out since.
struct Discharge {
  const Log* log{};
  std::size_t first{};          ///< of its samples: the first one of the discharge
  std::size_t last{};           ///< past its last
  std::vector<double> used_ah;  ///< at each sample from `first` on
};
/// The discharges of a log that begin full: at the log's begin where it says so, and after every charge up to the
/// highest voltage; each until it is charged again by more than a twentieth of what was taken out.
/// @param full_v  from 1 % below this on a battery is full; at a log's begin from 4 % below, which a load may take
/// @param full_ohm  what a load at the log's begin takes off besides, where it is known
[[nodiscard]] std::vector<Discharge> discharges_from_full(const Log& log, double full_v, double full_ohm = 0.0);

/// The highest voltage of all, loaded or not; 0 of nothing.
[[nodiscard]] double highest_voltage_v(const std::vector<Log>& logs);
/// The lowest one under a discharging current; infinite where there is none.
[[nodiscard]] double lowest_under_load_v(const Discharge& discharge);

/// When its load came on: a usual sample's time before the first one under load.
[[nodiscard]] double load_on_s(const Discharge& discharge);
/// When the voltage first fell to this, from the first load on, between samples [s]; NaN where it did not.
[[nodiscard]] double seconds_to_voltage(const Discharge& discharge, double voltage_v);

}  // namespace cosiva::battery
