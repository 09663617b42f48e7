#include "cosiva/journal/store/segment_log.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "cosiva/base/expect.h"

namespace cosiva::journal {
namespace {

constexpr std::size_t portion_bytes = std::size_t{512} << 10U;

}  // namespace

Result<void> SegmentLog::write(const Batch& batch) {
  COSIVA_EXPECT(!batch.empty());
  if (!file_ || file_bytes_ >= segment_bytes_) {
    if (auto begun = begin_segment(); !begun) return begun;
  }
  const auto appended = append(batch);
  if (auto durable = appended ? file_->sync() : tl::unexpected<Error>(appended.error()); !durable) {
    file_.reset();
    // The next attempt may need the space of what does not count. Where this fails, too, readers skip those bytes.
    if (file_bytes_ > 0) static_cast<void>(disk_.cut(name_, file_bytes_));
    return durable;
  }
  file_bytes_ += appended->bytes;
  next_ = appended->next;
  return {};
}

Result<SegmentLog::Appended> SegmentLog::append(const Batch& batch) {
  const std::string header = batch_header(batch, next_);
  ChainHash hash{next_.chain, header};
  std::string first = (file_bytes_ == 0 ? segment_header(next_) : "") + header;
  const std::size_t bytes = first.size() + batch.records().size() + Chain::bytes_count;
  std::string_view left = batch.records();
  for (; left.size() > portion_bytes; left.remove_prefix(portion_bytes)) {
    const std::string_view portion = left.substr(0, portion_bytes);
    const auto appended = file_->append(first.empty() ? portion : first.append(portion));
    if (!appended) return tl::unexpected<Error>(appended.error());
    hash.add(portion);
    first.clear();
  }
  hash.add(left);
  const Chain chain = hash.end();
  if (auto appended = file_->append(first.append(left).append(chain.bytes())); !appended)
    return tl::unexpected<Error>(appended.error());
  return Appended{{next_.store, next_.first + batch.count(), chain}, bytes};
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
