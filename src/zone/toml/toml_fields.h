#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/toml/toml_library.h"

namespace cosiva::zone {

/// The faults of a file. Reading goes on with stand-in values, so that the reader stays straight-line code; the reader
/// checks `any()` before using the result.
class TomlFaults {
 public:
  explicit TomlFaults(std::string origin) : origin_{std::move(origin)} {}

  void add(std::string code, std::uint32_t line, std::string_view path, std::string message);
  /// Of an item in another file.
  void add(Error error);
  [[nodiscard]] bool any() const { return !all_.empty(); }
  [[nodiscard]] const Error& first() const { return all_.front(); }
  /// The first hundred; those behind the first may be its consequences.
  [[nodiscard]] const std::vector<Error>& all() const { return all_; }
  /// "origin:line: path"; the path may be empty.
  [[nodiscard]] std::string location(std::uint32_t line, std::string_view path) const;

 private:
  std::string origin_;
  std::vector<Error> all_;
};

/// Whether this can be a name: 1 to 256 bytes without control characters.
[[nodiscard]] bool is_toml_name(std::string_view text);
/// In double quotes, with escapes.
[[nodiscard]] std::string toml_quoted(std::string_view text);
/// The shortest text that reads back to the same number, and is a TOML number.
[[nodiscard]] std::string toml_number(double value);

/// The required range of a number, and its description for messages.
struct NumberRange {
  std::string_view what;  ///< "a positive number of metres"
  double low;
  double high;
  bool low_allowed{true};
};

/// One table of a file, read field by field. Each read reports the expected and the found value, with file, line and
/// field path. Entries of an array of tables are counted from 1, as people count them: section[3].radius_m.
class TomlFields {
 public:
  TomlFields(TomlFaults& faults, const toml::table& table, std::string path)
      : faults_{&faults}, table_{&table}, path_{std::move(path)} {}

  [[nodiscard]] bool has(std::string_view key) const { return table_->contains(key); }
  /// Whether the field is an array, such as of tables.
  [[nodiscard]] bool is_list(std::string_view key) const;
  /// All keys, sorted.
  [[nodiscard]] std::vector<std::string> keys() const;
  /// Reports any other key as a fault, naming the nearest of these.
  void expect_only(std::initializer_list<std::string_view> keys) const;

  /// Without a fallback the field is required.
  [[nodiscard]] double number(std::string_view key, const NumberRange& range,
                              std::optional<double> fallback = std::nullopt) const;
  [[nodiscard]] std::uint32_t whole(std::string_view key, std::uint32_t low, std::uint32_t high,
                                    std::optional<std::uint32_t> fallback = std::nullopt) const;
  [[nodiscard]] bool flag(std::string_view key, bool fallback) const;
  /// 1 to 256 bytes, without control characters.
  [[nodiscard]] std::string name(std::string_view key) const;
  [[nodiscard]] std::optional<std::string> optional_name(std::string_view key) const;
  /// In radians, from `key`_deg or, where the last digit counts, `key`_rad: one of both, or the fallback.
  [[nodiscard]] double angle(std::string_view key, double within_deg,
                             std::optional<double> fallback_rad = std::nullopt) const;
  [[nodiscard]] std::string one_of(std::string_view key, std::initializer_list<std::string_view> terms) const;

  [[nodiscard]] std::optional<TomlFields> table(std::string_view key) const;
  [[nodiscard]] std::vector<TomlFields> tables(std::string_view key) const;
  [[nodiscard]] std::optional<std::vector<std::string>> names(std::string_view key) const;
  [[nodiscard]] std::optional<Point2> point(std::string_view key) const;  ///< [x, y] in metres

  /// A fault of this field (or of the whole table with an empty key).
  void fault(std::string_view key, std::string code, std::string message) const;
  [[nodiscard]] std::uint32_t line(std::string_view key = {}) const;
  [[nodiscard]] std::string location() const { return faults_->location(line(), path_); }  ///< "origin:line: path"
  [[nodiscard]] std::string path(std::string_view key = {}) const;

 private:
  /// Returns the field's node, or nothing after reporting a missing one (unless `optional`).
  [[nodiscard]] const toml::node* find(std::string_view key, std::string_view expected, bool optional) const;
  void expected(std::string_view key, std::string_view what, const toml::node& found) const;

  TomlFaults* faults_;
  const toml::table* table_;
  std::string path_;
};

inline constexpr double coordinate_max_m = 1e6;
inline constexpr NumberRange coordinate_m{"a number of metres within ±1000000", -coordinate_max_m, coordinate_max_m};

}  // namespace cosiva::zone
