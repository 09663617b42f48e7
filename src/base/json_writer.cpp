#include "cosiva/base/json_writer.h"

#include <charconv>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva {
namespace {

/// Number of characters from `i` on that need no escape: ASCII, no control characters, quotes or backslashes.
std::size_t plain_length(std::string_view text, std::size_t i) {
  const std::size_t begin = i;
  for (; i < text.size(); ++i) {
    const auto u = static_cast<unsigned char>(text[i]);
    if (u < 0x20 || u >= 0x80 || u == '"' || u == '\\') break;
  }
  return i - begin;
}

/// Length of the UTF-8 sequence at `i`, or 0 if the bytes are invalid (overlong, surrogate, truncated).
std::size_t utf8_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const auto follows = [&](std::size_t k) { return k < text.size() && (byte(k) & 0xC0U) == 0x80U; };
  const unsigned char lead = byte(i);
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return follows(i + 1) ? 2 : 0;
  if (lead >= 0xE0 && lead <= 0xEF) {
    if (!follows(i + 1) || !follows(i + 2)) return 0;
    if (lead == 0xE0 && byte(i + 1) < 0xA0) return 0;
    if (lead == 0xED && byte(i + 1) > 0x9F) return 0;
    return 3;
  }
  if (lead >= 0xF0 && lead <= 0xF4) {
    if (!follows(i + 1) || !follows(i + 2) || !follows(i + 3)) return 0;
    if (lead == 0xF0 && byte(i + 1) < 0x90) return 0;
    if (lead == 0xF4 && byte(i + 1) > 0x8F) return 0;
    return 4;
  }
  return 0;
}

}  // namespace

void append_json_string(std::string& out, std::string_view text) {
  static constexpr char hex[] = "0123456789abcdef";
  out += '"';
  for (std::size_t i = 0; i < text.size();) {
    // Keys and names usually need no escapes: all such characters are appended at once.
    if (const std::size_t plain = plain_length(text, i); plain > 0) {
      out.append(text, i, plain);
      i += plain;
      continue;
    }
    const char c = text[i];
    const auto u = static_cast<unsigned char>(c);
    if (u >= 0x80) {
      const std::size_t length = utf8_length(text, i);
      if (length == 0) {
        out += "\xEF\xBF\xBD";
        ++i;
      } else {
        out.append(text, i, length);
        i += length;
      }
      continue;
    }
    switch (c) {
      case '"': out += "\\\""; break;
      case '\\': out += "\\\\"; break;
      case '\n': out += "\\n"; break;
      case '\r': out += "\\r"; break;
      case '\t': out += "\\t"; break;
      default:
        out += "\\u00";
        out += hex[u >> 4U];
        out += hex[u & 0xFU];
    }
    ++i;
  }
  out += '"';
}

void JsonWriter::newline() {
  if (indent_ == 0) return;
  text_ += '\n';
  text_.append(open_.size() * static_cast<std::size_t>(indent_), ' ');
}

void JsonWriter::before_value() {
  if (after_key_) {
    after_key_ = false;
    return;
  }
  COSIVA_EXPECT(open_.empty() ? text_.empty() : open_.back() == '[');
  if (open_.empty()) return;
  if (!first_) text_ += ',';
  newline();
  first_ = false;
}

JsonWriter& JsonWriter::begin_object() {
  // The usual size of a message: growing to it by doubling would copy the text five times.
  constexpr std::size_t usual_bytes = 480;
  if (text_.empty()) text_.reserve(usual_bytes);
  before_value();
  text_ += '{';
  open_.push_back('{');
  first_ = true;
  return *this;
}

JsonWriter& JsonWriter::end_object() {
  COSIVA_EXPECT(!open_.empty() && open_.back() == '{' && !after_key_);
  open_.pop_back();
  if (!first_) newline();
  text_ += '}';
  first_ = false;
  return *this;
}

JsonWriter& JsonWriter::begin_array() {
  before_value();
  text_ += '[';
  open_.push_back('[');
  first_ = true;
  return *this;
}

JsonWriter& JsonWriter::end_array() {
  COSIVA_EXPECT(!open_.empty() && open_.back() == '[');
  open_.pop_back();
  if (!first_) newline();
  text_ += ']';
  first_ = false;
  return *this;
}

JsonWriter& JsonWriter::key(std::string_view name) {
  COSIVA_EXPECT(!open_.empty() && open_.back() == '{' && !after_key_);
  if (!first_) text_ += ',';
  newline();
  first_ = false;
  append_json_string(text_, name);
  text_ += indent_ == 0 ? ":" : ": ";
  after_key_ = true;
  return *this;
}

JsonWriter& JsonWriter::value(std::string_view text) {
  before_value();
  append_json_string(text_, text);
  return *this;
}

JsonWriter& JsonWriter::value(double number) {
  if (!std::isfinite(number)) return null();
  before_value();
  char buffer[32];
  // The shortest form would write 1e21 as a row of digits, which readers parse as an integer too large for 64 bits.
  const auto end = std::fabs(number) < 1e18
                       ? std::to_chars(buffer, buffer + sizeof buffer, number).ptr
                       : std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::scientific).ptr;
  text_.append(buffer, end);
  return *this;
}

JsonWriter& JsonWriter::value(bool flag) { return raw(flag ? "true" : "false"); }

JsonWriter& JsonWriter::null() { return raw("null"); }

JsonWriter& JsonWriter::raw(std::string_view json) {
  before_value();
  text_ += json;
  return *this;
}

JsonWriter& JsonWriter::integer(std::int64_t number) {
  before_value();
  char buffer[24];
  text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
  return *this;
}

JsonWriter& JsonWriter::unsigned_integer(std::uint64_t number) {
  before_value();
  char buffer[24];
  text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
  return *this;
}

}  // namespace cosiva
