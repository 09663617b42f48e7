#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

/// What a log's header says: which column holds what, in which unit, and what stands between two of them.
namespace cosiva::battery {

/// A column as it was found: a value is `scale` times what is written there, and `offset` more.
struct ColumnUnit {
  std::size_t at{};
  double scale{1.0};
  double offset{0.0};
};

struct LogColumns {
  char separator{','};
  std::vector<std::string> names;       ///< as they are written
  std::array<ColumnUnit, 3> columns{};  ///< of time [s], voltage [V], current [A]
  std::optional<ColumnUnit> temperature;
  std::optional<ColumnUnit> discharged;  ///< what the tester itself counted, out [Ah] …
  std::optional<ColumnUnit> charged;     ///< … and in
  std::optional<std::size_t> step;       ///< which says that another step of the test has begun
  std::string diagnostic{};              ///< where the names are not the format's own: how they were understood
};

/// The format's names of time, voltage and current.
inline constexpr std::array<std::string_view, 3> wanted_columns{"test_time_second", "voltage_volt", "current_ampere"};

/// Reads a header in the Battery Data Format's machine-readable names, its labels, or what testers call the same
/// quantities, where they name the unit: `Test_Time(s)`, `Voltage [mV]`, `I/mA`.
/// Fails ("log.column") with `place`, saying which is missing or lacks its unit.
[[nodiscard]] Result<LogColumns> read_columns(std::string_view line, const std::string& location);

/// A line's fields, trimmed, without their quotes; a separator within quotes is none.
[[nodiscard]] std::vector<std::string_view> cut_fields(std::string_view line, char separator);
/// A field as a number; under another separator than the comma a comma may stand for the decimal point.
[[nodiscard]] std::optional<double> field_number(std::string_view field, char separator);
/// What the field that should be one might be instead: ": seconds are wanted, not hours:minutes:seconds", or nothing.
[[nodiscard]] std::string field_hint(std::string_view field);

}  // namespace cosiva::battery
