#include "cosiva/wire/module_link/payload.h"

#include <string>

#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::wire::module_link {
namespace {

// Bits of an Odometry's and of a Drive's flags.
constexpr std::uint8_t line_lost_flag = 1;
constexpr std::uint8_t manoeuvre_flag = 2;
constexpr std::uint8_t seek_flag = 1;
constexpr std::uint8_t goal_flag = 2;
constexpr std::uint8_t room_flag = 4;
constexpr std::size_t manoeuvre_bytes = 6;
constexpr std::size_t room_bytes = 2;

struct Write {
  PayloadWriter& out;
  void operator()(const Hello& m) const {
    out.put(static_cast<std::uint8_t>(m.board));
    out.put(m.protocol_version);
    out.put(m.firmware_hash);
    out.put(m.session);
  }
  void operator()(const Heartbeat& m) const {
    out.put(m.uptime_ms);
    out.put(m.frames_bad);
    out.put(m.frames_missed);
    out.put(m.self_test);
  }
  void operator()(const Odometry& m) const {
    out.put(m.board_ms);
    out.put(m.distance_um);
    out.put(m.speed_mmps);
    out.put(m.line_offset_01mm);
    out.put(static_cast<std::uint8_t>((m.line_lost ? line_lost_flag : 0) | (m.manoeuvre ? manoeuvre_flag : 0)));
    if (m.manoeuvre) put(*m.manoeuvre);
  }
  void operator()(const Drive& m) const {
    out.put(m.speed_mmps);
    out.put(m.acceleration_mmps2);
    out.put(m.braking_mmps2);
    out.put(m.branch);
    const bool has_goal = m.seek && m.goal;
    out.put(
        static_cast<std::uint8_t>((m.seek ? seek_flag : 0) | (has_goal ? goal_flag : 0) | (m.room_mm ? room_flag : 0)));
    if (has_goal) put(*m.goal);
    if (m.room_mm) out.put(*m.room_mm);
  }
  void put(const Manoeuvre& m) const {
    out.put(m.x_mm);
    out.put(m.y_mm);
    out.put(m.turned_mrad);
  }
  void operator()(const TagRead& m) const {
    out.put(m.board_ms);
    out.put(m.number);
    out.put(m.age_ms);
  }
  void operator()(const Display& m) const {
    const std::size_t bytes = display_bytes(m.text);
    for (std::size_t i = 0; i < bytes; ++i) out.put(static_cast<std::uint8_t>(m.text[i]));
  }
  void operator()(const Ranges& m) const {
    COSIVA_EXPECT(m.range_mm.size() <= beams_max);
    out.put(m.board_ms);
    out.put(m.first_bearing_crad);
    out.put(m.beam_width_crad);
    for (const std::uint16_t range : m.range_mm) out.put(range);
  }
  void operator()(const Power& m) const {
    out.put(m.voltage_mv);
    out.put(m.current_ma);
    out.put(m.temperature_01C);
    out.put(m.charge_permille);
    if (!m.gauge) return;
    out.put(m.gauge->charge_ppm);
    out.put(m.gauge->charge_sd_01);
  }
  void operator()(const PilsParts& m) const {
    out.put(m.board_ms);
    out.put(m.supply_mv);
    out.put(m.plugs);
    for (const std::uint8_t reading : m.reading) out.put(reading);
    for (const PilsParts::Motor& motor : {m.left, m.right}) {
      out.put(motor.speed_mmps);
      out.put(motor.current_ma);
    }
  }
  void operator()(const SelfTestRequest& m) const { out.put(m.number); }
  void operator()(const SelfTestResult& m) const {
    COSIVA_EXPECT(m.parts.size() <= part_count);
    out.put(m.number);
    for (const PartFinding& part : m.parts) {
      out.put(static_cast<std::uint8_t>(part.part));
      out.put(static_cast<std::uint8_t>(part.finding));
    }
  }
};

enum Type : std::uint8_t {
  hello = 1,
  heartbeat,
  odometry,
  drive,
  tag_read,
  display,
  ranges,
  power,
  pils_parts,
  self_test_request,
  self_test_result
};

/// The only valid length; nothing where the length varies.
std::optional<std::size_t> fixed_length(std::uint8_t type) {
  switch (type) {
    case hello:
    case tag_read: return 10;
    case heartbeat: return 9;
    case pils_parts: return 23;
    case self_test_request: return 1;
    default: return std::nullopt;
  }
}

tl::unexpected<Error> wrong_length(std::size_t bytes, const std::string& expected) {
  return fail("link.length", "the payload has " + std::to_string(bytes) + " bytes, expected " + expected);
}
tl::unexpected<Error> wrong_value(const char* field, unsigned value, const char* expected) {
  return fail("link.value", std::string(field) + " is " + std::to_string(value) + ", expected " + expected);
}

Result<BoardMessage> read_hello(PayloadReader in) {
  const auto board = in.take<std::uint8_t>();
  if (board < 1 || board > all_boards.size()) return wrong_value("the board", board, "1 to 4");
  Hello m{};
  m.board = static_cast<Board>(board);
  m.protocol_version = in.take<std::uint8_t>();
  m.firmware_hash = in.take<std::uint32_t>();
  m.session = in.take<std::uint32_t>();
  return m;
}

Result<BoardMessage> read_heartbeat(PayloadReader in) {
  Heartbeat m;
  m.uptime_ms = in.take<std::uint32_t>();
  m.frames_bad = in.take<std::uint16_t>();
  m.frames_missed = in.take<std::uint16_t>();
  m.self_test = in.take<std::uint8_t>();
  return m;
}

Manoeuvre read_manoeuvre(PayloadReader& in) {
  Manoeuvre m;
  m.x_mm = in.take<std::int16_t>();
  m.y_mm = in.take<std::int16_t>();
  m.turned_mrad = in.take<std::int16_t>();
  return m;
}

Result<BoardMessage> read_odometry(std::span<const std::uint8_t> payload) {
  constexpr std::size_t head = 17;
  if (payload.size() != head && payload.size() != head + manoeuvre_bytes)
    return wrong_length(payload.size(), "17, or 23 with a manoeuvre");
  PayloadReader in{payload};
  Odometry m;
  m.board_ms = in.take<std::uint32_t>();
  m.distance_um = in.take<std::int64_t>();
  m.speed_mmps = in.take<std::int16_t>();
  m.line_offset_01mm = in.take<std::int16_t>();
  const auto flags = in.take<std::uint8_t>();
  if (flags > (line_lost_flag | manoeuvre_flag)) return wrong_value("the flags", flags, "0 to 3");
  const bool has_manoeuvre = (flags & manoeuvre_flag) != 0;
  if (has_manoeuvre != (payload.size() > head))
    return wrong_length(payload.size(), has_manoeuvre ? "23, by its flags" : "17, by its flags");
  m.line_lost = (flags & line_lost_flag) != 0;
  if (has_manoeuvre) m.manoeuvre = read_manoeuvre(in);
  return m;
}

Result<BoardMessage> read_drive(std::span<const std::uint8_t> payload) {
  constexpr std::size_t head = 8;
  if (payload.size() < head) return wrong_length(payload.size(), "8 or more");
  PayloadReader in{payload};
  Drive m;
  m.speed_mmps = in.take<std::int16_t>();
  m.acceleration_mmps2 = in.take<std::uint16_t>();
  m.braking_mmps2 = in.take<std::uint16_t>();
  m.branch = in.take<std::uint8_t>();
  const auto flags = in.take<std::uint8_t>();
  m.seek = (flags & seek_flag) != 0;
  const bool has_goal = (flags & goal_flag) != 0;
  const bool has_room = (flags & room_flag) != 0;
  if (flags > (seek_flag | goal_flag | room_flag) || (has_goal && !m.seek))
    return wrong_value("the flags", flags, "0, 1, 3, 4, 5 or 7");
  const std::size_t length = head + (has_goal ? manoeuvre_bytes : 0) + (has_room ? room_bytes : 0);
  if (payload.size() != length) return wrong_length(payload.size(), std::to_string(length) + ", by its flags");
  if (has_goal) m.goal = read_manoeuvre(in);
  if (has_room) m.room_mm = in.take<std::uint16_t>();
  return m;
}

Result<BoardMessage> read_tag(PayloadReader in) {
  TagRead m;
  m.board_ms = in.take<std::uint32_t>();
  m.number = in.take<std::uint32_t>();
  m.age_ms = in.take<std::uint16_t>();
  return m;
}

Result<BoardMessage> read_display(std::span<const std::uint8_t> payload) {
  if (payload.size() > text_bytes_max) return wrong_length(payload.size(), "at most 32");
  return Display{std::string(payload.begin(), payload.end())};
}

Result<BoardMessage> read_ranges(std::span<const std::uint8_t> payload) {
  constexpr std::size_t head = 8;
  if (payload.size() < head || payload.size() > head + 2 * beams_max || payload.size() % 2 != 0)
    return wrong_length(payload.size(), "8 and 2 for each of at most 32 beams");
  PayloadReader in{payload};
  Ranges m;
  m.board_ms = in.take<std::uint32_t>();
  m.first_bearing_crad = in.take<std::int16_t>();
  m.beam_width_crad = in.take<std::uint16_t>();
  m.range_mm.resize((payload.size() - head) / 2);
  for (auto& range : m.range_mm) range = in.take<std::uint16_t>();
  return m;
}

Result<BoardMessage> read_power(std::span<const std::uint8_t> payload) {
  constexpr std::size_t plain = 8;
  constexpr std::size_t with_gauge = 14;
  if (payload.size() != plain && payload.size() != with_gauge) return wrong_length(payload.size(), "8 or 14");
  PayloadReader in{payload};
  Power m;
  m.voltage_mv = in.take<std::uint16_t>();
  m.current_ma = in.take<std::int16_t>();
  m.temperature_01C = in.take<std::int16_t>();
  m.charge_permille = in.take<std::uint16_t>();
  if (m.charge_permille > 1000) return wrong_value("the charge", m.charge_permille, "0 to 1000");
  if (payload.size() == plain) return m;
  const auto charge_ppm = in.take<std::uint32_t>();
  m.gauge = {charge_ppm, in.take<std::uint16_t>()};
  if (charge_ppm > 1'000'000) return wrong_value("the charge", charge_ppm, "0 to 1000000");
  return m;
}

Result<BoardMessage> read_pils_parts(PayloadReader in) {
  constexpr std::uint8_t plugs_max = 7;
  PilsParts m;
  m.board_ms = in.take<std::uint32_t>();
  m.supply_mv = in.take<std::uint16_t>();
  m.plugs = in.take<std::uint8_t>();
  if (m.plugs > plugs_max) return wrong_value("the plugs", m.plugs, "0 to 7");
  for (std::uint8_t& reading : m.reading) reading = in.take<std::uint8_t>();
  for (PilsParts::Motor* motor : {&m.left, &m.right}) {
    motor->speed_mmps = in.take<std::int16_t>();
    motor->current_ma = in.take<std::int16_t>();
  }
  return m;
}

Result<BoardMessage> read_self_test(std::span<const std::uint8_t> payload) {
  if (payload.empty() || payload.size() > 1 + 2 * part_count || payload.size() % 2 == 0)
    return wrong_length(payload.size(), "1 and 2 for each of at most 8 parts");
  PayloadReader in{payload};
  SelfTestResult m{in.take<std::uint8_t>(), {}};
  for (std::size_t left = payload.size() / 2; left > 0; --left) {
    const auto part = in.take<std::uint8_t>();
    const auto finding = in.take<std::uint8_t>();
    if (part < 1 || part > part_count) return wrong_value("the part", part, "1 to 8");
    if (finding >= finding_count) return wrong_value("the finding", finding, "0 to 4");
    m.parts.push_back({static_cast<BoardPart>(part), static_cast<Finding>(finding)});
  }
  return m;
}

}  // namespace

std::size_t display_bytes(std::string_view text) {
  if (text.size() <= text_bytes_max) return text.size();
  std::size_t end = text_bytes_max;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return end;
}

void write_payload(PayloadWriter& out, const BoardMessage& message) { std::visit(Write{out}, message); }

Result<BoardMessage> read_payload(std::uint8_t type, std::span<const std::uint8_t> payload) {
  const auto length = fixed_length(type);
  if (length && payload.size() != *length) return wrong_length(payload.size(), std::to_string(*length));
  const PayloadReader in{payload};
  switch (type) {
    case hello: return read_hello(in);
    case heartbeat: return read_heartbeat(in);
    case odometry: return read_odometry(payload);
    case drive: return read_drive(payload);
    case tag_read: return read_tag(in);
    case display: return read_display(payload);
    case ranges: return read_ranges(payload);
    case power: return read_power(payload);
    case pils_parts: return read_pils_parts(in);
    case self_test_request: return SelfTestRequest{PayloadReader{payload}.take<std::uint8_t>()};
    case self_test_result: return read_self_test(payload);
    default: return fail("link.type", "message type " + std::to_string(type) + " is not known, expected 1 to 11");
  }
}

}  // namespace cosiva::wire::module_link
