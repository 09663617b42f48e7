#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/toml/toml_table.h"

namespace cosiva::experiments {

/// One table of a scenario, a campaign's plan or a site's, with the fields that these have. A misspelt field or term is
/// named with the nearest known one.
class Entry : public zone::TomlTable {
 public:
  /// The codes of faults begin with this: scenario.field.
  static constexpr std::string_view family = "scenario";

  using TomlTable::TomlTable;

  /// The text of a field of a table in this table, when both exist; never a fault.
  [[nodiscard]] std::optional<std::string> peek(std::string_view table, std::string_view key) const;

  /// A text of at most `bytes_max` bytes, not empty, without control characters but line breaks.
  [[nodiscard]] std::string text(std::string_view key, std::size_t bytes_max,
                                 const std::optional<std::string>& fallback = std::nullopt) const;
  /// One of these terms; for a misspelt one the fault names the nearest.
  [[nodiscard]] std::string one_of(std::string_view key, const std::vector<std::string_view>& terms,
                                   const std::optional<std::string>& fallback = std::nullopt) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key, std::size_t count_max) const;
  /// One of these terms or a list of them, each once; for a misspelt one the fault names the nearest.
  [[nodiscard]] std::vector<std::string> some_of(std::string_view key, const std::vector<std::string_view>& terms,
                                                 const std::vector<std::string>& fallback) const;
  /// A number, a list of numbers, or { from, to, steps, log } with both ends: 1 to `count_max` of them, each once, in
  /// rising order. `range.what` describes the permitted values.
  [[nodiscard]] std::vector<double> sweep(std::string_view key, const zone::NumberRange& range, std::size_t count_max,
                                          double fallback) const;
  [[nodiscard]] Point2 point(std::string_view key) const;  ///< [x, y] in metres
  /// 2 to `count_max` of them.
  [[nodiscard]] std::vector<Point2> points(std::string_view key, std::size_t count_max) const;
  /// The table of this name; a fault where the value is missing or of another type.
  [[nodiscard]] std::optional<Entry> table(std::string_view key) const;
  /// The tables under [[key]]; empty where there are none.
  [[nodiscard]] std::vector<Entry> tables(std::string_view key, std::size_t count_max) const;

 private:
  [[nodiscard]] std::optional<Point2> point_of(const toml::node& node) const;
  [[nodiscard]] std::vector<double> spread(const Entry& fields, const zone::NumberRange& range,
                                           std::size_t count_max) const;
};

}  // namespace cosiva::experiments
