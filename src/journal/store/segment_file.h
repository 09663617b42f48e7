#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/journal/store/disk.h"
#include "cosiva/journal/store/segment.h"

namespace cosiva::journal {

/// A file of a store, by its name.
struct SegmentFile {
  std::string name;
  RecordNumber first;
};

/// One segment of a store, as far as it counts.
struct SegmentSummary {
  std::string name;
  RecordNumber first;
  RecordNumber next;               ///< the first record of the following segment, or of the next one to be written
  std::size_t bytes;               ///< of the file
  std::size_t intact_bytes;        ///< those that count; the others were written again in the next segment, or are torn
  std::optional<SimTime> last_at;  ///< the time of its last record
  std::optional<RecordNumber> checkpoint;  ///< its last one (is_checkpoint)
};

/// What is read of a segment's file.
struct SegmentReading {
  SegmentSummary summary;
  std::optional<SegmentStart> begin;  ///< nothing where the file does not belong into the store here
  std::optional<SegmentStart> next;   ///< where the store continues
  bool torn;
  std::optional<Error> damage;  ///< as StoreContent::damage
};

/// The segments of a store, in their order. Fails as the disk does.
[[nodiscard]] Result<std::vector<SegmentFile>> segment_files(const Disk& disk);
/// Whether a segment that begins at `start` is that of the file, and continues the store at `expected`, where that is
/// known. Fails ("store.mixed", "store.gap", "store.chain"), and names the file.
[[nodiscard]] Result<void> check_start(const SegmentStart& start, const SegmentFile& file,
                                       const std::optional<SegmentStart>& expected);
/// Reads one from its bytes.
/// @param following  the first record of the next segment; nothing for the last one
/// @param expected   where the store continues; nothing before the first segment that is read
/// @param on_record  may be empty
[[nodiscard]] SegmentReading read_segment_bytes(std::string_view bytes, const SegmentFile& file,
                                                std::optional<RecordNumber> following,
                                                const std::optional<SegmentStart>& expected, const OnRecord& on_record);
/// Reads one from the disk. Fails as the disk does.
[[nodiscard]] Result<SegmentReading> read_segment_file(const Disk& disk, const SegmentFile& file,
                                                       std::optional<RecordNumber> following,
                                                       const std::optional<SegmentStart>& expected,
                                                       const OnRecord& on_record);

}  // namespace cosiva::journal
