#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

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
  std::vector<double> counted_ah{};   ///< the tester's own count of what went out until each sample; empty without one
  std::vector<std::string> diagnostics{};  ///< how it was understood, where that is not plain
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

}  // namespace cosiva::battery
