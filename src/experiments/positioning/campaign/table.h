#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

namespace cosiva::experiments {

/// A cell of a table. A NaN is an empty field in CSV and NULL in SQLite.
using TableValue = std::variant<std::int64_t, double, std::string>;

/// A table whose cells are computed on demand: the largest tables have millions of cells.
struct ResultTable {
  std::string name;  ///< of a-z and _
  struct Column {
    std::string name;  ///< with its unit: "rmse_m"
    enum class Kind { whole, number, text };
    Kind kind;
    std::function<TableValue(std::size_t row)> value;
  };
  std::vector<Column> columns;
  std::size_t rows{};
};

/// A header line, then a line per row; numbers in the shortest form that reads back to the same bits.
[[nodiscard]] std::string to_csv(const ResultTable& table);

}  // namespace cosiva::experiments
