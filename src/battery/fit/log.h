#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::battery {

/// A tester's record of one battery, sample by sample. A sample's current flowed since the previous sample.
struct Log {
  std::string name;  ///< file and series: "rates.csv, rate=1C"
  std::vector<double> time_s;
  std::vector<double> voltage_v;
  std::vector<double> current_a;           ///< positive discharges, as everywhere here (a file's + charges)
  std::vector<double> temperature_c;       ///< empty if the file has none; a sample without a value has the last one's
  std::string origin{};                    ///< the file …
  std::vector<std::size_t> line{};         ///< … and each sample's line in it
  std::vector<double> counted_ah{};        ///< the tester's own count of the charge taken out until each sample; empty
                                           ///< without one
  std::vector<std::string> diagnostics{};  ///< how the file was interpreted, if that is not obvious
};

/// Reads a CSV with the Battery Data Format's columns: `test_time_second`, `voltage_volt`, `current_ampere` (+
/// charges), optionally `temperature_t1_celsius` or `ambient_temperature_celsius`; other columns are used only to
/// distinguish series. Each value of a column that names a battery (`cell_id`, `channel`) is a series, also if their
/// rows are mixed; columns that may do so (`rate`, `discharge_number`, `run`) begin another series if the time
/// restarts. Fails ("log.…") naming file and line:
///  log.column   a column is missing or has another unit; log.number  a field is no number;
///  log.time     the time goes back within a series; log.gap     charge flowed between distant samples;
///  log.sign     discharges are recorded as charges, or the reverse;
///  log.percent  a percent column contains fractions, or the reverse; log.short  fewer than ten samples;
///  log.unit     implausible times: hours or minutes in a column of seconds
[[nodiscard]] Result<std::vector<Log>> read_logs(std::string_view csv, const std::string& origin);

}  // namespace cosiva::battery
