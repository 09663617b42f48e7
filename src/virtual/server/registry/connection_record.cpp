#include "cosiva/virtual/server/registry/connection_record.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

bool ConnectionRecord::on_connection(wire::ConnectionState state, SimTime now) {
  COSIVA_EXPECT(now >= changed_at_);
  const bool was_online = state_ == wire::ConnectionState::online;
  state_ = state;
  changed_at_ = now;
  return state == wire::ConnectionState::online && !was_online;
}

bool ConnectionRecord::on_report(SimTime now) {
  if (online() || now - changed_at_ <= will_outlived) return false;
  return on_connection(wire::ConnectionState::online, now);
}

void ConnectionRecord::archive(Archive& archive) { archive(state_, changed_at_); }

}  // namespace cosiva::virtual_side
