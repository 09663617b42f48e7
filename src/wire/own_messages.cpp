#include "wire/own_messages.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <limits>

#include "base/json_value.h"
#include "base/json_writer.h"

namespace cosiva::wire {
namespace {

constexpr std::size_t bytes_max = 16U << 10U;
constexpr std::size_t text_bytes_max = 128;
constexpr std::size_t lines_max = 8;  ///< boards in a report
constexpr std::size_t beams_max = 32;
constexpr double place_m_max = 1e5;
constexpr double size_m_max = 10.0;
constexpr double speed_mps_max = 100.0;
constexpr double heading_rad_max = 100.0;
/// Whole numbers of a double are exact up to here.
constexpr double whole_max = 9007199254740992.0;

/// Reads the fields of one object. The first fault is kept and everything after it is empty, so that a message reads as
/// a list of its fields, and `error` is asked once at the end.
class Fields {
 public:
  /// @param where  of this object in the message, such as "bodies.2."
  explicit Fields(const JsonValue& json, std::string where = {}) : json_{json}, where_{std::move(where)} {
    if (json_.object() == nullptr) complain("", "an object");
  }

  void number(std::string_view field, double low, double high, double& out) {
    if (const JsonValue* value = required(field)) take_number(*value, field, low, high, out);
  }
  /// For a field that may be missing, or null.
  void number(std::string_view field, double low, double high, std::optional<double>& out) {
    const JsonValue* value = optional(field);
    double read = 0.0;
    if (value != nullptr && take_number(*value, field, low, high, read)) out = read;
  }
  /// A number told in `unit`s, counted in whole ones inside.
  template <std::integral T>
  void counted(std::string_view field, double unit, T& out) {
    double read = 0.0;
    constexpr auto low = static_cast<double>(std::numeric_limits<T>::min());
    constexpr auto high = static_cast<double>(std::numeric_limits<T>::max());
    number(field, low * unit, high * unit, read);
    out = static_cast<T>(std::clamp(std::nearbyint(read / unit), low, high));
  }
  template <std::unsigned_integral T>
  void whole(std::string_view field, T& out) {
    double read = 0.0;
    number(field, 0.0, std::min(whole_max, static_cast<double>(std::numeric_limits<T>::max())), read);
    if (std::floor(read) != read) return complain(field, "a whole number");
    out = static_cast<T>(read);
  }
  void text(std::string_view field, std::string& out) {
    const JsonValue* value = required(field);
    if (value == nullptr) return;
    const std::string* read = value->text();
    if (read == nullptr || read->size() > text_bytes_max)
      return complain(field, "a text of at most " + std::to_string(text_bytes_max) + " bytes");
    out = *read;
  }
  void flag(std::string_view field, bool& out) {
    const JsonValue* value = required(field);
    if (value == nullptr) return;
    if (value->flag() == nullptr) return complain(field, "true or false");
    out = *value->flag();
  }
  void time(std::string_view field, SimTime& out) {
    std::string read;
    text(field, read);
    if (error_) return;
    const auto parsed = parse_iso8601(read);
    if (!parsed) return complain(field, "an ISO 8601 time");
    out = *parsed;
  }
  /// Calls `take(item, name)` for each item of a list; the name is relative to this object, "bodies.2".
  template <typename Take>
  void list(std::string_view field, std::size_t count_max, Take take) {
    const JsonValue* value = required(field);
    if (value == nullptr) return;
    const JsonValue::Array* items = value->array();
    if (items == nullptr || items->size() > count_max)
      return complain(field, "a list of at most " + std::to_string(count_max));
    for (std::size_t i = 0; i < items->size() && !error_; ++i)
      take((*items)[i], std::string(field) + "." + std::to_string(i));
  }
  /// Nothing where the field is missing or null, or something was wrong before.
  [[nodiscard]] const JsonValue* optional(std::string_view field) {
    if (error_) return nullptr;
    const JsonValue* value = json_.find(field);
    return value == nullptr || value->is_null() ? nullptr : value;
  }
  void complain(std::string_view field, std::string expected) {
    if (!error_) error_ = Error{"own.field", "expected " + std::move(expected), where_ + std::string(field)};
  }
  void take_over(std::optional<Error> inner) {
    if (!error_) error_ = std::move(inner);
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  [[nodiscard]] const JsonValue* required(std::string_view field) {
    if (error_) return nullptr;
    const JsonValue* value = json_.find(field);
    if (value == nullptr) complain(field, "this field");
    return value;
  }
  bool take_number(const JsonValue& value, std::string_view field, double low, double high, double& out) {
    const double* read = value.number();
    if (read == nullptr || !(*read >= low && *read <= high)) {
      char range[80];
      const int length = std::snprintf(range, sizeof range, "a number from %.10g to %.10g", low, high);
      complain(field, std::string(range, static_cast<std::size_t>(length)));
      return false;
    }
    out = *read + 0.0;  // no minus zero: it is written as "-0", an integer, and comes back as plain zero
    return true;
  }

  const JsonValue& json_;
  std::string where_;
  std::optional<Error> error_;
};

/// Parses the text, lets `read(fields, message)` take the fields, and gives the message or the first fault.
template <typename Message, typename Read>
Result<Message> read_message(std::string_view text, Read read) {
  const auto json = JsonValue::parse(text, bytes_max);
  if (!json) return tl::unexpected(json.error());
  Message message;
  Fields fields{*json};
  read(fields, message);
  if (fields.error()) return tl::unexpected(*fields.error());
  return message;
}

void read_body(Fields& in, Body& body) {
  in.text("id", body.id);
  in.text("kind", body.kind);
  in.number("x", -place_m_max, place_m_max, body.x_m);
  in.number("y", -place_m_max, place_m_max, body.y_m);
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

void read_line(Fields& in, BoardsReport::Line& line) {
  std::string word;
  in.text("board", word);
  const auto board = parse_board(word);
  if (!board) in.complain("board", "PILS, PRAV, DOBS or RALI");
  line.board = board.value_or(Board{});
  in.text("health", line.health);
  if (line.health != "ok" && line.health != "lost" && line.health != "faulty")
    in.complain("health", "ok, lost or faulty");
  in.text("firmware", word);
  const auto firmware = parse_hex(word);
  if (!firmware) in.complain("firmware", "eight hexadecimal digits");
  line.firmware_hash = firmware.value_or(0);
  in.whole("uptime_ms", line.uptime_ms);
  in.whole("frames", line.frames);
  in.whole("framesBad", line.frames_bad);
  in.whole("framesMissed", line.frames_missed);
  in.whole("selfTest", line.self_test);
}

void read_power(Fields& in, Power& power) {
  in.counted("voltage", 1e-3, power.voltage_mv);
  in.counted("current", 1e-3, power.current_ma);
  in.counted("temperature", 0.1, power.temperature_01C);
  in.counted("charge", 0.1, power.charge_permille);
}

void read_ranges(Fields& in, Ranges& ranges) {
  in.counted("first", 0.01, ranges.first_bearing_crad);
  in.counted("width", 0.01, ranges.beam_width_crad);
  in.list("m", beams_max, [&](const JsonValue& item, const std::string& name) {
    constexpr double range_m_max = 65.534;
    const double* range_m = item.number();
    if (!item.is_null() && (range_m == nullptr || !(*range_m >= 0.0 && *range_m <= range_m_max)))
      return in.complain(name, "metres from 0 to 65.534, or null");
    ranges.range_mm.push_back(range_m == nullptr ? no_echo
                                                 : static_cast<std::uint16_t>(std::nearbyint(*range_m * 1e3)));
  });
}

/// Reads an object inside the message, if it is there.
template <typename Part, typename Read>
void read_part(Fields& in, std::string_view field, std::optional<Part>& out, Read read) {
  const JsonValue* json = in.optional(field);
  if (json == nullptr) return;
  Fields fields{*json, std::string(field) + "."};
  Part part{};
  read(fields, part);
  in.take_over(fields.error());
  out = std::move(part);
}

}  // namespace

std::string to_json(const Ahead& ahead) {
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

Result<Ahead> ahead_from_json(std::string_view text) {
  return read_message<Ahead>(text, [](Fields& in, Ahead& ahead) {
    in.whole("headerId", ahead.header_id);
    in.time("timestamp", ahead.timestamp);
    in.text("mapId", ahead.map_id);
    in.list("bodies", Ahead::bodies_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      read_body(fields, ahead.bodies.emplace_back());
      in.take_over(fields.error());
    });
  });
}

std::string to_json(const Felt& felt) {
  JsonWriter json;
  json.begin_object()
      .field("aheadHeaderId", felt.ahead_header_id)
      .field("decided", to_iso8601(felt.decided))
      .field("braking", felt.braking)
      .field("body", felt.body);
  if (felt.distance_m) json.field("distance", *felt.distance_m);
  return json.end_object().take();
}

Result<Felt> felt_from_json(std::string_view text) {
  return read_message<Felt>(text, [](Fields& in, Felt& felt) {
    in.whole("aheadHeaderId", felt.ahead_header_id);
    in.time("decided", felt.decided);
    in.flag("braking", felt.braking);
    in.text("body", felt.body);
    in.number("distance", 0.0, place_m_max, felt.distance_m);
  });
}

std::string to_json(const Seen& seen) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", seen.header_id)
      .field("timestamp", to_iso8601(seen.timestamp))
      .field("mapId", seen.map_id);
  if (seen.thing) {
    json.key("thing")
        .begin_object()
        .field("x", seen.thing->x_m)
        .field("y", seen.thing->y_m)
        .field("radius", seen.thing->radius_m)
        .field("distance", seen.thing->distance_m)
        .end_object();
  }
  return json.field("clear", seen.clear_m).end_object().take();
}

Result<Seen> seen_from_json(std::string_view text) {
  return read_message<Seen>(text, [](Fields& in, Seen& seen) {
    in.whole("headerId", seen.header_id);
    in.time("timestamp", seen.timestamp);
    in.text("mapId", seen.map_id);
    read_part(in, "thing", seen.thing, [](Fields& fields, Seen::Thing& thing) {
      fields.number("x", -place_m_max, place_m_max, thing.x_m);
      fields.number("y", -place_m_max, place_m_max, thing.y_m);
      fields.number("radius", 0.0, size_m_max, thing.radius_m);
      fields.number("distance", 0.0, place_m_max, thing.distance_m);
    });
    in.number("clear", 0.0, place_m_max, seen.clear_m);
  });
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
        .field("selfTest", line.self_test)
        .end_object();
  }
  json.end_array();
  // Divided, not multiplied: 7.4 stays 7.4 and not 7.4000000000000004.
  if (const auto& power = report.power) {
    json.key("power")
        .begin_object()
        .field("voltage", power->voltage_mv / 1000.0)
        .field("current", power->current_ma / 1000.0)
        .field("temperature", power->temperature_01C / 10.0)
        .field("charge", power->charge_permille / 10.0)
        .end_object();
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
    if (radio.vehicle.empty()) in.complain("vehicle", "a vehicle such as CoSiVA/AIV1, or *");
    in.number("loss", 0.0, 1.0, radio.loss);
  });
}

}  // namespace cosiva::wire
