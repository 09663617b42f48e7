#include "cosiva/virtual/server/registry/membership.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void Membership::on_message(SimTime now) {
  COSIVA_EXPECT(last_received_ <= now);
  last_received_ = now;
}

void Membership::on_retired() {
  retired_ = true;
  awaited_ = false;
  handed_over_.reset();
}

void Membership::on_departed() {
  on_retired();
  departed_ = true;
}

void Membership::on_awaited() {
  COSIVA_EXPECT(!retired_);
  awaited_ = true;
}

void Membership::on_handed_over(SimTime now) {
  COSIVA_EXPECT(!retired_);
  COSIVA_EXPECT(!handed_over_ || handed_over_->last <= now);
  handed_over_ = {handed_over_ ? handed_over_->first : now, now};
}

void Membership::archive(Archive& archive) {
  archive(first_received_, last_received_, retired_, departed_, awaited_, handed_over_);
}

}  // namespace cosiva::virtual_side
