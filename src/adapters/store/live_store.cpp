#include "cosiva/adapters/store/live_store.h"

#include <random>
#include <thread>
#include <utility>

#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/base/expect.h"
#include "cosiva/journal/store/store_reading.h"

namespace cosiva::adapters {
namespace {

journal::SegmentStart new_store() {
  std::random_device random;
  return {(std::uint64_t{random()} << 32U) | random(), 1, {}};
}

/// Opens the folder, if necessary after another process has ended.
Result<std::unique_ptr<PosixDisk>> open_disk(const std::string& folder, std::chrono::milliseconds wait_max) {
  constexpr std::chrono::milliseconds step{50};
  for (;; wait_max -= step) {
    auto disk = PosixDisk::open(folder);
    if (disk || disk.error().code != "store.taken" || wait_max < step) return disk;
    std::this_thread::sleep_for(step);
  }
}

std::string cut_tail_text(const journal::StoreContent& content) {
  const journal::SegmentSummary& last = content.segments.back();
  return "the store ended within a write that was not confirmed: " + std::to_string(last.bytes - last.intact_bytes) +
         " bytes of " + last.name + " were cut off";
}

}  // namespace

Result<std::unique_ptr<LiveStore>> LiveStore::open(EventLoop& loop, const std::string& folder,
                                                   LiveStoreOptions options) {
  auto opened = open_disk(folder, options.wait_max);
  if (!opened) return tl::unexpected<Error>(opened.error());
  auto store = open(loop, std::shared_ptr<journal::Disk>{std::move(*opened)}, std::move(options));
  if (!store) {
    Error error = store.error();
    error.location = folder + "/" + error.location;
    return tl::unexpected<Error>(std::move(error));
  }
  return store;
}

Result<std::unique_ptr<LiveStore>> LiveStore::open(EventLoop& loop, std::shared_ptr<journal::Disk> disk,
                                                   LiveStoreOptions options) {
  COSIVA_EXPECT(disk != nullptr);
  journal::Restart restart;
  std::uint64_t records = 0;
  const auto take = [&](journal::RecordNumber number, const journal::RecordView& record) {
    restart.take(number, record);
    records = journal::is_checkpoint(record) ? 0 : records + 1;
  };
  const auto content = journal::recover_store(*disk, take, journal::RecoverFrom::checkpoint);
  if (!content) return tl::unexpected<Error>(content.error());
  if (!options.on_log) options.on_log = [](char, const std::string&) {};
  if (content->torn) options.on_log('w', cut_tail_text(*content));
  std::unique_ptr<LiveStore> store(new LiveStore(std::move(options), std::move(restart), records));
  store->commit_ = std::make_unique<GroupCommit>(loop, disk, content->next.value_or(new_store()), store->handlers(),
                                                 store->options_.commit);
  store->keep(loop, std::move(disk));
  return store;
}

LiveStore::LiveStore(LiveStoreOptions options, journal::Restart restart, std::uint64_t records)
    : options_{std::move(options)},
      restart_{std::move(restart)},
      state_{SimTime{}, wire::InputKind::persisted, {}, restart_.persisted().value_or(""), true},
      records_{records},
      undecided_{restart_.accepted().size()} {
  COSIVA_EXPECT(options_.checkpoint_period > 0);
}

GroupCommitHandlers LiveStore::handlers() {
  GroupCommitHandlers handlers;
  handlers.on_refusal = [this](const Error& error) {
    refusal_ = error;
    options_.on_log('e', "the disk refuses, commands cannot be stored: " + to_string(error));
  };
  handlers.on_recovery = [this] {
    refusal_.reset();
    options_.on_log('i', "the disk works again, and everything is stored");
  };
  handlers.on_gap = [this](std::uint32_t count) {
    records_ = options_.checkpoint_period;
    options_.on_log('e', std::to_string(count) + " records could not be stored; the store continues with the state");
  };
  return handlers;
}

void LiveStore::keep(EventLoop& loop, std::shared_ptr<journal::Disk> disk) {
  StoreKeeperHandlers handlers;
  handlers.on_damage = [this](const Error& error) {
    options_.on_log('e', "the store is damaged before the state of the last start: " + to_string(error) +
                             "; `cosiva journal repair` keeps what is before");
  };
  handlers.on_removed = [this](std::size_t count) {
    options_.on_log('i', std::to_string(count) + " old segments of the store were removed");
  };
  keeper_ = std::make_unique<StoreKeeper>(loop, std::move(disk), options_.keep, std::move(handlers));
}

void LiveStore::append(const wire::Input& input) {
  if (input.kind == wire::InputKind::persisted) {
    state_.payload = input.payload;
  } else {
    if (checkpoint_due() && undecided_ == 0) write_checkpoint();
    if (input.kind == wire::InputKind::command && input.flag) {
      COSIVA_EXPECT(undecided_ > 0);
      --undecided_;
    }
  }
  state_.at = input.at;
  input_.add(input);
  ++records_;
}

void LiveStore::complete() {
  if (input_.empty()) return;
  commit_->append(input_);
  input_.clear();
}

void LiveStore::complete_now(std::function<void()> durable) {
  commit_->append_now(input_, std::move(durable));
  input_.clear();
}

void LiveStore::write_checkpoint() {
  complete();
  journal::Batch checkpoint;
  if (const auto complete = complete_state_ ? complete_state_() : std::nullopt)
    checkpoint.add(journal::to_input(*complete, state_.at));
  checkpoint.add(state_);
  commit_->append_checkpoint(checkpoint);
  records_ = 0;
  for (Held& held : std::exchange(held_, {})) pass_on(std::move(held.proposal), std::move(held.decided));
}

void LiveStore::propose(wire::Input proposal, Decided decided) {
  COSIVA_EXPECT(proposal.kind == wire::InputKind::proposal);
  if (refusal_) return decided(tl::unexpected<Error>(*refusal_));
  if (checkpoint_due()) return held_.push_back({std::move(proposal), std::move(decided)});
  pass_on(std::move(proposal), std::move(decided));
}

void LiveStore::pass_on(wire::Input proposal, Decided decided) {
  ++undecided_;
  commit_->propose(std::move(proposal), [this, decided = std::move(decided)](const Result<void>& kept) {
    if (!kept) --undecided_;
    decided(kept);
  });
}

InputStore::Left LiveStore::take_left() {
  const journal::Restart restart = std::exchange(restart_, {});
  return {
      restart.state(), restart.inputs(), restart.persisted(), {restart.accepted().begin(), restart.accepted().end()}};
}

}  // namespace cosiva::adapters
