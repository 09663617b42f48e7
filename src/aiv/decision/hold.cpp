#include "cosiva/aiv/decision/hold.h"

#include "cosiva/base/archive.h"

namespace cosiva::aiv {

std::string_view to_string(Hold hold) {
  switch (hold) {
    case Hold::paused: return "paused";
    case Hold::broker_lost: return "broker lost";
    case Hold::server_lost: return "server lost";
    case Hold::board_lost: return "board lost";
    case Hold::board_faulty: return "board faulty";
    case Hold::line_lost: return "line lost";
    case Hold::zone_change: return "zone change";
    case Hold::action: return "action";
  }
  return "?";
}

void HoldSet::archive(Archive& archive) { archive(bits_); }

}  // namespace cosiva::aiv
