#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"

namespace cosiva {

/// A small JSON document, for options, commands and state files; the wire's hot path has its own reader.
class JsonValue {
 public:
  using Array = std::vector<JsonValue>;
  using Object = std::vector<std::pair<std::string, JsonValue>>;  ///< in the order of the text

  JsonValue() = default;
  template <typename T>
  requires(!std::same_as<std::remove_cvref_t<T>, JsonValue>) explicit JsonValue(T value) : value_{std::move(value)} {}

  /// Fails ("json.syntax") on anything that is not one JSON document, over `bytes_max`, or nested deeper than 64.
  [[nodiscard]] static Result<JsonValue> parse(std::string_view text, std::size_t bytes_max = 4U << 20U);

  [[nodiscard]] bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
  [[nodiscard]] const bool* flag() const { return std::get_if<bool>(&value_); }
  [[nodiscard]] const double* number() const { return std::get_if<double>(&value_); }
  [[nodiscard]] const std::string* text() const { return std::get_if<std::string>(&value_); }
  [[nodiscard]] const Array* array() const { return std::get_if<Array>(&value_); }
  [[nodiscard]] const Object* object() const { return std::get_if<Object>(&value_); }

  /// The member of this object, or nothing if there is none or this is no object.
  [[nodiscard]] const JsonValue* find(std::string_view key) const;
  [[nodiscard]] std::optional<double> number(std::string_view key) const;
  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
  [[nodiscard]] std::optional<bool> flag(std::string_view key) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::variant<std::monostate, bool, double, std::string, Array, Object> value_;
};

}  // namespace cosiva
