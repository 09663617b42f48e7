#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/json_value.h"
#include "cosiva/zone/lif/lif_diagnostics.h"

namespace cosiva::zone::lif {

/// A text of a file without control characters, as it is displayed and sent in messages.
[[nodiscard]] std::string printable(std::string text);

/// One object of a file, read field by field and never refused: a value in another form than the standard's is accepted
/// if its meaning is clear, with a diagnostic. A field that is absent or null does not exist.
class LifFields {
 public:
  /// @param value  of any kind; only an object has fields
  LifFields(LifDiagnostics& diagnostics, const JsonValue& value, const JsonLocation& location)
      : diagnostics_{&diagnostics}, value_{&value}, location_{location} {}

  [[nodiscard]] bool is_object() const { return value_->object() != nullptr; }
  [[nodiscard]] const JsonValue* value() const { return value_; }
  /// This item itself, where it is a text (or a number, which is converted to one).
  [[nodiscard]] std::optional<std::string> text() const;
  /// This item itself, where it is a finite number (or a text that contains one).
  [[nodiscard]] std::optional<double> number() const;

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
  [[nodiscard]] std::optional<double> number(std::string_view key) const;
  [[nodiscard]] std::optional<bool> flag(std::string_view key) const;
  /// Without fields where it is absent.
  [[nodiscard]] LifFields object(std::string_view key) const;
  /// Calls `visit(item)` for each; a single object counts as a list of one. Returns the number of items; nothing where
  /// the list is absent.
  template <typename Visit>
  std::optional<std::size_t> each(std::string_view key, const Visit& visit) const;

  /// Reports all other fields as lost.
  void known(std::initializer_list<std::string_view> keys) const;
  /// Reports a field that is present as lost.
  void lose(std::string_view key, std::string_view why) const;
  void record(Diagnostic::Kind kind, std::string_view key, std::string text, std::string sort = {}) const;
  [[nodiscard]] std::string location(std::string_view key = {}) const;

 private:
  [[nodiscard]] const JsonValue* find(std::string_view key) const;
  [[nodiscard]] LifFields member(std::string_view key, const JsonValue& value) const {
    return {*diagnostics_, value, {&location_, key, 0}};
  }
  void mend_list(std::string_view key) const;

  LifDiagnostics* diagnostics_;
  const JsonValue* value_;
  JsonLocation location_;  ///< points to that of the object around it, which must outlive this
};

template <typename Visit>
std::optional<std::size_t> LifFields::each(std::string_view key, const Visit& visit) const {
  const JsonValue* list = find(key);
  if (list == nullptr) return std::nullopt;
  const JsonLocation at{&location_, key, 0};
  if (list->array() == nullptr) {
    mend_list(key);
    if (list->object() == nullptr) return std::nullopt;
    visit(LifFields{*diagnostics_, *list, at});
    return 1;
  }
  for (std::size_t i = 0; i < list->array()->size(); ++i)
    visit(LifFields{*diagnostics_, (*list->array())[i], {&at, {}, i}});
  return list->array()->size();
}

}  // namespace cosiva::zone::lif
