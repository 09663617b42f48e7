#include "wire/battery_exchange.h"

#include "base/json_writer.h"
#include "wire/own_fields.h"

namespace cosiva::wire {

using own::Fields;
using own::read_message;

std::string to_json(const BatteryChange& change) {
  JsonWriter json;
  json.begin_object().field("battery", change.battery).field("run", change.run).field("reason", change.reason);
  return json.end_object().take();
}

std::string to_json(const BatteryReady& ready) {
  JsonWriter json;
  json.begin_object().field("battery", ready.battery).field("type", ready.type).field("cycles", ready.cycles);
  json.field("rest_s", ready.rest_s).field("temperature", ready.temperature_c).field("charge", ready.charge_percent);
  return json.end_object().take();
}

Result<BatteryChange> battery_change_from_json(std::string_view text) {
  return read_message<BatteryChange>(text, [](Fields& in, BatteryChange& change) {
    in.text("battery", change.battery);
    in.whole("run", change.run);
    in.text("reason", change.reason);
  });
}

Result<BatteryReady> battery_ready_from_json(std::string_view text) {
  return read_message<BatteryReady>(text, [](Fields& in, BatteryReady& ready) {
    in.text("battery", ready.battery);
    if (ready.battery.empty()) in.complain("battery", "its id");
    in.text("type", ready.type);
    in.number("cycles", 0.0, 1e6, ready.cycles);
    in.number("rest_s", 0.0, 1e9, ready.rest_s);
    in.number("temperature", -100.0, 200.0, ready.temperature_c);
    in.number("charge", 0.0, 100.0, ready.charge_percent);
  });
}

}  // namespace cosiva::wire
