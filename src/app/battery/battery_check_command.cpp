#include "cosiva/app/battery/battery_check_command.h"

#include <string>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/battery_types.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {

int run_battery_check(const BatteryFilesArguments& arguments) {
  JsonWriter json;
  json.begin_object().key("files").begin_array();
  std::string text;
  bool all_good = true;
  for (const std::string& file : arguments.files) {
    const auto type = load_battery_type(file);
    all_good = all_good && type;
    json.begin_object()
        .field("file", file)
        .field("good", type.has_value())
        .field("error", type ? std::string{} : to_string(type.error()))
        .end_object();
    text += (text.empty() ? "" : "\n") +
            (type ? file + ": good: " + type->name + ", " + decimals(type->capacity_ah, 2) + " Ah, " + type->licence
                  : to_string(type.error()));
  }
  json.end_array().end_object();
  print(arguments.json ? json.text() : text);
  return all_good ? exit_done : exit_bad_input;
}

}  // namespace cosiva::app
