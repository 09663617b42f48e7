#include "cosiva/adapters/thread_pool.h"

namespace cosiva::adapters {

ThreadPool::ThreadPool(std::size_t threads) {
  for (std::size_t i = 1; i < threads; ++i) threads_.emplace_back([this] { help(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock{mutex_};
    ends_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ThreadPool::work() {
  for (std::size_t i = next_.fetch_add(1); i < count_; i = next_.fetch_add(1)) call_(context_, i);
}

void ThreadPool::run(std::size_t count, Call call, void* context) {
  if (count <= 1 || threads_.empty()) {
    for (std::size_t i = 0; i < count; ++i) call(context, i);
    return;
  }
  {
    const std::lock_guard lock{mutex_};
    call_ = call;
    context_ = context;
    count_ = count;
    next_.store(0);
    busy_ = threads_.size();
    ++job_;
  }
  wake_.notify_all();
  work();
  std::unique_lock lock{mutex_};
  rest_.wait(lock, [this] { return busy_ == 0; });
}

void ThreadPool::help() {
  std::uint64_t done = 0;
  std::unique_lock lock{mutex_};
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || job_ != done; });
    if (ends_) return;
    done = job_;
    lock.unlock();
    work();
    lock.lock();
    if (--busy_ == 0) rest_.notify_one();
  }
}

}  // namespace cosiva::adapters
