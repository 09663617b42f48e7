#include "cosiva/journal/store/segment_log.h"

#include <algorithm>
#include <string>

#include "cosiva/base/expect.h"

namespace cosiva::journal {

Result<void> SegmentLog::write(const Batch& batch) {
  COSIVA_EXPECT(!batch.empty());
  std::string bytes;
  if (!file_ || file_bytes_ >= segment_bytes_) {
    if (auto begun = begin_segment(); !begun) return begun;
    bytes = segment_header(next_);
  }
  SegmentStart next = next_;
  bytes += sealed(batch, next);
  if (auto written = write(bytes); !written) {
    file_.reset();
    return written;
  }
  file_bytes_ += bytes.size();
  next_ = next;
  return {};
}

Result<void> SegmentLog::write(const std::string& bytes) {
  if (auto appended = file_->append(bytes); !appended) return appended;
  return file_->sync();
}

Result<void> SegmentLog::begin_segment() {
  file_.reset();
  file_bytes_ = 0;
  const std::string name = segment_name(next_.first);
  const auto names = disk_.names();
  if (!names) return tl::unexpected<Error>(names.error());
  // A segment of this name is one whose first write failed: none of its records counts.
  if (std::binary_search(names->begin(), names->end(), name)) {
    if (auto removed = disk_.remove(name); !removed) return removed;
  }
  auto file = disk_.create(name);
  if (!file) return tl::unexpected<Error>(file.error());
  file_ = std::move(*file);
  return {};
}

}  // namespace cosiva::journal
