#include "cosiva/virtual/server/context/server_link.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void ServerLink::came_up(SimTime now) {
  COSIVA_EXPECT(!up_);
  up_ = true;
  up_since_ = now;
  next_heartbeat_ = now;
}

void ServerLink::went_down() {
  COSIVA_EXPECT(up_);
  up_ = false;
  synchronised_ = false;
}

void ServerLink::set_synchronised() {
  COSIVA_EXPECT(up_ && !synchronised_);
  synchronised_ = true;
}

std::optional<std::string> ServerLink::take_heartbeat(SimTime now) {
  if (!up_ || now < next_heartbeat_) return std::nullopt;
  std::string heartbeat =
      "{\"headerId\":" + std::to_string(heartbeat_id_) + ",\"timestamp\":\"" + to_iso8601(now) + "\"}";
  ++heartbeat_id_;
  next_heartbeat_ = std::max(next_heartbeat_ + heartbeat_period, now);
  return heartbeat;
}

}  // namespace cosiva::virtual_side
