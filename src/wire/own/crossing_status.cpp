#include "cosiva/wire/own/crossing_status.h"

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {
namespace {

using namespace own;

constexpr double millisecond_s = 1e-3;

void write_identity(JsonWriter& json, const VehicleId& id) {
  json.field("manufacturer", id.manufacturer).field("serialNumber", id.serial_number);
}

void read_identity(Fields& in, VehicleId& id) {
  in.text("manufacturer", id.manufacturer);
  in.text("serialNumber", id.serial_number);
  if (!valid_serial_number(id.manufacturer)) in.report_fault("manufacturer", "A-Z a-z 0-9 _ . : -");
  if (!valid_serial_number(id.serial_number)) in.report_fault("serialNumber", "A-Z a-z 0-9 _ . : -");
}

void write_vehicles(JsonWriter& json, std::string_view field, const std::vector<CrossingStatus::Vehicle>& vehicles) {
  json.key(field).begin_array();
  for (const CrossingStatus::Vehicle& one : vehicles) {
    json.begin_object();
    write_identity(json, one.vehicle);
    json.field("age", static_cast<double>(one.age_ms) * millisecond_s).end_object();
  }
  json.end_array();
}

void read_vehicles(Fields& in, std::string_view field, std::vector<CrossingStatus::Vehicle>& vehicles) {
  in.list(field, CrossingStatus::vehicles_max, [&](const JsonValue& item, const std::string& name) {
    Fields fields{item, name + "."};
    CrossingStatus::Vehicle& one = vehicles.emplace_back();
    read_identity(fields, one.vehicle);
    fields.counted("age", millisecond_s, one.age_ms);
    in.take_over(fields.error());
  });
}

}  // namespace

std::string to_json(const CrossingStatus& status) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", status.header_id)
      .field("timestamp", to_iso8601(status.timestamp))
      .field("mapId", status.map_id);
  write_identity(json, status.unit);
  json.field("crossing", status.crossing).field("x", status.centre.x_m).field("y", status.centre.y_m);
  json.field("online", status.online);
  write_vehicles(json, "holders", status.holders);
  write_vehicles(json, "waiting", status.waiting);
  return json.end_object().take();
}

Result<CrossingStatus> crossing_status_from_json(std::string_view text) {
  return read_message<CrossingStatus>(text, [](Fields& in, CrossingStatus& status) {
    in.whole("headerId", status.header_id);
    in.time("timestamp", status.timestamp);
    in.text("mapId", status.map_id);
    read_identity(in, status.unit);
    in.text("crossing", status.crossing);
    in.number("x", -position_m_max, position_m_max, status.centre.x_m);
    in.number("y", -position_m_max, position_m_max, status.centre.y_m);
    in.flag("online", status.online);
    read_vehicles(in, "holders", status.holders);
    read_vehicles(in, "waiting", status.waiting);
  });
}

std::string to_json(const UnitSwitch& command) {
  JsonWriter json;
  return json.begin_object().field("crossing", command.crossing).field("on", command.on).end_object().take();
}

Result<UnitSwitch> unit_switch_from_json(std::string_view text) {
  return read_message<UnitSwitch>(text, [](Fields& in, UnitSwitch& command) {
    in.text("crossing", command.crossing);
    in.flag("on", command.on);
  });
}

}  // namespace cosiva::wire
