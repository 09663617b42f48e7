#include "cosiva/zone/lif/lif_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cosiva::zone::lif {
namespace {

std::string shortest(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

/// "0.55", also "0,55" with a decimal comma.
std::optional<double> number_in(std::string text) {
  std::replace(text.begin(), text.end(), ',', '.');
  const auto begin = text.find_first_not_of(" \t+");
  if (begin == std::string::npos) return std::nullopt;
  const auto end = text.find_last_not_of(" \t") + 1;
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data() + begin, text.data() + end, value);
  if (error != std::errc{} || stop != text.data() + end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

const JsonValue* LifFields::find(std::string_view key) const {
  const JsonValue* value = value_->find(key);
  return value == nullptr || value->is_null() ? nullptr : value;
}

bool LifFields::has(std::string_view key) const { return find(key) != nullptr; }

std::optional<std::string> LifFields::text() const {
  if (const std::string* text = value_->text()) return *text;
  if (const double* number = value_->number()) {
    diagnostics_->add(Diagnostic::Kind::mended, location_.text(),
                      "a number where a text belongs is taken as that text");
    return shortest(*number);
  }
  diagnostics_->add(Diagnostic::Kind::mended, location_.text(), "no text where one belongs; taken as absent");
  return std::nullopt;
}

std::optional<double> LifFields::number() const {
  if (const double* number = value_->number()) return *number;
  if (const std::string* text = value_->text()) {
    if (const auto number = number_in(*text)) {
      diagnostics_->add(Diagnostic::Kind::mended, location_.text(),
                        "a text where a number belongs is taken as that number",
                        std::string(location_.key) + " is a text");
      return number;
    }
  }
  diagnostics_->add(Diagnostic::Kind::mended, location_.text(), "no number where one belongs; taken as absent");
  return std::nullopt;
}

std::optional<std::string> LifFields::text(std::string_view key) const {
  const JsonValue* value = find(key);
  return value == nullptr ? std::nullopt : member(key, *value).text();
}

std::optional<double> LifFields::number(std::string_view key) const {
  const JsonValue* value = find(key);
  return value == nullptr ? std::nullopt : member(key, *value).number();
}

std::optional<bool> LifFields::flag(std::string_view key) const {
  const JsonValue* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (const bool* flag = value->flag()) return *flag;
  std::optional<bool> meant;
  if (const std::string* text = value->text()) {
    if (*text == "true" || *text == "True" || *text == "TRUE") meant = true;
    if (*text == "false" || *text == "False" || *text == "FALSE") meant = false;
  }
  if (const double* number = value->number(); number != nullptr && (*number == 0.0 || *number == 1.0))
    meant = *number == 1.0;
  record(Diagnostic::Kind::mended, key,
         meant ? "neither true nor false, but its meaning is clear" : "neither true nor false; taken as absent");
  return meant;
}

LifFields LifFields::object(std::string_view key) const {
  static const JsonValue nothing;
  const JsonValue* value = find(key);
  if (value == nullptr) return member(key, nothing);
  if (value->object() == nullptr) {
    record(Diagnostic::Kind::mended, key, "no object where one belongs; taken as absent");
    return member(key, nothing);
  }
  return member(key, *value);
}

void LifFields::mend_list(std::string_view key) const {
  const bool single = find(key)->object() != nullptr;
  record(Diagnostic::Kind::mended, key,
         single ? "a single object where a list belongs is taken as a list of one"
                : "no list where one belongs; taken as absent");
}

void LifFields::known(std::initializer_list<std::string_view> keys) const {
  const JsonValue::Object* members = value_->object();
  if (members == nullptr) return;
  for (const auto& [name, member] : *members) {
    if (std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
    const std::string shown = name.substr(0, 64);
    record(Diagnostic::Kind::lost, shown,
           "'" + shown + "' is no field of LIF " + diagnostics_->version() + "; not taken");
  }
}

void LifFields::lose(std::string_view key, std::string_view why) const {
  if (!has(key)) return;
  std::string text = "'";
  text.append(key).append("' is not taken: ").append(why);
  record(Diagnostic::Kind::lost, key, std::move(text));
}

void LifFields::record(Diagnostic::Kind kind, std::string_view key, std::string text, std::string sort) const {
  diagnostics_->add(kind, location(key), std::move(text), std::move(sort));
}

std::string LifFields::location(std::string_view key) const {
  return key.empty() ? location_.text() : JsonLocation{&location_, key, 0}.text();
}

}  // namespace cosiva::zone::lif
