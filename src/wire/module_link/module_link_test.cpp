#include "cosiva/wire/module_link/module_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::wire::module_link {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string to_hex(std::string_view bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (!text.empty()) text += ' ';
    text += digits[byte >> 4U];
    text += digits[byte & 0xFU];
  }
  return text;
}

std::string from_hex(std::string_view text) {
  std::istringstream in{std::string(text)};
  std::string bytes;
  for (unsigned byte = 0; in >> std::hex >> byte;) bytes.push_back(static_cast<char>(byte));
  return bytes;
}

struct Golden {
  const char* name;
  std::uint8_t sequence;
  BoardMessage message;
  const char* hex;
};

/// Generated once by a program in another language that has no line in common with this implementation;
/// docs/protocols/module-link.md shows the same bytes to implementers of the other end.
const std::vector<Golden>& golden() {
  static const std::vector<Golden> vectors{
      {"Hello", 0, Hello{Board::PILS, 1, 0xDEADBEEF, 0x01020304}, "02 11 0d 01 01 ef be ad de 04 03 02 01 72 85 00"},
      {"Heartbeat", 7, Heartbeat{123456, 2, 3, 0}, "06 12 07 40 e2 01 02 02 02 03 01 03 6f 7d 00"},
      {"Odometry", 8, Odometry{1000, -1234567, -250, -13, true},
       "05 13 08 e8 03 01 10 79 29 ed ff ff ff ff ff 06 ff f3 ff 01 33 b3 00"},
      {"Drive", 255, Drive{600, 500, 1000, 2}, "0a 14 ff 58 02 f4 01 e8 03 02 03 3b 30 00"},
      {"Odometry in a manoeuvre", 13, Odometry{2000, 5000000, 0, 0, true, Manoeuvre{214, -35, -1571}},
       "05 13 0d d0 07 01 04 40 4b 4c 01 01 01 01 01 01 01 01 03 03 d6 07 dd ff dd f9 85 fc 00"},
      {"Drive that seeks", 14, Drive{150, 500, 800, no_branch, true}, "04 14 0e 96 09 f4 01 20 03 ff 01 82 fd 00"},
      {"Drive to a goal", 15, Drive{150, 500, 800, no_branch, true, Manoeuvre{214, -35, -1571}},
       "04 14 0f 96 08 f4 01 20 03 ff 03 d6 07 dd ff dd f9 87 fc 00"},
      {"Drive with a room", 18, Drive{400, 500, 1000, 2, false, std::nullopt, 117},
       "0c 14 12 90 01 f4 01 e8 03 02 04 75 03 cd c8 00"},
      {"Drive to a goal with a room", 19, Drive{150, 500, 800, no_branch, true, Manoeuvre{214, -35, -1571}, 350},
       "04 14 13 96 08 f4 01 20 03 ff 07 d6 09 dd ff dd f9 5e 01 09 53 00"},
      {"TagRead", 9, TagRead{65536, 1000042, 15}, "03 15 09 01 02 01 04 6a 42 0f 02 0f 03 7a 2a 00"},
      {"Display", 10, Display{"AIV 3 été"}, "10 16 0a 41 49 56 20 33 20 c3 a9 74 c3 a9 95 35 00"},
      {"Ranges", 11, Ranges{60, -14, 14, {350, no_echo, 2000}},
       "04 17 0b 3c 01 01 04 f2 ff 0e 09 5e 01 ff ff d0 07 19 a6 00"},
      {"Power", 12, Power{7412, -35, 251, 987}, "08 18 0c f4 1c dd ff fb 05 db 03 b5 8d 00"},
      {"Power", 16, Power{7412, -35, 251, 987, Power::Gauge{987'123, 135}},
       "08 18 10 f4 1c dd ff fb 06 db 03 f3 0f 0f 02 87 03 e4 2e 00"},
      {"PilsParts", 20, PilsParts{1500, 5012, 7, {0, 0, 96, 255, 255, 32, 0, 0}, {-310, 140}, {325, 135}},
       "05 19 14 dc 05 01 04 94 13 07 01 05 60 ff ff 20 01 04 ca fe 8c 04 45 01 87 03 34 1f 00"},
      {"SelfTestRequest", 21, SelfTestRequest{3}, "06 1a 15 03 6e 16 00"},
      {"SelfTestResult", 22,
       SelfTestResult{3,
                      {{BoardPart::controller, Finding::passed},
                       {BoardPart::BRAC, Finding::passed},
                       {BoardPart::DEMS, Finding::implausible},
                       {BoardPart::PMOT, Finding::passed}}},
       "05 1b 16 03 01 02 02 04 03 02 04 03 0c 51 00"},
  };
  return vectors;
}

rc::Gen<BoardMessage> any_message() {
  const auto u8 = rc::gen::arbitrary<std::uint8_t>();
  const auto u16 = rc::gen::arbitrary<std::uint16_t>();
  const auto i16 = rc::gen::arbitrary<std::int16_t>();
  const auto u32 = rc::gen::arbitrary<std::uint32_t>();
  const auto as_message = [](auto gen) {
    return rc::gen::map(std::move(gen), [](auto m) { return BoardMessage{std::move(m)}; });
  };
  return rc::gen::oneOf(
      as_message(rc::gen::map(
          rc::gen::tuple(u32, u16, rc::gen::inRange(0, 8),
                         rc::gen::container<std::vector<std::uint8_t>>(PilsParts::sensors, u8), i16, i16),
          [](const auto& t) {
            const auto& [ms, supply, plugs, readings, left, right] = t;
            PilsParts parts{ms, supply, static_cast<std::uint8_t>(plugs), {}, {left, right}, {right, left}};
            std::ranges::copy(readings, parts.reading.begin());
            return parts;
          })),
      as_message(rc::gen::map(u8, [](std::uint8_t number) { return SelfTestRequest{number}; })),
      as_message(
          rc::gen::map(rc::gen::tuple(u8, rc::gen::inRange<std::size_t>(0, part_count + 1), rc::gen::inRange(0, 5)),
                       [](const auto& t) {
                         SelfTestResult result{std::get<0>(t), {}};
                         for (std::size_t i = 1; i <= std::get<1>(t); ++i)
                           result.parts.push_back({static_cast<BoardPart>(i), static_cast<Finding>(std::get<2>(t))});
                         return result;
                       })),
      as_message(rc::gen::map(rc::gen::tuple(rc::gen::inRange(0, 4), u8, u32, u32),
                              [](const auto& t) {
                                return Hello{all_boards[static_cast<std::size_t>(std::get<0>(t))], std::get<1>(t),
                                             std::get<2>(t), std::get<3>(t)};
                              })),
      as_message(rc::gen::build<Heartbeat>(rc::gen::set(&Heartbeat::uptime_ms), rc::gen::set(&Heartbeat::frames_bad),
                                           rc::gen::set(&Heartbeat::frames_missed),
                                           rc::gen::set(&Heartbeat::self_test))),
      as_message(rc::gen::build<Odometry>(
          rc::gen::set(&Odometry::board_ms), rc::gen::set(&Odometry::distance_um), rc::gen::set(&Odometry::speed_mmps),
          rc::gen::set(&Odometry::line_offset_01mm), rc::gen::set(&Odometry::line_lost),
          rc::gen::set(&Odometry::manoeuvre,
                       rc::gen::map(rc::gen::tuple(rc::gen::arbitrary<bool>(), i16, i16, i16),
                                    [](const auto& t) {
                                      const auto& [is_given, x, y, turned] = t;
                                      return is_given ? std::optional(Manoeuvre{x, y, turned}) : std::nullopt;
                                    })))),
      as_message(rc::gen::build<Drive>(rc::gen::set(&Drive::speed_mmps), rc::gen::set(&Drive::acceleration_mmps2),
                                       rc::gen::set(&Drive::braking_mmps2), rc::gen::set(&Drive::branch),
                                       rc::gen::set(&Drive::seek))),
      as_message(rc::gen::map(rc::gen::tuple(i16, i16, i16, i16),
                              [](const auto& t) {
                                const auto& [speed, x, y, turned] = t;
                                return Drive{speed, 500, 800, no_branch, true, Manoeuvre{x, y, turned}};
                              })),
      as_message(rc::gen::map(rc::gen::tuple(i16, rc::gen::arbitrary<bool>(), u16),
                              [](const auto& t) {
                                const auto& [speed, seek, room] = t;
                                return Drive{speed, 500, 800, no_branch, seek, std::nullopt, room};
                              })),
      as_message(rc::gen::build<TagRead>(rc::gen::set(&TagRead::board_ms), rc::gen::set(&TagRead::number),
                                         rc::gen::set(&TagRead::age_ms))),
      as_message(rc::gen::map(rc::gen::arbitrary<std::string>(),
                              [](std::string text) { return Display{text.substr(0, text_bytes_max)}; })),
      as_message(rc::gen::map(rc::gen::tuple(u32, i16, u16, rc::gen::arbitrary<std::vector<std::uint16_t>>()),
                              [](const auto& t) {
                                Ranges m{std::get<0>(t), std::get<1>(t), std::get<2>(t), std::get<3>(t)};
                                if (m.range_mm.size() > beams_max) m.range_mm.resize(beams_max);
                                return m;
                              })),
      as_message(rc::gen::map(rc::gen::tuple(u16, i16, i16, rc::gen::inRange<std::uint16_t>(0, 1001)),
                              [](const auto& t) {
                                return Power{std::get<0>(t), std::get<1>(t), std::get<2>(t), std::get<3>(t)};
                              })),
      as_message(
          rc::gen::map(rc::gen::tuple(u16, i16, rc::gen::inRange<std::uint32_t>(0, 1'000'001), u16), [](const auto& t) {
            const auto& [voltage, current, charge, sd] = t;
            return Power{voltage, current, 220, 500, Power::Gauge{charge, sd}};
          })));
}

/// The frame around a content that is right except for what the test puts wrong in it.
std::string framed(std::string content) {
  const std::uint16_t crc = crc16(content);
  content.push_back(static_cast<char>(crc & 0xFFU));
  content.push_back(static_cast<char>(crc >> 8U));
  std::string frame;
  std::size_t from = 0;
  for (;;) {
    const std::size_t zero = content.find('\0', from);
    const std::string part = content.substr(from, zero == std::string::npos ? zero : zero - from);
    frame.push_back(static_cast<char>(part.size() + 1));
    frame += part;
    if (zero == std::string::npos) return frame;
    from = zero + 1;
  }
}

std::string code_of(std::string_view frame) {
  const auto decoded = decode(frame);
  return decoded ? "none" : decoded.error().code;
}

TEST(Crc16, has_the_catalogue_s_check_value) { EXPECT_EQ(crc16("123456789"), 0x6F91); }

TEST(Crc16, of_nothing_is_its_start_value) { EXPECT_EQ(crc16(""), 0xFFFF); }

TEST(Frame, of_each_message_has_the_documented_bytes) {
  for (const Golden& vector : golden())
    EXPECT_EQ(to_hex(encode(vector.message, vector.sequence)), vector.hex) << vector.name;
}

TEST(Frame, of_the_document_is_read_as_the_message) {
  for (const Golden& vector : golden()) {
    const std::string bytes = from_hex(vector.hex);
    const auto frame = decode(std::string_view{bytes}.substr(0, bytes.size() - 1));
    ASSERT_TRUE(frame) << vector.name << ": " << to_string(frame.error());
    EXPECT_EQ(frame->sequence, vector.sequence);
    EXPECT_EQ(frame->message, vector.message);
  }
}

TEST(Frame, bytes_are_written_in_the_protocol_document) {
  std::ifstream file{source_dir() + "/docs/protocols/module-link.md"};
  const std::string document{std::istreambuf_iterator<char>{file}, {}};
  EXPECT_EQ(golden().size(), std::variant_size_v<BoardMessage> + 6) << "two of them have two forms, one five";
  for (const Golden& vector : golden()) EXPECT_THAT(document, HasSubstr(vector.hex)) << vector.name;
}

TEST(Frame, that_is_longest_fits_the_limit) {
  Ranges ranges;
  ranges.range_mm.assign(beams_max, 0x1234);
  EXPECT_LE(encode(ranges, 1).size(), frame_bytes_max);
  EXPECT_EQ(encode(ranges, 1).size(), 4U + 8U + 2U * 32U + 2U);  // head, CRC; beams; one COBS byte and the delimiter
}

TEST(Frame, of_a_long_text_has_whole_characters_only) {
  const std::string text = std::string(31, 'a') + "é";  // 33 bytes: the cut would fall inside é
  std::vector<BoardMessage> messages;
  Decoder{}.feed(encode(Display{text}, 0), messages);
  EXPECT_THAT(messages, ElementsAre(BoardMessage{Display{std::string(31, 'a')}}));
}

TEST(Frame, with_too_many_beams_is_a_defect_of_the_caller) {
  Ranges ranges;
  ranges.range_mm.assign(beams_max + 1, 1);
  EXPECT_DEATH(static_cast<void>(encode(ranges, 0)), "beams_max");
}

TEST(Frame, preserves_every_message) {
  EXPECT_TRUE(rc::check("decode(encode(m, n)) is m, n", [] {
    const BoardMessage message = *any_message();
    const auto sequence = *rc::gen::arbitrary<std::uint8_t>();
    const std::string bytes = encode(message, sequence);
    RC_ASSERT(bytes.find('\0') == bytes.size() - 1);
    const auto frame = decode(std::string_view{bytes}.substr(0, bytes.size() - 1));
    RC_ASSERT(frame.has_value());
    RC_ASSERT(frame->sequence == sequence);
    RC_ASSERT(frame->message == message);
  }));
}

TEST(Decode, names_what_is_wrong) {
  using namespace std::string_literals;
  EXPECT_EQ(code_of(""), "link.cobs");
  EXPECT_EQ(code_of("\x05\x01\x02"), "link.cobs");  // announces more bytes than there are
  EXPECT_EQ(code_of("\x03\x01\0"s), "link.cobs");   // a zero inside
  EXPECT_EQ(code_of(std::string(200, '\1')), "link.cobs");
  EXPECT_EQ(code_of("\x03\x11\x22"), "link.length");  // no room for a CRC
  EXPECT_EQ(code_of("\x05\x14\x01\x02\x03"), "link.crc");
  EXPECT_EQ(code_of(framed("\x24\x01")), "link.version");
  EXPECT_EQ(code_of(framed("\x10\x01")), "link.type");
  EXPECT_EQ(code_of(framed("\x1C\x01")), "link.type");
}

TEST(Decode, requires_the_exact_length) {
  for (const Golden& vector : golden()) {
    if (std::holds_alternative<Display>(vector.message)) continue;  // its text is the rest of the frame
    const std::string bytes = from_hex(vector.hex);
    const auto type = static_cast<char>(0x10U | (vector.message.index() + 1));
    for (std::size_t payload = 0; payload < 40; ++payload) {
      std::string content{type, '\1'};
      content.append(payload, '\1');
      if (std::holds_alternative<Ranges>(vector.message)) {
        EXPECT_EQ(code_of(framed(content)), payload >= 8 && payload % 2 == 0 ? "none" : "link.length") << payload;
        continue;
      }
      if (std::holds_alternative<Odometry>(vector.message)) {  // its flags, 1 everywhere here, announce no manoeuvre
        EXPECT_EQ(code_of(framed(content)), payload == 17 ? "none" : "link.length") << payload;
        continue;
      }
      if (std::holds_alternative<Drive>(vector.message)) {  // and no goal
        EXPECT_EQ(code_of(framed(content)), payload == 8 ? "none" : "link.length") << payload;
        continue;
      }
      if (std::holds_alternative<Power>(vector.message)) {  // 14 is valid as well, but 0x01010101 is not a charge
        const char* expected = payload == 8 ? "none" : payload == 14 ? "link.value" : "link.length";
        EXPECT_EQ(code_of(framed(content)), expected) << payload;
        continue;
      }
      if (std::holds_alternative<SelfTestResult>(vector.message)) {  // part 1 with finding 1, up to eight times
        const bool fits = payload % 2 == 1 && payload <= 17;
        EXPECT_EQ(code_of(framed(content)), fits ? "none" : "link.length") << payload;
        continue;
      }
      const std::size_t right = encode(vector.message, 1).size() - 6;
      EXPECT_EQ(code_of(framed(content)), payload == right ? "none" : "link.length") << vector.name << ' ' << payload;
    }
  }
  EXPECT_EQ(code_of(framed("\x16\x01" + std::string(33, 'x'))), "link.length");
  EXPECT_EQ(code_of(framed("\x16\x01" + std::string(32, 'x'))), "none");
  EXPECT_EQ(code_of(framed("\x17\x01" + std::string(8 + 66, 'x'))), "link.length");
}

TEST(Decode, refuses_values_out_of_range) {
  const std::string nine(9, '\1');
  EXPECT_EQ(code_of(framed("\x11\x01\x04" + nine)), "none");
  EXPECT_EQ(code_of(framed("\x11\x01\x05" + nine)), "link.value");                        // no fifth board
  EXPECT_EQ(code_of(framed("\x13\x01" + std::string(16, '\1') + "\x04")), "link.value");  // no such flag
  EXPECT_EQ(code_of(framed("\x14\x01" + std::string(7, '\1') + "\x01")), "none");
  EXPECT_EQ(code_of(framed("\x14\x01" + std::string(7, '\1') + "\x02")), "link.value");  // a goal without seek
  EXPECT_EQ(code_of(framed("\x14\x01" + std::string(7, '\1') + "\x06" + nine.substr(1))), "link.value");  // likewise
  EXPECT_EQ(code_of(framed("\x14\x01" + std::string(7, '\1') + "\x08")), "link.value");
  EXPECT_EQ(code_of(framed("\x18\x01" + std::string(6, '\1') + "\xE8\x03")), "none");        // 1000 ‰
  EXPECT_EQ(code_of(framed("\x18\x01" + std::string(6, '\1') + "\xE9\x03")), "link.value");  // 1001 ‰
  const std::string gauge = "\x18\x01" + std::string(6, '\1') + "\xE8\x03";
  EXPECT_EQ(code_of(framed(gauge + std::string("\x40\x42\x0F\0\1\0", 6))), "none");        // 1 000 000 ppm
  EXPECT_EQ(code_of(framed(gauge + std::string("\x41\x42\x0F\0\1\0", 6))), "link.value");  // and one more
}

TEST(Decode, refuses_readings_of_pils_parts_of_another_length_or_with_unknown_plugs) {
  const std::string head(6, '\1');
  EXPECT_EQ(code_of(framed("\x19\x01" + head + "\x07" + std::string(16, '\1'))), "none");
  EXPECT_EQ(code_of(framed("\x19\x01" + head + "\x08" + std::string(16, '\1'))), "link.value");
  EXPECT_EQ(code_of(framed("\x19\x01" + head + "\x07" + std::string(15, '\1'))), "link.length");
  EXPECT_EQ(code_of(framed("\x19\x01" + head + "\x07" + std::string(17, '\1'))), "link.length");
}

TEST(Decode, refuses_results_of_self_tests_with_half_a_part_too_many_or_unknown_ones) {
  EXPECT_EQ(code_of(framed("\x1A\x01\x05")), "none");
  EXPECT_EQ(code_of(framed("\x1A\x01\x05\x05")), "link.length");
  EXPECT_EQ(code_of(framed("\x1B\x01")), "link.length");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05")), "none");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05\x08\x04")), "none");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05\x08")), "link.length");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05\x09\x04")), "link.value");
  EXPECT_EQ(code_of(framed(std::string("\x1B\x01\x05\x00\x04", 5))), "link.value");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05\x08\x05")), "link.value");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05" + std::string(16, '\1'))), "none");
  EXPECT_EQ(code_of(framed("\x1B\x01\x05" + std::string(18, '\1'))), "link.length");
}

TEST(Decode, requires_a_manoeuvre_where_the_flags_announce_one_and_nowhere_else) {
  const std::string head(16, '\1');
  const std::string six(6, '\1');
  EXPECT_EQ(code_of(framed("\x13\x01" + head + "\x02" + six)), "none");
  EXPECT_EQ(code_of(framed("\x13\x01" + head + "\x03" + six)), "none");
  EXPECT_EQ(code_of(framed("\x13\x01" + head + "\x02")), "link.length");
  EXPECT_EQ(code_of(framed("\x13\x01" + head + "\x01" + six)), "link.length");
  EXPECT_EQ(code_of(framed("\x13\x01" + head + "\x02" + six + six)), "link.length");
}

TEST(Decode, requires_a_goal_where_the_flags_announce_one_and_nowhere_else) {
  const std::string head(7, '\1');
  const std::string six(6, '\1');
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x03" + six)), "none");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x03")), "link.length");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x01" + six)), "link.length");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x03" + six + six)), "link.length");
}

TEST(Decode, requires_a_room_where_the_flags_announce_one_and_nowhere_else) {
  const std::string head(7, '\1');
  const std::string two(2, '\1');
  const std::string eight(8, '\1');
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x04" + two)), "none");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x05" + two)), "none");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x07" + eight)), "none");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x04")), "link.length");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x01" + two)), "link.length");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x04" + eight)), "link.length");
  EXPECT_EQ(code_of(framed("\x14\x01" + head + "\x07" + two)), "link.length");
}

TEST(Decoder, takes_bytes_in_any_pieces) {
  EXPECT_TRUE(rc::check("the same messages, however the stream is cut", [] {
    const auto sent = *rc::gen::container<std::vector<BoardMessage>>(any_message());
    Encoder encoder;
    std::string stream;
    for (const BoardMessage& message : sent) encoder.append(stream, message);
    Decoder decoder;
    std::vector<BoardMessage> received;
    while (!stream.empty()) {
      const auto bytes = *rc::gen::inRange<std::size_t>(1, 1 + std::min<std::size_t>(stream.size(), 40));
      decoder.feed(stream.substr(0, bytes), received);
      stream.erase(0, bytes);
    }
    RC_ASSERT(received == sent);
    RC_ASSERT(decoder.counters().frames_bad == 0);
    RC_ASSERT(decoder.counters().frames_missed == 0);
    RC_ASSERT(decoder.counters().frames_good == sent.size());
  }));
}

TEST(Decoder, receives_the_next_frame_after_any_garbage) {
  EXPECT_TRUE(rc::check("garbage, a delimiter, then a good frame", [] {
    const auto garbage = *rc::gen::arbitrary<std::string>();
    const BoardMessage message = *any_message();
    Decoder decoder;
    std::vector<BoardMessage> received;
    decoder.feed(garbage, received);
    decoder.feed(std::string_view{"\0", 1}, received);
    decoder.feed(encode(message, 0), received);
    RC_ASSERT(!received.empty());
    RC_ASSERT(received.back() == message);
  }));
}

TEST(Decoder, loses_at_most_the_frame_that_garbage_runs_into) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed("noise before the cable was in", received);
  decoder.feed(encode(Drive{1, 2, 3, 4}, 0) + encode(Drive{5, 6, 7, 8}, 1), received);
  EXPECT_THAT(received, ElementsAre(BoardMessage{Drive{5, 6, 7, 8}}));
  EXPECT_EQ(decoder.counters().frames_bad, 1);
}

TEST(Decoder, never_makes_another_message_from_one_flipped_bit) {
  // A flip in a COBS code moves zeros, which a 16-bit CRC lets through once in 65 536 times such a frame also parses:
  // proven here for these 500 frames, bounded by that number for all others.
  Random random{7, "flips"};
  for (int round = 0; round < 500; ++round) {
    Ranges ranges{static_cast<std::uint32_t>(random.next()), -91, 14, {}};
    for (std::uint64_t i = random.below(14); i > 0; --i)
      ranges.range_mm.push_back(static_cast<std::uint16_t>(random.next() & (random.chance(0.3) ? 0xFF : 0xFFFF)));
    const BoardMessage sent = round % 2 == 0 ? BoardMessage{ranges} : golden()[random.below(golden().size())].message;
    const BoardMessage after = Drive{100, 200, 300, 0};
    const std::string stream = encode(sent, 1) + encode(after, 2) + encode(after, 3);
    for (std::size_t bit = 0; bit < 8 * encode(sent, 1).size(); ++bit) {
      std::string damaged = stream;
      damaged[bit / 8] = static_cast<char>(static_cast<unsigned char>(damaged[bit / 8]) ^ (1U << bit % 8));
      std::vector<BoardMessage> received;
      Decoder decoder;
      decoder.feed(damaged, received);
      for (const BoardMessage& message : received) ASSERT_EQ(message, after) << "bit " << bit;
      ASSERT_GE(received.size(), 1U) << "bit " << bit;
      ASSERT_GE(decoder.counters().frames_bad, 1) << "bit " << bit;
    }
  }
}

TEST(Decoder, ignores_empty_frames) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed(std::string(5, '\0') + encode(Heartbeat{}, 9), received);
  EXPECT_THAT(received, ElementsAre(BoardMessage{Heartbeat{}}));
  EXPECT_EQ(decoder.counters(), (Decoder::Counters{1, 0, 0}));
}

TEST(Decoder, drops_what_is_longer_than_a_frame_and_counts_it_once) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  for (int i = 0; i < 1000; ++i) decoder.feed(std::string(100, 'x'), received);
  EXPECT_EQ(decoder.counters().frames_bad, 0);  // the frame may still continue
  decoder.feed(std::string_view{"\0", 1}, received);
  EXPECT_EQ(decoder.counters().frames_bad, 1);
  decoder.feed(encode(Heartbeat{}, 0), received);
  EXPECT_THAT(received, ElementsAre(BoardMessage{Heartbeat{}}));
}

TEST(Decoder, counts_the_gaps_in_the_sequence_over_its_wrap) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed(encode(Drive{}, 254), received);  // the first sequence number that the decoder receives is no gap
  decoder.feed(encode(Drive{}, 255), received);
  decoder.feed(encode(Drive{}, 0), received);
  EXPECT_EQ(decoder.counters().frames_missed, 0);
  decoder.feed(encode(Drive{}, 3), received);
  EXPECT_EQ(decoder.counters().frames_missed, 2);
}

TEST(Decoder, restarts_the_sequence_at_a_hello) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed(encode(Drive{}, 100), received);
  decoder.feed(encode(Hello{Board::PILS, 1, 0, 5}, 0), received);
  decoder.feed(encode(Drive{}, 1), received);
  EXPECT_EQ(decoder.counters().frames_missed, 0);
}

TEST(Decoder, that_restarts_discards_the_half_frame_and_the_sequence_but_not_its_counts) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed(encode(Drive{}, 100), received);
  decoder.feed(encode(Drive{}, 101).substr(0, 5), received);
  decoder.restart();
  decoder.feed(encode(Drive{}, 0), received);
  EXPECT_EQ(decoder.counters(), (Decoder::Counters{2, 0, 0}));
}

TEST(Decoder, saturates_its_fault_counts) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  for (int i = 0; i < 70'000; ++i) decoder.feed(std::string_view{"\x05\0", 2}, received);
  EXPECT_EQ(decoder.counters().frames_bad, 65'535);
  EXPECT_THAT(received, IsEmpty());
}

TEST(Encoder, numbers_its_frames_and_wraps) {
  Encoder encoder;
  for (int i = 0; i < 300; ++i) {
    const std::string bytes = encoder.encode(Heartbeat{});
    const auto frame = decode(std::string_view{bytes}.substr(0, bytes.size() - 1));
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->sequence, i % 256);
  }
}

TEST(Decode, accepts_0_to_32_beams) {
  for (const std::size_t beams : {std::size_t{0}, std::size_t{1}, beams_max}) {
    Ranges ranges{1, 2, 3, {}};
    ranges.range_mm.assign(beams, 0x1234);
    const std::string bytes = encode(ranges, 1);
    const auto frame = decode(std::string_view{bytes}.substr(0, bytes.size() - 1));
    ASSERT_TRUE(frame) << beams;
    EXPECT_EQ(frame->message, BoardMessage{ranges});
  }
}

TEST(Decode, states_the_bytes_and_values_that_it_expects) {
  const auto message_of = [](std::string_view frame) {
    const auto decoded = decode(frame);
    return decoded ? "none" : decoded.error().message;
  };
  const std::string head(7, '\1');
  EXPECT_EQ(message_of(framed("\x11\x01" + head)), "the payload has 7 bytes, expected 10");
  EXPECT_EQ(message_of(framed("\x12\x01" + head)), "the payload has 7 bytes, expected 9");
  EXPECT_EQ(message_of(framed("\x15\x01" + head)), "the payload has 7 bytes, expected 10");
  EXPECT_EQ(message_of(framed("\x13\x01" + head)), "the payload has 7 bytes, expected 17, or 23 with a manoeuvre");
  EXPECT_EQ(message_of(framed("\x13\x01" + std::string(16, '\1') + "\x02")),
            "the payload has 17 bytes, expected 23, by its flags");
  EXPECT_EQ(message_of(framed("\x13\x01" + std::string(23, '\1'))),
            "the payload has 23 bytes, expected 17, by its flags");
  EXPECT_EQ(message_of(framed("\x14\x01" + head + "\x03")), "the payload has 8 bytes, expected 14, by its flags");
  EXPECT_EQ(message_of(framed("\x14\x01" + std::string(14, '\1'))),
            "the payload has 14 bytes, expected 8, by its flags");
  EXPECT_EQ(message_of(framed("\x14\x01" + head + "\x02")), "the flags is 2, expected 0, 1, 3, 4, 5 or 7");
  EXPECT_EQ(message_of(framed("\x11\x01\x05" + std::string(9, '\1'))), "the board is 5, expected 1 to 4");
  EXPECT_EQ(message_of(framed(std::string("\x11\x01\x00", 3) + std::string(9, '\1'))),
            "the board is 0, expected 1 to 4");
  EXPECT_EQ(message_of("\x03\x11\x22"), "the frame holds 2 bytes, expected 4 or more");
  EXPECT_EQ(message_of(framed("\x24\x01")), "the frame has version 2, expected 1");
  EXPECT_EQ(message_of(framed("\x1C\x01")), "message type 12 is not known, expected 1 to 11");
}

TEST(Decode, accepts_a_frame_without_payload) {
  const auto decoded = decode(framed("\x16\x07"));
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->sequence, 7);
  EXPECT_EQ(decoded->message, BoardMessage{Display{}});
}

TEST(Frame, of_a_text_of_continuation_bytes_only_is_empty) {
  std::vector<BoardMessage> messages;
  Decoder{}.feed(encode(Display{std::string(40, '\x80')}, 0), messages);
  EXPECT_THAT(messages, ElementsAre(BoardMessage{Display{}}));
}

TEST(Decoder, counts_a_frame_that_is_too_long_once_and_takes_the_next_one) {
  for (const std::vector<std::size_t>& pieces :
       {std::vector<std::size_t>{127}, {128}, {100, 28}, {128, 1}, {500, 500}}) {
    std::vector<BoardMessage> received;
    Decoder decoder;
    for (const std::size_t bytes : pieces) decoder.feed(std::string(bytes, '\1'), received);
    decoder.feed(std::string_view{"\0", 1}, received);
    EXPECT_EQ(decoder.counters().frames_bad, 1);
    EXPECT_THAT(received, IsEmpty());
    decoder.feed(encode(Heartbeat{}, 0), received);
    EXPECT_THAT(received, ElementsAre(BoardMessage{Heartbeat{}}));
    EXPECT_EQ(decoder.counters().frames_bad, 1);
  }
}

TEST(Decoder, that_restarts_within_a_frame_that_is_too_long_takes_the_next_one) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed(std::string(200, 'x'), received);
  decoder.restart();
  decoder.feed(encode(Heartbeat{}, 0), received);
  EXPECT_THAT(received, ElementsAre(BoardMessage{Heartbeat{}}));
}

TEST(Decoder, counts_up_to_254_missed_frames_at_a_time_and_saturates) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  decoder.feed(encode(Drive{}, 7), received);
  decoder.feed(encode(Drive{}, 6), received);  // 255 further: 254 are missing
  EXPECT_EQ(decoder.counters().frames_missed, 254);
  for (int i = 0; i < 300; ++i) decoder.feed(encode(Drive{}, static_cast<std::uint8_t>(5 - i)), received);
  EXPECT_EQ(decoder.counters().frames_missed, 65'535);
  EXPECT_EQ(decoder.counters().frames_good, 302);
}

TEST(Frame, of_a_drive_that_does_not_seek_has_no_goal) {
  const Manoeuvre goal{214, -35, -1571};
  EXPECT_EQ(encode(Drive{150, 500, 800, no_branch, false, goal}, 3), encode(Drive{150, 500, 800, no_branch, false}, 3));
  EXPECT_NE(encode(Drive{150, 500, 800, no_branch, true, goal}, 3), encode(Drive{150, 500, 800, no_branch, true}, 3));
}

TEST(Frame, of_an_odometry_states_a_lost_line_and_a_manoeuvre_each_by_a_flag) {
  // The flags are the 19th byte of the content: version and type, sequence, 4 + 8 + 2 + 2 bytes. No byte is zero, so
  // that COBS puts only its first code before them.
  const auto flags = [](bool lost, std::optional<Manoeuvre> manoeuvre) {
    const Odometry odometry{0x01010101, 0x0101010101010101, 0x0101, 0x0101, lost, manoeuvre};
    return static_cast<int>(encode(odometry, 1).at(19));
  };
  EXPECT_EQ(flags(true, std::nullopt), 1);
  EXPECT_EQ(flags(false, Manoeuvre{1, 2, 3}), 2);
  EXPECT_EQ(flags(true, Manoeuvre{1, 2, 3}), 3);
}

TEST(Frame, of_a_text_of_32_bytes_holds_all_of_it) {
  for (const std::string& text : {std::string(32, 'a'), std::string(30, 'a') + "é", std::string(28, 'a') + "🚚"}) {
    std::vector<BoardMessage> messages;
    Decoder{}.feed(encode(Display{text}, 0) + encode(Display{text + "b"}, 1), messages);
    EXPECT_THAT(messages, ElementsAre(BoardMessage{Display{text}}, BoardMessage{Display{text}}));
  }
}

TEST(Frame, of_a_long_text_is_cut_before_a_character_of_four_bytes) {
  for (const std::size_t before : {29U, 30U, 31U}) {
    std::vector<BoardMessage> messages;
    Decoder{}.feed(encode(Display{std::string(before, 'a') + "🚚"}, 0), messages);
    EXPECT_THAT(messages, ElementsAre(BoardMessage{Display{std::string(before, 'a')}})) << before;
  }
}

TEST(Decoder, counts_good_and_bad_frames_and_gaps_separately) {
  std::vector<BoardMessage> received;
  Decoder decoder;
  std::string damaged = encode(Drive{}, 1);
  damaged[1] = static_cast<char>(damaged[1] ^ 2);  // the type
  decoder.feed(encode(Drive{}, 0) + damaged + encode(Drive{}, 2) + encode(Drive{}, 5), received);
  EXPECT_EQ(decoder.counters(), (Decoder::Counters{3, 1, 3}));  // 1, 3 and 4 are missing
  decoder.feed(encode(Drive{}, 5), received);                   // repeated: 255 are missing
  EXPECT_EQ(decoder.counters(), (Decoder::Counters{4, 1, 258}));
}

TEST(Crc16, of_a_message_and_its_crc_is_zero) {
  // The byte and the low byte of the start value cancel each other: what is left is the start value's high byte.
  EXPECT_EQ(crc16("\xFF"), 0x00FF);
  EXPECT_NE(crc16("ab"), crc16("ba"));
  // The low byte comes first.
  EXPECT_EQ(crc16("123456789\x91\x6F"), 0);
}

TEST(AsRead, is_what_the_frame_of_any_message_holds) {
  EXPECT_TRUE(rc::check("decode(encode(m)) is as_read(m)", [] {
    const BoardMessage message = *any_message();
    const std::string bytes = encode(message, 5);
    const auto frame = decode(std::string_view{bytes}.substr(0, bytes.size() - 1));
    RC_ASSERT(frame.has_value());
    RC_ASSERT(frame->message == as_read(BoardMessage{message}));
  }));
}

TEST(AsRead, cuts_a_long_text_and_drops_the_goal_of_a_drive_that_does_not_seek) {
  EXPECT_EQ(as_read(Display{std::string(31, 'a') + "é"}), BoardMessage{Display{std::string(31, 'a')}});
  const Manoeuvre goal{214, -35, -1571};
  EXPECT_EQ(as_read(Drive{150, 500, 800, no_branch, false, goal}),
            (BoardMessage{Drive{150, 500, 800, no_branch, false}}));
  EXPECT_EQ(as_read(Drive{150, 500, 800, no_branch, true, goal}),
            (BoardMessage{Drive{150, 500, 800, no_branch, true, goal}}));
}

TEST(Decoder, counts_frames_passed_on_as_values_like_those_read_from_bytes) {
  Decoder of_bytes;
  Decoder of_values;
  std::vector<BoardMessage> received;
  const auto pass = [&](std::uint8_t sequence, const BoardMessage& message) {
    of_bytes.feed(encode(message, sequence), received);
    of_values.count(sequence, message);
    EXPECT_EQ(of_values.counters(), of_bytes.counters());
  };
  pass(7, Heartbeat{});
  pass(8, Heartbeat{});
  pass(11, Heartbeat{});                 // two are missing
  pass(0, Hello{Board::PILS, 1, 2, 3});  // a new sequence
  pass(1, Heartbeat{});
  of_bytes.restart();
  of_values.restart();
  pass(200, Heartbeat{});
  EXPECT_EQ(of_values.counters(), (Decoder::Counters{6, 0, 2}));
}

}  // namespace
}  // namespace cosiva::wire::module_link
