#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/time.h"
#include "wire/board.h"
#include "wire/core.h"
#include "wire/module_link/module_link.h"

namespace cosiva::aiv {

/// One module link per board: frames here, values above. It knows who answered and in what health (A18).
class BoardsLink {
 public:
  explicit BoardsLink(std::uint32_t vehicle_number);

  [[nodiscard]] std::optional<wire::Board> board_of(std::string_view port) const;
  [[nodiscard]] std::vector<std::string> ports() const;

  /// A byte stream came or went. A fresh one starts without remains of the old one's last frame.
  void on_port(wire::Board board, bool up);
  /// The messages in these bytes; the reference stays good until the next call.
  [[nodiscard]] const std::vector<wire::BoardMessage>& on_bytes(wire::Board board, std::string_view bytes);

  void send(wire::Board board, const wire::BoardMessage& message, wire::Effects& effects);
  /// Beats to every board, 10 Hz is due; asks boards that did not say yet who they are.
  void beat(std::uint32_t uptime_ms, wire::Effects& effects);

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

 private:
  struct Link {
    std::string port;
    wire::module_link::Encoder encoder;
    wire::module_link::Decoder decoder;
    Health health;
    std::uint64_t frames_good{0};  ///< the decoder's own count goes round
  };
  [[nodiscard]] Link& link(wire::Board board) { return links_[index(board)]; }
  [[nodiscard]] const Link& link(wire::Board board) const { return links_[index(board)]; }
  [[nodiscard]] static std::size_t index(wire::Board board) { return static_cast<std::size_t>(board) - 1; }

  std::array<Link, wire::all_boards.size()> links_;
  std::vector<wire::BoardMessage> received_;
};

}  // namespace cosiva::aiv
