#include "cosiva/journal/store/segment_file.h"

#include <utility>

#include "cosiva/journal/store/restart.h"

namespace cosiva::journal {
namespace {

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

Result<std::vector<SegmentFile>> segment_files(const Disk& disk) {
  const auto names = disk.names();
  if (!names) return tl::unexpected<Error>(names.error());
  std::vector<SegmentFile> files;
  for (const std::string& name : *names) {
    if (const auto first = segment_number(name)) files.push_back({name, *first});
  }
  return files;
}

Result<SegmentReading> read_segment_file(const Disk& disk, const SegmentFile& file,
                                         std::optional<RecordNumber> following,
                                         const std::optional<SegmentStart>& expected, const OnRecord& on_record) {
  const auto bytes = disk.read(file.name);
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  const auto start = segment_start(*bytes);
  const auto fits = start ? check_start(*start, file, expected) : Result<void>{};
  const bool counts = start && fits;
  SegmentReading reading{};
  const OnRecord observed = [&](RecordNumber number, const RecordView& record) {
    reading.summary.last_at = record.at;
    if (is_checkpoint(record)) reading.summary.checkpoint = number;
    if (on_record) on_record(number, record);
  };
  const SegmentContent segment = read_segment(*bytes, following.value_or(no_record), counts ? observed : OnRecord{});
  reading.damage = fits ? segment.damage : fits.error();
  reading.torn = segment.torn;
  if (!reading.damage && segment.torn && following)
    reading.damage = Error{"store.damaged", "the segment is cut short, although another one follows", {}};
  if (reading.damage) reading.damage->location = at_file(*reading.damage, file.name);
  reading.summary.name = file.name;
  reading.summary.first = file.first;
  reading.summary.next = counts ? segment.next : file.first;
  reading.summary.bytes = bytes->size();
  reading.summary.intact_bytes = counts ? segment.intact_bytes : 0;
  if (counts) {
    reading.begin = segment.start;
    reading.next = SegmentStart{segment.start.store, segment.next, segment.chain};
  }
  return reading;
}

}  // namespace cosiva::journal
