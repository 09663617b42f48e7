#include "cosiva/journal/store/store_verifier.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::journal {

Result<bool> StoreVerifier::step() {
  const auto files = segment_files(disk_);
  if (!files) return tl::unexpected<Error>(files.error());
  const RecordNumber from = verified_.empty() ? 0 : verified_.back().next;
  for (std::size_t i = 0; i + 1 < files->size(); ++i) {
    const SegmentFile& file = (*files)[i];
    if (file.first < from) continue;
    auto reading = read_segment_file(disk_, file, (*files)[i + 1].first, next_, {});
    if (!reading) return tl::unexpected<Error>(reading.error());
    if (reading->damage) return tl::unexpected<Error>(*reading->damage);
    next_ = reading->next;
    verified_.push_back(std::move(reading->summary));
    return true;
  }
  return false;
}

void StoreVerifier::removed() {
  COSIVA_EXPECT(!verified_.empty());
  verified_.pop_front();
}

}  // namespace cosiva::journal
