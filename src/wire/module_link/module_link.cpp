#include "cosiva/wire/module_link/module_link.h"

#include <array>
#include <limits>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/module_link/cobs.h"
#include "cosiva/wire/module_link/payload.h"

namespace cosiva::wire::module_link {
namespace {

constexpr std::array<std::uint16_t, 256> crc_table = [] {
  std::array<std::uint16_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0x8408U : crc >> 1U;
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

template <typename Byte>
std::uint16_t crc_over(const Byte* bytes, std::size_t count) {
  std::uint32_t crc = 0xFFFF;
  for (std::size_t i = 0; i < count; ++i)
    crc = crc >> 8U ^ crc_table[(crc ^ static_cast<std::uint8_t>(bytes[i])) & 0xFFU];
  return static_cast<std::uint16_t>(crc);
}

void count_up(std::uint16_t& counter, std::uint32_t by) {
  constexpr std::uint32_t top = std::numeric_limits<std::uint16_t>::max();
  counter = static_cast<std::uint16_t>(counter + by > top ? top : counter + by);
}

}  // namespace

std::uint16_t crc16(std::string_view bytes) { return crc_over(bytes.data(), bytes.size()); }

void append_frame(std::string& out, const BoardMessage& message, std::uint8_t sequence) {
  std::array<std::uint8_t, content_bytes_max> content;
  PayloadWriter writer{content};
  writer.put(static_cast<std::uint8_t>(version << 4U | type_number(message)));
  writer.put(sequence);
  write_payload(writer, message);
  writer.put(crc_over(content.data(), writer.size()));
  append_cobs(out, {content.data(), writer.size()});
  out.push_back('\0');
}

std::string encode(const BoardMessage& message, std::uint8_t sequence) {
  std::string out;
  out.reserve(32);
  append_frame(out, message, sequence);
  return out;
}

Result<Frame> decode(std::string_view frame) {
  const auto content = from_cobs(frame);
  if (!content) return fail("link.cobs", "the frame's zero-stuffing does not end with it");
  constexpr std::size_t around_payload = 4;
  if (content->size < around_payload)
    return fail("link.length", "the frame holds " + std::to_string(content->size) + " bytes, expected 4 or more");
  // A good frame, with its own CRC, leaves zero.
  if (crc_over(content->bytes.data(), content->size) != 0) return fail("link.crc", "the frame's CRC does not match");
  const std::uint8_t head = content->bytes[0];
  if (head >> 4U != version) {
    return fail("link.version",
                "the frame has version " + std::to_string(head >> 4U) + ", expected " + std::to_string(version));
  }
  auto message = read_payload(head & 0x0FU, content->view().subspan(2, content->size - around_payload));
  if (!message) return tl::unexpected(std::move(message).error());
  return Frame{content->bytes[1], std::move(*message)};
}

void change_to_read(BoardMessage& message) {
  if (auto* display = std::get_if<Display>(&message)) display->text.resize(display_bytes(display->text));
  if (auto* drive = std::get_if<Drive>(&message); drive != nullptr && !drive->seek) drive->goal.reset();
  if (const auto* ranges = std::get_if<Ranges>(&message)) COSIVA_EXPECT(ranges->range_mm.size() <= beams_max);
}

BoardMessage as_read(BoardMessage&& message) {
  change_to_read(message);
  return std::move(message);
}

void Decoder::feed(std::string_view bytes, std::vector<BoardMessage>& messages) {
  constexpr std::size_t frame_max = frame_bytes_max - 1;  // without its delimiter
  for (;;) {
    const std::size_t end = bytes.find('\0');
    const std::string_view piece = bytes.substr(0, end);
    if (frame_.size() + piece.size() > frame_max) overlong_ = true;
    if (end == std::string_view::npos) {
      if (overlong_)
        frame_.clear();
      else
        frame_.append(piece);
      return;
    }
    if (overlong_) {
      count_up(counters_.frames_bad, 1);  // longer than any frame
    } else if (frame_.empty()) {
      finish_frame(piece, messages);  // whole in these bytes: no copy
    } else {
      frame_.append(piece);
      finish_frame(frame_, messages);
    }
    frame_.clear();
    overlong_ = false;
    bytes.remove_prefix(end + 1);
  }
}

void Decoder::finish_frame(std::string_view frame, std::vector<BoardMessage>& messages) {
  if (frame.empty()) return;  // delimiters may be repeated: a sender puts some first to end old garbage
  auto decoded = decode(frame);
  if (!decoded) {
    count_up(counters_.frames_bad, 1);
    return;
  }
  count(decoded->sequence, decoded->message);
  messages.push_back(std::move(decoded->message));
}

void Decoder::count(std::uint8_t sequence, const BoardMessage& message) {
  counters_.frames_good = static_cast<std::uint16_t>(counters_.frames_good + 1U);
  if (last_sequence_ && !std::holds_alternative<Hello>(message))
    count_up(counters_.frames_missed, static_cast<std::uint8_t>(sequence - *last_sequence_ - 1));
  last_sequence_ = sequence;
}

void Decoder::restart() {
  frame_.clear();
  overlong_ = false;
  last_sequence_.reset();
}

void Encoder::archive(Archive& archive) { archive(sequence_); }

void Decoder::archive(Archive& archive) { archive(frame_, overlong_, last_sequence_, counters_); }

}  // namespace cosiva::wire::module_link
