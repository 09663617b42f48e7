#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cosiva {

/// Writes JSON into a string, in the order of the calls; numbers in the shortest form that reads back to the same bits.
/// Non-finite numbers become null. Misuse (a value where a key is due) is caught by COSIVA_EXPECT.
///
///     JsonWriter json;
///     json.begin_object().field("matched", 4).key("orphans").begin_array().end_array().end_object();
class JsonWriter {
 public:
  explicit JsonWriter(int indent = 0) : indent_{indent} {}

  JsonWriter& begin_object();
  JsonWriter& end_object();
  JsonWriter& begin_array();
  JsonWriter& end_array();
  JsonWriter& key(std::string_view name);
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view{text}); }
  JsonWriter& value(const std::string& text) { return value(std::string_view{text}); }
  JsonWriter& value(double number);
  JsonWriter& value(bool flag);
  template <std::integral T>
  requires(!std::same_as<T, bool>) JsonWriter& value(T number) {
    if constexpr (std::signed_integral<T>)
      return integer(static_cast<std::int64_t>(number));
    else
      return unsigned_integer(static_cast<std::uint64_t>(number));
  }
  JsonWriter& null();
  JsonWriter& raw(std::string_view json);  ///< already JSON

  template <typename T>
  JsonWriter& field(std::string_view name, const T& v) {
    key(name);
    return value(v);
  }

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::string take() { return std::move(text_); }
  [[nodiscard]] bool complete() const { return open_.empty() && !text_.empty(); }

 private:
  JsonWriter& integer(std::int64_t number);
  JsonWriter& unsigned_integer(std::uint64_t number);
  void before_value();
  void newline();

  std::string text_;
  std::vector<char> open_;  ///< '{' or '[' of everything still open
  bool first_{true};
  bool after_key_{false};
  int indent_;
};

/// Appends `text` quoted and escaped as a JSON string; bytes that are not UTF-8 are replaced by U+FFFD.
void append_json_string(std::string& out, std::string_view text);

}  // namespace cosiva
