#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/text.h"

/// Lines of numbers, as all these formats are made of.
namespace cosiva::experiments {

/// Where in which file: "odometry.csv:12".
[[nodiscard]] std::string place_of(std::string_view file, std::size_t line);

/// What stands between white space.
[[nodiscard]] std::vector<std::string_view> cut_at_spaces(std::string_view line);
/// number_of, and a plus may stand before it, as some programs write.
[[nodiscard]] std::optional<double> finite_number(std::string_view field);

/// A table with a header line; columns are found by name.
struct Table {
  std::string file;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;  ///< as wide as there are columns, finite

  /// Fails ("recording.header", "recording.number", "recording.width") with the line.
  [[nodiscard]] static Result<Table> read(std::string_view file, std::string_view text);
  [[nodiscard]] std::optional<std::size_t> find(std::string_view column) const;
  /// Fails ("recording.column") naming the columns there are.
  [[nodiscard]] Result<std::size_t> need(std::string_view column) const;
};

}  // namespace cosiva::experiments
