#include "cosiva/hmi/http_responses.h"

#include <array>
#include <string_view>
#include <utility>

namespace cosiva::app {

using adapters::http_error;
using adapters::HttpResponse;

HttpResponse json_response(std::string json, unsigned status) {
  return {status, "application/json", std::move(json), {}};
}

HttpResponse refusal(const Error& error) {
  using Case = std::pair<std::string_view, unsigned>;
  static constexpr std::array cases{Case{"command.impossible", 409},
                                    Case{"edit.undo", 409},
                                    Case{"edit.redo", 409},
                                    Case{"edit.zone", 409},
                                    Case{"plant.zone", 409},
                                    Case{"virtual_object.zone", 409},
                                    Case{"battery.not_requested", 409},
                                    Case{"virtual_object.room", 409},
                                    Case{"virtual_object.many", 429},
                                    Case{"virtual_object.unknown", 404}};
  unsigned status = 400;
  for (const auto& [code, meant] : cases)
    if (error.code == code) status = meant;
  return http_error(status, error.code, to_string(error));
}

void write_json(JsonWriter& json, const JsonValue& value) {
  if (const bool* flag = value.flag()) {
    json.value(*flag);
  } else if (const double* number = value.number()) {
    json.value(*number);
  } else if (const std::string* text = value.text()) {
    json.value(*text);
  } else if (const JsonValue::Array* array = value.array()) {
    json.begin_array();
    for (const JsonValue& element : *array) write_json(json, element);
    json.end_array();
  } else if (const JsonValue::Object* object = value.object()) {
    json.begin_object();
    for (const auto& [name, member] : *object) write_json(json.key(name), member);
    json.end_object();
  } else {
    json.null();
  }
}

}  // namespace cosiva::app
