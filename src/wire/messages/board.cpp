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

std::string_view to_string(Part part) {
  switch (part) {
    case Part::controller: return "controller";
    case Part::BRAC: return "BRAC";
    case Part::DEMS: return "DEMS";
    case Part::PMOT: return "PMOT";
    case Part::RFID: return "RFID";
    case Part::AFFI: return "AFFI";
    case Part::ranging: return "ranging";
    case Part::regulator: return "regulator";
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
  return std::string(to_string(static_cast<Part>(part))) + ": " + std::string(to_string(static_cast<Finding>(finding)));
}

std::string port_name(std::uint32_t vehicle_number, Board board) {
  return std::to_string(vehicle_number) + "/" + std::string(to_string(board));
}

}  // namespace cosiva::wire
