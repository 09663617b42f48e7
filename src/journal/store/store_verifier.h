#pragma once

#include <deque>
#include <optional>

#include "cosiva/base/result.h"
#include "cosiva/journal/store/disk.h"
#include "cosiva/journal/store/segment_file.h"

namespace cosiva::journal {

/// Verifies the segments that are complete, one after the other, also while others are written.
///
/// Invariant: each verified segment continues the one before.
class StoreVerifier {
 public:
  explicit StoreVerifier(const Disk& disk) : disk_{disk} {}
  /// Verifies the next segment; false where there is none now. Fails with the damage, and as the disk does.
  [[nodiscard]] Result<bool> step();
  /// Oldest first.
  [[nodiscard]] const std::deque<SegmentSummary>& verified() const { return verified_; }
  /// The oldest segment has been removed.
  void removed();

 private:
  const Disk& disk_;
  std::optional<SegmentStart> next_;
  std::deque<SegmentSummary> verified_;
};

}  // namespace cosiva::journal
