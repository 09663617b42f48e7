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
    case wire::InputKind::snapshot:
      inputs_.clear();
      state_.reset();
      if (auto state = core_state(record)) state_ = std::move(*state);
      complete_ = state_.has_value();
      break;
    case wire::InputKind::persisted:
      persisted_.reset();
      if (!record.payload.empty()) persisted_ = std::string(record.payload);
      if (is_checkpoint(record)) checkpoint_ = number;
      break;
    default: take_input(record);
  }
  COSIVA_EXPECT(!checkpoint_ || *checkpoint_ <= number);
}

void Restart::take_input(const RecordView& record) {
  const auto kind = static_cast<wire::InputKind>(record.kind);
  if (kind == wire::InputKind::command && record.flag && !accepted_.empty()) accepted_.pop_front();
  if (kind == wire::InputKind::configure) {  // a new core, which has taken nothing of the one before
    state_.reset();
    inputs_.clear();
    complete_ = true;
  }
  if (complete_) inputs_.push_back(record.input());
}

}  // namespace cosiva::journal
