#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/input_store.h"
#include "cosiva/adapters/store/group_commit.h"
#include "cosiva/adapters/store/store_keeper.h"
#include "cosiva/base/result.h"
#include "cosiva/journal/store/batch.h"
#include "cosiva/journal/store/restart.h"
#include "cosiva/journal/store/retention.h"

namespace cosiva::adapters {

struct LiveStoreOptions {
  /// The state is written again after this many records, so that a restart reads no more of them.
  std::uint64_t checkpoint_period{50'000};
  journal::Keep keep{};
  /// How long to wait for another process that uses the store: one that was killed may still be writing.
  std::chrono::milliseconds wait_max{std::chrono::seconds{10}};
  GroupCommitOptions commit{};
  /// Receives lines for the log: 'i', 'w' or 'e', and the text. May be empty.
  std::function<void(char level, const std::string& text)> on_log{};
};

/// The store of a live core, in a folder of the file system (docs/protocols/store.md).
///
/// Invariant: no command is accepted while a checkpoint is due, so that each checkpoint follows the records of all
/// commands accepted before.
class LiveStore final : public InputStore {
 public:
  /// Opens the folder, made where missing. Fails as PosixDisk::open() and recover_store() do.
  [[nodiscard]] static Result<std::unique_ptr<LiveStore>> open(EventLoop& loop, const std::string& folder,
                                                               LiveStoreOptions options);
  /// Likewise, on a disk that no other process writes. Fails as recover_store() does.
  [[nodiscard]] static Result<std::unique_ptr<LiveStore>> open(EventLoop& loop, std::shared_ptr<journal::Disk> disk,
                                                               LiveStoreOptions options);

  void append(const wire::Input& input) override;
  void complete() override;
  void complete_now(std::function<void()> durable) override;
  void propose(wire::Input proposal, Decided decided) override;
  void drain() override { commit_->drain(); }
  [[nodiscard]] Left take_left() override;
  void set_complete_state(CompleteState source) override { complete_state_ = std::move(source); }

 private:
  /// A command that waits for a checkpoint.
  struct Held {
    wire::Input proposal;
    Decided decided;
  };

  LiveStore(LiveStoreOptions options, journal::Restart restart, std::uint64_t records);
  [[nodiscard]] GroupCommitHandlers handlers();
  void keep(EventLoop& loop, std::shared_ptr<journal::Disk> disk);
  [[nodiscard]] bool checkpoint_due() const { return records_ >= options_.checkpoint_period; }
  void write_checkpoint();
  void pass_on(wire::Input proposal, Decided decided);

  LiveStoreOptions options_;
  journal::Restart restart_;
  CompleteState complete_state_;
  std::optional<Error> refusal_;  ///< nothing while the disk works
  wire::Input state_;             ///< persisted last; no payload: none
  journal::Batch input_;          ///< the records of the input that the core handles
  std::uint64_t records_{0};      ///< appended since the last checkpoint
  std::size_t undecided_{0};      ///< commands that were passed on, and not yet appended or refused
  std::deque<Held> held_;
  std::unique_ptr<GroupCommit> commit_;
  std::unique_ptr<StoreKeeper> keeper_;
};

}  // namespace cosiva::adapters
