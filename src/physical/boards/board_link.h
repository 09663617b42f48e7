#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/in_process/board_frames.h"
#include "cosiva/wire/in_process/frame_batch.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::physical {

/// Reports when a periodic task is due. A late task does not catch up in a burst. Invariant: taken, it is not due.
class Every {
 public:
  explicit Every(SimDuration period) : period_{period} {}
  void start(SimTime first) { next_ = first; }
  [[nodiscard]] bool due(SimTime now) const { return now >= next_; }
  [[nodiscard]] SimTime next() const { return next_; }
  /// True once per period.
  [[nodiscard]] bool take(SimTime now);

 private:
  SimDuration period_;
  SimTime next_{};
};

/// Where a board's frames go: to the bytes of a stream, or as values to the vehicle's next batch. Invariant: exactly
/// one of the two.
class BoardOutput {
 public:
  // Implicit: a board is given one or the other.
  BoardOutput(std::string& bytes) : bytes_{&bytes} {}          // NOLINT(google-explicit-constructor)
  BoardOutput(wire::FrameBatch& values) : values_{&values} {}  // NOLINT(google-explicit-constructor)
  /// Ends what was on the line before the first frame; values have no such remains.
  void put_delimiter() const;
  void put(wire::Board board, wire::module_link::Encoder& encoder, const wire::BoardMessage& message) const;

 private:
  std::string* bytes_{nullptr};
  wire::FrameBatch* values_{nullptr};
};

/// The behaviour that all boards have in common (A18): identification at power-up and on a new connection, a heartbeat
/// 10 times a second, frame numbering, and a count of damaged frames received. Sans-IO: frames in, frames appended to
/// `out`; and the requests of self-tests, which the board itself performs. Invariant: only a connected board has a
/// fresh connection.
class BoardLink {
 public:
  explicit BoardLink(wire::Board board);

  /// @param session  random per power-up; shows the other side that odometers count from zero again
  void power_up(SimTime now, std::uint32_t session);
  /// The byte stream was opened or closed. A board whose cable is unplugged keeps running and sends nothing.
  void connect(bool up);
  [[nodiscard]] bool connected() const { return connected_; }

  /// The messages in these bytes, valid until the next call. A Hello from the other side is a request: the board sends
  /// its own Hello at the next tick.
  [[nodiscard]] const std::vector<wire::BoardMessage>& receive(std::string_view bytes);
  /// Likewise, of a frame that is passed on as values.
  void receive(const wire::BoardFrames::Frame& frame);
  void tick(SimTime now, BoardOutput out);
  /// A tick before this time changes nothing, unless the connection changes or frames arrive first.
  [[nodiscard]] SimTime next_due() const {
    return connected_ && (hello_due_ || self_test_due_) ? SimTime::min() : heartbeat_.next();
  }
  void send(const wire::BoardMessage& message, BoardOutput out);
  /// The number of a self-test that has been requested, once: finish_self_test() is due.
  [[nodiscard]] std::optional<std::uint8_t> take_self_test() { return std::exchange(self_test_due_, std::nullopt); }
  /// Sends the result, which replaces the fault found earlier.
  void finish_self_test(std::uint8_t number, std::vector<wire::PartFinding> parts, BoardOutput out);
  /// The board has found a fault while it works: in the heartbeats from now on. The first one stays.
  void report_fault(wire::PartFinding fault);
  [[nodiscard]] bool faulty() const { return fault_ != 0; }

  /// Milliseconds since power-up; wraps after 49 days, as on a board.
  [[nodiscard]] std::uint32_t board_ms(SimTime now) const;
  [[nodiscard]] wire::Board board() const { return board_; }
  void archive(Archive& archive);  ///< session and clock, for a restart of the emulation

 private:
  void take_request(const wire::BoardMessage& message);

  wire::Board board_;
  SimTime powered_at_{};
  std::uint32_t session_{};
  bool connected_{false};
  bool fresh_{false};      ///< connected since the last tick
  bool hello_due_{false};  ///< fresh, or requested
  std::optional<std::uint8_t> self_test_due_;
  std::uint8_t fault_{0};  ///< as in a heartbeat
  Every heartbeat_{std::chrono::milliseconds{100}};
  wire::module_link::Encoder encoder_;
  wire::module_link::Decoder decoder_;
  std::vector<wire::BoardMessage> received_;
};

}  // namespace cosiva::physical
