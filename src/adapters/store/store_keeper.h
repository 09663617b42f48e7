#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"
#include "cosiva/journal/store/disk.h"
#include "cosiva/journal/store/retention.h"

namespace cosiva::adapters {

struct StoreKeeperHandlers {
  /// A segment is damaged; nothing is verified or removed any more.
  std::function<void(const Error&)> on_damage;
  std::function<void(std::size_t segments)> on_removed;
};

/// Verifies the complete segments of a store in the background, those that a restart did not read included, and removes
/// those that need not be retained any more.
///
/// Invariant: a segment is removed only after it, and those before it, have been verified.
class StoreKeeper {
 public:
  /// @param period    after which it searches for complete segments again
  /// @param handlers  called from the loop; each may be empty
  StoreKeeper(EventLoop& loop, std::shared_ptr<journal::Disk> disk, const journal::Keep& keep,
              StoreKeeperHandlers handlers, std::chrono::milliseconds period = std::chrono::seconds{10});
  /// Waits for the segment that is being read.
  ~StoreKeeper();
  StoreKeeper(const StoreKeeper&) = delete;
  StoreKeeper& operator=(const StoreKeeper&) = delete;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
