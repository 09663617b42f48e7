#include "cosiva/virtual/server/registry/message_counters.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void MessageCounters::on_missed(std::uint32_t missed) {
  COSIVA_EXPECT(missed < missed_per_message_max);
  missed_ += missed;
  COSIVA_EXPECT(missed_ <= messages_ * missed_per_message_max);
}

void MessageCounters::on_late() {
  COSIVA_EXPECT(missed_ >= 1);
  --missed_;
}

void MessageCounters::on_refused() {
  ++refused_;
  COSIVA_EXPECT(refused_ <= messages_);
}

void MessageCounters::on_outdated() {
  ++outdated_;
  COSIVA_EXPECT(outdated_ <= messages_);
}

void MessageCounters::on_dropped() {
  ++dropped_;
  COSIVA_EXPECT(dropped_ <= messages_);
}

void MessageCounters::archive(Archive& archive) {
  archive(messages_, missed_, refused_, v2x_refused_, outdated_, dropped_, rate_);
}

}  // namespace cosiva::virtual_side
