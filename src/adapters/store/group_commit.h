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
  std::chrono::milliseconds period{10};  ///< a record waits this long at most before it is written and synced
  std::size_t segment_bytes{std::size_t{64} << 20U};
  std::chrono::milliseconds retry{200};  ///< after a failure
};

struct GroupCommitHandlers {
  /// The disk refuses; called once for each change of the reason.
  std::function<void(const Error&)> on_refusal;
  /// The disk works again, and everything appended is durable.
  std::function<void()> on_recovery;
};

/// Appends the records of a loop to a store, and makes them durable together on a thread of its own: the loop never
/// waits for the disk. While the disk refuses, the records wait, and the writing is tried again.
///
/// Invariant: the records that wait follow the durable ones without a gap, and no proposal waits longer than one
/// attempt to write.
class GroupCommit {
 public:
  /// @param next      where the store continues
  /// @param handlers  called from the loop; each may be empty
  GroupCommit(EventLoop& loop, std::unique_ptr<journal::Disk> disk, const journal::SegmentStart& next,
              GroupCommitHandlers handlers, GroupCommitOptions options = {});
  /// Waits until everything is durable, or the disk refuses.
  ~GroupCommit();
  GroupCommit(const GroupCommit&) = delete;
  GroupCommit& operator=(const GroupCommit&) = delete;

  using Decided = std::function<void(const Result<void>&)>;
  /// Appends an input that the core handles now.
  void append(const wire::Input& input);
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
