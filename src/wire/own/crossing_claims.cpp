#include "cosiva/wire/own/crossing_claims.h"

#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {
namespace {

using namespace own;

constexpr std::uint32_t priority_max = 999;

void read_identity(Fields& in, VehicleId& vehicle) {
  in.text("manufacturer", vehicle.manufacturer);
  in.text("serialNumber", vehicle.serial_number);
  if (!valid_serial_number(vehicle.manufacturer)) in.report_fault("manufacturer", "A-Z a-z 0-9 _ . : -");
  if (!valid_serial_number(vehicle.serial_number)) in.report_fault("serialNumber", "A-Z a-z 0-9 _ . : -");
}

void read_claim(Fields& in, CrossingClaims::Claim& claim) {
  in.whole("id", claim.id);
  in.whole("stamp", claim.stamp);
  in.whole("priority", claim.priority);
  if (claim.priority > priority_max) in.report_fault("priority", "a whole number from 0 to 999");
  in.flag("granted", claim.granted);
  in.list("crossings", CrossingClaims::crossings_max, [&](const JsonValue& item, const std::string& name) {
    const std::string* crossing = item.text();
    if (crossing == nullptr || crossing->size() > text_bytes_max)
      return in.report_fault(name, "a crossing's name of at most " + std::to_string(text_bytes_max) + " bytes");
    claim.crossings.push_back(*crossing);
  });
}

}  // namespace

std::string to_json(const CrossingClaims& claims) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", claims.header_id)
      .field("timestamp", to_iso8601(claims.timestamp))
      .field("mapId", claims.map_id)
      .field("manufacturer", claims.vehicle.manufacturer)
      .field("serialNumber", claims.vehicle.serial_number)
      .field("x", claims.position.x_m)
      .field("y", claims.position.y_m)
      .field("clock", claims.clock);
  if (claims.claim) {
    json.key("claim")
        .begin_object()
        .field("id", claims.claim->id)
        .field("stamp", claims.claim->stamp)
        .field("priority", claims.claim->priority)
        .field("granted", claims.claim->granted)
        .key("crossings")
        .begin_array();
    for (const std::string& crossing : claims.claim->crossings) json.value(crossing);
    json.end_array().end_object();
  }
  json.key("yields").begin_array();
  for (const CrossingClaims::Yield& yield : claims.yields) {
    json.begin_object()
        .field("manufacturer", yield.vehicle.manufacturer)
        .field("serialNumber", yield.vehicle.serial_number)
        .field("claim", yield.claim)
        .end_object();
  }
  return json.end_array().end_object().take();
}

Result<CrossingClaims> crossing_claims_from_json(std::string_view text) {
  return read_message<CrossingClaims>(text, [](Fields& in, CrossingClaims& claims) {
    in.whole("headerId", claims.header_id);
    in.time("timestamp", claims.timestamp);
    in.text("mapId", claims.map_id);
    read_identity(in, claims.vehicle);
    in.number("x", -position_m_max, position_m_max, claims.position.x_m);
    in.number("y", -position_m_max, position_m_max, claims.position.y_m);
    in.whole("clock", claims.clock);
    read_part(in, "claim", claims.claim, read_claim);
    in.list("yields", CrossingClaims::yields_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      CrossingClaims::Yield& yield = claims.yields.emplace_back();
      read_identity(fields, yield.vehicle);
      fields.whole("claim", yield.claim);
      in.take_over(fields.error());
    });
  });
}

}  // namespace cosiva::wire
