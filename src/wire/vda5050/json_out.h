#pragma once

#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::wire::vda5050 {

/// Appends JSON to one string. Unlike JsonWriter this class keeps no stack: the last character determines whether a
/// comma is due, and keys are passed ready-made as `"name":`. A state message of a kilobyte takes one allocation.
class JsonOut {
 public:
  explicit JsonOut(std::size_t expected_bytes) { text_.reserve(expected_bytes); }

  JsonOut& open(char bracket) {
    comma();
    text_ += bracket;
    return *this;
  }
  JsonOut& close(char bracket) {
    text_ += bracket;
    return *this;
  }
  /// @param quoted  the key as written in JSON with its colon: R"("nodeId":)"
  JsonOut& key(std::string_view quoted) {
    comma();
    text_ += quoted;
    return *this;
  }
  JsonOut& value(std::string_view text) {
    comma();
    if (plain(text)) {
      text_ += '"';
      text_ += text;
      text_ += '"';
    } else {
      append_json_string(text_, text);
    }
    return *this;
  }
  JsonOut& value(const std::string& text) { return value(std::string_view{text}); }
  JsonOut& value(const char* text) { return value(std::string_view{text}); }
  JsonOut& value(bool flag) { return raw(flag ? "true" : "false"); }
  JsonOut& value(double number) {
    // JSON has no representation of NaN, and no schema takes null instead: a message that holds one is a defect of
    // CoSiVA.
    COSIVA_EXPECT(std::isfinite(number));
    // Adding zero turns −0 into 0: readers would take "-0" for an integer and drop its sign.
    return digits(number + 0.0);
  }
  JsonOut& value(std::uint32_t number) { return digits(number); }
  JsonOut& raw(std::string_view json) {
    comma();
    text_ += json;
    return *this;
  }

  template <typename T>
  JsonOut& field(std::string_view quoted, const T& v) {
    return key(quoted).value(v);
  }
  /// Leaves the field out where the text is empty.
  JsonOut& text_if_any(std::string_view quoted, const std::string& text) {
    return text.empty() ? *this : field(quoted, text);
  }
  /// Writes an array; `write(item)` writes one value.
  template <typename Range, typename Write>
  JsonOut& array(std::string_view quoted, const Range& items, Write write) {
    key(quoted).open('[');
    for (const auto& item : items) write(item);
    return close(']');
  }

  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void comma() {
    if (text_.empty()) return;
    const char last = text_.back();
    if (last != '{' && last != '[' && last != ':') text_ += ',';
  }
  static bool plain(std::string_view text) {
    for (const char c : text) {
      const auto u = static_cast<unsigned char>(c);
      if (u < 0x20 || u >= 0x80 || c == '"' || c == '\\') return false;
    }
    return true;
  }
  template <typename T>
  JsonOut& digits(T number) {
    comma();
    char buffer[32];
    text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
    return *this;
  }

  std::string text_;
};

}  // namespace cosiva::wire::vda5050
