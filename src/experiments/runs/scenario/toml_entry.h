#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/toml/toml_library.h"  // one configuration of toml++ for the whole program: its symbols are compiled once, in zone

namespace cosiva::experiments {

/// Records the first error of a scenario. Reading continues with substitute values, so that the reader stays
/// straight-line code; the caller checks first() before using the values.
class Faults {
 public:
  explicit Faults(std::string origin) : origin_{std::move(origin)} {}

  /// "origin:line: path: message"; the path may be empty.
  void add(std::string code, std::uint32_t line, std::string_view path, std::string message);
  [[nodiscard]] const std::optional<Error>& first() const { return first_; }

 private:
  std::string origin_;
  std::optional<Error> first_;
};

/// The permitted range of a number, with its description.
struct Range {
  std::string_view what;  ///< "a number of metres over 0, at most 1"
  double low;
  double high;
  bool low_allowed{true};
};

/// One table of a scenario, read field by field. Each read reports the expected and the actual value, with file, line
/// and path; the [[at]] tables are counted from 1: at[3].person.speed_mps.
class Entry {
 public:
  Entry(Faults& faults, const toml::table& table, std::string path)
      : faults_{&faults}, table_{&table}, path_{std::move(path)} {}

  [[nodiscard]] bool has(std::string_view key) const { return table_->contains(key); }
  /// Reports any other key as a fault, naming the nearest of these.
  void expect_only(const std::vector<std::string_view>& keys) const;
  [[nodiscard]] std::vector<std::string> keys() const;

  /// The text of a field of a table in this table, when both exist; never a fault.
  [[nodiscard]] std::optional<std::string> peek(std::string_view table, std::string_view key) const;

  /// Without a fallback the field is required.
  [[nodiscard]] double number(std::string_view key, const Range& range,
                              std::optional<double> fallback = std::nullopt) const;
  [[nodiscard]] std::int64_t whole(std::string_view key, std::int64_t low, std::int64_t high,
                                   std::optional<std::int64_t> fallback = std::nullopt) const;
  [[nodiscard]] bool flag(std::string_view key, bool fallback) const;
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
  [[nodiscard]] std::vector<double> sweep(std::string_view key, const Range& range, std::size_t count_max,
                                          double fallback) const;
  [[nodiscard]] Point2 point(std::string_view key) const;  ///< [x, y] in metres
  /// 2 to `count_max` of them.
  [[nodiscard]] std::vector<Point2> points(std::string_view key, std::size_t count_max) const;
  /// The table of this name; a fault where the value is missing or of another type.
  [[nodiscard]] std::optional<Entry> table(std::string_view key) const;
  /// The tables under [[key]]; empty where there are none.
  [[nodiscard]] std::vector<Entry> tables(std::string_view key, std::size_t count_max) const;

  /// A fault of this field, or of the whole table with an empty key.
  void fault(std::string_view key, std::string code, std::string message) const;
  [[nodiscard]] std::uint32_t line(std::string_view key = {}) const;

 private:
  [[nodiscard]] const toml::node* find(std::string_view key, std::string_view what, bool optional) const;
  void expected(std::string_view key, std::string_view what, const toml::node& found) const;
  [[nodiscard]] std::optional<Point2> point_of(const toml::node& node) const;
  [[nodiscard]] std::vector<double> spread(const Entry& fields, const Range& range, std::size_t count_max) const;
  [[nodiscard]] std::string path(std::string_view key) const;

  Faults* faults_;
  const toml::table* table_;
  std::string path_;
};

/// The term of `known` that was most likely meant; empty where none is near.
[[nodiscard]] std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known);
/// In quotes, short enough for one line.
[[nodiscard]] std::string quoted(std::string_view text);
/// The shortest text that reads back to the same number: "0.3".
[[nodiscard]] std::string shortest(double value);

}  // namespace cosiva::experiments
