#include "cosiva/adapters/store/store_keeper.h"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "cosiva/adapters/clock.h"
#include "cosiva/base/expect.h"
#include "cosiva/journal/store/store_verifier.h"

namespace cosiva::adapters {

struct StoreKeeper::Impl : std::enable_shared_from_this<StoreKeeper::Impl> {
  Impl(EventLoop& loop_, std::shared_ptr<journal::Disk> disk_, const journal::Keep& keep_,
       StoreKeeperHandlers handlers_, std::chrono::milliseconds period_)
      : loop{loop_}, disk{std::move(disk_)}, keep{keep_}, handlers{std::move(handlers_)}, period{period_} {}

  void work() {
    journal::StoreVerifier verifier{*disk};
    while (!wait_is_over()) {
      auto verified = verifier.step();
      for (; verified && *verified && !ended(); verified = verifier.step()) remove_old(verifier);
      if (verified) continue;
      // A disk that cannot be read now may be readable later; damage remains.
      if (verified.error().code.starts_with("disk.")) continue;
      return post([error = verified.error()](const StoreKeeperHandlers& to) {
        if (to.on_damage) to.on_damage(error);
      });
    }
  }

  void remove_old(journal::StoreVerifier& verifier) {
    const std::size_t old = journal::removable(verifier.verified(), keep, WallClock{}.now());
    std::size_t count = 0;
    for (; count < old && disk->remove(verifier.verified().front().name); ++count) verifier.removed();
    if (count == 0) return;
    post([count](const StoreKeeperHandlers& to) {
      if (to.on_removed) to.on_removed(count);
    });
  }

  bool wait_is_over() {
    std::unique_lock lock{mutex};
    changed.wait_for(lock, std::exchange(first, false) ? std::chrono::milliseconds{0} : period,
                     [this] { return ends; });
    return ends;
  }
  bool ended() {
    const std::lock_guard lock{mutex};
    return ends;
  }

  void post(std::function<void(const StoreKeeperHandlers&)> what) {
    loop.post([weak = weak_from_this(), what = std::move(what)] {
      if (const auto self = weak.lock()) what(self->handlers);
    });
  }

  EventLoop& loop;
  std::shared_ptr<journal::Disk> disk;
  journal::Keep keep;
  StoreKeeperHandlers handlers;
  std::chrono::milliseconds period;
  bool first{true};  ///< used by the thread only, as the verifier is

  std::mutex mutex;
  std::condition_variable changed;
  bool ends{false};
  std::thread thread;
};

StoreKeeper::StoreKeeper(EventLoop& loop, std::shared_ptr<journal::Disk> disk, const journal::Keep& keep,
                         StoreKeeperHandlers handlers, std::chrono::milliseconds period)
    : impl_{std::make_shared<Impl>(loop, std::move(disk), keep, std::move(handlers), period)} {
  COSIVA_EXPECT(period.count() > 0);
  impl_->thread = std::thread{[impl = impl_.get()] { impl->work(); }};
}

StoreKeeper::~StoreKeeper() {
  {
    const std::lock_guard lock{impl_->mutex};
    impl_->ends = true;
  }
  impl_->changed.notify_all();
  impl_->thread.join();
}

}  // namespace cosiva::adapters
