#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/journal/store/disk.h"
#include "cosiva/journal/store/segment.h"
#include "cosiva/journal/store/segment_file.h"

namespace cosiva::journal {

/// What is read of a store, up to the first damage.
struct StoreContent {
  std::vector<SegmentSummary> segments;
  /// Where the first segment that was read begins.
  std::optional<SegmentStart> begin;
  /// Where the store continues; nothing for a folder without segments, and where the only one is torn at once.
  std::optional<SegmentStart> next;
  /// The last segment ends with bytes that a power failure left of a write.
  bool torn{false};
  /// Of a segment (SegmentContent::damage), or between segments ("store.gap", "store.chain", "store.mixed"); names the
  /// file. The last summary is that of the damaged segment.
  std::optional<Error> damage;
};

/// Reads all segments, and checks that each continues the one before. Fails as the disk does. `on_record` may be empty.
[[nodiscard]] Result<StoreContent> read_store(const Disk& disk, const OnRecord& on_record = {});

/// From which segment on a store is recovered.
enum class RecoverFrom : std::uint8_t {
  beginning,
  checkpoint,  ///< the last one in which a restart can begin; where there is none, the first
};
/// Reads the segments of a store once each, checks that each continues the one before, and makes all that was read
/// durable; a torn tail is cut off, because nothing of it was confirmed. Fails as the disk does, and with the damage.
/// `on_record` may be empty; it is called where nothing is damaged.
[[nodiscard]] Result<StoreContent> recover_store(Disk& disk, const OnRecord& on_record = {},
                                                 RecoverFrom from = RecoverFrom::beginning);

/// Makes a damaged store usable: keeps all records before the damage, and renames what follows to "….damaged". Returns
/// what was read, with the damage.
[[nodiscard]] Result<StoreContent> repair_store(Disk& disk);
/// Removes the segments whose records are all before `from`; returns how many.
[[nodiscard]] Result<std::size_t> compact_store(Disk& disk, RecordNumber from);

}  // namespace cosiva::journal
