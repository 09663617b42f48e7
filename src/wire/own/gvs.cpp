#include "cosiva/wire/own/gvs.h"

#include <array>
#include <optional>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {
namespace {

using namespace own;

/// 256 detections of some 200 bytes.
constexpr std::size_t detections_bytes_max = 96U << 10U;
constexpr double period_s_max = 3600.0;

constexpr std::array<std::pair<ConnectionState, std::string_view>, 3> terms{
    {{ConnectionState::online, "ONLINE"},
     {ConnectionState::offline, "OFFLINE"},
     {ConnectionState::connection_broken, "CONNECTIONBROKEN"}}};

std::string_view word_of(ConnectionState state) {
  for (const auto& [known, word] : terms)
    if (known == state) return word;
  return "?";
}

std::optional<ConnectionState> state_of(std::string_view published) {
  for (const auto& [known, word] : terms)
    if (word == published) return known;
  return std::nullopt;
}

/// No longer than a reader takes, and no character cut in two.
std::string_view cut(std::string_view text) {
  if (text.size() <= text_bytes_max) return text;
  std::size_t end = text_bytes_max;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end);
}

void read_detection(Fields& in, GvsDetections::Detection& detection) {
  in.text("vehicle", detection.vehicle);
  in.whole("tag", detection.tag);
  in.time("at", detection.at);
  in.number("x", -position_m_max, position_m_max, detection.pose.x_m);
  in.number("y", -position_m_max, position_m_max, detection.pose.y_m);
  in.number("heading", -heading_rad_max, heading_rad_max, detection.pose.heading_rad);
  in.number("uncertainty", 0.0, position_m_max, detection.uncertainty_m);
  detection.pose.heading_rad = wrap_angle(detection.pose.heading_rad);
}

void read_corner(Fields& in, const JsonValue& item, const std::string& name, Point2& corner) {
  const JsonValue::Array* pair = item.array();
  const bool two = pair != nullptr && pair->size() == 2;
  const double* x = two ? (*pair)[0].number() : nullptr;
  const double* y = two ? (*pair)[1].number() : nullptr;
  const auto near = [](const double* m) { return m != nullptr && *m >= -position_m_max && *m <= position_m_max; };
  if (!near(x) || !near(y)) return in.report_fault(name, "a position [x, y] within 100 km");
  corner = {*x, *y};
}

}  // namespace

std::string to_json(const GvsDetections& detections) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", detections.header_id)
      .field("timestamp", to_iso8601(detections.timestamp))
      .field("period", detections.period_s)
      .key("detections")
      .begin_array();
  for (const GvsDetections::Detection& detection : detections.detections) {
    json.begin_object()
        .field("vehicle", detection.vehicle)
        .field("tag", detection.tag)
        .field("at", to_iso8601(detection.at))
        .field("x", detection.pose.x_m)
        .field("y", detection.pose.y_m)
        .field("heading", detection.pose.heading_rad)
        .field("uncertainty", detection.uncertainty_m)
        .end_object();
  }
  json.end_array().key("field").begin_array();
  for (const Point2& corner : detections.field) json.begin_array().value(corner.x_m).value(corner.y_m).end_array();
  return json.end_array().end_object().take();
}

Result<GvsDetections> gvs_detections_from_json(std::string_view text) {
  return read_message<GvsDetections>(
      text,
      [](Fields& in, GvsDetections& detections) {
        in.whole("headerId", detections.header_id);
        in.time("timestamp", detections.timestamp);
        in.number("period", 0.0, period_s_max, detections.period_s);
        in.list("detections", GvsDetections::detections_max, [&](const JsonValue& item, const std::string& name) {
          Fields fields{item, name + "."};
          read_detection(fields, detections.detections.emplace_back());
          in.take_over(fields.error());
        });
        in.list("field", GvsDetections::corners_max, [&](const JsonValue& item, const std::string& name) {
          read_corner(in, item, name, detections.field.emplace_back());
        });
      },
      detections_bytes_max);
}

std::string to_json(const GvsConnection& connection) {
  JsonWriter json;
  json.begin_object()
      .field("connectionState", word_of(connection.state))
      .field("timestamp", to_iso8601(connection.timestamp))
      .field("source", cut(connection.source))
      .field("trouble", cut(connection.trouble));
  return json.end_object().take();
}

Result<GvsConnection> gvs_connection_from_json(std::string_view text) {
  return read_message<GvsConnection>(text, [](Fields& in, GvsConnection& connection) {
    std::string state;
    in.text("connectionState", state);
    const auto known = state_of(state);
    if (!known) in.report_fault("connectionState", "ONLINE, OFFLINE or CONNECTIONBROKEN");
    connection.state = known.value_or(ConnectionState{});
    in.time("timestamp", connection.timestamp);
    in.text("source", connection.source);
    in.text("trouble", connection.trouble);
  });
}

}  // namespace cosiva::wire
