#include "cosiva/adapters/store/group_commit.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/journal/store/segment_log.h"

namespace cosiva::adapters {

using journal::Batch;

struct GroupCommit::Impl : std::enable_shared_from_this<GroupCommit::Impl> {
  struct Proposal {
    wire::Input input;
    Decided decided;
  };

  Impl(EventLoop& loop_, std::unique_ptr<journal::Disk> disk_, const journal::SegmentStart& next,
       GroupCommitHandlers handlers_, GroupCommitOptions options_)
      : loop{loop_},
        disk{std::move(disk_)},
        handlers{std::move(handlers_)},
        options{options_},
        log{*disk, next, options_.segment_bytes},
        durable{next.first} {}

  // --- the thread of the disk ------------------------------------------------------------------------------------

  void work() {
    std::unique_lock lock{mutex};
    for (;;) {
      changed.wait(lock, [this] { return ends || !waiting.empty() || !proposals.empty(); });
      if (waiting.empty() && proposals.empty()) return;
      changed.wait_for(lock, options.period, [this] { return ends || hurried || !proposals.empty(); });
      hurried = false;
      if (write_waiting(lock)) continue;
      if (ends) return;
      changed.wait_for(lock, options.retry, [this] { return ends; });
    }
  }

  /// Writes what waits. Where the disk refuses that, the records wait again, and the proposals are refused.
  bool write_waiting(std::unique_lock<std::mutex>& lock) {
    Batch records = std::exchange(waiting, {});
    std::vector<Proposal> proposed = std::exchange(proposals, {});
    writing = true;
    lock.unlock();
    const auto written = write(records, proposed);
    lock.lock();
    writing = false;
    if (written) {
      durable = log.next().first;
      recover();
    } else {
      records.add(waiting);
      waiting = std::move(records);
      refuse(written.error());
    }
    decide(std::move(proposed), written);
    changed.notify_all();
    return written.has_value();
  }

  /// Proposals follow the records of the core, so that they can be left out of the next attempt.
  Result<void> write(const Batch& records, const std::vector<Proposal>& proposed) {
    if (proposed.empty()) return log.write(records);
    Batch all = records;
    for (const Proposal& proposal : proposed) all.add(proposal.input);
    return log.write(all);
  }

  void decide(std::vector<Proposal> proposed, const Result<void>& written) {
    if (proposed.empty()) return;
    post([proposed = std::move(proposed), written](const GroupCommitHandlers&) {
      for (const Proposal& proposal : proposed) proposal.decided(written);
    });
  }

  void recover() {
    if (!std::exchange(refusal, std::nullopt)) return;
    post([](const GroupCommitHandlers& to) {
      if (to.on_recovery) to.on_recovery();
    });
  }

  void refuse(const Error& error) {
    if (refusal == error) return;
    refusal = error;
    post([error](const GroupCommitHandlers& to) {
      if (to.on_refusal) to.on_refusal(error);
    });
  }

  void post(std::function<void(const GroupCommitHandlers&)> what) {
    loop.post([weak = weak_from_this(), what = std::move(what)] {
      if (const auto self = weak.lock()) what(self->handlers);
    });
  }

  EventLoop& loop;
  std::unique_ptr<journal::Disk> disk;
  GroupCommitHandlers handlers;
  GroupCommitOptions options;
  journal::SegmentLog log;  ///< used by the thread only

  std::mutex mutex;  ///< of all that follows
  std::condition_variable changed;
  Batch waiting;
  std::vector<Proposal> proposals;
  journal::RecordNumber durable;
  std::optional<Error> refusal;
  bool hurried{false};
  bool writing{false};
  bool ends{false};
  std::thread thread;
};

GroupCommit::GroupCommit(EventLoop& loop, std::unique_ptr<journal::Disk> disk, const journal::SegmentStart& next,
                         GroupCommitHandlers handlers, GroupCommitOptions options)
    : impl_{std::make_shared<Impl>(loop, std::move(disk), next, std::move(handlers), options)} {
  impl_->thread = std::thread{[impl = impl_.get()] { impl->work(); }};
}

GroupCommit::~GroupCommit() {
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->ends = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

void GroupCommit::append(const wire::Input& input) {
  bool first = false;
  {
    const std::lock_guard lock{impl_->mutex};
    first = impl_->waiting.empty();
    impl_->waiting.add(input);
  }
  if (first) impl_->changed.notify_all();
}

void GroupCommit::propose(wire::Input input, Decided decided) {
  COSIVA_EXPECT(decided != nullptr);
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->proposals.push_back({std::move(input), std::move(decided)});
  }
  impl_->changed.notify_all();
}

void GroupCommit::drain() {
  std::unique_lock lock{impl_->mutex};
  impl_->hurried = true;
  impl_->changed.notify_all();
  impl_->changed.wait(lock, [this] {
    return impl_->refusal || (impl_->waiting.empty() && impl_->proposals.empty() && !impl_->writing);
  });
}

journal::RecordNumber GroupCommit::durable() const {
  const std::lock_guard lock{impl_->mutex};
  return impl_->durable;
}

}  // namespace cosiva::adapters
