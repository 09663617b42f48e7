#include "cosiva/journal/store/segment_file.h"

#include <utility>

#include "cosiva/journal/store/restart.h"

namespace cosiva::journal {
namespace {

Error at_file(Error error, const std::string& name) {
  error.location = name + (error.location.empty() ? "" : ": " + error.location);
  return error;
}

/// Nothing where the segment begins there; nothing is known before the first segment.
std::optional<Error> deviation(const SegmentStart& start, const SegmentFile& file,
                               const std::optional<SegmentStart>& expected) {
  if (start.first != file.first)
    return Error{
        "store.mixed", "the segment begins with record " + std::to_string(start.first) + ", unlike its name", {}};
  if (!expected) return std::nullopt;
  if (start.store != expected->store) return Error{"store.mixed", "the segment belongs to another store", {}};
  if (start.first != expected->first)
    return Error{"store.gap",
                 "the segment begins with record " + std::to_string(start.first) + ", but record " +
                     std::to_string(expected->first) + " would follow: records are missing",
                 {}};
  if (start.chain != expected->chain)
    return Error{"store.chain", "the segment does not continue the hash of the one before", {}};
  return std::nullopt;
}

}  // namespace

Result<void> check_start(const SegmentStart& start, const SegmentFile& file,
                         const std::optional<SegmentStart>& expected) {
  if (auto found = deviation(start, file, expected))
    return tl::unexpected<Error>(at_file(std::move(*found), file.name));
  return {};
}

Result<std::vector<SegmentFile>> segment_files(const Disk& disk) {
  const auto names = disk.names();
  if (!names) return tl::unexpected<Error>(names.error());
  std::vector<SegmentFile> files;
  for (const std::string& name : *names) {
    if (const auto first = segment_number(name)) files.push_back({name, *first});
  }
  return files;
}

SegmentReading read_segment_bytes(std::string_view bytes, const SegmentFile& file,
                                  std::optional<RecordNumber> following, const std::optional<SegmentStart>& expected,
                                  const OnRecord& on_record) {
  const auto start = segment_start(bytes);
  const auto deviating = start ? deviation(*start, file, expected) : std::nullopt;
  const bool counts = start && !deviating;
  SegmentReading reading{};
  const OnRecord observed = [&](RecordNumber number, const RecordView& record) {
    reading.summary.last_at = record.at;
    if (is_checkpoint(record)) reading.summary.checkpoint = number;
    if (on_record) on_record(number, record);
  };
  const SegmentContent segment = read_segment(bytes, following.value_or(no_record), counts ? observed : OnRecord{});
  reading.damage = deviating ? deviating : segment.damage;
  reading.torn = segment.torn;
  if (!reading.damage && segment.torn && following)
    reading.damage = Error{"store.damaged", "the segment is cut short, although another one follows", {}};
  if (reading.damage) reading.damage = at_file(std::move(*reading.damage), file.name);
  reading.summary.name = file.name;
  reading.summary.first = file.first;
  reading.summary.next = counts ? segment.next : file.first;
  reading.summary.bytes = bytes.size();
  reading.summary.intact_bytes = counts ? segment.intact_bytes : 0;
  if (counts) {
    reading.begin = segment.start;
    reading.next = SegmentStart{segment.start.store, segment.next, segment.chain};
  }
  return reading;
}

Result<SegmentReading> read_segment_file(const Disk& disk, const SegmentFile& file,
                                         std::optional<RecordNumber> following,
                                         const std::optional<SegmentStart>& expected, const OnRecord& on_record) {
  const auto bytes = disk.read(file.name);
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  return read_segment_bytes(*bytes, file, following, expected, on_record);
}

}  // namespace cosiva::journal
