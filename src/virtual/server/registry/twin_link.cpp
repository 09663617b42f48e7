#include "cosiva/virtual/server/registry/twin_link.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void TwinLink::on_appeared(std::size_t twin) {
  COSIVA_EXPECT(!twin_);
  twin_ = twin;
}

void TwinLink::on_monitored(std::size_t entity) {
  COSIVA_EXPECT(!entity_);
  entity_ = entity;
}

void TwinLink::on_base(std::optional<zone::TrackPosition> end) {
  COSIVA_EXPECT(twin_);
  base_end_ = end;
}

void TwinLink::on_shift(SimTime now, double m) {
  COSIVA_EXPECT(m >= 0.0);
  if (shifted_at_ && now - *shifted_at_ <= shift_kept && m < shift_m_) return;
  shifted_at_ = now;
  shift_m_ = m;
}

void TwinLink::on_returned() {
  present_ = false;
  base_end_.reset();
  shifted_at_.reset();
}

std::size_t TwinLink::entity() const {
  COSIVA_EXPECT(entity_);
  return *entity_;
}

double TwinLink::take_shift_m(SimTime now) {
  const auto at = std::exchange(shifted_at_, std::nullopt);
  return at && now - *at <= shift_kept ? shift_m_ : 0.0;
}

void TwinLink::archive(Archive& archive) { archive(twin_, entity_, present_, base_end_, shifted_at_, shift_m_); }

}  // namespace cosiva::virtual_side
