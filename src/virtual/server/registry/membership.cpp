#include "cosiva/virtual/server/registry/membership.h"

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void Membership::on_retired() {
  retired_ = true;
  handed_over_.reset();
}

void Membership::on_handed_over(SimTime now) {
  COSIVA_EXPECT(!retired_);
  COSIVA_EXPECT(!handed_over_ || handed_over_->last <= now);
  handed_over_ = {handed_over_ ? handed_over_->first : now, now};
}

}  // namespace cosiva::virtual_side
