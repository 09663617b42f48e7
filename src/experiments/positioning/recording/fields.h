#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/text.h"

/// Lines of numbers, the basis of all these formats.
namespace cosiva::experiments {

/// File and line: "odometry.csv:12".
[[nodiscard]] std::string location_of(std::string_view file, std::size_t line);

/// Splits a line at white space.
[[nodiscard]] std::vector<std::string_view> cut_at_spaces(std::string_view line);
/// As number_of, but allows a leading plus, which some programs write.
[[nodiscard]] std::optional<double> finite_number(std::string_view field);

/// The separator of a table's fields, from its header: the first of comma, semicolon and tab that occurs, else white
/// space.
[[nodiscard]] char separator_of(std::string_view header);
/// The fields of a line, without surrounding blanks and quotes; a separator at the end follows the last field.
[[nodiscard]] std::vector<std::string_view> cut_at(char separator, std::string_view line);

/// A table with a header line; columns are found by name. The header may be the last of the comments (#) before the
/// numbers.
struct RecordingTable {
  std::string file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;  ///< one value per column; finite in columns without a fault
  /// Of each column: its first field that is not a finite number. Unused columns may contain text.
  std::vector<std::optional<Error>> faults;

  /// Fails ("recording.header", "recording.width") with the line.
  [[nodiscard]] static Result<RecordingTable> read(std::string_view file, std::string_view text);
  [[nodiscard]] std::optional<std::size_t> find(std::string_view column) const;
  /// Fails ("recording.column") with the available columns, ("recording.number") where the column contains an invalid
  /// number.
  [[nodiscard]] Result<std::size_t> need(std::string_view column) const;
  /// The same for an optional column.
  [[nodiscard]] Result<std::optional<std::size_t>> want(std::string_view column) const;

 private:
  void take_row(const std::vector<std::string_view>& fields, std::size_t line);
};

}  // namespace cosiva::experiments
