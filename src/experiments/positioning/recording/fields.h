#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/text.h"

/// Lines of numbers, as all these formats are made of.
namespace cosiva::experiments {

/// Where in which file: "odometry.csv:12".
[[nodiscard]] std::string location_of(std::string_view file, std::size_t line);

/// What stands between white space.
[[nodiscard]] std::vector<std::string_view> cut_at_spaces(std::string_view line);
/// number_of, and a plus may stand before it, as some programs write.
[[nodiscard]] std::optional<double> finite_number(std::string_view field);

/// What a table's fields are cut at, by its header: the first of comma, semicolon and tab that stands in it, else
/// blanks.
[[nodiscard]] char separator_of(std::string_view header);
/// The fields of a line, without blanks and quotes about them; a separator at its end ends the last one.
[[nodiscard]] std::vector<std::string_view> cut_at(char separator, std::string_view line);

/// A table with a header line; columns are found by name. The header may be the last of the comments (#) before the
/// numbers.
struct Table {
  std::string file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;  ///< as wide as there are columns; finite in columns that have no fault
  /// Of each column: its first field that is no finite number. Columns that nobody needs may hold words.
  std::vector<std::optional<Error>> faults;

  /// Fails ("recording.header", "recording.width") with the line.
  [[nodiscard]] static Result<Table> read(std::string_view file, std::string_view text);
  [[nodiscard]] std::optional<std::size_t> find(std::string_view column) const;
  /// Fails ("recording.column") naming the columns there are, ("recording.number") where it holds what is no number.
  [[nodiscard]] Result<std::size_t> need(std::string_view column) const;
  /// The same of one that may be missing.
  [[nodiscard]] Result<std::optional<std::size_t>> want(std::string_view column) const;

 private:
  void take_row(const std::vector<std::string_view>& fields, std::size_t line);
};

}  // namespace cosiva::experiments
