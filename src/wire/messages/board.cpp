#include "cosiva/wire/messages/board.h"

namespace cosiva::wire {

std::string_view to_string(Board board) {
  switch (board) {
    case Board::PILS: return "PILS";
    case Board::PRAV: return "PRAV";
    case Board::DOBS: return "DOBS";
    case Board::RALI: return "RALI";
  }
  return "?";
}

std::string port_name(std::uint32_t vehicle_number, Board board) {
  return std::to_string(vehicle_number) + "/" + std::string(to_string(board));
}

}  // namespace cosiva::wire
