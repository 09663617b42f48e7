#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

/// Tables of numbers in the vision system's files. Only this folder includes this header.
namespace cosiva::vision {

/// File and line: "points.csv:12".
[[nodiscard]] std::string location_of(const std::string& file, std::size_t line);
/// Fields between separators; one separator at the line's end begins no further field.
[[nodiscard]] std::vector<std::string_view> cut(std::string_view line, char separator);
/// For messages, shortened.
[[nodiscard]] std::string in_quotes(std::string_view field);

/// Rows of finite numbers within a million.
struct Table {
  struct Row {
    std::size_t line;
    std::vector<double> numbers;  ///< in the order of the requested columns
  };
  std::vector<Row> rows;
};
/// The first line that is no comment ('#') must name `columns`, in any order, separated by semicolons or commas;
/// further columns are allowed. Fails (`code`) with file and line.
[[nodiscard]] Result<Table> read_table(std::string_view text, const std::vector<std::string_view>& columns,
                                       const std::string& code, const std::string& file);

}  // namespace cosiva::vision
