#include "cosiva/aiv/onboard/supervision.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

Supervision::Supervision(SimDuration timeout, bool rali) : timeout_{timeout}, rali_fitted_{rali} {
  COSIVA_EXPECT(timeout > SimDuration::zero());
}

void Supervision::on_server_heartbeat(SimTime now) {
  server_heartbeat_at_ = now;
  server_left_ = false;
}

void Supervision::expect_server(SimTime now) {
  // The time of the last heartbeat stays: a vehicle that is given one owner after the other is not supervised less.
  server_heartbeat_at_ = server_heartbeat_at_.value_or(now);
  server_left_ = false;
}

void Supervision::server_left() { server_left_ = server_heartbeat_at_.has_value(); }

bool Supervision::release_server() {
  COSIVA_EXPECT(!server_left_ || server_heartbeat_at_);
  if (!server_left_) return false;
  server_heartbeat_at_.reset();
  server_left_ = false;
  return true;
}

void Supervision::archive(Archive& archive) {
  archive(broker_message_at_, link_check_timer_, server_heartbeat_at_, server_left_, board_message_at_);
}

}  // namespace cosiva::aiv
