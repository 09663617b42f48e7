#include "cosiva/virtual/server/registry/connection_record.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

bool ConnectionRecord::on_connection(wire::ConnectionState state, SimTime now, SimTime stamp) {
  COSIVA_EXPECT(now >= changed_at_);
  const bool was_online = state_ == wire::ConnectionState::online;
  state_ = state;
  changed_at_ = now;
  if (state != wire::ConnectionState::online) return false;
  return std::exchange(online_stamp_, stamp) != stamp || !was_online;
}

bool ConnectionRecord::on_report(SimTime now) {
  if (online() || now - changed_at_ <= will_outlived) return false;
  state_ = wire::ConnectionState::online;
  changed_at_ = now;
  return true;
}

void ConnectionRecord::archive(Archive& archive) { archive(state_, changed_at_, online_stamp_); }

}  // namespace cosiva::virtual_side
