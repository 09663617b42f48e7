#include "cosiva/journal/store/store_reading.h"

#include <string_view>
#include <utility>

namespace cosiva::journal {

Result<StoreContent> read_store(const Disk& disk, const OnRecord& on_record, RecordNumber from) {
  const auto files = segment_files(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  StoreContent content;
  for (std::size_t i = 0; i < files->size() && !content.damage; ++i) {
    if ((*files)[i].first < from) continue;
    std::optional<RecordNumber> following;
    if (i + 1 < files->size()) following = (*files)[i + 1].first;
    auto reading = read_segment_file(disk, (*files)[i], following, content.next, on_record);
    if (!reading) return tl::unexpected<Error>(reading.error());
    if (content.segments.empty()) content.begin = reading->begin;
    if (reading->next) content.next = reading->next;
    content.torn = reading->torn;
    content.damage = std::move(reading->damage);
    content.segments.push_back(std::move(reading->summary));
  }
  return content;
}

Result<RecordNumber> last_checkpoint(const Disk& disk) {
  const auto files = segment_files(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  for (std::size_t i = files->size(); i > 0; --i) {
    std::optional<RecordNumber> following;
    if (i < files->size()) following = (*files)[i].first;
    const auto reading = read_segment_file(disk, (*files)[i - 1], following, {}, {});
    if (!reading) return tl::unexpected<Error>(reading.error());
    if (reading->summary.checkpoint) return reading->summary.first;
  }
  return 0;
}

namespace {

/// Keeps what counts of a segment, in a new file: what was read may be in the memory of the file system only, if a sync
/// failed before, and would be lost in a later power failure although records follow that were durable. A segment
/// without any record would prevent the next one, of the same name.
Result<void> keep_intact(Disk& disk, const SegmentSummary& segment) {
  if (segment.next == segment.first) return disk.remove(segment.name);
  const auto bytes = disk.read(segment.name);
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  return disk.replace(segment.name, std::string_view{*bytes}.substr(0, segment.intact_bytes));
}

}  // namespace

Result<StoreContent> recover_store(Disk& disk, const OnRecord& on_record, RecordNumber from) {
  auto content = read_store(disk, on_record, from);
  if (!content) return content;
  if (content->damage) return tl::unexpected<Error>(*content->damage);
  if (content->segments.empty()) return content;
  if (const auto kept = keep_intact(disk, content->segments.back()); !kept) return tl::unexpected<Error>(kept.error());
  return content;
}

Result<StoreContent> repair_store(Disk& disk) {
  auto content = read_store(disk);
  if (!content || !content->damage) return content;
  const auto files = segment_files(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  const SegmentSummary& damaged = content->segments.back();
  for (const SegmentFile& file : *files) {
    if (file.first < damaged.first) continue;
    const auto bytes = disk.read(file.name);
    if (!bytes) return tl::unexpected<Error>(bytes.error());
    if (const auto kept = disk.replace(file.name + ".damaged", *bytes); !kept)
      return tl::unexpected<Error>(kept.error());
    const auto mended = file.first == damaged.first ? keep_intact(disk, damaged) : disk.remove(file.name);
    if (!mended) return tl::unexpected<Error>(mended.error());
  }
  return content;
}

Result<std::size_t> compact_store(Disk& disk, RecordNumber from) {
  const auto files = segment_files(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  std::size_t removed = 0;
  for (std::size_t i = 0; i + 1 < files->size() && (*files)[i + 1].first <= from; ++i) {
    if (const auto done = disk.remove((*files)[i].name); !done) return tl::unexpected<Error>(done.error());
    ++removed;
  }
  return removed;
}

}  // namespace cosiva::journal
