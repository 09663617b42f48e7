#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "cosiva/base/result.h"
#include "cosiva/journal/store/batch.h"
#include "cosiva/journal/store/disk.h"
#include "cosiva/journal/store/segment.h"

namespace cosiva::journal {

/// Writes batches to the segments of a store, each durable before the next. After a failure the same batch can be
/// written again: it then begins a new segment, because a file system may report a later sync as successful although it
/// has lost the bytes of the failed one.
///
/// Invariant: the hash is that over all records written, and the next batch begins with the record that follows them.
class SegmentLog {
 public:
  /// @param next           where the store continues: in a new segment
  /// @param segment_bytes  a segment that has reached this size is followed by another one
  SegmentLog(Disk& disk, const SegmentStart& next, std::size_t segment_bytes)
      : disk_{disk}, next_{next}, segment_bytes_{segment_bytes} {}

  /// The batch is durable when this returns. Fails as the disk does; then none of the batch counts, and what was
  /// written of it is cut off: otherwise a batch too large for the disk would leave no space for any other.
  [[nodiscard]] Result<void> write(const Batch& batch);
  /// The next batch begins a new segment.
  void end_segment() { file_.reset(); }
  /// Where the store continues.
  [[nodiscard]] const SegmentStart& next() const { return next_; }

 private:
  struct Appended {
    SegmentStart next;
    std::size_t bytes;
  };
  /// Large batches in portions: the disk writes them while the hash is computed.
  [[nodiscard]] Result<Appended> append(const Batch& batch);
  [[nodiscard]] Result<void> begin_segment();

  Disk& disk_;
  SegmentStart next_;
  std::size_t segment_bytes_;
  std::unique_ptr<DiskFile> file_;
  std::string name_;  ///< of the segment begun last
  std::size_t file_bytes_{0};
};

}  // namespace cosiva::journal
