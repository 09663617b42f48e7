#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

/// How readers of CoSiVA's own messages take fields (own_messages.h, v2x.h): unknown ones are ignored; a wrong type, a
/// number out of its range or not finite, and a list that is too long are refused, naming the field ("own.field").
namespace cosiva::wire::own {

inline constexpr std::size_t bytes_max = 16U << 10U;  ///< of a whole message
inline constexpr std::size_t text_bytes_max = 128;
inline constexpr double position_m_max = 1e5;
inline constexpr double size_m_max = 10.0;
inline constexpr double speed_mps_max = 100.0;
inline constexpr double heading_rad_max = 100.0;
/// Whole numbers of a double are exact up to here.
inline constexpr double whole_max = 9007199254740992.0;

/// Reads the fields of one object. The first fault is stored and every later field reads as empty, so that the code of
/// a reader is a list of its fields, and `error` is queried once at the end.
class Fields {
 public:
  /// @param where  of this object in the message, such as "bodies.2."
  explicit Fields(const JsonValue& json, std::string where = {}) : json_{json}, where_{std::move(where)} {
    if (json_.object() == nullptr) report_fault("", "an object");
  }

  void number(std::string_view field, double low, double high, double& out) {
    if (const JsonValue* value = required(field)) take_number(*value, field, low, high, out);
  }
  /// For a field that may be missing, or null.
  void number(std::string_view field, double low, double high, std::optional<double>& out) {
    const JsonValue* value = optional(field);
    double read = 0.0;
    if (value != nullptr && take_number(*value, field, low, high, read)) out = read;
  }
  [[nodiscard]] bool has(std::string_view field) const { return json_.find(field) != nullptr; }
  /// A number given in `unit`s on the wire, stored as a count of whole units.
  template <std::integral T>
  void counted(std::string_view field, double unit, T& out) {
    double read = 0.0;
    constexpr auto low = static_cast<double>(std::numeric_limits<T>::min());
    constexpr auto high = static_cast<double>(std::numeric_limits<T>::max());
    number(field, low * unit, high * unit, read);
    out = static_cast<T>(std::clamp(std::nearbyint(read / unit), low, high));
  }
  template <std::unsigned_integral T>
  void whole(std::string_view field, T& out) {
    double read = 0.0;
    number(field, 0.0, std::min(whole_max, static_cast<double>(std::numeric_limits<T>::max())), read);
    if (std::floor(read) != read) return report_fault(field, "a whole number");
    out = static_cast<T>(read);
  }
  void text(std::string_view field, std::string& out, std::size_t longest = text_bytes_max) {
    const JsonValue* value = required(field);
    if (value == nullptr) return;
    const std::string* read = value->text();
    if (read == nullptr || read->size() > longest)
      return report_fault(field, "a text of at most " + std::to_string(longest) + " bytes");
    out = *read;
  }
  void flag(std::string_view field, bool& out) {
    const JsonValue* value = required(field);
    if (value == nullptr) return;
    if (value->flag() == nullptr) return report_fault(field, "true or false");
    out = *value->flag();
  }
  void time(std::string_view field, SimTime& out) {
    std::string read;
    text(field, read);
    if (error_) return;
    const auto parsed = parse_iso8601(read);
    if (!parsed) return report_fault(field, "an ISO 8601 time");
    out = *parsed;
  }
  /// Calls `take(item, name)` for each item of a list; the name is relative to this object, "bodies.2".
  template <typename Take>
  void list(std::string_view field, std::size_t count_max, Take take) {
    const JsonValue* value = required(field);
    if (value == nullptr) return;
    const JsonValue::Array* items = value->array();
    if (items == nullptr || items->size() > count_max)
      return report_fault(field, "a list of at most " + std::to_string(count_max));
    for (std::size_t i = 0; i < items->size() && !error_; ++i)
      take((*items)[i], std::string(field) + "." + std::to_string(i));
  }
  /// A field's name in the whole message.
  [[nodiscard]] std::string location(const std::string& field) const { return where_ + field; }
  /// Nothing where the field is missing or null, or an earlier field was wrong.
  [[nodiscard]] const JsonValue* optional(std::string_view field) {
    if (error_) return nullptr;
    const JsonValue* value = json_.find(field);
    return value == nullptr || value->is_null() ? nullptr : value;
  }
  void report_fault(std::string_view field, std::string expected) {
    if (!error_) error_ = Error{"own.field", "expected " + std::move(expected), where_ + std::string(field)};
  }
  void take_over(std::optional<Error> inner) {
    if (!error_) error_ = std::move(inner);
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  [[nodiscard]] const JsonValue* required(std::string_view field) {
    if (error_) return nullptr;
    const JsonValue* value = json_.find(field);
    if (value == nullptr) report_fault(field, "this field");
    return value;
  }
  bool take_number(const JsonValue& value, std::string_view field, double low, double high, double& out) {
    const double* read = value.number();
    if (read == nullptr || !(*read >= low && *read <= high)) {
      char range[80];
      const int length = std::snprintf(range, sizeof range, "a number from %.10g to %.10g", low, high);
      report_fault(field, std::string(range, static_cast<std::size_t>(length)));
      return false;
    }
    out = *read + 0.0;  // no minus zero: "-0" would be read back as an integer, plain zero
    return true;
  }

  const JsonValue& json_;
  std::string where_;
  std::optional<Error> error_;
};

/// Parses the text, lets `read(fields, message)` take the fields, and gives the message or the first fault.
template <typename Message, typename Read>
Result<Message> read_message(std::string_view text, Read read, std::size_t longest = bytes_max) {
  const auto json = JsonValue::parse(text, longest);
  if (!json) return tl::unexpected(json.error());
  Message message;
  Fields fields{*json};
  read(fields, message);
  if (fields.error()) return tl::unexpected(*fields.error());
  return message;
}

/// Reads an object inside the message, if there is one.
template <typename Part, typename Read>
void read_part(Fields& in, std::string_view field, std::optional<Part>& out, Read read) {
  const JsonValue* json = in.optional(field);
  if (json == nullptr) return;
  Fields fields{*json, std::string(field) + "."};
  Part part{};
  read(fields, part);
  in.take_over(fields.error());
  out = std::move(part);
}

}  // namespace cosiva::wire::own
