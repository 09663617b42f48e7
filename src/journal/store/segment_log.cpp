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
    // The next attempt may need the space of what does not count. Where this fails, too, readers skip those bytes.
    if (file_bytes_ > 0) static_cast<void>(disk_.cut(name_, file_bytes_));
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
  name_ = segment_name(next_.first);
  const auto names = disk_.names();
  if (!names) return tl::unexpected<Error>(names.error());
  // A segment of this name is one whose first write failed: none of its records counts.
  if (std::binary_search(names->begin(), names->end(), name_)) {
    if (auto removed = disk_.remove(name_); !removed) return removed;
  }
  auto file = disk_.create(name_);
  if (!file) return tl::unexpected<Error>(file.error());
  file_ = std::move(*file);
  return {};
}

}  // namespace cosiva::journal
