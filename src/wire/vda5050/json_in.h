#pragma once

#include <simdjson.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/terms.h"

namespace cosiva::wire::vda5050 {

enum class Need { required, optional };

/// The location of a value in the message, as a chain on the stack; converted to a text only for an error.
struct FieldLocation {
  const FieldLocation* up{};
  std::string_view key;
  std::size_t index{none};
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
};
/// "state.nodeStates[3].sequenceId"
[[nodiscard]] std::string to_string(const FieldLocation& location);

/// The first fault of a message; later ones are not reported.
struct Trouble {
  std::optional<Error> error;
  void set(const FieldLocation& location, std::string_view code, std::string message) {
    if (!error) error = Error{std::string(code), std::move(message), to_string(location)};
  }
};

/// One JSON object being read. Every call reads one field into `out`, leaves `out` unchanged where an optional field is
/// absent or null, and records the first fault; after that all calls do nothing.
class Fields {
 public:
  Fields(simdjson::dom::object object, const FieldLocation& location, Trouble& trouble)
      : object_{object}, location_{location}, trouble_{trouble} {}

  [[nodiscard]] bool ok() const { return !trouble_.error.has_value(); }
  /// Present and not null.
  [[nodiscard]] bool has(std::string_view key) const;

  /// Identifiers and keys: at most `text_bytes_max` bytes.
  void text(std::string_view key, std::string& out, Need need);
  /// Text for display only: cut at `text_bytes_max` bytes, since a long description must not cost the message.
  void description(std::string_view key, std::string& out);
  /// |number| ≤ 1e9, and at least `low`.
  void number(std::string_view key, double& out, Need need, double low = -number_max, double high = number_max);
  void number(std::string_view key, std::optional<double>& out, double low = -number_max, double high = number_max);
  /// 0 … 2³² − 1; 3.0 counts as 3, as in JSON schemas.
  void count(std::string_view key, std::uint32_t& out, Need need);
  void flag(std::string_view key, bool& out, Need need);
  void timestamp(std::string_view key, SimTime& out, Need need);
  /// Radians, brought into (−π, π].
  void angle(std::string_view key, double& out, Need need);
  void angle(std::string_view key, std::optional<double>& out);
  void parameter_value(std::string_view key, ParameterValue& out);

  template <typename T, std::size_t N>
  void word(std::string_view key, const std::array<Word<T>, N>& table, T& out, Need need) {
    std::string_view text;
    if (!string(key, text, need)) return;
    if (const auto value = value_of(table, text)) {
      out = *value;
    } else {
      unknown_word(key, text);
    }
  }

  /// `read(Fields&)` on the object under `key`.
  template <typename Read>
  void object(std::string_view key, Need need, Read read) {
    const auto element = find(key, need);
    if (!element) return;
    const FieldLocation here{&location_, key};
    simdjson::dom::object inner;
    if (element->get(inner) != simdjson::SUCCESS) return wrong_type(here, "an object", *element);
    Fields fields{inner, here, trouble_};
    read(fields);
  }

  /// `read(Fields&, item)` on each object of the array under `key`.
  template <typename T, typename Read>
  void each(std::string_view key, Need need, std::vector<T>& out, Read read) {
    const auto element = find(key, need);
    if (!element) return;
    const FieldLocation here{&location_, key};
    simdjson::dom::array items;
    if (!bounded_array(*element, here, items)) return;
    out.reserve(items.size());
    std::size_t index = 0;
    for (const simdjson::dom::element item : items) {
      const FieldLocation at{&here, {}, index++};
      simdjson::dom::object inner;
      if (item.get(inner) != simdjson::SUCCESS) return wrong_type(at, "an object", item);
      Fields fields{inner, at, trouble_};
      read(fields, out.emplace_back());
      if (!ok()) return;
    }
  }

  /// Texts of the array under `key`, for lists of terms.
  template <typename Read>
  void each_text(std::string_view key, Read read) {
    const auto element = find(key, Need::optional);
    if (!element) return;
    const FieldLocation here{&location_, key};
    simdjson::dom::array items;
    if (!bounded_array(*element, here, items)) return;
    for (const simdjson::dom::element item : items) {
      std::string_view text;
      if (item.get(text) != simdjson::SUCCESS) return wrong_type(here, "a list of texts", item);
      read(text);
    }
  }

  void report(std::string_view key, std::string_view code, std::string message) {
    trouble_.set(FieldLocation{&location_, key}, code, std::move(message));
  }

  static constexpr double number_max = 1e9;

 private:
  [[nodiscard]] std::optional<simdjson::dom::element> find(std::string_view key, Need need);
  [[nodiscard]] bool string(std::string_view key, std::string_view& out, Need need);
  [[nodiscard]] bool bounded_array(simdjson::dom::element element, const FieldLocation& here,
                                   simdjson::dom::array& out);
  void wrong_type(const FieldLocation& here, std::string_view expected, simdjson::dom::element found);
  void unknown_word(std::string_view key, std::string_view text);

  simdjson::dom::object object_;
  const FieldLocation& location_;
  Trouble& trouble_;
};

/// The flat header (§6.4). All fields of a required header must be present; of an optional one, those present are read.
/// A version other than 2.x is refused in both cases ("vda.version").
void read_header(Fields& fields, Header& header, Need need);

/// Parses within the bounds of codec.h, reads the root object with `read`, and gives the message or the first fault.
template <typename T, typename Read>
[[nodiscard]] Result<T> decode_message(std::string_view json, std::string_view name, Read read);

[[nodiscard]] Result<simdjson::dom::object> parse_root(std::string_view json, std::string_view name);

template <typename T, typename Read>
Result<T> decode_message(std::string_view json, std::string_view name, Read read) {
  const auto root = parse_root(json, name);
  if (!root) return tl::unexpected<Error>(root.error());
  Trouble trouble;
  const FieldLocation location{nullptr, name};
  Fields fields{*root, location, trouble};
  T message;
  read(fields, message);
  if (trouble.error) return tl::unexpected<Error>(std::move(*trouble.error));
  return message;
}

}  // namespace cosiva::wire::vda5050
