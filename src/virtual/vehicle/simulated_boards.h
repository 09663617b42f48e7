#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::virtual_side {

/// The boards of one virtual AIV, as its on-board program knows them: the frames of the module link in both directions.
/// There are no wires. Invariant: no frame is damaged.
class SimulatedBoards {
 public:
  /// The motors of PILS stop by themselves this long after the last Drive.
  static constexpr SimDuration drive_timeout = std::chrono::milliseconds{300};

  /// @param session  of this power-up
  explicit SimulatedBoards(std::uint32_t session) : session_{session} {}

  void power_up(SimTime now);
  void on_bytes(SimTime now, wire::Board board, std::string_view bytes);

  /// The boards' measurements of the body.
  struct Measured {
    double odometer_m;  ///< in the body frame; all others are in the travel frame
    double speed_mps;
    bool line_lost;
    const Pose2* manoeuvre{nullptr};  ///< pose relative to the start of the manoeuvre, if there is one
    bool indirect{false};             ///< the travel frame is the body frame turned round
  };
  /// Called at every tick: lets each board send its due messages; their bytes are available from `spoken` until the
  /// next call.
  void speak(SimTime now, const Measured& measured);
  [[nodiscard]] const std::string& spoken(wire::Board board) const { return line(board).out; }

  /// PRAV has read a number. PRAV sends it with a later `speak`, delayed like that of a real reader.
  void on_tag(SimTime read_at, std::uint32_t number) { readings_.push_back({read_at, number}); }
  /// The command to the motors; nothing: brake.
  [[nodiscard]] const wire::Drive* drive(SimTime now) const {
    return drive_ && now - driven_at_ <= drive_timeout ? &*drive_ : nullptr;
  }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Line {
    wire::module_link::Encoder encoder;
    wire::module_link::Decoder decoder;
    bool hello_due{true};  ///< after power-up, or on request
    std::optional<std::uint8_t> self_test_due{};
    std::string out;  ///< keeps its capacity
  };
  struct Reading {
    SimTime read_at;
    std::uint32_t number;
  };
  [[nodiscard]] Line& line(wire::Board board) { return lines_[static_cast<std::size_t>(board) - 1]; }
  [[nodiscard]] const Line& line(wire::Board board) const { return lines_[static_cast<std::size_t>(board) - 1]; }
  void send(wire::Board board, const wire::BoardMessage& message);
  void send_odometry(SimTime now, const Measured& measured);
  void send_readings(SimTime now);
  [[nodiscard]] std::uint32_t board_ms(SimTime now) const {
    return static_cast<std::uint32_t>((now - powered_at_) / std::chrono::milliseconds{1});
  }

  std::uint32_t session_;
  SimTime powered_at_{};
  std::array<Line, wire::all_boards.size()> lines_;
  SimTime heartbeat_next_{};
  SimTime ranges_next_{};
  SimTime power_next_{};
  std::optional<wire::Drive> drive_;
  SimTime driven_at_{};
  std::vector<Reading> readings_;
  std::vector<wire::BoardMessage> received_;
  /// A fan without echoes: virtual objects are perceived through VirtualObstacles, and a second source would contradict
  /// it.
  wire::BoardMessage no_echoes_{wire::Ranges{0, -84, 14, std::vector<std::uint16_t>(13, wire::no_echo)}};
};

}  // namespace cosiva::virtual_side
