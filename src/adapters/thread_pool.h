#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "cosiva/base/workers.h"

namespace cosiva::adapters {

/// Permanent threads for cores that take Workers. The caller of for_each works as well; parts are taken one by one, so
/// that no thread waits for the slowest part.
class ThreadPool final : public Workers {
 public:
  /// @param threads  in all, the caller's own included; at least one
  explicit ThreadPool(std::size_t threads);
  ~ThreadPool() override;
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  [[nodiscard]] std::size_t threads() const { return threads_.size() + 1; }

 protected:
  void run(std::size_t count, Call call, void* context) override;

 private:
  void help();
  void work();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable rest_;
  std::uint64_t job_{0};
  std::size_t busy_{0};  ///< helpers that are on the present job
  bool ends_{false};
  Call call_{};
  void* context_{};
  std::size_t count_{0};
  std::atomic<std::size_t> next_{0};
  std::vector<std::thread> threads_;
};

}  // namespace cosiva::adapters
