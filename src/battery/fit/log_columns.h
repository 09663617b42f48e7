#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

/// The header of a log: the content and unit of each column, and the separator.
namespace cosiva::battery {

/// A column as found: a value is `scale` times the field, plus `offset`.
struct ColumnUnit {
  std::size_t at{};
  double scale{1.0};
  double offset{0.0};
};

struct LogColumns {
  char separator{','};
  std::vector<std::string> names;       ///< as written
  std::array<ColumnUnit, 3> columns{};  ///< of time [s], voltage [V], current [A]
  std::optional<ColumnUnit> temperature;
  std::optional<ColumnUnit> discharged;  ///< the tester's own count of charge, out [Ah] …
  std::optional<ColumnUnit> charged;     ///< … and in
  std::optional<std::size_t> step;       ///< number of the test's step
  std::string diagnostic{};              ///< if the names are not the format's own: how they were interpreted
};

/// The format's names of time, voltage and current.
inline constexpr std::array<std::string_view, 3> wanted_columns{"test_time_second", "voltage_volt", "current_ampere"};

/// Reads a header in the Battery Data Format's machine-readable names, its labels, or testers' names of the same
/// quantities, if they contain the unit: `Test_Time(s)`, `Voltage [mV]`, `I/mA`. Fails ("log.column") with `place`,
/// naming the column that is missing or lacks its unit.
[[nodiscard]] Result<LogColumns> read_columns(std::string_view line, const std::string& location);

/// A line's fields, trimmed, without their quotes; a separator within quotes does not count.
[[nodiscard]] std::vector<std::string_view> cut_fields(std::string_view line, char separator);
/// A field as a number; with another separator than the comma a comma may be the decimal point.
[[nodiscard]] std::optional<double> field_number(std::string_view field, char separator);
/// A hint at the probable content of an invalid field: ": seconds are wanted, not hours:minutes:seconds", or nothing.
[[nodiscard]] std::string field_hint(std::string_view field);

}  // namespace cosiva::battery
