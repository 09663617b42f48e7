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
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t spare_bytes_max = std::size_t{32} << 20U;

}  // namespace

struct GroupCommit::Impl : std::enable_shared_from_this<GroupCommit::Impl> {
  struct Proposal {
    wire::Input input;
    Decided decided;
  };
  /// What waits for the disk.
  struct Pending {
    Batch records;
    std::vector<Proposal> proposals;
    std::vector<std::function<void()>> notices;  ///< of records
    Clock::time_point since;                     ///< the first of the records waits

    void add(const Batch& more) {
      if (records.empty()) since = Clock::now();
      records.add(more);
    }
    [[nodiscard]] bool empty() const { return records.empty() && proposals.empty(); }
  };

  Impl(EventLoop& loop_, std::shared_ptr<journal::Disk> disk_, const journal::SegmentStart& next,
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
      changed.wait(lock, [this] { return wanted.end || !waiting.empty(); });
      if (waiting.empty()) return;
      changed.wait_until(lock, waiting.since + options.period,
                         [this] { return wanted.end || wanted.at_once || !waiting.proposals.empty(); });
      wanted.at_once = false;
      if (waiting.empty()) continue;  // given up meanwhile
      if (write_waiting(lock)) continue;
      if (wanted.end) return;
      changed.wait_for(lock, options.retry, [this] { return wanted.end; });
    }
  }

  /// Writes what waits. Where the disk refuses that, the records wait again, and the proposals are refused.
  bool write_waiting(std::unique_lock<std::mutex>& lock) {
    Pending taken = std::exchange(waiting, {});
    std::swap(waiting.records, spare);
    writing = true;
    lock.unlock();
    const auto written = write(taken.records, taken.proposals);
    lock.lock();
    writing = false;
    if (written) {
      durable = log.next().first;
      taken.records.clear();
      if (taken.records.records().capacity() <= spare_bytes_max) spare = std::move(taken.records);
      notify(std::move(taken.notices));
      recover();
    } else {
      wait_again(taken);
      refuse(written.error());
    }
    limit_waiting();
    decide(std::move(taken.proposals), written);
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

  /// Records that could not be written wait before those that came meanwhile.
  void wait_again(Pending& taken) {
    taken.records.add(waiting.records);
    waiting.records = std::move(taken.records);
    waiting.notices.insert(waiting.notices.begin(), taken.notices.begin(), taken.notices.end());
  }

  void notify(std::vector<std::function<void()>> awaited) {
    if (awaited.empty()) return;
    post([awaited = std::move(awaited)](const GroupCommitHandlers&) {
      for (const auto& notice : awaited) notice();
    });
  }

  /// Memory is bounded, however long the disk refuses.
  void limit_waiting() {
    if (waiting.records.records().size() <= options.waiting_bytes_max) return;
    gapped = true;
    post([count = std::exchange(waiting.records, {}).count()](const GroupCommitHandlers& to) {
      if (to.on_gap) to.on_gap(count);
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
  std::shared_ptr<journal::Disk> disk;
  GroupCommitHandlers handlers;
  GroupCommitOptions options;
  journal::SegmentLog log;  ///< used by the thread only

  std::mutex mutex;  ///< of all that follows
  std::condition_variable changed;
  Pending waiting;
  Batch spare;  ///< empty: its memory is used again
  journal::RecordNumber durable;
  std::optional<Error> refusal;
  struct Wanted {
    bool at_once{false};  ///< before the period is over
    bool end{false};
  };
  Wanted wanted;
  bool gapped{false};  ///< records are given up until a checkpoint
  bool writing{false};
  std::thread thread;
};

GroupCommit::GroupCommit(EventLoop& loop, std::shared_ptr<journal::Disk> disk, const journal::SegmentStart& next,
                         GroupCommitHandlers handlers, GroupCommitOptions options)
    : impl_{std::make_shared<Impl>(loop, std::move(disk), next, std::move(handlers), options)} {
  impl_->thread = std::thread{[impl = impl_.get()] { impl->work(); }};
}

GroupCommit::~GroupCommit() {
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->wanted.end = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

void GroupCommit::append(const Batch& records) {
  bool first = false;
  {
    const std::lock_guard lock{impl_->mutex};
    if (impl_->gapped) return;
    first = impl_->waiting.empty();
    impl_->waiting.add(records);
    impl_->limit_waiting();
  }
  if (first) impl_->changed.notify_all();
}

void GroupCommit::append_now(const Batch& records, std::function<void()> durable) {
  COSIVA_EXPECT(durable != nullptr);
  {
    const std::lock_guard lock{impl_->mutex};
    // Within a gap the next checkpoint covers what these records would have.
    if (!impl_->gapped) impl_->waiting.add(records);
    impl_->waiting.notices.push_back(std::move(durable));
    impl_->wanted.at_once = true;
  }
  impl_->changed.notify_all();
}

void GroupCommit::append_checkpoint(const Batch& records) {
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->gapped = false;
    impl_->waiting.add(records);
  }
  impl_->changed.notify_all();
}

void GroupCommit::propose(wire::Input input, Decided decided) {
  COSIVA_EXPECT(decided != nullptr);
  {
    const std::lock_guard lock{impl_->mutex};
    if (impl_->gapped) {
      const Error stalled{"disk.io", "the disk has not written for too long", {}};
      return impl_->decide({{std::move(input), std::move(decided)}},
                           tl::unexpected<Error>(impl_->refusal.value_or(stalled)));
    }
    impl_->waiting.proposals.push_back({std::move(input), std::move(decided)});
  }
  impl_->changed.notify_all();
}

void GroupCommit::drain() {
  std::unique_lock lock{impl_->mutex};
  impl_->wanted.at_once = true;
  impl_->changed.notify_all();
  impl_->changed.wait(lock, [this] { return impl_->refusal || (impl_->waiting.empty() && !impl_->writing); });
}

journal::RecordNumber GroupCommit::durable() const {
  const std::lock_guard lock{impl_->mutex};
  return impl_->durable;
}

}  // namespace cosiva::adapters
