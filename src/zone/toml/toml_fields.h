#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/toml/toml_table.h"

namespace cosiva::zone {

/// Whether this can be a name: 1 to 256 bytes without control characters.
[[nodiscard]] bool is_toml_name(std::string_view text);
/// In double quotes, with escapes.
[[nodiscard]] std::string toml_quoted(std::string_view text);

/// One table of a zone's file, with the fields that zones have.
class TomlFields : public TomlTable {
 public:
  using TomlTable::TomlTable;

  /// Whether the field is an array, such as of tables.
  [[nodiscard]] bool is_list(std::string_view key) const;
  /// 1 to 256 bytes, without control characters.
  [[nodiscard]] std::string name(std::string_view key) const;
  [[nodiscard]] std::optional<std::string> optional_name(std::string_view key) const;
  /// In radians, from `key`_deg or, where the last digit counts, `key`_rad: one of both, or the fallback.
  [[nodiscard]] double angle(std::string_view key, double within_deg,
                             std::optional<double> fallback_rad = std::nullopt) const;
  [[nodiscard]] std::string one_of(std::string_view key, std::initializer_list<std::string_view> terms) const {
    return one_of(key, std::vector<std::string_view>{terms});
  }
  [[nodiscard]] std::string one_of(std::string_view key, const std::vector<std::string_view>& terms) const;

  [[nodiscard]] std::optional<TomlFields> table(std::string_view key) const;
  [[nodiscard]] std::vector<TomlFields> tables(std::string_view key) const;
  [[nodiscard]] std::optional<std::vector<std::string>> names(std::string_view key) const;
  [[nodiscard]] std::optional<Point2> point(std::string_view key) const;  ///< [x, y] in metres
};

inline constexpr double coordinate_max_m = 1e6;
inline constexpr NumberRange coordinate_m{"a number of metres within ±1000000", -coordinate_max_m, coordinate_max_m};

}  // namespace cosiva::zone
