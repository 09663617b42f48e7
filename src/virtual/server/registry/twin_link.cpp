#include "cosiva/virtual/server/registry/twin_link.h"

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

void TwinLink::on_returned() {
  present_ = false;
  base_end_.reset();
}

std::size_t TwinLink::entity() const {
  COSIVA_EXPECT(entity_);
  return *entity_;
}

void TwinLink::archive(Archive& archive) { archive(twin_, entity_, present_, base_end_); }

}  // namespace cosiva::virtual_side
