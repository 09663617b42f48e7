#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/aiv/onboard/periodic.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/in_process/board_frames.h"
#include "cosiva/wire/in_process/frame_batch.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/module_link/module_link.h"
#include "cosiva/wire/module_link/self_tests.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// One module link per board: frames on the boards' side, values on the vehicle's side. Records which boards have
/// responded, their health (A18), and those of their last readings that are reported unchanged.
///
/// Invariant: there is a new obstacle reading only where there is one at all.
class BoardsLink {
 public:
  /// @param as_values  frames are passed on as values (wire/in_process/board_frames.h); they leave at flush()
  /// @param rali       the vehicle has this board
  explicit BoardsLink(std::uint32_t vehicle_number, bool as_values = false, bool rali = true);

  [[nodiscard]] std::optional<wire::Board> board_of(std::string_view port) const;
  [[nodiscard]] std::vector<std::string> ports() const;

  /// A byte stream has opened or closed. A new stream starts without remains of the old stream's last frame.
  void on_port(wire::Board board, bool up);
  /// The messages in these bytes; the reference is valid until the next call.
  [[nodiscard]] const std::vector<wire::BoardMessage>& on_bytes(wire::Board board, std::string_view bytes);

  /// Likewise of frames passed on as values, all of one board.
  void on_frames(std::span<const wire::BoardFrames::Frame> frames);

  /// The program starts: its uptime counts from now.
  void start(SimTime now) { started_ = now; }
  [[nodiscard]] SimDuration uptime(SimTime now) const { return now - started_; }
  [[nodiscard]] const std::optional<wire::Power>& power() const { return power_; }
  [[nodiscard]] const std::optional<wire::Ranges>& ranges() const { return ranges_; }
  [[nodiscard]] const std::optional<wire::PilsParts>& pils() const { return pils_; }
  /// Once: a board that has another session than before although its port stayed open, so its supply had failed.
  [[nodiscard]] std::optional<wire::Board> take_restarted() { return std::exchange(restarted_, std::nullopt); }

  /// Requests a self-test of each board that the vehicle has. Only at standstill.
  void request_self_test(SimTime now, wire::Effects& effects);
  [[nodiscard]] const wire::module_link::SelfTests& self_tests() const { return self_tests_; }

  /// True once after new ranges have come.
  [[nodiscard]] bool take_new_ranges();

  void send(wire::Board board, const wire::BoardMessage& message, wire::Effects& effects);
  /// Lets all frames leave that wait to be passed on as values.
  void flush(wire::Effects& effects);
  /// Sends heartbeats to every board at 10 Hz, and requests to boards that have not identified themselves yet.
  void on_tick(SimTime now, wire::Effects& effects);

  struct Health {
    bool connected{false};
    std::optional<wire::Hello> hello;  ///< since the port came
    std::uint8_t self_test{0};
    std::uint32_t uptime_ms{0};
    std::uint16_t frames_bad{0};     ///< that the board received
    std::uint16_t frames_missed{0};  ///< likewise
  };
  [[nodiscard]] const Health& health(wire::Board board) const { return link(board).health; }
  struct Frames {
    std::uint64_t good;    ///< received from the board
    std::uint32_t bad;     ///< by either side
    std::uint32_t missed;  ///< by either side
  };
  [[nodiscard]] Frames frames(wire::Board board) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Link {
    std::string port;
    wire::module_link::Encoder encoder;
    wire::module_link::Decoder decoder;
    Health health;
    std::uint64_t frames_good{0};  ///< the decoder's own count wraps
  };
  void take(Link& of, const wire::BoardMessage& message);
  [[nodiscard]] Link& link(wire::Board board) { return links_[index(board)]; }
  [[nodiscard]] const Link& link(wire::Board board) const { return links_[index(board)]; }
  [[nodiscard]] static std::size_t index(wire::Board board) { return static_cast<std::size_t>(board) - 1; }

  std::vector<wire::Board> boards_;  ///< that the vehicle has
  std::array<Link, wire::all_boards.size()> links_;
  std::vector<wire::BoardMessage> received_;
  std::optional<wire::FrameBatch> batch_;  ///< where frames are passed on as values
  SimTime started_{};
  Periodic heartbeat_timer_;
  std::optional<wire::Power> power_;
  std::optional<wire::Ranges> ranges_;
  std::optional<wire::PilsParts> pils_;
  std::optional<wire::Board> restarted_;
  wire::module_link::SelfTests self_tests_;
  bool new_ranges_{false};
};

}  // namespace cosiva::aiv
