#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/toml/toml_library.h"

namespace cosiva::zone {

/// The faults of a file. Reading goes on with stand-in values, so that the reader stays straight-line code; the reader
/// checks `any()` before using the result.
class TomlFaults {
 public:
  /// @param family  begins the codes of wrong fields: "zone" for zone.field, zone.missing and zone.unknown_key
  explicit TomlFaults(std::string origin, std::string_view family = "zone")
      : origin_{std::move(origin)}, family_{family} {}

  void add(std::string code, std::uint32_t line, std::string_view path, std::string message);
  /// Of an item in another file.
  void add(Error error);
  [[nodiscard]] bool any() const { return !all_.empty(); }
  [[nodiscard]] const Error& first() const { return all_.front(); }
  /// The first hundred; those behind the first may be its consequences.
  [[nodiscard]] const std::vector<Error>& all() const { return all_; }
  /// "origin:line: path"; the path may be empty.
  [[nodiscard]] std::string location(std::uint32_t line, std::string_view path) const;
  /// "zone.field" for the kind "field".
  [[nodiscard]] std::string code(std::string_view kind) const;

 private:
  std::string origin_;
  std::string family_;
  std::vector<Error> all_;
};

/// The required range of a number, and its description for messages.
struct NumberRange {
  std::string_view what;  ///< "a positive number of metres"
  double low;
  double high;
  bool low_allowed{true};

  [[nodiscard]] bool contains(double value) const;
};

/// One table of a file, read field by field: what the readers of all kinds of files have in common. Each read reports
/// the expected and the found value, with file, line and field path. Entries of an array of tables are counted from 1,
/// as people count them: section[3].radius_m.
class TomlTable {
 public:
  TomlTable(TomlFaults& faults, const toml::table& table, std::string path)
      : faults_{&faults}, table_{&table}, path_{std::move(path)} {}

  [[nodiscard]] bool has(std::string_view key) const { return table_->contains(key); }
  /// All keys, sorted.
  [[nodiscard]] std::vector<std::string> keys() const;
  /// Reports any other key as a fault, naming the nearest of these.
  void expect_only(std::initializer_list<std::string_view> keys) const;
  void expect_only(const std::vector<std::string_view>& keys) const;

  /// Without a fallback the field is required.
  [[nodiscard]] double number(std::string_view key, const NumberRange& range,
                              std::optional<double> fallback = std::nullopt) const;
  [[nodiscard]] std::int64_t whole(std::string_view key, std::int64_t low, std::int64_t high,
                                   std::optional<std::int64_t> fallback = std::nullopt) const;
  [[nodiscard]] bool flag(std::string_view key, bool fallback) const;

  /// A fault of this field (or of the whole table with an empty key).
  void fault(std::string_view key, std::string code, std::string message) const;
  [[nodiscard]] std::uint32_t line(std::string_view key = {}) const;
  [[nodiscard]] std::string location() const { return faults_->location(line(), path_); }  ///< "origin:line: path"
  [[nodiscard]] std::string path(std::string_view key = {}) const;

 protected:
  /// Returns the field's node, or nothing after reporting a missing one (unless `optional`).
  [[nodiscard]] const toml::node* find(std::string_view key, std::string_view what, bool optional) const;
  void expected(std::string_view key, std::string_view what, const toml::node& found) const;
  /// The tables under [[key]]; none where there are none, and after a fault.
  [[nodiscard]] std::vector<const toml::table*> list(
      std::string_view key, std::string_view what,
      std::size_t count_max = std::numeric_limits<std::size_t>::max()) const;
  /// The path of an entry of a list, counted from 1.
  [[nodiscard]] std::string entry_path(std::string_view key, std::size_t number) const;
  [[nodiscard]] TomlFaults& faults() const { return *faults_; }
  [[nodiscard]] const toml::table& table_here() const { return *table_; }

 private:
  void expect_among(std::span<const std::string_view> keys) const;

  TomlFaults* faults_;
  const toml::table* table_;
  std::string path_;
};

}  // namespace cosiva::zone
