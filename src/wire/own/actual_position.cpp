#include "cosiva/wire/own/actual_position.h"

#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {

using own::Fields;
using own::read_message;

namespace {

void read_names(Fields& in, std::string& session, std::uint32_t& sequence) {
  in.text("session", session);
  if (session.empty()) in.report_fault("session", "a name");
  in.whole("sequence", sequence);
}

}  // namespace

std::string to_json(const ActualPositionRequest& request) {
  JsonWriter json;
  json.begin_object().field("session", request.session).field("sequence", request.sequence);
  return json.end_object().take();
}

std::string to_json(const ActualPosition& position) {
  JsonWriter json;
  json.begin_object().field("session", position.session).field("sequence", position.sequence);
  json.field("at", to_iso8601(position.at)).field("x", position.X_MB.x_m).field("y", position.X_MB.y_m);
  json.field("heading", position.X_MB.heading_rad).field("uncertainty", position.uncertainty_m);
  return json.end_object().take();
}

Result<ActualPositionRequest> actual_position_request_from_json(std::string_view text) {
  return read_message<ActualPositionRequest>(
      text, [](Fields& in, ActualPositionRequest& request) { read_names(in, request.session, request.sequence); });
}

Result<ActualPosition> actual_position_from_json(std::string_view text) {
  return read_message<ActualPosition>(text, [](Fields& in, ActualPosition& position) {
    read_names(in, position.session, position.sequence);
    in.time("at", position.at);
    in.number("x", -own::position_m_max, own::position_m_max, position.X_MB.x_m);
    in.number("y", -own::position_m_max, own::position_m_max, position.X_MB.y_m);
    in.number("heading", -own::heading_rad_max, own::heading_rad_max, position.X_MB.heading_rad);
    in.number("uncertainty", 0.0, own::position_m_max, position.uncertainty_m);
    position.X_MB.heading_rad = wrap_angle(position.X_MB.heading_rad);
  });
}

}  // namespace cosiva::wire
