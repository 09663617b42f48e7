#include "cosiva/wire/own/own_messages.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {
namespace {

using namespace own;

constexpr std::size_t lines_max = 8;  ///< boards in a report
constexpr std::size_t beams_max = 32;

void read_body(Fields& in, Body& body) {
  in.text("id", body.id);
  in.text("kind", body.kind);
  in.number("x", -position_m_max, position_m_max, body.x_m);
  in.number("y", -position_m_max, position_m_max, body.y_m);
  in.number("heading", -heading_rad_max, heading_rad_max, body.heading_rad);
  in.number("length", 0.0, size_m_max, body.length_m);
  in.number("radius", 0.0, size_m_max, body.radius_m);
  in.number("vx", -speed_mps_max, speed_mps_max, body.vx_mps);
  in.number("vy", -speed_mps_max, speed_mps_max, body.vy_mps);
}

std::optional<Board> parse_board(std::string_view word) {
  for (const Board board : all_boards) {
    if (to_string(board) == word) return board;
  }
  return std::nullopt;
}

std::string hex(std::uint32_t number) {
  char text[9];
  static_cast<void>(std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(number)));
  return text;
}

std::optional<std::uint32_t> parse_hex(std::string_view text) {
  if (text.size() != 8) return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit && !(c >= 'a' && c <= 'f')) return std::nullopt;
    number = number << 4U | static_cast<std::uint32_t>(digit ? c - '0' : c - 'a' + 10);
  }
  return number;
}

/// The number of a term in an enumeration that begins with `first`.
template <typename Term>
void read_term(Fields& in, const char* field, unsigned first, std::size_t count, Term& term) {
  std::string word;
  in.text(field, word);
  for (unsigned i = first; i < first + count; ++i) {
    if (to_string(static_cast<Term>(i)) != word) continue;
    term = static_cast<Term>(i);
    return;
  }
  in.report_fault(field, "a term of docs/protocols/module-link.md");
}

void read_part_finding(Fields& in, PartFinding& part) {
  read_term(in, "part", 1, part_count, part.part);
  read_term(in, "finding", 0, finding_count, part.finding);
}

void read_line(Fields& in, BoardsReport::Line& line) {
  std::string word;
  in.text("board", word);
  const auto board = parse_board(word);
  if (!board) in.report_fault("board", "PILS, PRAV, DOBS or RALI");
  line.board = board.value_or(Board{});
  in.text("health", line.health);
  if (line.health != "ok" && line.health != "lost" && line.health != "faulty" && line.health != "absent")
    in.report_fault("health", "ok, lost, faulty or absent");
  in.text("firmware", word);
  const auto firmware = parse_hex(word);
  if (!firmware) in.report_fault("firmware", "eight hexadecimal digits");
  line.firmware_hash = firmware.value_or(0);
  in.whole("uptime_ms", line.uptime_ms);
  in.whole("frames", line.frames);
  in.whole("framesBad", line.frames_bad);
  in.whole("framesMissed", line.frames_missed);
  in.whole("selfTest", line.self_test);
  if (!in.has("parts")) return;
  in.list("parts", part_count, [&](const JsonValue& item, const std::string& name) {
    Fields fields{item, in.location(name) + "."};
    read_part_finding(fields, line.parts.emplace_back());
    in.take_over(fields.error());
  });
}

void read_proxy(Fields& in, ProxyCounts& proxy) {
  in.text("agent", proxy.agent);
  in.whole("sent", proxy.sent);
  in.whole("delivered", proxy.delivered);
}

void read_pils(Fields& in, PilsParts& parts) {
  in.counted("supply", 1e-3, parts.supply_mv);
  in.whole("plugs", parts.plugs);
  std::size_t count = 0;
  in.list("dems", PilsParts::sensors, [&](const JsonValue& item, const std::string& name) {
    const double* reading = item.number();
    if (reading == nullptr || !(*reading >= 0.0 && *reading <= 255.0) || *reading != std::floor(*reading))
      return in.report_fault(name, "a whole number from 0 to 255");
    parts.reading[count++] = static_cast<std::uint8_t>(*reading);
  });
  if (count != PilsParts::sensors) in.report_fault("dems", "8 readings");
  in.counted("leftSpeed", 1e-3, parts.left.speed_mmps);
  in.counted("leftCurrent", 1e-3, parts.left.current_ma);
  in.counted("rightSpeed", 1e-3, parts.right.speed_mmps);
  in.counted("rightCurrent", 1e-3, parts.right.current_ma);
}

void read_power(Fields& in, Power& power) {
  in.counted("voltage", 1e-3, power.voltage_mv);
  in.counted("current", 1e-3, power.current_ma);
  in.counted("temperature", 0.1, power.temperature_01C);
  in.counted("charge", 0.1, power.charge_permille);
  if (!in.has("chargeStdDev")) return;
  power.gauge = Power::Gauge{};
  in.counted("chargeFine", 1e-4, power.gauge->charge_ppm);
  in.counted("chargeStdDev", 0.01, power.gauge->charge_sd_01);
}

void read_ranges(Fields& in, Ranges& ranges) {
  in.counted("first", 0.01, ranges.first_bearing_crad);
  in.counted("width", 0.01, ranges.beam_width_crad);
  in.list("m", beams_max, [&](const JsonValue& item, const std::string& name) {
    constexpr double range_m_max = 65.534;
    const double* range_m = item.number();
    if (!item.is_null() && (range_m == nullptr || !(*range_m >= 0.0 && *range_m <= range_m_max)))
      return in.report_fault(name, "metres from 0 to 65.534, or null");
    ranges.range_mm.push_back(range_m == nullptr ? no_echo
                                                 : static_cast<std::uint16_t>(std::nearbyint(*range_m * 1e3)));
  });
}

}  // namespace

std::string to_json(const VirtualObstacles& ahead) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", ahead.header_id)
      .field("timestamp", to_iso8601(ahead.timestamp))
      .field("mapId", ahead.map_id)
      .key("bodies")
      .begin_array();
  for (const Body& body : ahead.bodies) {
    json.begin_object()
        .field("id", body.id)
        .field("kind", body.kind)
        .field("x", body.x_m)
        .field("y", body.y_m)
        .field("heading", body.heading_rad)
        .field("length", body.length_m)
        .field("radius", body.radius_m)
        .field("vx", body.vx_mps)
        .field("vy", body.vy_mps)
        .end_object();
  }
  return json.end_array().end_object().take();
}

Result<VirtualObstacles> virtual_obstacles_from_json(std::string_view text) {
  return read_message<VirtualObstacles>(text, [](Fields& in, VirtualObstacles& ahead) {
    in.whole("headerId", ahead.header_id);
    in.time("timestamp", ahead.timestamp);
    in.text("mapId", ahead.map_id);
    in.list("bodies", VirtualObstacles::bodies_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      read_body(fields, ahead.bodies.emplace_back());
      in.take_over(fields.error());
    });
  });
}

std::string to_json(const VirtualObstaclesAck& perceived) {
  JsonWriter json;
  json.begin_object()
      .field("virtualObstaclesHeaderId", perceived.virtual_obstacles_header_id)
      .field("decided", to_iso8601(perceived.decided))
      .field("braking", perceived.braking)
      .field("body", perceived.body);
  if (perceived.distance_m) json.field("distance", *perceived.distance_m);
  return json.end_object().take();
}

Result<VirtualObstaclesAck> virtual_obstacles_ack_from_json(std::string_view text) {
  return read_message<VirtualObstaclesAck>(text, [](Fields& in, VirtualObstaclesAck& perceived) {
    in.whole("virtualObstaclesHeaderId", perceived.virtual_obstacles_header_id);
    in.time("decided", perceived.decided);
    in.flag("braking", perceived.braking);
    in.text("body", perceived.body);
    in.number("distance", 0.0, position_m_max, perceived.distance_m);
  });
}

std::string to_json(const DetectedObstacleReport& detected) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", detected.header_id)
      .field("timestamp", to_iso8601(detected.timestamp))
      .field("mapId", detected.map_id);
  if (detected.obstacle) {
    json.key("obstacle")
        .begin_object()
        .field("x", detected.obstacle->x_m)
        .field("y", detected.obstacle->y_m)
        .field("radius", detected.obstacle->radius_m)
        .field("distance", detected.obstacle->distance_m)
        .end_object();
  }
  return json.field("clear", detected.clear_m).end_object().take();
}

Result<DetectedObstacleReport> detected_obstacle_from_json(std::string_view text) {
  return read_message<DetectedObstacleReport>(text, [](Fields& in, DetectedObstacleReport& detected) {
    in.whole("headerId", detected.header_id);
    in.time("timestamp", detected.timestamp);
    in.text("mapId", detected.map_id);
    read_part(in, "obstacle", detected.obstacle, [](Fields& fields, DetectedObstacleReport::Obstacle& obstacle) {
      fields.number("x", -position_m_max, position_m_max, obstacle.x_m);
      fields.number("y", -position_m_max, position_m_max, obstacle.y_m);
      fields.number("radius", 0.0, size_m_max, obstacle.radius_m);
      fields.number("distance", 0.0, position_m_max, obstacle.distance_m);
    });
    in.number("clear", 0.0, position_m_max, detected.clear_m);
  });
}

void write_pils(JsonWriter& json, const PilsParts& parts) {
  json.begin_object().field("supply", parts.supply_mv / 1000.0).field("plugs", parts.plugs).key("dems").begin_array();
  for (const std::uint8_t reading : parts.reading) json.value(reading);
  json.end_array()
      .field("leftSpeed", parts.left.speed_mmps / 1000.0)
      .field("leftCurrent", parts.left.current_ma / 1000.0)
      .field("rightSpeed", parts.right.speed_mmps / 1000.0)
      .field("rightCurrent", parts.right.current_ma / 1000.0)
      .end_object();
}

std::string to_json(const BoardsReport& report) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", report.header_id)
      .field("timestamp", to_iso8601(report.timestamp))
      .key("boards")
      .begin_array();
  for (const BoardsReport::Line& line : report.boards) {
    json.begin_object()
        .field("board", to_string(line.board))
        .field("health", line.health)
        .field("firmware", hex(line.firmware_hash))
        .field("uptime_ms", line.uptime_ms)
        .field("frames", line.frames)
        .field("framesBad", line.frames_bad)
        .field("framesMissed", line.frames_missed)
        .field("selfTest", line.self_test);
    if (!line.parts.empty()) {
      json.key("parts").begin_array();
      for (const PartFinding& part : line.parts)
        json.begin_object().field("part", to_string(part.part)).field("finding", to_string(part.finding)).end_object();
      json.end_array();
    }
    json.end_object();
  }
  json.end_array();
  // Divided, not multiplied: 7.4 stays 7.4 and not 7.4000000000000004.
  if (const auto& power = report.power) {
    json.key("power")
        .begin_object()
        .field("voltage", power->voltage_mv / 1000.0)
        .field("current", power->current_ma / 1000.0)
        .field("temperature", power->temperature_01C / 10.0)
        .field("charge", power->charge_permille / 10.0);
    if (const auto& gauge = power->gauge)
      json.field("chargeFine", gauge->charge_ppm / 10'000.0).field("chargeStdDev", gauge->charge_sd_01 / 100.0);
    json.end_object();
  }
  if (const auto& ranges = report.ranges) {
    json.key("ranges")
        .begin_object()
        .field("first", ranges->first_bearing_crad / 100.0)
        .field("width", ranges->beam_width_crad / 100.0)
        .key("m")
        .begin_array();
    for (const std::uint16_t range_mm : ranges->range_mm) {
      if (range_mm == no_echo)
        json.null();
      else
        json.value(range_mm / 1000.0);
    }
    json.end_array().end_object();
  }
  if (const auto& pils = report.pils) write_pils(json.key("pils"), *pils);
  if (!report.affi.empty()) json.field("affi", report.affi);
  if (!report.proxies.empty()) {
    json.key("proxies").begin_array();
    for (const ProxyCounts& proxy : report.proxies) {
      json.begin_object()
          .field("agent", proxy.agent)
          .field("sent", proxy.sent)
          .field("delivered", proxy.delivered)
          .end_object();
    }
    json.end_array();
  }
  return json.end_object().take();
}

Result<BoardsReport> boards_report_from_json(std::string_view text) {
  return read_message<BoardsReport>(text, [](Fields& in, BoardsReport& report) {
    in.whole("headerId", report.header_id);
    in.time("timestamp", report.timestamp);
    in.list("boards", lines_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      read_line(fields, report.boards.emplace_back());
      in.take_over(fields.error());
    });
    read_part(in, "power", report.power, read_power);
    read_part(in, "ranges", report.ranges, read_ranges);
    read_part(in, "pils", report.pils, read_pils);
    if (in.has("affi")) in.text("affi", report.affi);
    if (!in.has("proxies")) return;
    in.list("proxies", BoardsReport::proxies_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      read_proxy(fields, report.proxies.emplace_back());
      in.take_over(fields.error());
    });
  });
}

std::string to_json(const Radio& radio) {
  JsonWriter json;
  json.begin_object().field("vehicle", radio.vehicle).field("loss", radio.loss).end_object();
  return json.take();
}

Result<Radio> radio_from_json(std::string_view text) {
  return read_message<Radio>(text, [](Fields& in, Radio& radio) {
    in.text("vehicle", radio.vehicle);
    if (radio.vehicle.empty()) in.report_fault("vehicle", "a vehicle such as CoSiVA/AIV1, or *");
    in.number("loss", 0.0, 1.0, radio.loss);
  });
}

}  // namespace cosiva::wire
