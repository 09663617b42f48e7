#include "cosiva/journal/store/restart.h"

#include "cosiva/base/expect.h"
#include "cosiva/journal/format.h"

namespace cosiva::journal {

bool is_checkpoint(const RecordView& record) {
  return record.kind == static_cast<std::uint8_t>(wire::InputKind::persisted) && record.flag;
}

void Restart::take(RecordNumber number, const RecordView& record) {
  if (record.kind == format::end_kind) return;
  switch (static_cast<wire::InputKind>(record.kind)) {
    case wire::InputKind::proposal: accepted_.push_back(record.input()); break;
    case wire::InputKind::persisted:
      persisted_.reset();
      if (!record.payload.empty()) persisted_ = std::string(record.payload);
      if (is_checkpoint(record)) checkpoint_ = number;
      break;
    case wire::InputKind::command:
      if (!record.flag || accepted_.empty()) break;
      accepted_.pop_front();
      break;
    default: break;
  }
  COSIVA_EXPECT(!checkpoint_ || *checkpoint_ <= number);
}

}  // namespace cosiva::journal
