#include "cosiva/journal/store/store_reading.h"

#include <deque>
#include <string>
#include <string_view>
#include <utility>

namespace cosiva::journal {

Result<StoreContent> read_store(const Disk& disk, const OnRecord& on_record) {
  const auto files = segment_files(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  StoreContent content;
  for (std::size_t i = 0; i < files->size() && !content.damage; ++i) {
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

namespace {

/// A segment whose file has been read.
struct HeldSegment {
  SegmentFile file;
  std::string bytes;
  SegmentReading reading;
};

/// The segments of a store from the last one with a checkpoint on, or all of them, in their order.
Result<std::deque<HeldSegment>> last_segments(const Disk& disk, RecoverFrom from) {
  const auto files = segment_files(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  std::deque<HeldSegment> segments;
  for (std::size_t i = files->size(); i > 0; --i) {
    std::optional<RecordNumber> following;
    if (i < files->size()) following = (*files)[i].first;
    const SegmentFile& file = (*files)[i - 1];
    auto bytes = disk.read(file.name);
    if (!bytes) return tl::unexpected<Error>(bytes.error());
    SegmentReading reading = read_segment_bytes(*bytes, file, following, {}, {});
    const bool begins = from == RecoverFrom::checkpoint && reading.summary.checkpoint;
    segments.push_front({file, std::move(*bytes), std::move(reading)});
    if (begins) break;
  }
  return segments;
}

/// The contents of segments that continue each other. Fails with the first damage.
Result<StoreContent> joined(const std::deque<HeldSegment>& segments) {
  StoreContent content;
  for (const auto& [file, bytes, reading] : segments) {
    const auto fits = reading.begin ? check_start(*reading.begin, file, content.next) : Result<void>{};
    if (!fits) return tl::unexpected<Error>(fits.error());
    if (reading.damage) return tl::unexpected<Error>(*reading.damage);
    if (content.segments.empty()) content.begin = reading.begin;
    if (reading.next) content.next = reading.next;
    content.torn = reading.torn;
    content.segments.push_back(reading.summary);
  }
  return content;
}

std::string_view intact_part(std::string_view bytes, const SegmentSummary& segment) {
  return bytes.substr(0, segment.intact_bytes);
}

/// Keeps what counts of a segment, in a new file: what was read may be in the memory of the file system only, if a sync
/// failed before, and would be lost in a later power failure although records follow that were durable. A segment
/// without any record would prevent the next one, of the same name.
Result<void> keep_intact(Disk& disk, const SegmentSummary& segment, std::string_view bytes) {
  if (segment.next == segment.first) return disk.remove(segment.name);
  return disk.replace(segment.name, intact_part(bytes, segment));
}

}  // namespace

Result<StoreContent> recover_store(Disk& disk, const OnRecord& on_record, RecoverFrom from) {
  auto segments = last_segments(disk, from);
  if (!segments) return tl::unexpected<Error>(segments.error());
  auto content = joined(*segments);
  if (!content || segments->empty()) return content;
  const HeldSegment& last = segments->back();
  if (const auto kept = keep_intact(disk, last.reading.summary, last.bytes); !kept)
    return tl::unexpected<Error>(kept.error());
  for (; on_record && !segments->empty(); segments->pop_front())
    visit_records(intact_part(segments->front().bytes, segments->front().reading.summary), on_record);
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
    const auto mended = file.first == damaged.first ? keep_intact(disk, damaged, *bytes) : disk.remove(file.name);
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
