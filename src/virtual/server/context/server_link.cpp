#include "cosiva/virtual/server/context/server_link.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
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
  message_received_ = false;
}

void ServerLink::set_synchronised() {
  COSIVA_EXPECT(up_ && !synchronised_);
  synchronised_ = true;
}

bool ServerLink::take_message_received() {
  COSIVA_EXPECT(up_ || !message_received_);
  return std::exchange(message_received_, false);
}

std::optional<std::string> ServerLink::take_heartbeat(SimTime now) {
  if (!up_ || now < next_heartbeat_) return std::nullopt;
  std::string heartbeat =
      "{\"headerId\":" + std::to_string(heartbeat_id_) + ",\"timestamp\":\"" + to_iso8601(now) + "\"}";
  ++heartbeat_id_;
  next_heartbeat_ = std::max(next_heartbeat_ + heartbeat_period, now);
  return heartbeat;
}

void ServerLink::archive(Archive& archive) {
  archive(up_, message_received_, synchronised_, up_since_, next_heartbeat_, heartbeat_id_);
}

}  // namespace cosiva::virtual_side
