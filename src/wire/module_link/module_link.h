#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/board.h"

/// The module link: COBS frames with CRC-16 between the on-board program and a board, over any byte stream.
/// Specified with golden byte vectors in docs/protocols/module-link.md.
namespace cosiva::wire::module_link {

inline constexpr std::uint8_t version = 1;
inline constexpr std::size_t frame_bytes_max = 128;  ///< encoded, with its delimiter
inline constexpr std::size_t text_bytes_max = 32;    ///< of a Display
inline constexpr std::size_t beams_max = 32;         ///< of a Ranges

/// CRC-16/MCRF4XX: reflected 0x1021, start 0xFFFF; "123456789" gives 0x6F91.
[[nodiscard]] std::uint16_t crc16(std::string_view bytes);

/// One frame ready for the stream, delimiter included. A text over 32 bytes loses whole characters from its end; more
/// than 32 beams are a defect of the caller (COSIVA_EXPECT).
[[nodiscard]] std::string encode(const BoardMessage& message, std::uint8_t sequence);
/// The same, appended to `out`, which saves an allocation where several frames leave together.
void append_frame(std::string& out, const BoardMessage& message, std::uint8_t sequence);

/// Changes the message to what the other side reads from its frame: a text over 32 bytes loses whole characters from
/// its end, and a Drive that does not seek has no goal. More than 32 beams are a defect of the caller (COSIVA_EXPECT).
void change_to_read(BoardMessage& message);
/// Likewise, the message itself.
[[nodiscard]] BoardMessage as_read(BoardMessage&& message);

/// Numbers the frames that it sends.
class Encoder {
 public:
  /// Of a frame that is passed on as values instead.
  [[nodiscard]] std::uint8_t next_sequence() { return sequence_++; }
  [[nodiscard]] std::string encode(const BoardMessage& message) { return module_link::encode(message, sequence_++); }
  void append(std::string& out, const BoardMessage& message) { append_frame(out, message, sequence_++); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::uint8_t sequence_{0};
};

/// Takes bytes in any pieces and gives the messages in them; resynchronises at the next delimiter after damage.
class Decoder {
 public:
  /// frames_good wraps; the two others saturate at 65 535, so that a fault count never returns to zero.
  struct Counters {
    std::uint16_t frames_good{};
    std::uint16_t frames_bad{};
    std::uint16_t frames_missed{};  ///< gaps in the sequence numbers; a Hello restarts the sequence and counts none
    friend bool operator==(const Counters&, const Counters&) = default;
  };
  /// Appends the complete messages. Never fails: damage is counted.
  void feed(std::string_view bytes, std::vector<BoardMessage>& messages);
  /// A frame passed on as values: counted like one that was read from bytes.
  void count(std::uint8_t sequence, const BoardMessage& message);
  /// A new connection: discards the unfinished frame and the last sequence number; the counters go on.
  void restart();
  [[nodiscard]] const Counters& counters() const { return counters_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void finish_frame(std::string_view frame, std::vector<BoardMessage>& messages);
  std::string frame_;     ///< the bytes since the last delimiter, when they arrived in pieces
  bool overlong_{false};  ///< more bytes arrived than a frame can hold: all are dropped up to the next delimiter
  std::optional<std::uint8_t> last_sequence_;
  Counters counters_;
};

/// The content of one frame without its delimiter.
/// Errors: link.cobs, link.crc, link.version, link.type, link.length, link.value.
struct Frame {
  std::uint8_t sequence;
  BoardMessage message;
};
[[nodiscard]] Result<Frame> decode(std::string_view frame);

}  // namespace cosiva::wire::module_link
