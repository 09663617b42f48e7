#include "cosiva/journal/store/store_reading.h"

#include <string_view>
#include <utility>

namespace cosiva::journal {
namespace {

struct SegmentFile {
  std::string name;
  RecordNumber first;
};

Result<std::vector<SegmentFile>> segments_of(const Disk& disk) {
  const auto names = disk.names();
  if (!names) return tl::unexpected<Error>(names.error());
  std::vector<SegmentFile> files;
  for (const std::string& name : *names) {
    if (const auto first = segment_number(name)) files.push_back({name, *first});
  }
  return files;
}

std::string at_file(const Error& error, const std::string& name) {
  return name + (error.location.empty() ? "" : ": " + error.location);
}

/// Whether the segment begins where the store continues; nothing is known before the first segment.
Result<void> check_start(const SegmentStart& start, const SegmentFile& file, const std::optional<SegmentStart>& next) {
  if (start.first != file.first)
    return fail("store.mixed", "the segment begins with record " + std::to_string(start.first) + ", unlike its name");
  if (!next) return {};
  if (start.store != next->store) return fail("store.mixed", "the segment belongs to another store");
  if (start.first != next->first)
    return fail("store.gap", "the segment begins with record " + std::to_string(start.first) + ", but record " +
                                 std::to_string(next->first) + " would follow: records are missing");
  if (start.chain != next->chain)
    return fail("store.chain", "the segment does not continue the hash of the one before");
  return {};
}

}  // namespace

Result<StoreContent> read_store(const Disk& disk, const OnRecord& on_record) {
  const auto files = segments_of(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  StoreContent content;
  for (std::size_t i = 0; i < files->size() && !content.damage; ++i) {
    const SegmentFile& file = (*files)[i];
    const bool last = i + 1 == files->size();
    const auto bytes = disk.read(file.name);
    if (!bytes) return tl::unexpected<Error>(bytes.error());
    const auto start = segment_start(*bytes);
    const auto fits = start ? check_start(*start, file, content.next) : Result<void>{};
    const bool counts = start && fits;
    const SegmentContent segment =
        read_segment(*bytes, last ? no_record : (*files)[i + 1].first, counts ? on_record : OnRecord{});
    content.damage = fits ? segment.damage : fits.error();
    if (!content.damage && segment.torn && !last)
      content.damage = Error{"store.damaged", "the segment is cut short, although another one follows", {}};
    if (content.damage) content.damage->location = at_file(*content.damage, file.name);
    if (counts) content.next = SegmentStart{segment.start.store, segment.next, segment.chain};
    content.torn = segment.torn;
    content.segments.push_back(
        {file.name, file.first, counts ? segment.next : file.first, bytes->size(), counts ? segment.intact_bytes : 0});
  }
  return content;
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

Result<StoreContent> recover_store(Disk& disk, const OnRecord& on_record) {
  auto content = read_store(disk, on_record);
  if (!content) return content;
  if (content->damage) return tl::unexpected<Error>(*content->damage);
  if (content->segments.empty()) return content;
  if (const auto kept = keep_intact(disk, content->segments.back()); !kept) return tl::unexpected<Error>(kept.error());
  return content;
}

Result<StoreContent> repair_store(Disk& disk) {
  auto content = read_store(disk);
  if (!content || !content->damage) return content;
  const auto files = segments_of(disk);
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
  const auto files = segments_of(disk);
  if (!files) return tl::unexpected<Error>(files.error());
  std::size_t removed = 0;
  for (std::size_t i = 0; i + 1 < files->size() && (*files)[i + 1].first <= from; ++i) {
    if (const auto done = disk.remove((*files)[i].name); !done) return tl::unexpected<Error>(done.error());
    ++removed;
  }
  return removed;
}

}  // namespace cosiva::journal
