#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/journal/store/batch.h"
#include "cosiva/journal/store/disk.h"
#include "cosiva/journal/store/segment.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

struct GroupCommitOptions {
  /// A record waits this long at most before it is written and synced, unless others are being written then.
  std::chrono::milliseconds period{10};
  std::size_t segment_bytes{std::size_t{64} << 20U};
  std::chrono::milliseconds retry{200};  ///< after a failure
  /// Records that wait for a disk that refuses or stalls; where there are more, all of them are given up (on_gap).
  std::size_t waiting_bytes_max{std::size_t{64} << 20U};
};

struct GroupCommitHandlers {
  /// The disk refuses; called once for each change of the reason.
  std::function<void(const Error&)> on_refusal;
  /// The disk works again, and everything appended is durable.
  std::function<void()> on_recovery;
  /// This many records have been given up, and following ones are, until append_checkpoint() is called.
  std::function<void(std::uint32_t)> on_gap;
};

/// Appends the records of a loop to a store, and makes them durable together on a thread of its own: the loop never
/// waits for the disk. While the disk refuses, the records wait, and the writing is tried again.
///
/// Invariant: the records that wait follow the durable ones without a gap, or begin with a checkpoint; and no proposal
/// waits longer than one attempt to write.
class GroupCommit {
 public:
  /// @param disk      also used by others, to read and to remove old segments
  /// @param next      where the store continues
  /// @param handlers  called from the loop; each may be empty
  GroupCommit(EventLoop& loop, std::shared_ptr<journal::Disk> disk, const journal::SegmentStart& next,
              GroupCommitHandlers handlers, GroupCommitOptions options = {});
  /// Waits until everything is durable, or the disk refuses.
  ~GroupCommit();
  GroupCommit(const GroupCommit&) = delete;
  GroupCommit& operator=(const GroupCommit&) = delete;

  using Decided = std::function<void(const Result<void>&)>;
  /// Appends the records of an input that the core handles now: after a crash the store has all of them or none.
  void append(const journal::Batch& records);
  /// Likewise, without waiting for others; `durable` is called from the loop when they are, and never where they are
  /// lost.
  void append_now(const journal::Batch& records, std::function<void()> durable);
  /// Likewise, of records from which a restart can begin.
  void append_checkpoint(const journal::Batch& records);
  /// Writes an input that the core handles only once its record is durable, at once. `decided` is called from the loop:
  /// when the record is durable, or with the disk's refusal; then the store does not contain the record.
  void propose(wire::Input input, Decided decided);
  /// Waits until everything is durable, or the disk refuses.
  void drain();
  /// All records before this one are durable.
  [[nodiscard]] journal::RecordNumber durable() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
