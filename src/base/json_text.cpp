#include "cosiva/base/json_text.h"

namespace cosiva {

void write_json(JsonWriter& json, const JsonValue& value) {
  if (const bool* flag = value.flag()) {
    json.value(*flag);
  } else if (const double* number = value.number()) {
    json.value(*number);
  } else if (const std::string* text = value.text()) {
    json.value(*text);
  } else if (const JsonValue::Array* items = value.array()) {
    json.begin_array();
    for (const JsonValue& item : *items) write_json(json, item);
    json.end_array();
  } else if (const JsonValue::Object* members = value.object()) {
    json.begin_object();
    for (const auto& [name, member] : *members) write_json(json.key(name), member);
    json.end_object();
  } else {
    json.null();
  }
}

std::string to_text(const JsonValue& value) {
  JsonWriter json;
  write_json(json, value);
  return json.take();
}

}  // namespace cosiva
