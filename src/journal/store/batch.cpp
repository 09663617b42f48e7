#include "cosiva/journal/store/batch.h"

#include "cosiva/base/expect.h"
#include "cosiva/journal/record.h"

namespace cosiva::journal {

void Batch::add(const wire::Input& input) {
  append_record(records_, input);
  ++count_;
  COSIVA_EXPECT(count_ > 0);
}

void Batch::add(const Batch& other) {
  records_ += other.records_;
  count_ += other.count_;
  COSIVA_EXPECT(count_ >= other.count_);
}

}  // namespace cosiva::journal
