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

std::string_view to_string(BoardPart part) {
  switch (part) {
    case BoardPart::controller: return "controller";
    case BoardPart::BRAC: return "BRAC";
    case BoardPart::DEMS: return "DEMS";
    case BoardPart::PMOT: return "PMOT";
    case BoardPart::RFID: return "RFID";
    case BoardPart::AFFI: return "AFFI";
    case BoardPart::ranging: return "ranging";
    case BoardPart::regulator: return "regulator";
  }
  return "?";
}

std::string_view to_string(Finding finding) {
  switch (finding) {
    case Finding::passed: return "passed";
    case Finding::no_response: return "no response";
    case Finding::implausible: return "implausible readings";
    case Finding::does_not_turn: return "does not turn";
    case Finding::low_supply: return "supply too low";
  }
  return "?";
}

std::string fault_text(std::uint8_t code) {
  const unsigned part = code >> 4U;
  const unsigned finding = code & 0xFU;
  if (part < 1 || part > part_count || finding < 1 || finding >= finding_count) return "fault " + std::to_string(code);
  return std::string(to_string(static_cast<BoardPart>(part))) + ": " +
         std::string(to_string(static_cast<Finding>(finding)));
}

std::string port_name(std::uint32_t vehicle_number, Board board) {
  return std::to_string(vehicle_number) + "/" + std::string(to_string(board));
}

}  // namespace cosiva::wire
